//! `istar decode`

use crate::archive::Archive;
use crate::render::{self, Look, bands, draw_cpu, draw_tiles};
use crate::vectors::{self, Subject};
use crate::{Outcome, files, pictures};
use clap::ValueEnum;
use istar::container::{self, Payload};
use istar::grid::Point;
use istar::model::RegionId;
use istar::raster::Painter;
use istar::style::Styles;
use istar::{Camera, Image, Limits, raster};
use std::path::PathBuf;

/// Decode the whole picture to a PNG, or as lines and areas to an SVG, PDF or EPS
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
    /// Where to write the PNG, or an .svg, .pdf or .eps
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
    #[command(flatten)]
    lines: vectors::LineArgs,
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
    let mut archive = Archive::open(&args.input)?;
    archive.check_length()?;
    let size = archive.index.layout().size;
    let width = args.width.unwrap_or(size[0]);
    let scale = f64::from(width) / f64::from(size[0]);
    let height = (f64::from(size[1]) * scale).round().max(1.0) as u32;
    Limits::default().check_size([width, height]).map_err(|error| error.to_string())?;
    let mut camera = Camera::new(size, [width, height]);
    camera.look_at(Point::new(size.map(|n| 0.5 * f64::from(n))), scale);
    if let Some(format) = vectors::format_of(&args.output) {
        vectors::refuse(args.no_antialias, "--no-antialias", &args.output)?;
        vectors::refuse(args.what == What::Regions, "--what regions", &args.output)?;
        let section = render::whole(files::read_image(&args.input)?.0);
        let names = container::names(&archive.index).map_err(|error| archive.at(&error))?;
        let styles = Styles::new(&section.image);
        let subject =
            Subject { input: &args.input, section: &section, styles: &styles, names: &names };
        return output.finish(&vectors::draw(&args.lines, format, &subject, &camera)?);
    }
    args.lines.check(&args.output)?;
    let png = match archive.index.payload() {
        Payload::Tiles => {
            // At its own size the pixels that it was made from are wanted; at others, smooth boundaries.
            let antialias = !args.no_antialias && (width != size[0] || !archive.holds_labels()?);
            tiles(args, archive, &camera, antialias)?
        }
        Payload::Labels if width == size[0] => {
            whole(args, &files::read_exact(&args.input)?.0, &camera)?
        }
        Payload::Labels => whole(args, &files::read_image(&args.input)?.0, &camera)?,
    };
    output.finish(&png)
}

fn whole(args: &Args, image: &Image, camera: &Camera) -> Result<Vec<u8>, String> {
    match args.what {
        What::Color => {
            let pixels = draw_cpu(&Painter::new(image), camera, !args.no_antialias);
            pictures::write_png(camera.viewport(), &pixels)
        }
        What::Regions => {
            check_regions(args, image.regions.len())?;
            let numbers: Vec<u16> = numbers(image, camera, |region| region);
            pictures::write_png_labels(camera.viewport(), &numbers)
        }
    }
}

fn tiles(
    args: &Args,
    mut archive: Archive,
    camera: &Camera,
    antialias: bool,
) -> Result<Vec<u8>, String> {
    match args.what {
        What::Color => {
            let look = Look { antialias, sheet: None, absorbed: Vec::new() };
            let pixels = draw_tiles(&mut archive, camera, &look)?;
            pictures::write_png(camera.viewport(), &pixels)
        }
        What::Regions => {
            check_regions(args, archive.index.regions() as usize)?;
            let mut all = Vec::new();
            for band in bands(&archive, camera) {
                let section = archive.view(&band)?;
                let camera = section.camera(&band);
                all.extend(numbers(&section.image, &camera, |own| section.regions[own as usize]));
            }
            pictures::write_png_labels(camera.viewport(), &all)
        }
    }
}

fn check_regions(args: &Args, regions: usize) -> Result<(), String> {
    if regions < usize::from(u16::MAX) {
        return Ok(());
    }
    let name = args.input.display();
    Err(format!("{name}: {regions} regions do not fit 16 bits: decode --what color"))
}

/// For each pixel of a view 1 more than the number of its region, 0 beside the picture.
fn numbers(image: &Image, camera: &Camera, number: impl Fn(RegionId) -> RegionId) -> Vec<u16> {
    let [width, height] = camera.viewport();
    let label = |x: u32, y: u32| {
        let point = camera.to_source([f64::from(x) + 0.5, f64::from(y) + 0.5]);
        raster::region_at(image, &point).map_or(0, |region| number(region) as u16 + 1)
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| label(x, y)).collect()
}
