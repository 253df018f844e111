//! `istar decode`

use crate::render::draw_cpu;
use crate::{Outcome, files, pictures};
use clap::ValueEnum;
use istar::grid::Point;
use istar::{Camera, Limits, raster};
use std::path::PathBuf;

/// Decode to a PNG of the whole picture
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
    /// Where to write the PNG
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Width in pixels; the height follows [default: the source's]
    #[arg(long, value_name = "W", value_parser = clap::value_parser!(u32).range(1..))]
    width: Option<u32>,
    /// Let the middle of each pixel decide, without blending
    #[arg(long)]
    no_antialias: bool,
    /// What the pixels mean
    #[arg(long, value_enum, default_value_t = What::Color)]
    what: What,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum What {
    /// Each region's colour
    Color,
    /// Each region's number + 1 in 16-bit grey; 0 is none
    Regions,
}

pub fn run(args: &Args) -> Outcome {
    let output = files::Output::create(&args.output)?;
    // At its own size the pixels that it was made from are wanted; at others, smooth boundaries.
    let (mut image, _) = files::read_exact(&args.input)?;
    if args.width.is_some_and(|width| width != image.size[0]) {
        image = files::read_image(&args.input)?.0;
    }
    let width = args.width.unwrap_or(image.size[0]);
    let scale = f64::from(width) / f64::from(image.size[0]);
    let height = (f64::from(image.size[1]) * scale).round().max(1.0) as u32;
    Limits::default().check_size([width, height]).map_err(|error| error.to_string())?;
    let mut camera = Camera::new(image.size, [width, height]);
    camera.look_at(Point::new(image.size.map(|n| 0.5 * f64::from(n))), scale);

    let png = match args.what {
        What::Color => {
            let pixels = draw_cpu(&image, &camera, !args.no_antialias);
            pictures::write_png([width, height], &pixels)?
        }
        What::Regions => {
            if image.regions.len() >= usize::from(u16::MAX) {
                return Err(format!(
                    "{}: {} regions do not fit 16 bits: decode --what color",
                    args.input.display(),
                    image.regions.len()
                ));
            }
            let label = |x: u32, y: u32| {
                let point = camera.to_source([f64::from(x) + 0.5, f64::from(y) + 0.5]);
                raster::region_at(&image, &point).map_or(0, |region| region as u16 + 1)
            };
            let labels: Vec<u16> = (0..height)
                .flat_map(|y| (0..width).map(move |x| (x, y)))
                .map(|(x, y)| label(x, y))
                .collect();
            pictures::write_png_labels([width, height], &labels)?
        }
    };
    output.finish(&png)
}
