//! Pictures whose edges are antialiased: pixels that a boundary passes through hold a mixture of the
//! colours on its two sides. Each belongs to the region that covers more of it, and how much more
//! tells where within the pixel the boundary lies.
//!
//! Colours are mixed as they are stored, multiplied by their opacity, as drawing programs do it.

use super::Source;
use crate::error::Result;
use crate::grid;
use crate::limits::Limits;
use rayon::prelude::*;
use std::collections::HashMap;

/// How far around a pixel the colours are looked for that it may be a mixture of, in pixels: those
/// nearest to it first.
const REACHES: [i64; 3] = [1, 2, 3];
/// How far a pixel's colour may be from a mixture, in steps of a byte: what rounding leaves; what more
/// than two colours in a pixel leave, where nothing nearer explains it.
const ROUNDED: f32 = 3.0;
const ROUGH: f32 = 24.0;
/// Colours at most that strokes too thin to show theirs may have, and the sure pixels that it takes to
/// count as one.
const PALETTE: usize = 256;
const LEAST_COUNT: u32 = 16;
/// The least change of coverage across a pixel at which a boundary has a direction; along a straight
/// one it is at least twice that. Less of it is left where another boundary is near.
const LEAST_SLOPE: f32 = 0.25;

/// A colour multiplied by its opacity, in steps of a byte.
type Mixable = [f32; 4];

/// A pixel that a boundary passes through.
#[derive(Debug, Clone, Copy)]
struct Mixed {
    x: u32,
    /// The class that covers more of it, and the other.
    classes: [u32; 2],
    /// The first's part of it; none where that is not known well enough to tell where the boundary is.
    part: Option<f32>,
}

/// What the colours of a picture say.
struct Fringes<'a> {
    size: [u32; 2],
    colors: &'a [[u8; 4]],
    /// Whether a pixel is in a square of two by two of one colour: that is not a mixture.
    sure: Vec<bool>,
}

/// Rows of a picture that are looked at to tell whether its edges are antialiased.
const ROWS: usize = 256;
/// The greatest part of a mixture that shows that it is one.
const MOST: f32 = 0.98;
/// Mixtures at least, and how many of the pixels that could be some.
const LEAST_MIXED: usize = 8;
const LEAST_SHARE: f64 = 0.5;

impl Source<2> {
    /// A picture of straight RGBA colours: [`from_antialiased`](Self::from_antialiased) where most of what
    /// is not in a flat area is a mixture of the flat colours around it, else
    /// [`from_colors`](Self::from_colors).
    ///
    /// # Errors
    /// As [`from_colors`](Self::from_colors).
    pub fn from_picture(size: [u32; 2], colors: &[[u8; 4]], limits: &Limits) -> Result<Source<2>> {
        limits.check_size(size)?;
        if colors.len() == grid::count(size) && Fringes::new(size, colors).are_antialiased() {
            return Self::from_antialiased(size, colors, limits);
        }
        Self::from_colors(size, colors, limits)
    }

    /// A picture of straight RGBA colours with antialiased edges: pixels of mixed colours belong to the
    /// region that covers more of them, and the source's [`distances`](Self::distances) tell where
    /// boundaries lie within pixels. What is no mixture of the colours around it is a class of its own.
    ///
    /// # Errors
    /// As [`from_colors`](Self::from_colors).
    pub fn from_antialiased(
        size: [u32; 2],
        colors: &[[u8; 4]],
        limits: &Limits,
    ) -> Result<Source<2>> {
        limits.check_size(size)?;
        if colors.len() != grid::count(size) {
            // Says what is wrong.
            return Self::from_colors(size, colors, limits);
        }
        // What is transparent is one class, whatever colour it hides.
        let shown = |&color: &[u8; 4]| if color[3] == 0 { [0; 4] } else { color };
        let colors: Vec<[u8; 4]> = colors.par_iter().map(shown).collect();
        let mixed = Fringes::new(size, &colors).mixed();
        let mut settled = colors;
        settled.par_chunks_mut(size[0] as usize).zip(&mixed).for_each(|(row, mixed)| {
            mixed.iter().for_each(|m| row[m.x as usize] = m.classes[0].to_le_bytes());
        });
        let distances = distances(size, &settled, &mixed);
        Self::from_colors(size, &settled, limits)?.with_distances(distances)
    }
}

