//! The curve that a chain of cracks seems to follow, from all that was seen of it: which side of it pixels
//! lie on says where it can be, the more exactly the longer it has been smooth.
//!
//! Place, direction and curvature at the chain's head are a normal distribution; a pixel's side cuts it in two,
//! and the half that is left is taken for a normal distribution again. Between corners the curvature drifts.
//!
//! All arithmetic is that of IEEE doubles with + − × ÷ and square roots, which every machine rounds alike: a
//! file decodes to the same bits everywhere.

use super::lattice::Corner;

/// What a tracker takes a curve for.
#[derive(Clone, Copy)]
pub struct Habit {
    /// Variance that curvature gains a step, and direction.
    pub bend: f64,
    pub turn: f64,
    /// Variance of a pixel's place.
    pub blur: f64,
}

/// Where a curve is believed to be.
#[derive(Clone, Copy)]
pub struct Tracker {
    habit: Habit,
    /// A place on it, and the direction there, of length 1.
    place: [f64; 2],
    heading: [f64; 2],
    /// To the left, in radians a pixel.
    curvature: f64,
    /// Variances and covariances of what is to be added to place (to the left), direction and curvature.
    ee: f64,
    ef: f64,
    ek: f64,
    ff: f64,
    fk: f64,
    kk: f64,
}

/// How far to the left of a curve a pixel's middle is, in standard deviations of what is known of both.
#[derive(Clone, Copy, Default)]
pub struct Side {
    pub z: f64,
    along: f64,
    spread: f64,
}

impl Side {
    /// Standard deviation of the curve's place there.
    pub fn spread(self) -> f64 {
        self.spread
    }
}

/// At the start of a chain, and after a corner: variances of place, direction and curvature.
const UNKNOWN: [f64; 3] = [0.25, 0.3, 2.5e-4];
/// Less likely than this many standard deviations is a corner, after which all is open again.
const CORNER: f64 = -2.4;
/// Curvature and steps stay within these.
const SHARPEST: f64 = 0.7;
const FARTHEST: f64 = 3.0;
/// How far the square of a length may be from 1 to be put right without a root.
const NEARLY: f64 = 0.01;

impl Tracker {
    pub fn new(habit: Habit) -> Self {
        let mut tracker = Tracker {
            habit,
            place: [0.0; 2],
            heading: [1.0, 0.0],
            curvature: 0.0,
            ee: 0.0,
            ef: 0.0,
            ek: 0.0,
            ff: 0.0,
            fk: 0.0,
            kk: 0.0,
        };
        tracker.open();
        tracker
    }

    /// Starts at a corner, in a direction.
    pub fn start(&mut self, corner: Corner, d: u32) {
        let step = Corner { x: 0, y: 0 }.ahead(d, 1);
        self.place = [f64::from(corner.x), f64::from(corner.y)];
        self.heading = [f64::from(step.x), f64::from(step.y)];
        self.curvature = 0.0;
        self.open();
    }

    fn open(&mut self) {
        [self.ee, self.ff, self.kk] = UNKNOWN;
        (self.ef, self.ek, self.fk) = (0.0, 0.0, 0.0);
    }

    /// Goes on to where a corner is nearest.
    pub fn advance(&mut self, corner: Corner) {
        let (a, _) = self.seen_from([f64::from(corner.x), f64::from(corner.y)]);
        let left = self.left();
        let bend = self.curvature * a;
        for axis in 0..2 {
            self.place[axis] += self.heading[axis] * a + left[axis] * (0.5 * bend * a);
        }
        self.rotate(bend);
        let half = 0.5 * a * a;
        let (ff, fk) = (self.ff, self.fk);
        self.ee += 2.0 * a * self.ef
            + 2.0 * half * self.ek
            + a * a * ff
            + 2.0 * a * half * fk
            + half * half * self.kk;
        self.ef += a * ff + (half + a * a) * fk + a * half * self.kk + a * self.ek;
        self.ek += a * fk + half * self.kk;
        self.ff += 2.0 * a * fk + a * a * self.kk;
        self.fk += a * self.kk;
        let far = a.abs();
        self.ff += self.habit.turn * far;
        self.kk += self.habit.bend * far;
        self.bound();
    }

    /// Which side of the curve the middle of a pixel is on.
    #[inline]
    pub fn side(&self, [x, y]: [i32; 2]) -> Side {
        let (along, left) = self.seen_from([f64::from(x) + 0.5, f64::from(y) + 0.5]);
        let half = 0.5 * along * along;
        let variance = self.ee
            + 2.0 * along * self.ef
            + 2.0 * half * self.ek
            + along * along * self.ff
            + 2.0 * along * half * self.fk
            + half * half * self.kk
            + self.habit.blur;
        let spread = variance.max(1e-9).sqrt();
        Side { z: (left - self.curvature * half) / spread, along, spread }
    }

