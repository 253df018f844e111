//! `istar compare`

use crate::{Outcome, files, pictures, progress};
use istar::Limits;
use serde_json::json;
use std::path::PathBuf;

/// Compare a file with the picture it was made from
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
    /// The original PNG
    #[arg(value_name = "ORIGINAL.png")]
    original: PathBuf,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Outcome {
    let stages = progress::Stages::new();
    stages.set("reading");
    let (image, bytes) = files::read_image(&args.input)?;
    let source = pictures::read_source(&args.original, &Limits::default())?;
    stages.set("comparing");
    let result = istar::compare(&image, &source).map_err(|error| files::at(&args.input, &error))?;
    drop(stages);

    let ratio = 3.0 * result.pixels as f64 / bytes.len() as f64;
    let wrong = result.wrong_pixels as f64 / result.pixels as f64;
    if args.json {
        let boundary = result.boundary_error.map(|e| json!({ "mean": e.mean, "p95": e.p95 }));
        println!(
            "{}",
            json!({
                "bytes": bytes.len(),
                "ratio": ratio,
                // JSON has no infinity: null says that nothing differs.
                "psnr": result.psnr.is_finite().then_some(result.psnr),
                "wrong_pixels": wrong,
                "boundary_error_px": boundary,
                "lost_regions": result.lost_regions,
            })
        );
        return Ok(());
    }
    println!("bytes           {} ({ratio:.0} : 1 against raw RGB)", bytes.len());
    println!("psnr            {:.2} dB", result.psnr);
    println!("wrong pixels    {:.3} % ({})", 100.0 * wrong, result.wrong_pixels);
    println!("lost regions    {}", result.lost_regions);
    if let Some(error) = result.boundary_error {
        println!("boundary error  {:.2} px mean, {:.2} px at 95 %", error.mean, error.p95);
    }
    Ok(())
}
