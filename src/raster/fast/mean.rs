//! Pixels of several samples: their means.

use super::pair::rounded;

/// Rows of pixels that are the means of squares of samples.
pub(super) struct Means {
    /// Samples along an axis of a pixel, [`MAX_SAMPLES`](crate::placement::MAX_SAMPLES) at most.
    samples: usize,
    /// What the samples below each other add up to: two channels in 16 bits each, into which no more go than there may be.
    red_blue: Vec<u32>,
    green_alpha: Vec<u32>,
}

impl Means {
    /// Of so many pixels a row.
    pub fn new(samples: usize, pixels: usize) -> Self {
        let sums = vec![0; samples * pixels];
        Means { samples, red_blue: sums.clone(), green_alpha: sums }
    }

    /// Writes a row of pixels, from the rows of samples that it is made of.
    pub fn write(&mut self, band: &[[u8; 4]], pixels: &mut [[u8; 4]]) {
        self.red_blue.fill(0);
        self.green_alpha.fill(0);
        for row in band.chunks_exact(self.red_blue.len()) {
            let sums = self.red_blue.iter_mut().zip(&mut self.green_alpha);
            for ((red_blue, green_alpha), sample) in sums.zip(row) {
                let sample = u32::from_le_bytes(*sample);
                *red_blue += sample & 0x00ff_00ff;
                *green_alpha += (sample >> 8) & 0x00ff_00ff;
            }
        }
        // Most often there are two: a loop of known length takes two thirds of the time.
        if self.samples == 2 {
            self.across::<2>(band, pixels)
        } else {
            self.across::<1>(band, pixels)
        }
    }

    /// Adds up what is side by side, so many samples at a time.
    fn across<const SOME: usize>(&self, band: &[[u8; 4]], pixels: &mut [[u8; 4]]) {
        let count = (self.samples * self.samples) as u32;
        let share = 1.0 / count as f32;
        let [red_blue, green_alpha] = [&self.red_blue, &self.green_alpha]
            .map(|sums| sums.as_chunks::<SOME>().0.chunks_exact(self.samples / SOME));
        for (x, (pixel, sums)) in pixels.iter_mut().zip(red_blue.zip(green_alpha)).enumerate() {
            let add = |sums: &[[u32; SOME]]| sums.as_flattened().iter().sum::<u32>();
            let (red_blue, green_alpha) = (add(sums.0), add(sums.1));
            if green_alpha >> 16 != 255 * count {
                *pixel = self.blended(band, x);
                continue;
            }
            let sums = [red_blue & 0xffff, green_alpha & 0xffff, red_blue >> 16];
            let [r, g, b] = sums.map(|sum| rounded(sum as f32 * share));
            *pixel = (r | g << 8 | b << 16 | 255 << 24).to_le_bytes();
        }
    }

    /// Where not all samples are opaque, colours count as much as they cover.
    fn blended(&self, band: &[[u8; 4]], x: usize) -> [u8; 4] {
        let mut sum = [0u32; 4];
        for row in band.chunks_exact(self.red_blue.len()) {
            for &[r, g, b, a] in &row[x * self.samples..][..self.samples] {
                let a = u32::from(a);
                sum[0] += u32::from(r) * a;
                sum[1] += u32::from(g) * a;
                sum[2] += u32::from(b) * a;
                sum[3] += a;
            }
        }
        let [r, g, b, a] = sum;
        if a == 0 {
            return [0; 4];
        }
        let count = (self.samples * self.samples) as u32;
        let [r, g, b] = [r, g, b].map(|sum| (sum + a / 2) / a);
        [r, g, b, (a + count / 2) / count].map(|channel| channel as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placement::MAX_SAMPLES;

    const PIXELS: usize = 5;

    #[test]
    fn means_are_rounded_whether_samples_are_opaque_or_not() {
        for samples in 1..=MAX_SAMPLES as usize {
            // The brightest there are, any, and some that are not opaque.
            for seed in 0..20usize {
                let byte = |i: usize| (((i + 7) * (seed + 3) * 2_654_435) >> 9) as u8;
                let alpha = |i: usize| if seed % 2 == 0 { 255 } else { byte(5 * i) };
                let sample = |i: usize| match seed {
                    0 => [255; 4],
                    _ => [byte(i), byte(2 * i), byte(3 * i), alpha(i)],
                };
                let stride = samples * PIXELS;
                let band: Vec<[u8; 4]> = (0..samples * stride).map(sample).collect();
                let mut found = [[9; 4]; PIXELS];
                // What was before does not stay.
                let mut means = Means::new(samples, PIXELS);
                means.write(&vec![[77; 4]; band.len()], &mut found);
                means.write(&band, &mut found);
                for (x, found) in found.iter().enumerate() {
                    let own = |i: &usize| i % stride / samples == x;
                    let of = |what: &dyn Fn([u8; 4]) -> f64| -> f64 {
                        (0..band.len()).filter(own).map(|i| what(band[i])).sum()
                    };
                    let opacity = of(&|color| f64::from(color[3]));
                    let wanted = opacity / (samples * samples) as f64;
                    let off = (f64::from(found[3]) - wanted).abs();
                    assert!(off < 0.5 + 1e-6, "{samples} {seed}: {found:?}");
                    if opacity == 0.0 {
                        continue;
                    }
                    for c in 0..3 {
                        let sum = of(&|color| f64::from(color[c]) * f64::from(color[3]));
                        let off = (f64::from(found[c]) - sum / opacity).abs();
                        assert!(off < 0.5 + 1e-6, "{samples} {seed}: {found:?}");
                    }
                }
            }
        }
    }
}
