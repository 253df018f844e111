//! `istar encode`

use crate::pictures::{self, RegionKind};
use crate::survey::texel_sizes;
use crate::tell::{aside, tell};
use crate::{Outcome, files, names, progress, stream};
use clap::ValueEnum;
use istar::container::Names;
use istar::labels::Connectivity;
use istar::{
    Chosen, EncodeOptions, Forbidden, Gamma, Kernel, Lossy, Shard, StreamOptions, Target, container,
};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Encode a PNG: flat colours in 8 bits, or labels in 16-bit grey
#[derive(clap::Args)]
pub struct Args {
    /// The PNG
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Where to write the .istar file
    #[arg(short, long, value_name = "OUT.istar")]
    output: PathBuf,
    #[command(flatten)]
    options: Options,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Options that take the whole picture at once.
const NEEDS_WHOLE: [&str; 8] =
    ["texel_size", "psnr", "max_bytes", "payload", "kernel", "min_region", "label_cost", "forbid"];

/// How to encode.
#[derive(clap::Args)]
struct Options {
    /// Source pixels a texel stands for: 2, 4, 8, 16, 32 or 64, everywhere. Without it each block of
    /// the picture has its own, as it pays
    #[arg(long, value_name = "N")]
    texel_size: Option<u32>,
    /// The smallest file that reaches this PSNR
    #[arg(long, value_name = "DB", conflicts_with = "texel_size", value_parser = decibels)]
    psnr: Option<f64>,
    /// The best file of at most N bytes
    #[arg(long, value_name = "N", conflicts_with_all = ["texel_size", "psnr"])]
    max_bytes: Option<u64>,
    /// Keep every pixel: the file holds the picture's labels, in tiles where it is large, and what draws it makes
    /// texels of them
    #[arg(long, conflicts_with_all = ["texel_size", "psnr", "max_bytes", "min_region", "forbid"])]
    lossless: bool,
    /// What the file holds. Without it: labels for --lossless, --psnr and --max-bytes, unless more is asked
    /// for than labels can tell; else texels
    #[arg(long, value_enum)]
    payload: Option<PayloadName>,
    /// What a region is
    #[arg(long, value_enum, default_value_t, conflicts_with = "lossless")]
    regions: RegionKind,
    /// Cut the picture into tiles of N pixels, a power of two from 64, with coarser levels beside it; 0 for
    /// one tile. Without it, large pictures are
    #[arg(long, value_name = "N", value_parser = tile_size)]
    tile_size: Option<u32>,
    /// Read the picture row by row, in memory that does not grow with its height, and keep every pixel:
    /// tiles hold labels, from which texels are drawn. Without it, pictures of more than 134 megapixels are
    #[arg(long, conflicts_with_all = NEEDS_WHOLE)]
    stream: bool,
    /// Make part I of N of a picture's tiles, row by row; `istar merge` joins the parts
    #[arg(long, value_name = "I/N", value_parser = shard, conflicts_with_all = NEEDS_WHOLE)]
    shard: Option<Shard>,
    /// Interpolation of texels
    #[arg(long, value_enum, default_value_t = KernelName::Quadratic)]
    kernel: KernelName,
    /// Decoding function
    #[arg(long, value_enum, default_value_t = GammaName::Voronoi)]
    gamma: GammaName,
    /// How many neighbours of a pixel may belong to its region
    #[arg(long, value_enum, default_value_t = ConnectivityName::Four)]
    connectivity: ConnectivityName,
    /// Merge regions of fewer pixels into the neighbour with the longest common boundary; 0 keeps all
    #[arg(long, value_name = "AREA", default_value_t = EncodeOptions::default().min_region)]
    min_region: u32,
    /// What a pixel of another region costs whatever its colour, as a part of black for white: with 0
    /// colours alone count, with more the boundary between two regions of like colours does too
    #[arg(long, value_name = "PART", conflicts_with = "lossless", value_parser = part)]
    label_cost: Option<f64>,
    /// Part regions that must not meet by a layer between them: A and B by VIA, each a label as in 7
    /// or a colour as in #00ff7f. May be given several times
    #[arg(long, value_name = "A,B,VIA", value_parser = forbidden)]
    forbid: Vec<Forbidden>,
    /// What regions are called: rows of a label as in 7 or a colour as in #00ff7f, a comma, and the name.
    /// The file tells it to who looks at it
    #[arg(long, value_name = "TABLE.csv")]
    names: Option<PathBuf>,
}

fn decibels(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|&db: &f64| db > 0.0);
    number.ok_or_else(|| "give a number above 0, as in 35".into())
}