    /// Learns that a pixel is to the left of the curve, or that it is not: `side` is where it was believed to be.
    /// Returns how likely that was, in standard deviations.
    pub fn learn(&mut self, normal: &Normal, side: Side, is_left: bool) -> f64 {
        let Side { z, along, spread } = side;
        let t = if is_left { z } else { -z };
        let (ratio, shrink) = normal.cut(t);
        let half = 0.5 * along * along;
        let gain = [
            (self.ee + along * self.ef + half * self.ek) / spread,
            (self.ef + along * self.ff + half * self.fk) / spread,
            (self.ek + along * self.fk + half * self.kk) / spread,
        ];
        let by = if is_left { -ratio } else { ratio };
        let left = self.left();
        for axis in 0..2 {
            self.place[axis] += left[axis] * (gain[0] * by);
        }
        self.rotate(gain[1] * by);
        self.curvature += gain[2] * by;
        self.ee -= gain[0] * gain[0] * shrink;
        self.ef -= gain[0] * gain[1] * shrink;
        self.ek -= gain[0] * gain[2] * shrink;
        self.ff -= gain[1] * gain[1] * shrink;
        self.fk -= gain[1] * gain[2] * shrink;
        self.kk -= gain[2] * gain[2] * shrink;
        self.bound();
        t
    }

    /// A corner: the curve goes on from there in a direction, and nothing else is known.
    pub fn turn_at(&mut self, corner: Corner, d: u32, before: u32) {
        let steps = [d, before].map(|d| Corner { x: 0, y: 0 }.ahead(d, 1));
        self.start(corner, d);
        let toward =
            [f64::from(2 * steps[0].x + steps[1].x), f64::from(2 * steps[0].y + steps[1].y)];
        self.head(toward);
    }

    /// How far ahead and to the left a place is.
    fn seen_from(&self, at: [f64; 2]) -> (f64, f64) {
        let by = [at[0] - self.place[0], at[1] - self.place[1]];
        let left = self.left();
        let along = by[0] * self.heading[0] + by[1] * self.heading[1];
        (along.clamp(-FARTHEST, FARTHEST), by[0] * left[0] + by[1] * left[1])
    }

    /// y grows downwards.
    fn left(&self) -> [f64; 2] {
        [self.heading[1], -self.heading[0]]
    }

    fn rotate(&mut self, by: f64) {
        let left = self.left();
        self.head([self.heading[0] + left[0] * by, self.heading[1] + left[1] * by]);
    }

    fn head(&mut self, toward: [f64; 2]) {
        let square = toward[0] * toward[0] + toward[1] * toward[1];
        if (square - 1.0).abs() < NEARLY {
            // What the length is divided by, to first order: the next time puts right what is left.
            let scale = 1.5 - 0.5 * square;
            self.heading = toward.map(|along| along * scale);
            return;
        }
        let length = square.sqrt();
        if length > 1e-3 && length < 1e3 {
            self.heading = toward.map(|along| along / length);
        }
    }

    fn bound(&mut self) {
        self.curvature = self.curvature.clamp(-SHARPEST, SHARPEST);
        for (variance, most) in [(&mut self.ee, 4.0), (&mut self.ff, 1.0), (&mut self.kk, 0.1)] {
            *variance = variance.clamp(1e-12, most);
        }
        for (covariance, a, b) in [
            (&mut self.ef, self.ee, self.ff),
            (&mut self.ek, self.ee, self.kk),
            (&mut self.fk, self.ff, self.kk),
        ] {
            // Roots take long, and are seldom needed.
            if *covariance * *covariance > a * b {
                *covariance = (a * b).sqrt().copysign(*covariance);
            }
        }
    }

    /// Whether what was that likely shows a corner.
    pub fn is_corner(t: f64) -> bool {
        t < CORNER
    }
}

/// The normal distribution, in tables.
pub struct Normal {
    /// By standard deviations, the share below; and of what is below, how far its mean is from 0.
    below: Vec<f64>,
    means: Vec<f64>,
}

/// Standard deviations on both sides, and places in the table for each.
const REACH: f64 = 8.0;
const FINE: f64 = 32.0;

