//! `istar merge`

use crate::archive::Archive;
use crate::tell::tell;
use crate::{Outcome, files};
use istar::container::{self, Payload, TiledWriter};
use std::io::Write;
use std::path::PathBuf;

/// Join the shards of one picture, as `encode --shard` makes them
#[derive(clap::Args)]
pub struct Args {
    /// The shards, in any order
    #[arg(value_name = "SHARD.istar", required = true)]
    shards: Vec<PathBuf>,
    /// Where to write the .istar file
    #[arg(short, long, value_name = "OUT.istar")]
    output: PathBuf,
}

pub fn run(args: &Args) -> Outcome {
    let output = files::Output::create(&args.output)?;
    let mut shards: Vec<Archive> =
        args.shards.iter().map(|path| Archive::open(path)).collect::<Result<_, _>>()?;
    let Some(first) = shards.first() else { return Ok(()) };
    let layout = first.index.layout().clone();
    for shard in &shards {
        shard.check_length()?;
        if shard.index.payload() != Payload::Tiles {
            return Err(shard.at(&"it holds labels in one tile: there is nothing to merge"));
        }
        if *shard.index.layout() != layout {
            return Err(shard.at(&"it is of another picture than the first, or cut otherwise"));
        }
    }
    let notes = container::notes(&shards[0].index).map_err(|error| shards[0].at(&error))?;
    let names = container::names(&shards[0].index).map_err(|error| shards[0].at(&error))?;
    let regions = shards.iter().map(|shard| shard.index.regions()).max().unwrap_or(0);
    let mut writer = TiledWriter::new(layout.clone()).map_err(|error| error.to_string())?;
    let unwritable = |error| format!("cannot write a temporary file: {}", files::reason(&error));
    let mut spool = output.spool()?;
    let (mut tiles, mut missing) = (0u64, 0u64);
    for tile in layout.tiles() {
        let mut found: Option<Vec<u8>> = None;
        for shard in &mut shards {
            match (shard.tile_bytes(tile)?, &found) {
                (Some(bytes), Some(before)) if bytes != *before => {
                    return Err(shard.at(&format!("{tile} differs from that of another shard")));
                }
                (Some(bytes), None) => found = Some(bytes),
                _ => {}
            }
        }
        let Some(bytes) = found else {
            missing += 1;
            continue;
        };
        tiles += 1;
        spool.write_all(&bytes).map_err(unwritable)?;
        writer.add(tile, &bytes).map_err(|error| error.to_string())?;
    }
    let mut assembly = writer.finish(regions, &notes).map_err(|error| error.to_string())?;
    assembly.set_names(&names).map_err(|error| error.to_string())?;
    let bytes = assembly.length();
    output.finish_with(|file| assembly.write(&mut spool, file))?;
    let left = match missing {
        0 => String::new(),
        n => format!("; {n} are still missing"),
    };
    tell!("{}: {tiles} tiles{left}, {bytes} bytes", args.output.display())
}