impl<'a> Fringes<'a> {
    fn new(size: [u32; 2], colors: &'a [[u8; 4]]) -> Self {
        let [width, height] = size.map(|along| along as usize);
        let mut sure = vec![false; colors.len()];
        sure.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for top in y.saturating_sub(1)..=y {
                let Some(below) = colors.get((top + 1) * width..(top + 2) * width) else { break };
                let above = &colors[top * width..][..width];
                for x in 1..width {
                    let color = above[x];
                    if above[x - 1] == color && below[x - 1] == color && below[x] == color {
                        (row[x - 1], row[x]) = (true, true);
                    }
                }
            }
        });
        debug_assert_eq!(height * width, colors.len());
        Fringes { size, colors, sure }
    }

    /// The pixels of each row that hold mixtures, from left to right.
    fn mixed(&self) -> Vec<Vec<Mixed>> {
        let palette = self.palette();
        let [width, height] = self.size;
        (0..height)
            .into_par_iter()
            .map(|y| {
                let unsure = (0..width).filter(|&x| !self.sure[self.index([x, y])]);
                unsure.filter_map(|x| self.mixture([x, y], &palette)).collect()
            })
            .collect()
    }

    /// Whether most pixels that could be mixtures are, in some rows.
    fn are_antialiased(&self) -> bool {
        let palette = self.palette();
        let [width, height] = self.size;
        let step = (height as usize).div_ceil(ROWS).max(1);
        let rows: Vec<u32> = (0..height).step_by(step).collect();
        let count = |&y: &u32| {
            let unsure = (0..width).map(|x| [x, y]).filter(|&at| !self.sure[self.index(at)]);
            unsure.fold((0, 0), |(mixed, all), at| {
                let has_its_color = palette.contains(&self.colors[self.index(at)]);
                let mixture = if has_its_color { None } else { self.mixture(at, &palette) };
                let is_mixed = mixture.is_some_and(|m| m.part.is_none_or(|part| part < MOST));
                (mixed + usize::from(is_mixed), all + 1)
            })
        };
        let (mixed, all) =
            rows.par_iter().map(count).reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        mixed >= LEAST_MIXED && mixed as f64 > LEAST_SHARE * all as f64
    }

    fn index(&self, at: [u32; 2]) -> usize {
        grid::index(self.size, at)
    }

    /// The colours that are sure and not rare, the most frequent first.
    fn palette(&self) -> Vec<[u8; 4]> {
        let width = self.size[0] as usize;
        let note = |counts: &mut HashMap<[u8; 4], u32>, (color, count)| {
            if count > 0 {
                *counts.entry(color).or_default() += count;
            }
        };
        let count = |(colors, sure): (&[[u8; 4]], &[bool])| {
            let mut counts: HashMap<[u8; 4], u32> = HashMap::new();
            let mut run = (colors[0], 0);
            for (&color, &sure) in colors.iter().zip(sure) {
                if color != run.0 {
                    note(&mut counts, run);
                    run = (color, 0);
                }
                run.1 += u32::from(sure);
            }
            note(&mut counts, run);
            counts
        };
        let rows = self.colors.par_chunks(width).zip(self.sure.par_chunks(width));
        let counts = rows.map(count).reduce(HashMap::new, |mut sum, counts| {
            counts.into_iter().for_each(|(color, count)| *sum.entry(color).or_default() += count);
            sum
        });
        let mut common: Vec<([u8; 4], u32)> =
            counts.into_iter().filter(|&(_, count)| count >= LEAST_COUNT).collect();
        common.sort_unstable_by_key(|&(color, count)| (std::cmp::Reverse(count), color));
        common.into_iter().take(PALETTE).map(|(color, _)| color).collect()
    }

    /// What a pixel is a mixture of; none where it is a colour of its own.
    fn mixture(&self, at: [u32; 2], palette: &[[u8; 4]]) -> Option<Mixed> {
        let color = self.colors[self.index(at)];
        let mut around: Vec<[u8; 4]> = Vec::new();
        let mut best: Option<Mixture> = None;
        for reach in REACHES {
            let known = around.len();
            for next in self.ring(at, reach) {
                let index = self.index(next);
                if self.sure[index] && !around.contains(&self.colors[index]) {
                    around.push(self.colors[index]);
                }
            }
            // One of the colours around it, and next to it: no mixture.
            if reach == 1 && around.contains(&color) {
                return None;
            }
            for (i, &b) in around.iter().enumerate().skip(known.max(1)) {
                for &a in &around[..i] {
                    best = Mixture::of(color, [a, b]).better(best);
                }
            }
            if let Some(best) = best.as_ref().filter(|best| best.residual <= ROUNDED) {
                return Some(best.at(at[0]));
            }
        }
        // A stroke too thin to show its colour, which the picture shows elsewhere.
        for &a in around.iter().take(2) {
            let farthest = self.farthest(at, a, color);
            for &q in palette.iter().filter(|&&q| q != a && !around.contains(&q)) {
                let mixture = Mixture::of(color, [a, q]);
                // It has the colour that comes next beyond all that is seen of it.
                if mixture.residual <= ROUNDED && Mixture::of(farthest, [q, a]).residual <= ROUNDED
                {
                    best = mixture.without_part().better(best);
                }
            }
        }
        let best = best.filter(|best| best.residual <= ROUGH)?;
        Some(if best.residual <= ROUNDED { best } else { best.without_part() }.at(at[0]))
    }

    /// The pixels at a distance, within the picture.
    fn ring(&self, at: [u32; 2], reach: i64) -> impl Iterator<Item = [u32; 2]> {
        let size = self.size;
        let offsets = (-reach..=reach).flat_map(move |y| (-reach..=reach).map(move |x| [x, y]));
        offsets.filter(move |by| by.iter().any(|along| along.abs() == reach)).filter_map(
            move |by| {
                let moved = [0, 1].map(|axis| i64::from(at[axis]) + by[axis]);
                let is_in = (0..2).all(|axis| (0..i64::from(size[axis])).contains(&moved[axis]));
                is_in.then(|| moved.map(|along| along as u32))
            },
        )
    }

    /// Of the pixels around, and `color` itself, the colour that is farthest from `a` on the way to
    /// `color` and beyond.
    fn farthest(&self, at: [u32; 2], a: [u8; 4], color: [u8; 4]) -> [u8; 4] {
        let (from, to) = (mixable(a), mixable(color));
        let along = |c: [u8; 4]| -> f32 {
            let c = mixable(c);
            (0..4).map(|e| (c[e] - from[e]) * (to[e] - from[e])).sum()
        };
        let near = (1..=2).flat_map(|reach| self.ring(at, reach));
        let colors = near.map(|next| self.colors[self.index(next)]);
        let on_the_way = colors.filter(|&c| Mixture::of(color, [a, c]).residual <= ROUNDED);
        on_the_way.chain([color]).max_by(|&a, &b| along(a).total_cmp(&along(b))).unwrap_or(color)
    }
}