fn tile_size(word: &str) -> Result<u32, String> {
    let fits =
        |&size: &u32| size == 0 || (size.is_power_of_two() && (64..=1 << 30).contains(&size));
    word.parse().ok().filter(fits).ok_or_else(|| "give a power of two from 64, or 0".into())
}

fn shard(word: &str) -> Result<Shard, String> {
    let parts = word.split_once('/').and_then(|(number, count)| {
        let (number, count): (u32, u32) = (number.parse().ok()?, count.parse().ok()?);
        (1..=count).contains(&number).then(|| Shard { number: number - 1, count })
    });
    parts.ok_or_else(|| "give a part and how many there are, as in 1/4".into())
}

fn part(word: &str) -> Result<f64, String> {
    let number = word.parse().ok().filter(|part| (0.0..=1.0).contains(part));
    number.ok_or_else(|| "give a number from 0 to 1, as in 0.05".into())
}

fn forbidden(words: &str) -> Result<Forbidden, String> {
    let classes: Option<Vec<u32>> = words.split(',').map(class).collect();
    match classes.as_deref() {
        Some(&[a, b, via]) => Ok(Forbidden { pair: [a, b], via }),
        _ => Err("give three labels (1,2,3) or colours (#rrggbb,#rrggbb,#rrggbb)".into()),
    }
}

