//! `istar info`

use crate::tell::tell;
use crate::{Outcome, files};
use istar::model::Block;
use istar::{Image, container, embed, fit, raster};
use serde_json::json;
use std::collections::BTreeSet;
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
    let (image, bytes) = files::read_image(&args.input)?;
    let parts = container::parts(&bytes).map_err(|error| files::at(&args.input, &error))?;
    let notes = container::notes(&bytes).map_err(|error| files::at(&args.input, &error))?;
    let label_size =
        container::label_size(&bytes).map_err(|error| files::at(&args.input, &error))?;
    let payload = if label_size.is_some() { "labels" } else { "texels" };
    let sizes = texel_sizes(&image);
    let violations = embed::model_violations(&image);
    let seams = raster::seams(&image);
    let head = bytes.len() - parts.iter().map(|part| part.stored as usize).sum::<usize>();
    if args.json {
        let mut by_part = serde_json::Map::new();
        by_part.insert("head".into(), head.into());
        by_part.extend(parts.iter().map(|part| (part.name(), part.stored.into())));
        tell!(
            "{}",
            json!({
                "size": image.size,
                "payload": payload,
                // null where it is texels.
                "label_size": label_size,
                "regions": image.regions.len(),
                "nodes": image.nodes.len(),
                "ghosts": image.ghosts().len(),
                "edges": image.edges.len(),
                "faces": image.faces.len(),
                "texel_size": sizes,
                "scalars": fit::scalars(&image),
                "kernel": image.kernel.name(),
                "gamma": image.gamma.name(),
                "tiles": 1,
                "levels": 1,
                "violations": violations,
                // null where the file does not say.
                "violations_before_repair": notes.violations_before,
                "seams": seams,
                "bytes": bytes.len(),
                "bytes_by_part": by_part,
            })
        )?;
        return Ok(());
    }
    let [width, height] = image.size;
    let sizes: Vec<String> = sizes.iter().map(u32::to_string).collect();
    tell!("size        {width}×{height} pixels")?;
    tell!(
        "payload     {payload}{}",
        match label_size {
            None => String::new(),
            Some(1) => ": one for each pixel; what follows is fitted to them".into(),
            Some(n) => format!(": one for {n}×{n} pixels; what follows is fitted to them"),
        }
    )?;
    tell!("regions     {}", image.regions.len())?;
    tell!(
        "complex     {} nodes ({} of them ghosts), {} edges, {} faces",
        image.nodes.len(),
        image.ghosts().len(),
        image.edges.len(),
        image.faces.len()
    )?;
    tell!(
        "texel size  {}",
        if sizes.is_empty() { "none: all solid".into() } else { sizes.join(", ") }
    )?;
    tell!("scalars     {}", fit::scalars(&image))?;
    tell!("kernel      {}", image.kernel.name())?;
    tell!("gamma       {}", image.gamma.name())?;
    tell!("tiles       1, levels 1")?;
    match notes.violations_before {
        Some(before) => tell!("violations  {violations}, before repair {before}")?,
        None => tell!("violations  {violations}")?,
    }
    tell!("seams       {seams}")?;
    tell!("bytes       {}", bytes.len())?;
    tell!("  head      {head}")?;
    for part in &parts {
        tell!("  {}      {}", part.name(), part.stored)?;
    }
    Ok(())
}

/// The texel sizes in use, smallest first.
pub fn texel_sizes(image: &Image) -> BTreeSet<u32> {
    let size = |block: &Block<3>| match block {
        Block::Solid(_) => None,
        Block::Cells(cells) => Some(1 << cells.texel_log2),
    };
    image.blocks.iter().filter_map(size).collect()
}
