//! `istar compare`

use crate::pictures::{self, RegionKind};
use crate::tell::tell;
use crate::{Outcome, files, progress};
use istar::labels::Source;
use istar::{BoundaryError, Limits, RegionComparison};
use serde_json::{Value, json};
use std::cmp::Reverse;
use std::path::PathBuf;

/// How many regions are told on a terminal.
const WORST: usize = 20;

/// Compare a file with the picture it was made from
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
    /// The original PNG
    #[arg(value_name = "ORIGINAL.png")]
    original: PathBuf,
    /// Tell each region that differs: as JSON all of them, by number; else the worst 20
    #[arg(long)]
    regions: bool,
    /// What a region of the original is. Without it, where its edges are antialiased, what the file is
    /// nearer to: the regions that they part, or every colour
    #[arg(long, value_name = "KIND", value_enum, default_value_t)]
    original_regions: RegionKind,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let stages = progress::Stages::new();
    stages.set("reading");
    let (image, bytes) = files::read_exact(&args.input)?;
    let read = |kind| pictures::read_source(&args.original, kind, &Limits::default());
    let compare = |source: &Source<2>| {
        match args.regions {
            true => istar::compare_by_region(&image, source),
            false => istar::compare(&image, source).map(|result| (result, Vec::new())),
        }
        .map_err(|error| files::at(&args.input, &error))
    };
    let mut source = read(args.original_regions)?;
    stages.set("comparing");
    let (mut result, mut regions) = compare(&source)?;
    if args.original_regions == RegionKind::Auto && source.distances().is_some() {
        let exact = read(RegionKind::Exact)?;
        let with_exact = compare(&exact)?;
        if with_exact.0.psnr > result.psnr {
            source = exact;
            (result, regions) = with_exact;
        }
    }
    let mut differ: Vec<RegionComparison> = regions.into_iter().filter(|r| !r.exact()).collect();
    drop(stages);

    let ratio = 3.0 * result.pixels as f64 / bytes.len() as f64;
    let wrong = result.wrong_pixels as f64 / result.pixels as f64;
    if args.json {
        let mut told = json!({
            "bytes": bytes.len(),
            "ratio": ratio,
            // JSON has no infinity: null says that nothing differs.
            "psnr": result.psnr.is_finite().then_some(result.psnr),
            "wrong_pixels": wrong,
            "boundary_error_px": boundary(result.boundary_error),
            "lost_regions": result.lost_regions,
            "antialiased": source.distances().is_some(),
        });
        if args.regions {
            let region = |region: &RegionComparison| region_json(region, &source);
            told["regions"] = differ.iter().map(region).collect();
        }
        tell!("{told}")?;
        return Ok(());
    }
    tell!("bytes           {} ({ratio:.0} : 1 against raw RGB)", bytes.len())?;
    tell!("psnr            {:.2} dB", result.psnr)?;
    tell!("wrong pixels    {:.3} % ({})", 100.0 * wrong, result.wrong_pixels)?;
    tell!("lost regions    {}", result.lost_regions)?;
    if source.distances().is_some() {
        tell!(
            "edges           antialiased: a mixed pixel counts as of the region that has more of it"
        )?;
    }
    if let Some(error) = result.boundary_error {
        tell!("boundary error  {:.2} px mean, {:.2} px at 95 %", error.mean, error.p95)?;
    }
    if args.regions {
        differ.sort_by_key(|region| (Reverse(region.wrong_pixels), region.region));
        print_worst(&differ, &source)?;
    }
    Ok(())
}

fn boundary(error: Option<BoundaryError>) -> Value {
    error.map_or(Value::Null, |e| json!({ "mean": e.mean, "p95": e.p95 }))
}

fn region_json(region: &RegionComparison, source: &Source<2>) -> Value {
    json!({
        "region": region.region,
        "class": source.class_name(region.class),
        "at": region.at,
        "pixels": region.pixels,
        "decoded_pixels": region.decoded_pixels,
        "wrong_pixels": region.wrong_pixels,
        "lost": region.lost(),
        "boundary_error_px": boundary(region.boundary_error),
    })
}

fn print_worst(regions: &[RegionComparison], source: &Source<2>) -> Outcome {
    tell!("regions that differ  {}", regions.len())?;
    if regions.is_empty() {
        return Ok(());
    }
    tell!("\n  region  first pixel     pixels    decoded      wrong  boundary  class")?;
    for region in regions.iter().take(WORST) {
        let [x, y] = region.at;
        let boundary = region.boundary_error.map_or(String::new(), |e| format!("{:.2} px", e.mean));
        tell!(
            "{:>8}  {:>11}  {:>9}  {:>9}  {:>9}  {boundary:>8}  {}",
            region.region,
            format!("{x},{y}"),
            region.pixels,
            if region.lost() { "lost".into() } else { region.decoded_pixels.to_string() },
            region.wrong_pixels,
            source.class_name(region.class),
        )?;
    }
    Ok(())
}
