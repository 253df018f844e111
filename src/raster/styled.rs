//! Colours by styles: fills, patterns and outlines. The twin of `shaders/styles.wgsl`, in f64.

use super::reference::Around;
use super::sample::Sample;
use crate::model::{Image, NodeId, RegionId};
use crate::placement::SceneView;
use crate::style::{Style, Styles, read};

/// What a scene is drawn with.
pub(super) struct Styled<'a> {
    pub model: &'a Image,
    /// Without, every region has its own colour.
    pub styles: Option<&'a Styles>,
    pub view: &'a SceneView,
    /// Sub-samples along an axis of a screen pixel.
    pub samples: f64,
    /// Blend across boundaries.
    pub antialias: bool,
}

/// How a place looks for boundaries: rays are sent out, and looked along.
pub(super) struct Search {
    rays: u32,
    /// Places on a ray that are looked at, lest something small lies between.
    steps: u32,
    /// Of half the angle between two rays: the nearest boundary is no further off the direction of one.
    least_cosine: f64,
    /// How far rays go, in screen pixels.
    pub reach: f64,
}

/// How often a ray that has crossed a boundary is halved.
const HALVINGS: u32 = 3;

impl Search {
    /// For outlines that reach so far: wide ones take more.
    pub fn new(reach: f64, samples: f64) -> Self {
        // Sub-samples look from many places.
        let (rays, steps) = match if samples > 1.0 { 0.0 } else { reach } {
            ..=3.0 => (8, 1),
            ..=8.0 => (16, 2),
            _ => (32, 4),
        };
        let least_cosine = (std::f64::consts::PI / f64::from(rays)).cos();
        // A little further, so that one gets across a boundary that is just within reach.
        Search { rays, steps, least_cosine, reach: reach / least_cosine + 0.5 }
    }
}

impl Styled<'_> {
    /// The premultiplied colour at a place on the screen, alpha up to 255 as the other channels.
    pub fn color(&self, screen: [f64; 2]) -> [f64; 4] {
        let Some(around) = self.around(screen) else { return [0.0; 4] };
        let shares = match self.antialias {
            true => {
                Sample { model: self.model, view: self.view, samples: self.samples }.shares(screen)
            }
            false => vec![(around.node, 1.0)],
        };
        let mut sum = [0.0; 4];
        for (node, share) in shares {
            let fill = self.fill(node, screen);
            (0..4).for_each(|channel| sum[channel] += share * fill[channel]);
        }
        if let Some((cover, color)) = self.outline(screen, around.node) {
            over(&mut sum, color, cover);
        }
        sum.map(|channel| 255.0 * channel)
    }

    /// The colour of a node's region, premultiplied.
    fn fill(&self, node: NodeId, screen: [f64; 2]) -> [f64; 4] {
        let words = self.words(node);
        let [r, g, b, a] = read::color(words[0]);
        let mut sum = [r * a, g * a, b * a, a];
        let [x, y, step] = self.view.pattern;
        let middle = self.view.viewport.map(|n| 0.5 * f64::from(n));
        let at = [x + (screen[0] - middle[0]) * step, y + (screen[1] - middle[1]) * step];
        let cover = read::pattern(&words, at, step / self.samples, self.antialias);
        over(&mut sum, words[3], cover);
        sum
    }

    /// The outline that covers most of a place, and how much of it.
    fn outline(&self, screen: [f64; 2], own: NodeId) -> Option<(f64, u32)> {
        let reach = self.styles?.reach().at(self.view.source);
        if reach == 0.0 {
            return None;
        }
        let search = Search::new(reach, self.samples);
        // Where several lie over each other the widest is seen.
        let (mut best, mut rank) = (None, 0.0);
        for i in 0..search.rays {
            let angle = f64::from(i) * std::f64::consts::TAU / f64::from(search.rays);
            let ray = [angle.cos(), angle.sin()];
            let Some((other, distance)) = self.crossed(screen, own, ray, &search) else { continue };
            let [own, other] = [own, other].map(|node| self.words(node));
            if read::grouped(&own, &other) {
                continue;
            }
            for (words, along) in [(own, distance), (other, -distance)] {
                let (cover, width) =
                    read::outline(&words, along, self.view.source, self.samples, self.antialias);
                if cover * width > rank {
                    (best, rank) = (Some((cover, words[1])), cover * width);
                }
            }
        }
        best
    }

    /// Where a ray gets into another region: its node, and how far the boundary that was crossed is.
    fn crossed(
        &self,
        screen: [f64; 2],
        own: NodeId,
        ray: [f64; 2],
        search: &Search,
    ) -> Option<(NodeId, f64)> {
        let region = |node: NodeId| self.region(node);
        let at = |along: f64| self.around([screen[0] + along * ray[0], screen[1] + along * ray[1]]);
        let stride = search.reach / f64::from(search.steps);
        let (mut from, mut to) = (0.0, stride);
        let mut there = at(to)?;
        for _ in 1..search.steps {
            if region(there.node) == region(own) {
                (from, to) = (to, to + stride);
                there = at(to)?;
            }
        }
        if region(there.node) == region(own) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (from + to);
            let halfway = at(middle)?;
            if region(halfway.node) == region(own) {
                from = middle;
            } else {
                (to, there) = (middle, halfway);
            }
        }
        let mut distance = 0.5 * (from + to);
        if let Some(side) = there.sides.first()
            && region(side.node) == region(own)
        {
            let [p, by_x, by_y, ..] = side.local;
            let slope = by_x * ray[0] + by_y * ray[1];
            if slope > 0.0 {
                let crossed = (to - p / (slope * self.samples)).clamp(from, to);
                distance = crossed * (slope / by_x.hypot(by_y)).max(search.least_cosine);
            }
        }
        Some((there.node, distance))
    }

    fn around(&self, screen: [f64; 2]) -> Option<Around> {
        let sub_pixel = 1.0 / (self.view.scale * self.samples);
        Around::new(self.model, &self.view.place(screen), [sub_pixel; 2])
    }

    /// The region as which a node's is drawn.
    fn region(&self, node: NodeId) -> Option<RegionId> {
        let region = self.model.nodes[node as usize].region?;
        Some(self.styles.map_or(region, |styles| styles.drawn_as(region)))
    }

    /// The record of a node's region.
    fn words(&self, node: NodeId) -> [u32; 4] {
        let Some(region) = self.model.nodes[node as usize].region else { return [0; 4] };
        match self.styles {
            Some(styles) => styles.drawn(region),
            None => Style::plain(self.model.regions[region as usize].color).words(),
        }
    }
}

/// Puts so much of a colour over a premultiplied one.
fn over(below: &mut [f64; 4], color: u32, cover: f64) {
    let [r, g, b, a] = read::color(color);
    let cover = cover * a;
    for (channel, above) in below.iter_mut().zip([r, g, b, 1.0]) {
        *channel += cover * (above - *channel);
    }
}
