//! Interpolation of texels inside a cell.

/// How texels become values between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kernel {
    /// Uniform quadratic B-spline: one texel in the middle of each cell, 3 taps an axis, C¹.
    #[default]
    Quadratic,
    /// Linear: texels on the corners of cells, 2 taps an axis, C⁰.
    Linear,
}

impl Kernel {
    /// Texels that reach into one cell, along one axis.
    pub const fn taps(self) -> usize {
        match self {
            Kernel::Quadratic => 3,
            Kernel::Linear => 2,
        }
    }

    /// Texels along an axis that serve `cells` cells: `cells + 2`, or `cells + 1`.
    pub const fn texels(self, cells: u32) -> u32 {
        cells + self.taps() as u32 - 1
    }

    /// The name in files, on the command line and in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Kernel::Quadratic => "quadratic",
            Kernel::Linear => "linear",
        }
    }

    /// Weights of the taps at `u` in `[0, 1]` across a cell; the linear kernel's third is zero.
    pub fn weights(self, u: f64) -> [f64; 3] {
        match self {
            Kernel::Quadratic => {
                [0.5 * (1.0 - u) * (1.0 - u), 0.75 - (u - 0.5) * (u - 0.5), 0.5 * u * u]
            }
            Kernel::Linear => [1.0 - u, u, 0.0],
        }
    }

    /// [`weights`](Self::weights) as polynomials of `u`: of each tap the constant, the factor of u and
    /// that of u².
    pub const fn polynomials(self) -> [[f64; 3]; 3] {
        match self {
            Kernel::Quadratic => [[0.5, -1.0, 0.5], [0.5, 1.0, -1.0], [0.0, 0.0, 0.5]],
            Kernel::Linear => [[1.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3]],
        }
    }

    /// Derivatives of [`weights`](Self::weights) by `u`.
    pub fn slopes(self, u: f64) -> [f64; 3] {
        match self {
            Kernel::Quadratic => [u - 1.0, 1.0 - 2.0 * u, u],
            Kernel::Linear => [-1.0, 1.0, 0.0],
        }
    }

    /// Their second derivatives, which are the same all over a cell.
    pub const fn bends(self) -> [f64; 3] {
        match self {
            Kernel::Quadratic => [1.0, -2.0, 1.0],
            Kernel::Linear => [0.0; 3],
        }
    }

    /// What texel `at` of texels `ratio` times as fine is made of, where the interpolant is to be the
    /// very same: the weights of a coarse cell's taps. Fine texel 0 is the first tap of the coarse
    /// cell's first fine cell; the last that its interpolant tells is `ratio` + 1 (linear: `ratio`).
    pub fn refined(self, ratio: u32, at: u32) -> [f64; 3] {
        let step = 1.0 / f64::from(ratio);
        match self {
            // The blossom of each weight at the two knots around the fine cell that the texel is in
            // the middle of.
            Kernel::Quadratic => {
                let (a, b) = ((f64::from(at) - 1.0) * step, f64::from(at) * step);
                [0.5 * (1.0 - a) * (1.0 - b), 0.5 * (1.0 + a + b) - a * b, 0.5 * a * b]
            }
            Kernel::Linear => self.weights(f64::from(at) * step),
        }
    }

    /// Value and Jacobian of the interpolant at `u` in a cell.
    ///
    /// `texel(k)` is the texel at tap `k`, each axis in `0..taps`. The Jacobian's `[e][axis]` is the
    /// derivative of value component `e` along `axis`, per cell width.
    pub fn interpolate<const D: usize, const E: usize>(
        self,
        u: [f64; D],
        texel: impl Fn([usize; D]) -> [u8; E],
    ) -> ([f64; E], [[f64; D]; E]) {
        let weights = u.map(|u| self.weights(u));
        let slopes = u.map(|u| self.slopes(u));
        let mut value = [0.0; E];
        let mut jacobian = [[0.0; D]; E];
        for tap in 0..self.taps().pow(D as u32) {
            let mut rest = tap;
            let k: [usize; D] = std::array::from_fn(|_| {
                let along = rest % self.taps();
                rest /= self.taps();
                along
            });
            let t = texel(k);
            let mut weight = 1.0;
            for axis in 0..D {
                weight *= weights[axis][k[axis]];
            }
            for e in 0..E {
                value[e] += weight * f64::from(t[e]);
            }
            for axis in 0..D {
                let mut slope = slopes[axis][k[axis]];
                for other in 0..D {
                    if other != axis {
                        slope *= weights[other][k[other]];
                    }
                }
                for e in 0..E {
                    jacobian[e][axis] += slope * f64::from(t[e]);
                }
            }
        }
        (value, jacobian)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_sum_to_one_and_slopes_to_zero() {
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            for i in 0..=10 {
                let u = f64::from(i) / 10.0;
                assert!((kernel.weights(u).iter().sum::<f64>() - 1.0).abs() < 1e-12);
                assert!(kernel.slopes(u).iter().sum::<f64>().abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_jacobian_is_the_derivative() {
        let texel = |k: [usize; 2]| [(17 * k[0] + 91 * k[1] * k[0] + 5) as u8, (k[1] * 60) as u8];
        let h = 1e-6;
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            let (_, jacobian) = kernel.interpolate([0.3, 0.8], texel);
            for axis in 0..2 {
                let at = |s: f64| {
                    let mut u = [0.3, 0.8];
                    u[axis] += s;
                    kernel.interpolate(u, texel).0
                };
                for e in 0..2 {
                    let numeric = (at(h)[e] - at(-h)[e]) / (2.0 * h);
                    assert!((numeric - jacobian[e][axis]).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn finer_texels_draw_the_same() {
        for kernel in [Kernel::Quadratic, Kernel::Linear] {
            let coarse = [10.0, 200.0, 30.0];
            let draw = |texels: &[f64], u: f64| -> f64 {
                kernel.weights(u).iter().zip(texels).map(|(w, t)| w * t).sum()
            };
            for ratio in [2, 4, 8] {
                let fine: Vec<f64> = (0..kernel.texels(ratio))
                    .map(|at| {
                        kernel.refined(ratio, at).iter().zip(coarse).map(|(w, t)| w * t).sum()
                    })
                    .collect();
                for cell in 0..ratio as usize {
                    for u in [0.0, 0.3, 1.0] {
                        let there = draw(&coarse, (cell as f64 + u) / f64::from(ratio));
                        assert!((draw(&fine[cell..], u) - there).abs() < 1e-9);
                    }
                }
            }
        }
    }

    #[test]
    fn quadratic_is_smooth_across_cells() {
        // Cells 0 and 1 of a row of four texels: value and slope agree where they meet.
        let row = [10u8, 200, 30, 90];
        let at = |cell: usize, u: f64| Kernel::Quadratic.interpolate([u], |k| [row[cell + k[0]]]);
        let (left, right) = (at(0, 1.0), at(1, 0.0));
        assert!((left.0[0] - right.0[0]).abs() < 1e-9);
        assert!((left.1[0][0] - right.1[0][0]).abs() < 1e-9);
    }
}