/// A pixel as a mixture of two colours.
#[derive(Debug, Clone, Copy)]
struct Mixture {
    /// The one that there is more of, and the other.
    colors: [[u8; 4]; 2],
    part: f32,
    has_part: bool,
    /// How far it is from that, in steps of a byte.
    residual: f32,
}

impl Mixture {
    fn of(color: [u8; 4], [a, b]: [[u8; 4]; 2]) -> Self {
        let [c, from, to] = [color, b, a].map(mixable);
        let dot = |x: Mixable, y: Mixable| -> f32 { x.iter().zip(y).map(|(x, y)| x * y).sum() };
        let minus = |x: Mixable, y: Mixable| -> Mixable { std::array::from_fn(|e| x[e] - y[e]) };
        let (whole, here) = (minus(to, from), minus(c, from));
        let part = (dot(here, whole) / dot(whole, whole).max(1.0)).clamp(0.0, 1.0);
        let rest: Mixable = std::array::from_fn(|e| here[e] - part * whole[e]);
        let residual = dot(rest, rest).sqrt();
        let (colors, part) = if part >= 0.5 { ([a, b], part) } else { ([b, a], 1.0 - part) };
        Mixture { colors, part, has_part: true, residual }
    }

    fn without_part(self) -> Self {
        Mixture { has_part: false, ..self }
    }

