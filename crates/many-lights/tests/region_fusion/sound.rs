//! P2 and P7: every point of every shadow is hidden from everywhere in the cell, by rays against the
//! boxes; joined, moved, and whatever order they came in.

use crate::rows::{GROUNDS, Ground, Rows, rows};
use crate::streams::FUSIONS;
use dapple_many_lights::region::fusion::{Verdict, join};
use dapple_many_lights::region::horizon::{Projection, Umbra, project};
use dapple_many_lights::region::{Cuboid, Edge, Fusion};
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64Mcg;

/// Metres by which boxes are larger than they are: rays along their sides meet them.
const TOUCH: f64 = 1e-9;

/// Whether a segment between points (u, w, h) meets a box.
fn meets(from: [f64; 3], to: [f64; 3], b: &Cuboid) -> bool {
    let mut span = [0.0_f64, 1.0_f64];
    for (axis, side) in [b.u, b.w, b.h].into_iter().enumerate() {
        let side = [side[0] - TOUCH, side[1] + TOUCH];
        let (start, along) = (from[axis], to[axis] - from[axis]);
        if along == 0.0 {
            if !(side[0] <= start && start <= side[1]) {
                return false;
            }
            continue;
        }
        let [a, b] = side.map(|end| (end - start) / along);
        span = [span[0].max(a.min(b)), span[1].min(a.max(b))];
    }
    span[0] <= span[1]
}

/// The corners of a cell and some points inside.
fn viewpoints(cell: &Cuboid, random: &mut Pcg64Mcg) -> Vec<[f64; 3]> {
    let mut points: Vec<[f64; 3]> = (0..8)
        .map(|corner| [cell.u[corner & 1], cell.w[corner >> 1 & 1], cell.h[corner >> 2]])
        .collect();
    let mut within = |side: [f64; 2]| side[0] + random.random::<f64>() * (side[1] - side[0]);
    points.extend((0..4).map(|_| [within(cell.u), within(cell.w), within(cell.h)]));
    points
}

/// Places within a shadow: its corners, and where others of the plane begin and end, to both sides.
fn places(shadow: &Umbra, all: &[Umbra], random: &mut Pcg64Mcg) -> Vec<[f64; 2]> {
    let ends = all.iter().flat_map(|other| other.u).flat_map(|u| [u - 1e-6, u, u + 1e-6]);
    let some: Vec<f64> = ends.filter(|u| shadow.u[0] < *u && *u < shadow.u[1]).collect();
    let mut us = shadow.u.to_vec();
    us.extend((0..4.min(some.len())).map(|_| some[random.random_range(0..some.len())]));
    us.push(shadow.u[0] + random.random::<f64>() * (shadow.u[1] - shadow.u[0]));
    us.iter()
        // An edge may fall below the foot on its way to an end.
        .filter(|&&u| shadow.height(u) >= shadow.foot)
        .flat_map(|&u| {
            let top = shadow.height(u);
            let foot = shadow.foot.max(top - 200.0);
            [foot, top, foot + random.random::<f64>() * (top - foot)].map(|h| [u, h])
        })
        .collect()
}

/// A place of a shadow on a plane that some point of the cell sees, if one is found, and the number of
/// rays.
fn seen(
    rows: &Rows,
    plane: f64,
    shadow: &Umbra,
    all: &[Umbra],
    random: &mut Pcg64Mcg,
    rays: &mut u64,
) -> Option<String> {
    let places = places(shadow, all, random);
    let points = viewpoints(&rows.cell, random);
    places.iter().find_map(|&[u, h]| {
        points.iter().find_map(|&from| {
            *rays += 1;
            let is_hidden = rows.boxes.iter().any(|b| meets(from, [u, plane, h], b));
            (!is_hidden).then(|| format!("{u}, {h} of {shadow:?} from {from:?}"))
        })
    })
}

/// Shadows of a horizon of which a place is seen; how many there were, and rays.
fn faults(rows: &Rows, fusion: Fusion, edge: Edge, seed: u64, sum: &mut [u64; 2]) -> Vec<String> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut found = Vec::new();
    rows.on_planes(fusion, edge, |horizon, plane| {
        let nodes: Vec<Umbra> = horizon.nodes().collect();
        for shadow in &nodes {
            sum[0] += 1;
            found.extend(seen(rows, plane, shadow, &nodes, &mut random, &mut sum[1]));
        }
    });
    found
}

