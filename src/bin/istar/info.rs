//! `istar info`

use crate::archive::Archive;
use crate::survey::{self, Survey};
use crate::tell::tell;
use crate::{Outcome, files};
use istar::container::{self, Part, Payload};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Tell what is in a file
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let mut archive = Archive::open(&args.input)?;
    archive.check_length()?;
    let notes = container::notes(&archive.index).map_err(|error| archive.at(&error))?;
    let names = container::names(&archive.index).map_err(|error| archive.at(&error))?;
    let layout = archive.index.layout().clone();
    let label_size = match archive.index.payload() {
        Payload::Labels => Some(1u32 << layout.block_log2),
        Payload::Tiles => archive.holds_labels()?.then_some(1),
    };
    let payload = if label_size.is_some() { "labels" } else { "texels" };
    let mut survey = Survey::default();
    let mut regions = archive.index.regions() as usize;
    if archive.index.payload() == Payload::Labels {
        let image = files::read_image(&args.input)?.0;
        survey.add(&image);
        regions = image.regions.len();
    } else {
        survey::level(&mut survey, &mut archive, 0, |_, tile| tile.map(|_| ()))?;
    }
    let Survey { violations, seams, .. } = survey;
    let (tiles, parts) = parts(&mut archive)?;
    let head = archive.index.directory_bytes();
    if args.json {
        let mut by_part = serde_json::Map::new();
        by_part.insert("head".into(), head.into());
        by_part.extend(parts.iter().map(|part| (part.name.into(), part.bytes.into())));
        tell!(
            "{}",
            json!({
                "size": layout.size,
                "payload": payload,
                // null where it is texels.
                "label_size": label_size,
                "regions": regions,
                // By colour.
                "names": names.iter().map(|(color, name)| (hex(color), name)).collect::<BTreeMap<_, _>>(),
                "nodes": survey.nodes,
                "ghosts": survey.ghosts,
                "edges": survey.edges,
                "faces": survey.faces,
                "texel_size": survey.texel_sizes,
                "scalars": survey.scalars,
                "kernel": layout.kernel.name(),
                "gamma": layout.gamma.name(),
                "tiles": tiles,
                "levels": layout.levels,
                // Of a tile, in pixels of its level; null where one shows all.
                "tile_size": (tiles > 1).then(|| 1u32 << layout.tile_log2),
                "violations": violations,
                // null where the file does not say.
                "violations_before_repair": notes.violations_before,
                "seams": seams,
                "bytes": archive.length,
                "bytes_by_part": by_part,
            })
        )?;
        return Ok(());
    }
    let [width, height] = layout.size;
    let sizes: Vec<String> = survey.texel_sizes.iter().map(u32::to_string).collect();
    tell!("size        {width}×{height} pixels")?;
    tell!(
        "payload     {payload}{}",
        match label_size {
            None => String::new(),
            Some(1) => ": one for each pixel; what follows is drawn from them".into(),
            Some(n) => format!(": one for {n}×{n} pixels; what follows is fitted to them"),
        }
    )?;
    match names.len() {
        0 => tell!("regions     {regions}")?,
        n => tell!("regions     {regions}, names for {n} of their colours (--json has them)")?,
    }
    tell!(
        "complex     {} nodes ({} of them ghosts), {} edges, {} faces",
        survey.nodes,
        survey.ghosts,
        survey.edges,
        survey.faces
    )?;
    tell!(
        "texel size  {}",
        if sizes.is_empty() { "none: all solid".into() } else { sizes.join(", ") }
    )?;
    tell!("scalars     {}", survey.scalars)?;
    tell!("kernel      {}", layout.kernel.name())?;
    tell!("gamma       {}", layout.gamma.name())?;
    match tiles {
        1 => tell!("tiles       1, levels 1")?,
        _ => tell!(
            "tiles       {tiles} of {0}×{0} pixels in {1} levels; what is counted is the finest's, on borders \
             in each tile",
            1u32 << layout.tile_log2,
            layout.levels
        )?,
    }
    match notes.violations_before {
        Some(before) => tell!("violations  {violations}, before repair {before}")?,
        None => tell!("violations  {violations}")?,
    }
    tell!("seams       {seams}")?;
    tell!("bytes       {}", archive.length)?;
    tell!("  {:<14}  {head}", "head")?;
    for Part { name, bytes } in &parts {
        tell!("  {name:<14}  {bytes}")?;
    }
    Ok(())
}

/// A colour as `--names` takes it.
fn hex([r, g, b, a]: [u8; 4]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}{a:02x}")
}

/// The number of tiles, and the bytes of their parts, of each kind in all.
fn parts(archive: &mut Archive) -> Result<(u64, Vec<Part>), String> {
    let mut tiles = 0;
    let mut sums: Vec<Part> = Vec::new();
    for tile in archive.index.layout().clone().tiles() {
        let Some(bytes) = archive.tile_bytes(tile)? else { continue };
        tiles += 1;
        let parts = container::parts(&archive.index, &bytes);
        for part in parts.map_err(|error| archive.at(&error))? {
            match sums.iter_mut().find(|sum| sum.name == part.name) {
                Some(sum) => sum.bytes += part.bytes,
                None => sums.push(part),
            }
        }
    }
    Ok((tiles, sums))
}