/// A label, or a colour of six or eight digits.
pub fn class(word: &str) -> Option<u32> {
    let Some(digits) = word.strip_prefix('#') else { return word.parse().ok() };
    let digits = if digits.len() == 6 { format!("{digits}ff") } else { digits.into() };
    let color = u32::from_str_radix(&digits, 16).ok().filter(|_| digits.len() == 8)?;
    // As `Source` has it: red in the lowest byte, and all that is transparent the same.
    Some(if color & 0xff == 0 { 0 } else { color.swap_bytes() })
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PayloadName {
    /// The picture as it is drawn: opens at once
    Texels,
    /// Labels, far smaller: what opens the file fits texels to them first
    Labels,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum KernelName {
    /// Smooth curves
    Quadratic,
    /// As in the paper
    Linear,
}

#[derive(Clone, Copy, ValueEnum)]
enum GammaName {
    /// The nearest node wins
    Voronoi,
    /// Boundaries may have planes of their own: T junctions come out as T
    Planes,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ConnectivityName {
    /// Those that share a side with it
    #[value(name = "4")]
    Four,
    /// Those at its corners too: a line that steps diagonally stays one region
    #[value(name = "8")]
    Eight,
}

pub fn run(args: &Args) -> Outcome {
    let default = EncodeOptions::default();
    let options = EncodeOptions {
        texel_size: args.options.texel_size,
        kernel: match args.options.kernel {
            KernelName::Quadratic => Kernel::Quadratic,
            KernelName::Linear => Kernel::Linear,
        },
        gamma: match args.options.gamma {
            GammaName::Voronoi => Gamma::Voronoi,
            GammaName::Planes => Gamma::Planes,
        },
        connectivity: match args.options.connectivity {
            ConnectivityName::Four => Connectivity::Face,
            ConnectivityName::Eight => Connectivity::Vertex,
        },
        min_region: args.options.min_region,
        forbidden: args.options.forbid.clone(),
        label_cost: args.options.label_cost.unwrap_or(default.label_cost),
        ..default
    };
    let names = args.options.names.as_deref().map(names::read).transpose()?.unwrap_or_default();
    let output = files::Output::create(&args.output)?;
    if args.options.streams(&args.input)? {
        return encode_rows(args, &options, &names, output);
    }
    if args.options.lossless {
        if args.options.payload == Some(PayloadName::Texels) {
            return Err("--lossless goes with no --payload texels: only labels keep all".into());
        }
        return encode_lossless(args, &options, &names, output);
    }
    let psnr = args.options.psnr.map(Target::Psnr);
    let most = args.options.max_bytes.map(|most| most.saturating_sub(names.bytes_in_file()));
    let target = psnr.or(most.map(Target::MaxBytes));
    match target {
        Some(target) if args.options.holds_labels()? => {
            return encode_lossy(args, &options, target, &names, output);
        }
        None if args.options.payload == Some(PayloadName::Labels) => {
            return Err("--payload labels takes --lossless, --psnr or --max-bytes: give one".into());
        }
        _ => {}
    }
    let Encoded { chosen: Chosen { image, psnr, .. }, bytes, is_antialiased } =
        encode_file(&args.input, args.options.regions, &options, target, args.options.tile_size)?;
    let bytes = named(bytes, &names)?;
    output.finish(&bytes)?;
    if let (Some(wanted), Some(psnr)) = (args.options.psnr, psnr)
        && psnr < wanted
    {
        aside(&format!("{wanted} dB cannot be reached: the best is {psnr:.2} dB"));
    }
    let [width, height] = image.size;
    if args.json {
        tell!(
            "{}",
            json!({
                "bytes": bytes.len(),
                "size": image.size,
                "antialiased": is_antialiased,
                "regions": image.regions.len(),
                "texel_size": texel_sizes(&image),
            })
        )?;
    } else {
        tell!(
            "{}: {width}×{height} pixels, {} regions{}, {} bytes",
            args.output.display(),
            image.regions.len(),
            if is_antialiased { " with antialiased edges" } else { "" },
            bytes.len()
        )?;
    }
    Ok(())
}

impl Options {
    /// Whether the picture is encoded row by row.
    fn streams(&self, input: &Path) -> Result<bool, String> {
        let is_told = self.stream || self.shard.is_some();
        if is_told && (self.regions == RegionKind::Antialiased || self.tile_size == Some(0)) {
            return Err("row by row there are tiles, and no antialiased edges: leave out \
                 --tile-size 0 and --regions antialiased, or --stream and --shard"
                .into());
        }
        let needs_whole = self.texel_size.is_some()
            || self.psnr.is_some()
            || self.max_bytes.is_some()
            || self.payload.is_some()
            || self.kernel != KernelName::Quadratic
            || self.min_region > 0
            || self.label_cost.is_some()
            || !self.forbid.is_empty()
            || self.regions == RegionKind::Antialiased
            || self.tile_size == Some(0);
        let in_tiles = self.lossless && self.tile_size.is_some_and(|size| size > 0);
        if in_tiles && needs_whole {
            return Err(
                "labels in tiles go with no --payload and no --kernel linear: leave these out, or \
                 --tile-size"
                    .into(),
            );
        }
        Ok(is_told || in_tiles || !needs_whole && stream::is_large(input, self.lossless))
    }

    /// Whether a file for a target is of labels.
    fn holds_labels(&self) -> Result<bool, String> {
        let needs_texels = self.min_region > 0
            || self.label_cost.is_some()
            || !self.forbid.is_empty()
            || self.tile_size.is_some_and(|size| size > 0)
            || self.connectivity != ConnectivityName::Four;
        match self.payload {
            Some(PayloadName::Labels) if needs_texels => Err(
                "--payload labels goes with no --min-region, --label-cost, --forbid, --tile-size \
                     or --connectivity: leave them out, or the payload"
                    .into(),
            ),
            payload => Ok(payload.map_or(!needs_texels, |payload| payload == PayloadName::Labels)),
        }
    }
}

/// A file with names, if there are any.
fn named(bytes: Vec<u8>, names: &Names) -> Result<Vec<u8>, String> {
    if names.is_empty() {
        return Ok(bytes);
    }
    container::with_names(&bytes, names).map_err(|error| error.to_string())
}

fn encode_rows(
    args: &Args,
    options: &EncodeOptions,
    names: &Names,
    output: files::Output,
) -> Outcome {
    let default = StreamOptions::default();
    let options = StreamOptions {
        tile_log2: args.options.tile_size.map_or(default.tile_log2, |n| n.trailing_zeros() as u8),
        gamma: options.gamma,
        connectivity: options.connectivity,
        shard: args.options.shard.unwrap_or(default.shard),
        limits: options.limits.clone(),
    };
    let written = stream::encode(&args.input, &options, names, output)?;
    let ([width, height], Shard { number, count }) = (written.size, options.shard);
    if args.json {
        let told = json!({
            "bytes": written.bytes,
            "size": written.size,
            "regions": written.regions,
            "streamed": true,
            "lossless": true,
            "shard": (count > 1).then_some([number + 1, count]),
        });
        return tell!("{told}");
    }
    let which = match count {
        1 => String::new(),
        _ => format!(", part {} of {count}", number + 1),
    };
    tell!(
        "{}: {width}×{height} pixels{which}, {} regions, {} bytes",
        args.output.display(),
        written.regions,
        written.bytes
    )
}

fn encode_lossy(
    args: &Args,
    options: &EncodeOptions,
    target: Target,
    names: &Names,
    output: files::Output,
) -> Outcome {
    let stages = progress::Stages::new();
    stages.set("reading");
    let source = pictures::read_source(&args.input, args.options.regions, &options.limits)?;
    let stage = |stage| stages.set(stage);
    let Lossy { bytes, scale, psnr } = istar::encode_lossy(&source, options, target, stage)
        .map_err(|error| files::at(&args.input, &error))?;
    drop(stages);
    let bytes = named(bytes, names)?;
    output.finish(&bytes)?;
    let [width, height] = source.size();
    // Where within pixels antialiased edges lie is no matter of labels.
    let is_antialiased = source.distances().is_some();
    if args.json {
        // JSON has no infinity.
        let told = json!({
            "bytes": bytes.len(),
            "size": source.size(),
            "antialiased": is_antialiased,
            "lossless": psnr.is_infinite() && !is_antialiased,
            "psnr": psnr.is_finite().then_some(psnr),
            "label_size": scale,
        });
        return tell!("{told}");
    }
    let quality = match (psnr.is_infinite(), scale) {
        (true, _) if is_antialiased => "all regions without loss, edges no longer mixed".into(),
        (true, _) => "without loss".into(),
        (_, 1) => format!("{psnr:.2} dB"),
        _ => format!("{psnr:.2} dB, a label for {scale}×{scale} pixels"),
    };
    let name = args.output.display();
    tell!("{name}: {width}×{height} pixels, {} bytes, {quality}", bytes.len())
}

fn encode_lossless(
    args: &Args,
    options: &EncodeOptions,
    names: &Names,
    output: files::Output,
) -> Outcome {
    let stages = progress::Stages::new();
    stages.set("reading");
    let source = pictures::read_source(&args.input, RegionKind::Exact, &options.limits)?;
    stages.set("packing labels");
    let bytes =
        istar::encode_lossless(&source, options).map_err(|error| files::at(&args.input, &error))?;
    drop(stages);
    let bytes = named(bytes, names)?;
    output.finish(&bytes)?;
    let [width, height] = source.size();
    if args.json {
        let told = json!({ "bytes": bytes.len(), "size": source.size(), "lossless": true });
        tell!("{told}")?;
    } else {
        tell!(
            "{}: {width}×{height} pixels, {} bytes, without loss",
            args.output.display(),
            bytes.len()
        )?;
    }
    Ok(())
}

/// An encoded picture.
pub struct Encoded {
    pub chosen: Chosen,
    /// The file.
    pub bytes: Vec<u8>,
    /// Whether mixed colours were read as edges.
    pub is_antialiased: bool,
}

/// Reads and encodes a picture, with the texel size of the options where there is no target, in tiles of the
/// width that is asked for, or of what suits it.
pub fn encode_file(
    input: &Path,
    kind: RegionKind,
    options: &EncodeOptions,
    target: Option<Target>,
    tile_size: Option<u32>,
) -> Result<Encoded, String> {
    let stages = progress::Stages::new();
    stages.set("reading");
    let source = pictures::read_source(input, kind, &options.limits)?;
    let stage = |stage| stages.set(stage);
    let chosen =
        match target {
            Some(target) => istar::encode_to(&source, options, target, stage),
            None => istar::encode_with_notes(&source, options, stage)
                .map(|(image, notes)| Chosen { image, notes, psnr: None }),
        }
        .map_err(|error| files::at(input, &error))?;
    stages.set("packing");
    let Chosen { image, notes, .. } = &chosen;
    let tile_log2 = match tile_size {
        None => istar::suitable_tile_log2(image.size),
        Some(0) => None,
        Some(width) => Some(width.trailing_zeros() as u8),
    };
    let bytes = match tile_log2 {
        None => container::write_with(image, notes),
        Some(log2) => istar::encode_pyramid(image, notes, log2, options, stage),
    }
    .map_err(|error| files::at(input, &error))?;
    Ok(Encoded { chosen, bytes, is_antialiased: source.distances().is_some() })
}