#[test]
fn every_place_of_every_shadow_is_hidden_from_the_whole_cell() {
    let mut sum = [0; 2];
    for seed in 0..24 {
        let ground = GROUNDS[seed as usize % GROUNDS.len()];
        let rows = rows(seed, 5.0 + 15.0 * (seed % 7) as f64 / 6.0, ground);
        for fusion in FUSIONS {
            for edge in [Edge::Flat, Edge::Sloped, Edge::Hull] {
                let found = faults(&rows, fusion, edge, seed, &mut sum);
                assert!(found.is_empty(), "{seed} {fusion:?} {edge:?}: {}", found[0]);
            }
        }
    }
    let [shadows, rays] = sum;
    assert!(shadows > 10_000 && rays > 500_000, "{shadows} shadows, {rays} rays");
}

#[test]
fn whatever_the_order_of_arrival_shadows_are_sound_and_by_height_they_are_the_same() {
    let mut sum = [0; 2];
    for seed in 100..116 {
        let ground = GROUNDS[seed as usize % GROUNDS.len()];
        let mut rows = rows(seed, 12.0, ground);
        let by_height = |rows: &Rows| {
            let mut all = Vec::new();
            rows.on_planes(Fusion::HeightOrdered, Edge::Flat, |horizon, _| {
                all.push(horizon.nodes().collect::<Vec<_>>());
            });
            all
        };
        let in_first_order = by_height(&rows);
        for permutation in 0..3 {
            rows.boxes.shuffle(&mut Pcg64Mcg::seed_from_u64(permutation));
            let found = faults(&rows, Fusion::Insertion, Edge::Flat, seed, &mut sum);
            assert!(found.is_empty(), "{seed} {permutation}: {}", found[0]);
            assert_eq!(by_height(&rows), in_first_order);
        }
    }
    assert!(sum[0] > 5_000 && sum[1] > 250_000, "{sum:?}");
}

/// Rules of joining.
#[derive(Clone, Copy, Debug)]
enum Rule {
    Join,
    /// What does not meet, over the gap.
    AcrossGaps,
    /// What meets, as high as the higher.
    AsHighAsTheHigher,
    /// What meets, down to the lower foot.
    DownToTheLower,
}

fn by_rule(rule: Rule, a: &Umbra, b: &Umbra) -> Option<Umbra> {
    let u = [a.u[0].min(b.u[0]), a.u[1].max(b.u[1])];
    let (low, high) = (a.top[0].min(b.top[0]), a.top[0].max(b.top[0]));
    let (deep, foot) = (a.foot.min(b.foot), a.foot.max(b.foot));
    let joined = join(a, b);
    match rule {
        Rule::Join => joined,
        Rule::AcrossGaps => {
            let gap = a.u[0].max(b.u[0]) - a.u[1].min(b.u[1]);
            (gap > 0.1 && foot < low).then_some(Umbra::flat(u, foot, low))
        }
        Rule::AsHighAsTheHigher => {
            joined.filter(|_| high > low + 1.0).map(|_| Umbra::flat(u, foot, high))
        }
        Rule::DownToTheLower => {
            joined.filter(|_| foot > deep + 1.0).map(|_| Umbra::flat(u, deep, low))
        }
    }
}

#[test]
fn shadows_that_are_joined_wrongly_are_seen_through() {
    for rule in [Rule::Join, Rule::AcrossGaps, Rule::AsHighAsTheHigher, Rule::DownToTheLower] {
        let (mut pairs, mut found, mut rays) = (0, 0, 0);
        for seed in 0..12 {
            let rows = rows(seed, 6.0, Ground::Hilly(6.0));
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            rows.on_planes(Fusion::None, Edge::Flat, |horizon, plane| {
                let nodes: Vec<Umbra> = horizon.nodes().collect();
                for pair in nodes.windows(2) {
                    let Some(joined) = by_rule(rule, &pair[0], &pair[1]) else { continue };
                    let fault = seen(&rows, plane, &joined, &nodes, &mut random, &mut rays);
                    pairs += 1;
                    found += u32::from(fault.is_some());
                }
            });
        }
        assert!(pairs > 100, "{rule:?}: {pairs} pairs");
        match rule {
            Rule::Join => assert_eq!(found, 0),
            _ => assert!(found > pairs / 10, "{rule:?}: {found} of {pairs} are seen through"),
        }
    }
}