    /// This, or the one found before where that explains as much.
    fn better(self, before: Option<Self>) -> Option<Self> {
        Some(before.filter(|before| before.residual <= self.residual).unwrap_or(self))
    }

    fn at(self, x: u32) -> Mixed {
        Mixed {
            x,
            classes: self.colors.map(u32::from_le_bytes),
            part: self.has_part.then_some(self.part),
        }
    }
}

fn mixable([r, g, b, a]: [u8; 4]) -> Mixable {
    let opacity = f32::from(a) / 255.0;
    [f32::from(r) * opacity, f32::from(g) * opacity, f32::from(b) * opacity, f32::from(a)]
}

/// How far the middle of each pixel is from the boundary of its region, in pixels: in pixels of mixed
/// colours and those beside them, where a straight boundary explains them, and half a pixel where two
/// colours meet unmixed; else NaN.
fn distances(size: [u32; 2], settled: &[[u8; 4]], mixed: &[Vec<Mixed>]) -> Vec<f32> {
    let cuts = Cuts { size, settled, mixed };
    let lines: Vec<Vec<Option<Line>>> = (0..size[1])
        .into_par_iter()
        .map(|y| mixed[y as usize].iter().map(|pixel| cuts.line(y, pixel)).collect())
        .collect();
    let mut distances = vec![f32::NAN; settled.len()];
    distances.par_chunks_mut(size[0] as usize).zip(0..size[1]).for_each(|(row, y)| {
        for (x, distance) in (0..).zip(row) {
            *distance = cuts.distance([x, y], &lines).unwrap_or(f32::NAN);
        }
    });
    distances
}

/// A straight boundary through a pixel: n · x = 0, with x from the pixel's middle.
#[derive(Debug, Clone, Copy)]
struct Line {
    /// Towards the class that covers more of the pixel, of length 1.
    normal: [f32; 2],
    /// How far the pixel's middle is from it, in pixels.
    distance: f32,
}

struct Cuts<'a> {
    size: [u32; 2],
    settled: &'a [[u8; 4]],
    mixed: &'a [Vec<Mixed>],
}

