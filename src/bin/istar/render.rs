//! `istar render`

use crate::archive::{Archive, Section};
use crate::styles::{Absorbed, Sheet};
use crate::vectors::{self, Subject};
use crate::{Outcome, files, pictures, progress};
use clap::ValueEnum;
use istar::container::{self, Payload};
use istar::grid::Point;
use istar::model::RegionId;
use istar::raster::Painter;
use istar::style::Styles;
use istar::{Camera, Image, Limits, MAX_SCALE};
use rayon::prelude::*;
use std::path::PathBuf;

/// Draw one view of a picture to a PNG, or as lines and areas to an SVG, PDF or EPS
#[derive(clap::Args)]
pub struct Args {
    /// The .istar file
    #[arg(value_name = "IN.istar")]
    input: PathBuf,
    /// Where to write the PNG, or an .svg, .pdf or .eps, whose unit is a pixel of the screen
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// The source pixel in the middle, e.g. 1200.5,800.25
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true)]
    center: Point<2>,
    /// Screen pixels per source pixel
    #[arg(long, value_name = "S", value_parser = parse_scale)]
    scale: f64,
    /// Screen pixels, e.g. 800x600
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    size: [u32; 2],
    /// Degrees by which the picture is turned, clockwise
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true)]
    rotate: f64,
    /// Mirror the picture, left to right, before it is turned
    #[arg(long)]
    flip: bool,
    /// What draws it
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
    /// Let the middle of each pixel decide, without blending
    #[arg(long)]
    no_antialias: bool,
    /// How regions are drawn: colours, outlines, patterns, what is hidden
    #[arg(long, value_name = "STYLE.json")]
    style: Option<PathBuf>,
    #[command(flatten)]
    lines: vectors::LineArgs,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Backend {
    /// No graphics card needed
    Cpu,
    /// The shaders that the viewer runs
    Gpu,
}

pub fn run(args: &Args) -> Outcome {
    let sheet = args.style.as_deref().map(Sheet::read).transpose()?;
    let output = files::Output::create(&args.output)?;
    let mut archive = Archive::open(&args.input)?;
    archive.check_length()?;
    let size = archive.index.layout().size;
    let mut camera = Camera::new(size, args.size);
    camera.look_at(args.center, args.scale);
    if !args.rotate.is_finite() {
        return Err(format!("--rotate {}: that is no number of degrees", args.rotate));
    }
    camera.turn(args.rotate, args.flip, args.size.map(|n| 0.5 * f64::from(n)));
    let absorbed = match &sheet {
        Some(sheet) if sheet.absorbs() => archive.coarsest()?,
        _ => None,
    };
    let absorbed = absorbed
        .zip(sheet.as_ref())
        .map_or_else(Vec::new, |(section, sheet)| sheet.absorbed(&section.image, &section.regions));
    let look = Look { antialias: !args.no_antialias, sheet, absorbed };
    if let Some(format) = vectors::format_of(&args.output) {
        vectors::refuse(args.no_antialias, "--no-antialias", &args.output)?;
        vectors::refuse(args.backend == Backend::Gpu, "--backend gpu", &args.output)?;
        let section = match archive.index.payload() {
            Payload::Labels => whole(files::read_image(&args.input)?.0),
            Payload::Tiles => archive.view(&camera)?,
        };
        let names = container::names(&archive.index).map_err(|error| archive.at(&error))?;
        let (camera, styles) = (section.camera(&camera), look.styles(&section));
        let subject =
            Subject { input: &args.input, section: &section, styles: &styles, names: &names };
        return output.finish(&vectors::draw(&args.lines, format, &subject, &camera)?);
    }
    args.lines.check(&args.output)?;
    let pixels = if archive.index.payload() == Payload::Labels || args.backend == Backend::Gpu {
        let section = match archive.index.payload() {
            Payload::Labels => whole(files::read_image(&args.input)?.0),
            Payload::Tiles => archive.view(&camera)?,
        };
        let camera = section.camera(&camera);
        let styles = look.styles(&section);
        match args.backend {
            Backend::Cpu => {
                draw_cpu(&Painter::with_styles(&section.image, styles), &camera, look.antialias)
            }
            Backend::Gpu => draw_gpu(&section.image, &styles, &camera, look.antialias)?,
        }
    } else {
        draw_tiles(&mut archive, &camera, &look)?
    };
    output.finish(&pictures::write_png(args.size, &pixels)?)
}

