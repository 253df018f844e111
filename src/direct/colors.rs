//! Positions of nodes: those that share a list are told apart by few places that are far from each other.

use crate::model::{Lists, RegionId};

/// Places for nodes, the best first. The first four are as far from each other as from none else; what
/// lies between two of them is nearer to these than to any other. So it does not matter which region has
/// which, as long as no more are needed.
const PLACES: [[u8; 3]; 15] = [
    [19, 19, 19],
    [236, 236, 19],
    [236, 19, 236],
    [19, 236, 236],
    [255, 255, 255],
    [0, 0, 255],
    [0, 255, 0],
    [255, 0, 0],
    [127, 127, 127],
    [127, 127, 0],
    [127, 127, 255],
    [127, 0, 127],
    [127, 255, 127],
    [0, 127, 127],
    [255, 127, 127],
];

/// Pairs of regions that are sorted at a time.
const MANY: usize = 1 << 20;

/// Of [`PLACES`], those that any regions may have.
const FREE: usize = 4;

/// Whether all of these are places at which nothing can be wrong, and all different.
pub fn are_apart(positions: impl Iterator<Item = [u8; 3]>) -> bool {
    let mut taken = [false; FREE];
    positions.into_iter().all(|position| {
        let place = PLACES[..FREE].iter().position(|&place| place == position);
        place.is_some_and(|place| !std::mem::replace(&mut taken[place], true))
    })
}

/// A position for each region: regions in one list have different ones, if there are enough.
pub fn positions(regions: usize, lists: &Lists) -> Vec<[u8; 3]> {
    let mut pairs: Vec<[RegionId; 2]> = Vec::new();
    let mut enough = MANY;
    for list in lists.iter() {
        let all = list.iter().flat_map(|&a| list.iter().map(move |&b| [a, b]));
        pairs.extend(all.filter(|[a, b]| a != b));
        // Most come many times.
        if pairs.len() > enough {
            pairs.sort_unstable();
            pairs.dedup();
            enough = MANY.max(2 * pairs.len());
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut starts = vec![0u32; regions + 1];
    pairs.iter().for_each(|pair| starts[pair[0] as usize + 1] += 1);
    for region in 0..regions {
        starts[region + 1] += starts[region];
    }
    let beside = |region: RegionId| {
        &pairs[starts[region as usize] as usize..starts[region as usize + 1] as usize]
    };
    let mut places = vec![usize::MAX; regions];
    for region in last_first(regions, &beside) {
        let mut taken = [false; PLACES.len()];
        for &[_, other] in beside(region) {
            if let Some(taken) = taken.get_mut(places[other as usize]) {
                *taken = true;
            }
        }
        places[region as usize] = taken.iter().position(|&taken| !taken).unwrap_or(0);
    }
    places.into_iter().map(|place| PLACES[place]).collect()
}

/// Regions in the order that takes the fewest places: each before those that were left with fewer
/// neighbours than it when those with the fewest were taken away one by one.
fn last_first<'a>(
    regions: usize,
    beside: &impl Fn(RegionId) -> &'a [[RegionId; 2]],
) -> Vec<RegionId> {
    let mut degrees: Vec<usize> = (0..regions as RegionId).map(|r| beside(r).len()).collect();
    let most = degrees.iter().copied().max().unwrap_or(0);
    let mut waiting: Vec<Vec<RegionId>> = vec![Vec::new(); most + 1];
    for (region, &degree) in (0..).zip(&degrees) {
        waiting[degree].push(region);
    }
    let mut order = Vec::with_capacity(regions);
    let mut is_out = vec![false; regions];
    let mut least = 0;
    while order.len() < regions {
        let Some(region) = waiting[least].pop() else {
            least += 1;
            continue;
        };
        if degrees[region as usize] != least
            || std::mem::replace(&mut is_out[region as usize], true)
        {
            // It waits elsewhere, with fewer.
            continue;
        }
        order.push(region);
        for &[_, other] in beside(region) {
            if !is_out[other as usize] {
                let degree = &mut degrees[other as usize];
                *degree -= 1;
                waiting[*degree].push(other);
                least = least.min(*degree);
            }
        }
    }
    order.reverse();
    order
}