impl Cuts<'_> {
    fn class(&self, at: [u32; 2]) -> u32 {
        u32::from_le_bytes(self.settled[grid::index(self.size, at)])
    }

    fn find(&self, [x, y]: [u32; 2]) -> Option<usize> {
        self.mixed[y as usize].binary_search_by_key(&x, |pixel| pixel.x).ok()
    }

    /// A class's part of a pixel.
    fn part(&self, at: [u32; 2], class: u32) -> f32 {
        let mixed = self.find(at).map(|i| self.mixed[at[1] as usize][i]);
        match mixed {
            Some(Mixed { classes: [first, _], part: Some(part), .. }) if first == class => part,
            Some(Mixed { classes: [_, second], part: Some(part), .. }) if second == class => {
                1.0 - part
            }
            _ => f32::from(u8::from(self.class(at) == class)),
        }
    }

    fn line(&self, y: u32, pixel: &Mixed) -> Option<Line> {
        let part = pixel.part?;
        let at = |dx: i64, dy: i64| {
            let clamped = |along: u32, by: i64, axis: usize| {
                (i64::from(along) + by).clamp(0, i64::from(self.size[axis]) - 1) as u32
            };
            self.part([clamped(pixel.x, dx, 0), clamped(y, dy, 1)], pixel.classes[0])
        };
        let slope = |of: &dyn Fn(i64, i64) -> f32| {
            let side = |along: i64| of(along, -1) + 2.0 * of(along, 0) + of(along, 1);
            (side(1) - side(-1)) / 8.0
        };
        let slopes =
            [slope(&|along, across| at(along, across)), slope(&|along, across| at(across, along))];
        let steepness = (slopes[0] * slopes[0] + slopes[1] * slopes[1]).sqrt();
        if steepness < LEAST_SLOPE {
            return None;
        }
        let normal = slopes.map(|slope| slope / steepness);
        Some(Line { normal, distance: distance_of(part, normal) })
    }

    /// How far the middle of a pixel is from the boundary of its region, if it is near.
    fn distance(&self, at: [u32; 2], lines: &[Vec<Option<Line>>]) -> Option<f32> {
        if let Some(own) = self.find(at) {
            return lines[at[1] as usize][own].map(|line| line.distance);
        }
        let class = self.class(at);
        let (mut sum, mut count) = (0.0, 0.0);
        for by in [[-1i64, 0], [1, 0], [0, -1], [0, 1]] {
            let next = [0, 1].map(|axis| i64::from(at[axis]) + by[axis]);
            if (0..2).any(|axis| !(0..i64::from(self.size[axis])).contains(&next[axis])) {
                continue;
            }
            let next = next.map(|along| along as u32);
            let Some(mixed) = self.find(next) else {
                // The boundary lies between the two.
                if self.class(next) != class {
                    return Some(0.5);
                }
                continue;
            };
            let pixel = &self.mixed[next[1] as usize][mixed];
            let Some(line) = lines[next[1] as usize][mixed] else { continue };
            let Some(side) = pixel.classes.iter().position(|&c| c == class) else { continue };
            // From the middle of the next pixel to this one's.
            let step: f32 = (0..2).map(|axis| line.normal[axis] * -by[axis] as f32).sum();
            let signed = line.distance + step;
            let distance = if side == 0 { signed } else { -signed };
            // None of it is beyond the boundary.
            sum += distance.max(0.5);
            count += 1.0;
        }
        (count > 0.0).then(|| sum / count)
    }
}

