//! How much of a pixel lies on which side of the boundaries near its middle.

/// What p is about a pixel's middle: its value there, its gradient, and its second derivatives by x twice, by x and y, and by
/// y twice; all in pixels.
pub(super) type Local = [f64; 6];

/// Half the diagonal of a pixel: one further from all boundaries is of one region.
pub(super) const REACH: f64 = 0.7072;

/// How far from the middle p gets to zero along its steepest way, which bends: p - |∇p| t + h t² / 2 = 0. Where it turns
/// before, it does not within reach. `None` where p is level.
pub(super) fn distance([p, x, y, xx, xy, yy]: Local) -> Option<f64> {
    let square = x * x + y * y;
    if square == 0.0 {
        return None;
    }
    let p = p.max(0.0);
    let bend = (x * x * xx + 2.0 * x * y * xy + y * y * yy) / square;
    let left = square - 2.0 * bend * p;
    let along = 2.0 * p / (square.sqrt() + left.max(0.0).sqrt());
    Some(if left < 0.0 { along.max(REACH) } else { along })
}

/// Whether the [`distance`], on whichever side of the boundary, is `reach` or more. Without roots: most places are far from all
/// boundaries, and are to cost little.
#[inline]
pub(super) fn is_beyond([p, x, y, xx, xy, yy]: Local, reach: f64) -> bool {
    let square = x * x + y * y;
    let power = reach * reach * square * square * square;
    let bend = reach * reach * (x * x * xx + (x + x) * y * xy + y * y * yy);
    // All times twice the square of the gradient: p at `reach`, but for what the gradient takes.
    let left = (p + p) * square + bend;
    let (left, bend) = if p < 0.0 { (-left, -bend) } else { (left, bend) };
    // And where it turns before, nobody knows.
    (left > 0.0) & (left * left >= 4.0 * power) & ((bend <= 0.0) | (power >= bend * bend))
}

/// How much of a pixel lies on the positive side of a line at `distance` from its middle, which lies there
/// too.
pub(super) fn share_of_square(distance: f64, normal: [f64; 2]) -> f64 {
    let [x, y] = normal.map(f64::abs);
    let length = (x * x + y * y).sqrt();
    let (a, b) = (x.max(y) / length, x.min(y) / length);
    let left = 0.5 * (a + b) - distance;
    if left <= 0.0 {
        1.0
    } else if left > b {
        // The line leaves a trapezium on its other side, else a triangle.
        0.5 + distance / a
    } else {
        1.0 - left * left / (2.0 * a * b)
    }
}

/// Places that are counted in a pixel where three regions meet, no two in a row or a column.
#[derive(Debug, Clone, Copy)]
pub(super) enum Places {
    Sixteen = 16,
    /// In a sub-sample, of which a pixel has several.
    Four = 4,
}

impl Places {
    /// Those of a sub-sample, where a pixel has so many along an axis.
    pub fn of(samples: f64) -> Self {
        if samples > 1.0 { Places::Four } else { Places::Sixteen }
    }
}

/// How much of a pixel each of three regions covers: the middle's own, the nearest and the next. The
/// first two are positive on the middle's side of each, `between` on the side of the nearest. Each place
/// is the deepest's, since planes may leave a gap.
pub(super) fn shares_of_three([near, next, between]: [Local; 3], places: Places) -> [f64; 3] {
    const ROWS: [u8; 16] = [8, 0, 12, 4, 10, 2, 14, 6, 9, 1, 13, 5, 11, 3, 15, 7];
    let mut counts = [0.0; 3];
    let count = places as u8;
    let share = 1.0 / f64::from(count);
    for i in 0..count {
        let row = ROWS[usize::from(i)] / (16 / count);
        let [x, y] = [i, row].map(|n| (f64::from(n) + 0.5) * share - 0.5);
        let at = |[p, by_x, by_y, xx, xy, yy]: Local| {
            p + x * (by_x + 0.5 * xx * x + xy * y) + y * (by_y + 0.5 * yy * y)
        };
        let [near, next, between] = [near, next, between].map(at);
        let depths = [near.min(next), between.min(-near), (-next).min(-between)];
        let owner = if depths[0] >= depths[1].max(depths[2]) {
            0
        } else if depths[1] >= depths[2] {
            1
        } else {
            2
        };
        counts[owner] += share;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::{REACH, distance, is_beyond, share_of_square};

    #[test]
    fn a_boundary_that_bends_is_as_far_as_it_is() {
        // A circle about (2, 0).
        let circle = |radius: f64| distance([4.0 - radius * radius, -4.0, 0.0, 2.0, 0.0, 2.0]);
        assert!((circle(1.5).unwrap() - 0.5).abs() < 1e-12);
        assert!((circle(2.0).unwrap()).abs() < 1e-12);
        // p comes near to zero and turns.
        let near_miss = [0.02, -0.1, 0.0, 0.26, 0.0, 0.0];
        assert_eq!(distance(near_miss), Some(REACH));
        assert_eq!(distance([1.0, 0.0, 0.0, 3.0, 0.0, 0.0]), None);
        for local in [[0.5, 0.6, 0.1, 0.2, 0.1, -0.3], [0.5, 0.8, 0.1, 0.2, 0.1, -0.3], near_miss] {
            let is_near = distance(local).is_some_and(|distance| distance < REACH);
            // What turns within reach is looked at.
            assert_eq!(is_beyond(local, REACH), !is_near && local != near_miss);
            assert_eq!(is_beyond(local.map(|n| -n), REACH), is_beyond(local, REACH));
        }
    }

    #[test]
    fn a_share_is_the_area_under_the_line() {
        for normal in [[1.0, 0.0], [0.3, -0.9], [0.7, 0.7], [-0.2, 0.05]] {
            let length = f64::hypot(normal[0], normal[1]);
            for distance in [0.0, 0.1, 0.3, 0.45, 0.6, 0.8] {
                let steps = 400;
                let at = |i: usize| (i as f64 + 0.5) / steps as f64 - 0.5;
                let inside = (0..steps * steps).filter(|i| {
                    let p = normal[0] * at(i % steps) + normal[1] * at(i / steps);
                    p / length + distance > 0.0
                });
                let area = inside.count() as f64 / (steps * steps) as f64;
                let share = share_of_square(distance, normal);
                assert!((share - area).abs() < 0.003, "{normal:?} {distance}: {share} {area}");
            }
        }
    }
}