/// How a picture is drawn.
pub struct Look {
    /// Blend across boundaries.
    pub antialias: bool,
    /// Without, as the file has it.
    pub sheet: Option<Sheet>,
    /// Regions that others absorb, as the coarsest level tells: so all views of a picture agree, but for what is too small
    /// to be seen there.
    pub absorbed: Vec<Absorbed>,
}

impl Look {
    fn styles(&self, section: &Section) -> Styles {
        match &self.sheet {
            None => Styles::new(&section.image),
            Some(sheet) => {
                sheet.styles(&section.image, &section.regions, section.step(), &self.absorbed)
            }
        }
    }
}

/// A picture that is all there is, as a section of its own.
pub fn whole(image: Image) -> Section {
    let regions = (0..image.regions.len() as RegionId).collect();
    Section { level: 0, first: [0; 2], image, regions }
}

/// Rows of a view that are drawn at a time, where the tiles of all are too many to be held at once.
const BAND: u32 = 256;
/// Tiles that are.
const MOST_AT_ONCE: usize = 64;
/// Rows that one core draws at a time.
const ROWS_AT_ONCE: u32 = 128;

/// Draws a view of a file of texels, with no more of its tiles in memory than a band of the view needs.
pub fn draw_tiles(
    archive: &mut Archive,
    camera: &Camera,
    look: &Look,
) -> Result<Vec<[u8; 4]>, String> {
    let mut pixels = Vec::with_capacity(istar::grid::count(camera.viewport()));
    for band in bands(archive, camera) {
        let section = archive.view(&band)?;
        let painter = Painter::with_styles(&section.image, look.styles(&section));
        pixels.extend(draw_cpu(&painter, &section.camera(&band), look.antialias));
    }
    Ok(pixels)
}

/// The views of the rows of another, from above, each on not too many tiles.
pub fn bands(archive: &Archive, camera: &Camera) -> Vec<Camera> {
    let [width, height] = camera.viewport();
    if archive.tiles_in_view(camera) <= MOST_AT_ONCE {
        return vec![camera.clone()];
    }
    let band = |from: u32| {
        let rows = BAND.min(height - from);
        let mut band = camera.clone();
        band.resize([width, rows]);
        let middle = f64::from(from) + 0.5 * f64::from(rows);
        let center = camera.to_source([0.5 * f64::from(width), middle]);
        band.look_at(center, camera.scale());
        band
    };
    (0..height).step_by(BAND as usize).map(band).collect()
}

/// Draws a view on all cores.
pub fn draw_cpu(painter: &Painter<'_>, camera: &Camera, antialias: bool) -> Vec<[u8; 4]> {
    let [width, height] = camera.viewport();
    let bar = progress::rows(height);
    let mut pixels = vec![[0; 4]; istar::grid::count([width, height])];
    // A cell is looked at once a band.
    let band = (width as usize * ROWS_AT_ONCE as usize).max(1);
    let bands = pixels.par_chunks_mut(band).enumerate();
    bands.for_each(|(band, rows)| {
        painter.draw(camera, band as u32 * ROWS_AT_ONCE, antialias, rows);
        bar.inc(u64::from(ROWS_AT_ONCE));
    });
    bar.finish_and_clear();
    pixels
}

#[cfg(feature = "gpu")]
fn draw_gpu(
    image: &Image,
    styles: &Styles,
    camera: &Camera,
    antialias: bool,
) -> Result<Vec<[u8; 4]>, String> {
    istar::gpu::render(image, styles, camera, antialias).map_err(|error| error.to_string())
}

#[cfg(not(feature = "gpu"))]
fn draw_gpu(_: &Image, _: &Styles, _: &Camera, _: bool) -> Result<Vec<[u8; 4]>, String> {
    Err("this istar was built without GPU support: build it with --features cli,gpu, or take \
         --backend cpu"
        .into())
}

fn parse_scale(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(scale) if scale > 0.0 && scale <= MAX_SCALE => Ok(scale),
        _ => Err(format!("a number above 0 and up to {MAX_SCALE}")),
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) =
        text.split_once(['x', '×']).ok_or("two numbers with an x, e.g. 800x600")?;
    let side = |text: &str| text.trim().parse().map_err(|_| format!("“{text}” is not a size"));
    let size = [side(width)?, side(height)?];
    Limits::default().check_size(size).map_err(|error| error.to_string())?;
    Ok(size)
}