/// How far a pixel's middle is from a straight boundary, beyond which less than half of the pixel lies.
fn distance_of(part: f32, normal: [f32; 2]) -> f32 {
    let [long, short] = {
        let [x, y] = normal.map(f32::abs);
        if x > y { [x, y] } else { [y, x] }
    };
    // The boundary meets opposite sides of the pixel, or cuts off a corner.
    let straight = (part - 0.5) * long;
    if straight <= 0.5 * (long - short) {
        return straight;
    }
    0.5 * (long + short) - (2.0 * long * short * (1.0 - part)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: u32 = 40;
    /// Distances of pixels that a boundary passes through, and of those beside them.
    const MIXED: std::ops::Range<f32> = 0.0..0.499;
    const BESIDE: std::ops::Range<f32> = 0.499..9.0;
    const BACK: [f32; 4] = [240.0, 230.0, 210.0, 255.0];
    const FRONT: [f32; 4] = [20.0, 60.0, 160.0, 255.0];

    /// A shape as an antialiased picture: the mean of 32 by 32 samples of each pixel.
    fn drawn(is_in: impl Fn(f32, f32) -> bool) -> Vec<[u8; 4]> {
        const SAMPLES: u32 = 32;
        let pixel = |[x, y]: [u32; 2]| {
            let places = grid::places([SAMPLES; 2]);
            let sample = |along: u32, s: u32| along as f32 + (s as f32 + 0.5) / SAMPLES as f32;
            let inside = places.filter(|s| is_in(sample(x, s[0]), sample(y, s[1]))).count();
            let part = inside as f32 / (SAMPLES * SAMPLES) as f32;
            std::array::from_fn(|c| (BACK[c] + part * (FRONT[c] - BACK[c])).round() as u8)
        };
        grid::places([SIDE; 2]).map(pixel).collect()
    }

    fn read(colors: &[[u8; 4]]) -> Source<2> {
        Source::from_antialiased([SIDE; 2], colors, &Limits::default()).unwrap()
    }

    /// The greatest error of the distances that are known, of those in a range, and how many there are.
    fn worst(
        source: &Source<2>,
        range: std::ops::Range<f32>,
        truth: impl Fn(f32, f32) -> f32,
    ) -> (f32, usize) {
        let known = source.distances().unwrap().iter().enumerate();
        // At the picture's rim half of what is around a pixel is not seen.
        let inner =
            |i: usize| grid::place([SIDE; 2], i).iter().all(|along| (2..SIDE - 2).contains(along));
        let known = known.filter(|&(i, distance)| inner(i) && range.contains(distance));
        known.fold((0.0, 0), |(worst, count), (i, &distance)| {
            let [x, y] = grid::place([SIDE; 2], i).map(|along| along as f32 + 0.5);
            (f32::max(worst, (distance - truth(x, y).abs()).abs()), count + 1)
        })
    }

    #[test]
    fn straight_edges_are_found_within_a_twentieth_of_a_pixel() {
        for degrees in 0..24 {
            let (sin, cos) = (degrees as f32 * 15.0 + 2.0).to_radians().sin_cos();
            let signed = |x: f32, y: f32| (x - 20.3) * cos + (y - 19.6) * sin;
            let source = read(&drawn(|x, y| signed(x, y) > 0.0));
            let classes = source.classes();
            for (i, at) in grid::places([SIDE; 2]).enumerate() {
                let inside = signed(at[0] as f32 + 0.5, at[1] as f32 + 0.5);
                let is_front = classes[i].to_le_bytes()[0] == FRONT[0] as u8;
                assert!(inside.abs() < 0.02 || is_front == (inside > 0.0), "{degrees} {at:?}");
            }
            let (inside, count) = worst(&source, MIXED, signed);
            assert!(inside < 0.06 && count >= 35, "{degrees}: {inside} of {count}");
            let (beside, _) = worst(&source, BESIDE, signed);
            assert!(beside < 0.17, "{degrees}: {beside}");
        }
    }

    #[test]
    fn discs_are_found_within_a_twentieth_of_a_pixel() {
        for (x0, y0, radius) in [(20.0, 20.0, 12.0), (19.3, 20.8, 7.5)] {
            let signed = |x: f32, y: f32| radius - (x - x0).hypot(y - y0);
            let source = read(&drawn(|x, y| signed(x, y) > 0.0));
            let (inside, count) = worst(&source, MIXED, signed);
            assert!(inside < 0.06 && count as f32 > 6.0 * radius, "{inside} of {count}");
            let (beside, _) = worst(&source, BESIDE, signed);
            assert!(beside < 0.11, "{beside}");
        }
    }

    #[test]
    fn antialiased_edges_are_told_from_others() {
        let disc = |x: f32, y: f32| 12.0 > (x - 20.3).hypot(y - 19.6);
        let drawn = drawn(disc);
        let is_antialiased = |size: [u32; 2], colors: &[[u8; 4]]| {
            let source = Source::from_picture(size, colors, &Limits::default());
            source.unwrap().distances().is_some()
        };
        assert!(is_antialiased([SIDE; 2], &drawn));
        let crisp: Vec<[u8; 4]> = grid::places([SIDE; 2])
            .map(|[x, y]| if disc(x as f32, y as f32) { [9, 9, 9, 255] } else { [200, 0, 0, 255] })
            .collect();
        assert!(!is_antialiased([SIDE; 2], &crisp));
        // A band of the colour between two others is a colour of its own.
        let band: Vec<[u8; 4]> = grid::places([SIDE; 2])
            .map(|[x, y]| [40 * (1 + (x + y / 3) / 10) as u8, 0, 0, 255])
            .collect();
        assert!(!is_antialiased([SIDE; 2], &band));
        let noise: Vec<[u8; 4]> = (0..SIDE * SIDE)
            .map(|i| i.wrapping_mul(2_654_435_761).to_be_bytes())
            .map(|[r, g, b, _]| [r, g, b, 255])
            .collect();
        assert!(!is_antialiased([SIDE; 2], &noise));
        assert!(!is_antialiased([1, 1], &[[1; 4]]));
        assert!(Source::from_picture([3, 3], &[[1; 4]], &Limits::default()).is_err());
    }

    #[test]
    fn a_picture_without_mixtures_keeps_its_colors() {
        let colors: Vec<[u8; 4]> = grid::places([SIDE; 2])
            .map(|[x, y]| if (x / 7 + y / 5) % 3 == 0 { [9, 9, 9, 255] } else { [200, 0, 0, 255] })
            .collect();
        let exact = Source::from_colors([SIDE; 2], &colors, &Limits::default()).unwrap();
        assert_eq!(read(&colors).classes(), exact.classes());
    }

    #[test]
    fn a_thin_stroke_has_the_color_that_the_picture_shows_elsewhere() {
        let is_in = |x: f32, y: f32| x < 6.0 || (y - 20.2).abs() < 0.45;
        let source = read(&drawn(is_in));
        let mut classes = source.classes().to_vec();
        classes.sort_unstable();
        classes.dedup();
        assert_eq!(classes.len(), 2, "no mixture is a colour");
        let front = |x: u32, y: u32| {
            source.classes()[(y * SIDE + x) as usize].to_le_bytes()[0] == FRONT[0] as u8
        };
        assert!((0..SIDE).all(|x| front(x, 20)), "the stroke is whole");
    }

    #[test]
    fn edges_over_nothing_are_edges_too() {
        let colors: Vec<[u8; 4]> = grid::places([SIDE; 2])
            .map(|[x, y]| match x {
                0..18 => [x as u8, y as u8, 7, 0],
                18 => [250, 10, 10, 64],
                _ => [250, 10, 10, 255],
            })
            .collect();
        let source = read(&colors);
        assert!(source.classes().iter().all(|&c| c == 0 || c >> 24 == 255));
        let distance = source.distances().unwrap()[(3 * SIDE + 18) as usize];
        assert!((distance - 0.249).abs() < 0.01, "{distance}");
    }

    #[test]
    fn the_smallest_pictures_and_empty_ones_are_no_harm() {
        for size in [[1, 1], [1, 5], [5, 1], [2, 2]] {
            let colors: Vec<[u8; 4]> =
                (0..size[0] * size[1]).map(|i| [i as u8, 0, 0, 255]).collect();
            for colors in [vec![[0; 4]; colors.len()], colors] {
                let exact = Source::from_colors(size, &colors, &Limits::default()).unwrap();
                let source = Source::from_antialiased(size, &colors, &Limits::default()).unwrap();
                assert_eq!(source.classes(), exact.classes(), "{size:?}");
            }
        }
    }

    #[test]
    fn a_photograph_is_left_as_it_is() {
        let mut state = 1u32;
        let colors: Vec<[u8; 4]> = (0..SIDE * SIDE)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let [_, g, b, r] = state.to_le_bytes();
                [r, g, b, 255]
            })
            .collect();
        let exact = Source::from_colors([SIDE; 2], &colors, &Limits::default()).unwrap();
        assert_eq!(read(&colors).classes(), exact.classes());
    }
}
