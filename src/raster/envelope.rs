//! Who wins along a line on which every score is a polynomial of degree two.

/// A score along a line, u from 0 to 1: the constant, the factor of u and that of u².
pub(crate) type Curve = [f64; 3];

/// Stretches shorter than this, in u, are none.
const TINY: f64 = 1e-10;

fn at([a, b, c]: Curve, u: f64) -> f64 {
    a + u * (b + u * c)
}

/// The stretches of the line by who is greatest there, the first of equals: where each ends, and its place in
/// `curves`. The last ends at 1; none without curves.
pub(crate) fn greatest(curves: &[Curve]) -> Vec<(f64, usize)> {
    let mut ends = vec![1.0];
    for (i, one) in curves.iter().enumerate() {
        for other in &curves[i + 1..] {
            let roots = roots(std::array::from_fn(|k| other[k] - one[k]));
            ends.extend(roots.into_iter().filter(|&u| u > 0.0 && u < 1.0));
        }
    }
    ends.sort_unstable_by(f64::total_cmp);
    let mut stretches: Vec<(f64, usize)> = Vec::new();
    let mut from = 0.0;
    for end in ends {
        // Where nobody overtakes another, the middle tells of all.
        let middle = 0.5 * (from + end);
        let ahead = |first: usize, i: usize| at(curves[i], middle) > at(curves[first], middle);
        let first = (0..curves.len()).reduce(|first, i| if ahead(first, i) { i } else { first });
        let Some(first) = first else { return stretches };
        match stretches.last_mut() {
            Some(last) if last.1 == first || end - from < TINY => last.0 = end,
            _ => stretches.push((end, first)),
        }
        from = end;
    }
    stretches
}

/// Where a curve is zero; what is no number is nowhere.
fn roots([a, b, c]: Curve) -> [f64; 2] {
    // Without the difference of two large numbers.
    let s = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    [s / c, a / s]
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn stretches_are_few_and_end_where_curves_cross() {
        assert_eq!(greatest(&[]), []);
        assert_eq!(greatest(&[[1.0, 2.0, 3.0]]), [(1.0, 0)]);
        assert_eq!(greatest(&[[5.0, 0.0, 0.0]; 3]), [(1.0, 0)]);
        assert_eq!(greatest(&[[0.0; 3], [-1.0, 4.0, 0.0]]), [(0.25, 0), (1.0, 1)]);
        // A bump between two of the same.
        let bump = [-3.0 / 16.0, 1.0, -1.0];
        assert_eq!(greatest(&[[0.0; 3], bump]), [(0.25, 0), (0.75, 1), (1.0, 0)]);
        // One that only touches.
        assert_eq!(greatest(&[[0.0; 3], [-0.25, 1.0, -1.0]]), [(1.0, 0)]);
    }

    proptest! {
        #[test]
        fn at_any_place_the_greatest_is_told(
            curves in prop::collection::vec(prop::array::uniform3(-9i8..9), 1..7),
            u in 0.0..1.0f64,
        ) {
            let curves: Vec<Curve> = curves.into_iter().map(|c| c.map(f64::from)).collect();
            let stretches = greatest(&curves);
            let (_, told) = *stretches.iter().find(|&&(end, _)| u <= end).unwrap();
            let most = curves.iter().map(|&curve| at(curve, u)).fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(at(curves[told], u) > most - 1e-6, "{stretches:?}");
            prop_assert!(stretches.is_sorted_by(|a, b| a.0 < b.0 && a.1 != b.1), "{stretches:?}");
        }
    }
}