/// Boxes that lights may lie in, anywhere among the rows and behind them.
fn clusters(rows: &Rows, random: &mut Pcg64Mcg) -> Vec<Cuboid> {
    let behind = rows.cell.w[1] + 10.0;
    (0..150)
        .map(|n| {
            let u = random.random_range(0.0..120.0);
            let w = random.random_range(behind..behind + 150.0);
            let h = random.random_range(1.0..20.0);
            let [a, b, c] = match n % 3 {
                0 => [0.0; 3],
                1 => [8.0, 0.0, 3.0],
                _ => [5.0, 5.0, 10.0],
            };
            Cuboid { u: [u, u + a], w: [w, w + b], h: [h, h + c] }
        })
        .collect()
}

/// Which clusters are hidden on the last plane before them.
fn hidden(rows: &Rows, fusion: Fusion, edge: Edge, clusters: &[Cuboid]) -> Vec<bool> {
    let mut hidden = vec![false; clusters.len()];
    let planes = rows.planes();
    rows.on_planes(fusion, edge, |horizon, plane| {
        let next = planes.iter().copied().find(|p| *p > plane).unwrap_or(f64::INFINITY);
        for (hidden, cluster) in hidden.iter_mut().zip(clusters) {
            if (plane..next).contains(&cluster.w[0]) {
                let p: Projection = project(&rows.cell, cluster, plane);
                *hidden = horizon.test(&p, &mut 0) == Verdict::Hidden;
            }
        }
    });
    hidden
}

#[test]
fn joining_hides_more_and_nothing_that_is_seen() {
    for ground in GROUNDS {
        let (mut sums, mut rays) = ([0; 3], 0);
        for seed in 200..230 {
            let rows = rows(seed, 5.0 + 0.5 * (seed - 200) as f64, ground);
            let mut random = Pcg64Mcg::seed_from_u64(seed);
            let clusters = clusters(&rows, &mut random);
            let by = FUSIONS.map(|fusion| hidden(&rows, fusion, Edge::Flat, &clusters));
            for (n, cluster) in clusters.iter().enumerate() {
                let [none, insertion, ordered] = [by[0][n], by[1][n], by[2][n]];
                assert!(!none || insertion && ordered, "{seed}: {cluster:?}");
                // Feet may keep the tallest from those that it would join one at a time.
                assert!(!insertion || ordered || ground != Ground::Endless, "{seed}: {cluster:?}");
                (0..3).for_each(|fusion| sums[fusion] += u32::from(by[fusion][n]));
                if !(insertion || ordered) {
                    continue;
                }
                for to in viewpoints(cluster, &mut random) {
                    for from in viewpoints(&rows.cell, &mut random) {
                        rays += 1;
                        let is_hidden = rows.boxes.iter().any(|b| meets(from, to, b));
                        assert!(is_hidden, "{seed}: {to:?} from {from:?}");
                    }
                }
            }
        }
        let [none, insertion, ordered] = sums;
        assert!(none < insertion && insertion < ordered, "{ground:?}: {sums:?}");
        assert!(none > 500 && rays > 100_000, "{ground:?}: {sums:?}, {rays} rays");
    }
}

/// H4.3: the wider the cell is against the lots, of 10 m, the more of what is found is found by
/// joining.
#[test]
fn joining_matters_more_for_wider_cells() {
    let gains = [2.0, 8.0, 16.0, 30.0].map(|width| {
        let mut sums = [0.0; 3];
        for seed in 300..340 {
            let rows = rows(seed, width, Ground::Endless);
            let clusters = clusters(&rows, &mut Pcg64Mcg::seed_from_u64(seed));
            for (sum, fusion) in sums.iter_mut().zip(FUSIONS) {
                let hidden = hidden(&rows, fusion, Edge::Flat, &clusters);
                *sum += hidden.iter().filter(|hidden| **hidden).count() as f64;
            }
        }
        assert!(sums[0] > 300.0, "{width} m: {sums:?}");
        [sums[1] / sums[0], sums[2] / sums[0]]
    });
    for fusion in [0, 1] {
        let gains = gains.map(|gain| gain[fusion]);
        assert!(gains.is_sorted() && gains[3] > 1.1 * gains[0], "{gains:?}");
    }
}
