//! Boundaries as lines: what γ parts, traced exactly and told in few smooth curves, to be written as SVG, PDF or
//! EPS.
//!
//! Each boundary of two regions is an arc from where it meets others to where it meets others again, and is
//! traced once: the regions on its two sides share it to the last digit. Within a cell every p_ab is a
//! polynomial of the place. Where boundaries cross a line its roots tell, and squares are quartered until
//! each has one boundary, or one place where three meet, which Newton's method finds. On the borders of
//! cells both sides are asked; where they differ, the border itself is the boundary there.

mod arcs;
mod border;
mod cells;
mod drawing;
mod eps;
mod field;
mod fit;
mod motif;
mod pdf;
mod pen;
mod place;
mod postfix;
mod rings;
mod square;
mod svg;

pub use drawing::{Drawing, Format, Scene};
pub use fit::Curve;
pub use place::Window;
pub use rings::Ring;

use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::model::{Image, RegionId};
use field::OUTSIDE;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// How far from its boundary a traced curve is, at most, in units of its window, unless asked otherwise: about
/// what an eye sees at 8×.
pub const TOLERANCE: f64 = 0.05;

/// A boundary from one end to the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Arc {
    /// The regions at its left and at its right, y downwards: of an arc to the right the left is above. `None` is
    /// outside of what was traced.
    pub sides: [Option<RegionId>; 2],
    /// Numbers of the places where it starts and ends: arcs that meet have the same. An arc that closes on
    /// itself has one number twice.
    pub ends: [u32; 2],
    /// Where it starts, in units from the window's first place.
    pub start: [f64; 2],
    /// Its curves, one after the other.
    pub curves: Vec<Curve>,
}

impl Arc {
    /// Where it ends.
    pub fn end(&self) -> [f64; 2] {
        self.curves.last().map_or(self.start, Curve::end)
    }

    /// The same the other way.
    #[must_use]
    pub fn reversed(&self) -> Arc {
        let starts = [self.start].into_iter().chain(self.curves.iter().map(Curve::end));
        let mut curves: Vec<Curve> =
            self.curves.iter().zip(starts).map(|(curve, start)| curve.reversed(start)).collect();
        curves.reverse();
        let ([left, right], [from, to]) = (self.sides, self.ends);
        Arc { sides: [right, left], ends: [to, from], start: self.end(), curves }
    }
}

/// The boundaries in a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Traced {
    /// The window's extent, in its units.
    pub size: [f64; 2],
    /// All arcs, the window's own frame among them.
    pub arcs: Vec<Arc>,
}

/// Traces the boundaries of what a window shows of a picture; what of the window is beyond the picture is left
/// out. Curves are no further than `tolerance`, in the window's units, from where γ parts regions; something
/// closed of up to four tolerances across may be missed.
///
/// # Errors
/// [`Error::Usage`] where the window shows nothing or the tolerance is no positive number, [`Error::Limit`] where
/// it would take more memory than `limits` allow, or very long.
pub fn trace(model: &Image, window: &Window, tolerance: f64, limits: &Limits) -> Result<Traced> {
    let Some(window) = window.within(model.size) else {
        return Err(Error::Usage("the view shows nothing of the picture: move it there".into()));
    };
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::Usage("a tolerance is a number above 0".into()));
    }
    let mut pieces = cells::pieces(model, window, tolerance, limits.memory)?;
    let mut chains = arcs::chains(&pieces);
    if arcs::close_slivers(&mut pieces, &chains, tolerance) {
        chains = arcs::chains(&pieces);
    }
    let arc = |chain: &arcs::Chain| {
        let of_chain = chain.pieces.iter().map(|&(piece, is_back)| {
            let [a, b, c, d] = pieces[piece as usize].curve;
            if is_back { [d, c, b, a] } else { [a, b, c, d] }
        });
        let (start, curves) = fit::fitted(of_chain.collect(), chain.is_loop, tolerance);
        let sides = chain.sides.map(|label| (label != OUTSIDE).then_some(label));
        Arc { sides, ends: chain.ends, start, curves }
    };
    let mut arcs: Vec<Arc> = chains.par_iter().map(arc).collect();
    join(&mut arcs);
    Ok(Traced { size: window.size.map(|along| along * window.scale), arcs })
}

/// Gives arcs that meet the very same place there: each came to it by sums of its own.
fn join(arcs: &mut [Arc]) {
    let mut places = FxHashMap::default();
    for arc in arcs {
        let start = *places.entry(arc.ends[0]).or_insert(arc.start);
        let end = *places.entry(arc.ends[1]).or_insert(arc.end());
        arc.start = start;
        match arc.curves.last_mut() {
            Some(Curve::Line(to) | Curve::Cubic([_, _, to])) => *to = end,
            None if start != end => arc.curves.push(Curve::Line(end)),
            None => {}
        }
    }
}
