//! Squares that change their label where what is drawn in the end comes nearer to the source.
//!
//! A label is first the one that is least wrong in its square. But boundaries are drawn through squares, and
//! where a square is about half one label's and half another's, only a look at what is drawn tells which is
//! better. Many are tried at once, so far from each other that what each changes can be told apart.

use super::{Reduced, Search};
use crate::error::Result;
use crate::grid::{self, Point};
use crate::labels::Source;
use crate::model::Image;
use crate::open::fit_squares;
use crate::raster;
use rayon::prelude::*;

/// Every so many squares along each axis one is tried, and how far it is taken to change what is drawn.
const APART: u32 = 5;
const REACH: u32 = 2;
/// What another label may make worse in its own square before it is tried, as a part of all of it.
const DOUBTFUL: f32 = 0.3;
/// A crack that a change adds takes so many times the bits of another: it is seldom where it was expected.
const UNEXPECTED: f32 = 1.4;

/// A square that changes its label.
#[derive(Clone, Copy)]
struct Flip {
    square: usize,
    from: u32,
    to: u32,
}

impl Search<'_> {
    /// Squares with classes that are better once they are drawn, where a bit is worth so many pixels of
    /// black for white. `classes` are what they have before.
    pub(super) fn flipped(
        &self,
        reduced: &Reduced,
        classes: Vec<u32>,
        price: f32,
    ) -> Result<Reduced> {
        let size = reduced.size;
        let crack = price * UNEXPECTED * reduced.crack_bits;
        let mut flipped = Reduced { classes, flips: reduced.flips.clone(), ..*reduced };
        let seen = near_boundaries(size, &flipped.classes);
        for row in 0..APART {
            let mut now = self.drawn_errors(&flipped, &seen)?;
            for column in 0..APART {
                let squares = (row..size[1])
                    .step_by(APART as usize)
                    .flat_map(|y| (column..size[0]).step_by(APART as usize).map(move |x| [x, y]));
                let flips: Vec<Flip> =
                    squares.filter_map(|square| self.doubtful(&flipped, square)).collect();
                if flips.is_empty() {
                    continue;
                }
                flips.iter().for_each(|flip| flipped.classes[flip.square] = flip.to);
                let then = self.drawn_errors(&flipped, &seen)?;
                for Flip { square, from, to } in flips {
                    let at = grid::place(size, square);
                    let cracks = |own: u32| {
                        beside(size, at).filter(|&other| flipped.classes[other] != own).count()
                    };
                    let more = cracks(to) as f32 - cracks(from) as f32;
                    let by: f32 = around(size, at, REACH).map(|i| then[i] - now[i]).sum();
                    if by + crack * more < 0.0 {
                        around(size, at, REACH).for_each(|i| now[i] = then[i]);
                        flipped.note(square, from, to);
                    } else {
                        flipped.classes[square] = from;
                    }
                }
            }
        }
        Ok(flipped)
    }

    /// The label that a square could well have in place of its own: that of one beside it.
    fn doubtful(&self, reduced: &Reduced, at: [u32; 2]) -> Option<Flip> {
        let square = grid::index(reduced.size, at);
        let from = reduced.classes[square];
        let error = |class: u32| self.error(reduced, square, class);
        let others = beside(reduced.size, at).map(|other| reduced.classes[other]);
        let others = others.filter(|&other| other != from).map(|other| (error(other), other));
        let (wrong, to) = others.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
        let all = self.pixels(reduced, square).count() as f32 * self.unlike(from, to);
        (wrong - error(from) < DOUBTFUL * all).then_some(Flip { square, from, to })
    }

    /// What is wrong in each square that is `seen` when labels are drawn, in pixels of black for white.
    fn drawn_errors(&self, reduced: &Reduced, seen: &[bool]) -> Result<Vec<f32>> {
        let limits = &self.options.limits;
        let squares = match self.source.has_colors() {
            true => {
                let colors: Vec<[u8; 4]> =
                    reduced.classes.iter().map(|class| class.to_le_bytes()).collect();
                Source::from_colors(reduced.size, &colors, limits)
            }
            false => Source::from_labels(reduced.size, reduced.classes.clone(), limits),
        }?;
        let kind = (self.options.kernel, self.options.gamma);
        let image = fit_squares(&squares, kind, limits, self.source.size(), reduced.scale_log2)?;
        let colors: Vec<[f32; 3]> =
            image.regions.iter().map(|region| super::seen_color(region.color)).collect();
        let error = |(square, &seen)| {
            if seen { self.drawn_error(reduced, &image, &colors, square) } else { 0.0 }
        };
        Ok(seen.par_iter().enumerate().map(error).collect())
    }

    fn drawn_error(
        &self,
        reduced: &Reduced,
        image: &Image,
        colors: &[[f32; 3]],
        square: usize,
    ) -> f32 {
        let size = self.source.size();
        let error = |pixel: usize| {
            let point = Point { whole: grid::place(size, pixel).map(i64::from), frac: [0.5; 2] };
            let shown = raster::region_at(image, &point);
            let shown = shown.map_or([0.0; 3], |region| colors[region as usize]);
            let truth = self.color(self.source.classes()[pixel]);
            super::squared(shown, truth)
        };
        self.pixels(reduced, square).map(error).sum()
    }
}

/// Squares in which what is drawn may change when those at boundaries change sides.
fn near_boundaries(size: [u32; 2], classes: &[u32]) -> Vec<bool> {
    let mut seen = vec![false; classes.len()];
    for square in 0..classes.len() {
        let at = grid::place(size, square);
        if beside(size, at).any(|other| classes[other] != classes[square]) {
            around(size, at, 2 * REACH).for_each(|near| seen[near] = true);
        }
    }
    seen
}

/// The squares on the four sides of one.
fn beside(size: [u32; 2], [x, y]: [u32; 2]) -> impl Iterator<Item = usize> {
    [[x.wrapping_sub(1), y], [x + 1, y], [x, y.wrapping_sub(1)], [x, y + 1]]
        .into_iter()
        .filter(move |at| at[0] < size[0] && at[1] < size[1])
        .map(move |at| grid::index(size, at))
}

/// A square and those so near to it.
fn around(size: [u32; 2], at: [u32; 2], by: u32) -> impl Iterator<Item = usize> {
    let along = move |axis: usize| at[axis].saturating_sub(by)..(at[axis] + by + 1).min(size[axis]);
    along(1).flat_map(move |y| along(0).map(move |x| grid::index(size, [x, y])))
}