impl Normal {
    pub fn new() -> Self {
        let steps = (2.0 * REACH * FINE) as usize;
        let mut below = vec![0.0; steps + 1];
        let at = |i: f64| density(i / FINE - REACH);
        for i in 0..steps {
            let i_f = i as f64;
            // Simpson's rule.
            let part = (at(i_f) + 4.0 * at(i_f + 0.5) + at(i_f + 1.0)) / (6.0 * FINE);
            below[i + 1] = below[i] + part;
        }
        let mean = |(i, below): (usize, &f64)| at(i as f64) / below.max(1e-12);
        let means = below.iter().enumerate().map(mean).collect();
        Normal { below, means }
    }

    /// The share below `t`.
    pub fn below(&self, t: f64) -> f64 {
        between(&self.below, t)
    }

    /// Of what is below `t`: how far its mean is below 0, and by how much its variance is less than 1.
    fn cut(&self, t: f64) -> (f64, f64) {
        if t > 6.0 {
            return (0.0, 0.0);
        }
        if t < -6.0 {
            let t = t.max(-12.0);
            return (-t, 1.0);
        }
        let ratio = between(&self.means, t);
        (ratio, (ratio * (ratio + t)).clamp(0.0, 1.0))
    }
}

/// What a table says for so many standard deviations.
fn between(table: &[f64], t: f64) -> f64 {
    let place = ((t + REACH) * FINE).clamp(0.0, (table.len() - 2) as f64 + 0.999);
    // Numbers of 32 bits turn into doubles and back in one instruction.
    let i = place as i32;
    let part = place - f64::from(i);
    let [low, high] = [table[i as usize], table[i as usize + 1]];
    low * (1.0 - part) + high * part
}

/// e^(−t²/2) / √2π.
fn density(t: f64) -> f64 {
    let x = 0.5 * t * t / 1024.0;
    let mut power = 1.0 - x * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0)));
    for _ in 0..10 {
        power *= power;
    }
    power * 0.398_942_280_401_432_7
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_are_the_normal_distribution() {
        let normal = Normal::new();
        for (t, below) in
            [(0.0, 0.5), (1.0, 0.841_344_75), (-2.0, 0.022_750_13), (3.0, 0.998_650_1)]
        {
            assert!((normal.below(t) - below).abs() < 1e-6, "{t}");
        }
        assert!(normal.below(-100.0) >= 0.0 && normal.below(100.0) <= 1.0 + 1e-9);
        // Half of it: the mean of |x|, and its variance.
        let (ratio, shrink) = normal.cut(0.0);
        assert!(
            (ratio - 0.797_884_56).abs() < 1e-6
                && (shrink - std::f64::consts::FRAC_2_PI).abs() < 1e-6
        );
    }

    /// Follows the cracks between the pixels inside and outside a disc; how sure it was of the last ones.
    fn followed(radius: f64) -> Vec<f64> {
        let is_inside = |[x, y]: [i32; 2]| (f64::from(x) + 0.5).hypot(f64::from(y) + 0.5) < radius;
        let normal = Normal::new();
        let mut tracker = Tracker::new(Habit { bend: 1e-9, turn: 1e-8, blur: 1e-3 });
        // From the far right upwards: the inside is on the left.
        let mut corner = Corner { x: radius.floor() as i32, y: 0 };
        while !is_inside([corner.x - 1, -1]) || is_inside([corner.x, -1]) {
            corner.x -= 1;
        }
        let mut d = 3;
        tracker.start(corner, d);
        (0..4 * radius as usize)
            .map(|_| {
                corner = corner.ahead(d, 1);
                tracker.advance(corner);
                let [left, right] = corner.pixels_ahead(d);
                let sides = [left, right].map(|pixel| (tracker.side(pixel), is_inside(pixel)));
                for (pixel, (_, is_left)) in [left, right].into_iter().zip(sides) {
                    tracker.learn(&normal, tracker.side(pixel), is_left);
                }
                d = match (sides[0].1, sides[1].1) {
                    (true, false) => d,
                    (false, _) => (d + 3) & 3,
                    (true, true) => (d + 1) & 3,
                };
                let sure = sides
                    .map(|(side, is_left)| normal.below(if is_left { side.z } else { -side.z }));
                sure[0].min(sure[1])
            })
            .collect()
    }

    #[test]
    fn a_circle_is_known_the_better_the_longer_it_is_followed() {
        let sure = followed(400.0);
        let part = |range: std::ops::Range<usize>| {
            let part = &sure[range];
            part.iter().filter(|&&sure| sure > 0.9).count() as f64 / part.len() as f64
        };
        assert!(part(400..1600) > part(0..60) + 0.1, "{} {}", part(400..1600), part(0..60));
        assert!(part(400..1600) > 0.8);
    }
}
