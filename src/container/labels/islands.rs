//! Areas that take more bits than they are worth.

use std::collections::BTreeMap;

/// About the bits of an area of its own, beside its cracks: to say where it starts and what it is.
const AREA_BITS: f32 = 18.0;
/// Areas of more pixels are never merged.
const LARGE: usize = 1 << 12;
/// Times that all areas are looked at.
const ROUNDS: usize = 2;

/// Gives areas of one label the label of one beside them, where their bits are not worth what is wrong
/// then: `error` is that of a label at a pixel, `price` what a bit may cost, `crack_bits` the bits that each
/// crack around an area takes.
pub fn merge_islands(
    size: [u32; 2],
    labels: &mut [u32],
    error: &(dyn Fn(usize, u32) -> f32 + Sync),
    price: f32,
    crack_bits: f32,
) {
    let [w, h] = size.map(|n| n as usize);
    let mut area: Vec<usize> = Vec::new();
    let mut ahead: Vec<usize> = Vec::new();
    for _ in 0..ROUNDS {
        let mut is_done = vec![false; labels.len()];
        let mut has_merged = false;
        for first in 0..labels.len() {
            if is_done[first] {
                continue;
            }
            let own = labels[first];
            area.clear();
            ahead.push(first);
            is_done[first] = true;
            let mut around: BTreeMap<u32, u32> = BTreeMap::new();
            let mut count = 0;
            while let Some(at) = ahead.pop() {
                count += 1;
                if count <= LARGE {
                    area.push(at);
                }
                let (x, y) = (at % w, at / w);
                let beside = [
                    (x > 0).then(|| at - 1),
                    (x + 1 < w).then(|| at + 1),
                    (y > 0).then(|| at - w),
                    (y + 1 < h).then(|| at + w),
                ];
                for next in beside.into_iter().flatten() {
                    if labels[next] != own {
                        if count <= LARGE {
                            *around.entry(labels[next]).or_default() += 1;
                        }
                    } else if !is_done[next] {
                        is_done[next] = true;
                        ahead.push(next);
                    }
                }
            }
            if count > LARGE {
                continue;
            }
            let before: f32 = area.iter().map(|&at| error(at, own)).sum();
            let cost = |to: u32| area.iter().map(|&at| error(at, to)).sum::<f32>() - before;
            // The boundary with others stays.
            let best = around.iter().map(|(&to, &shared)| {
                (cost(to) - price * (AREA_BITS + crack_bits * shared as f32), to)
            });
            if let Some((gain, to)) = best.min_by(|a, b| a.0.total_cmp(&b.0))
                && gain < 0.0
            {
                area.iter().for_each(|&at| labels[at] = to);
                has_merged = true;
            }
        }
        if !has_merged {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_that_are_not_worth_their_bits_take_the_label_that_is_least_wrong() {
        // A large area of 1 beside one of 9, and in each a spot of 5.
        let size = [40, 20];
        let mut labels: Vec<u32> = (0..800).map(|i| if i % 40 < 20 { 1 } else { 9 }).collect();
        for (x, y) in [(4, 4), (5, 4), (4, 5), (5, 5), (30, 8)] {
            labels[y * 40 + x] = 5;
        }
        // On the boundary, with as much of one on its sides as of the other.
        labels[12 * 40 + 19] = 2;
        let truth = labels.clone();
        let error = |at: usize, label: u32| (f32::from(truth[at] as u8) - label as f32).abs();
        let merged = |price: f32| {
            let mut merged = labels.clone();
            merge_islands(size, &mut merged, &error, price, 1.0);
            merged
        };
        assert_eq!(merged(0.01), labels, "4 for a spot of one pixel are more than 18 bits");
        let some = merged(0.3);
        assert_eq!((some[8 * 40 + 30], some[12 * 40 + 19]), (9, 1));
        assert_eq!(some[4 * 40 + 4], 5, "16 for a spot of four pixels");
        assert!(merged(2.0).iter().all(|label| [1, 9].contains(label)));
    }
}
