//! What nothing that is still asked can touch may go: verdicts stay as they are.

use crate::rows::{Ground, rows};
use dapple_many_lights::region::fusion::{
    Horizon, NOTHING, Verdict, around, asked_part, reference,
};
use dapple_many_lights::region::horizon::{Projection, Umbra, project};
use dapple_many_lights::region::{Cuboid, Edge, Fusion};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Small boxes behind the rows, before and beside their ends, at some height.
fn occludees(seed: u64) -> Vec<Cuboid> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let middle: f64 = random.random_range(0.0..120.0);
    let boxes = (0..40).map(|_| {
        let mut side = |from: f64, to: f64, most: f64| {
            let low = random.random_range(from..to);
            [low, low + random.random_range(0.0..most)]
        };
        let u = side(middle - 40.0, middle + 40.0, 6.0);
        Cuboid { u, w: side(12.0, 180.0, 3.0), h: side(-2.0, 20.0, 4.0) }
    });
    boxes.collect()
}

#[derive(Default)]
struct Found {
    hidden: [usize; 2],
    different: usize,
    shadows: [usize; 2],
}

/// Verdicts on all that is open, plane by plane, with all shadows and with what of them is asked.
fn found(fusion: Fusion, ground: Ground, edge: Edge) -> Found {
    let mut found = Found::default();
    for seed in 0..60 {
        let rows = rows(seed, 5.0 + 0.2 * seed as f64, ground);
        let mut open = occludees(seed);
        let mut all = Horizon::new(fusion);
        let mut part = Horizon::new(fusion);
        let mut reference = reference::Horizon::new(fusion);
        let mut last = None;
        for plane in rows.planes() {
            open.retain(|occludee| occludee.w[0] >= plane);
            let on = |occludee: &Cuboid| project(&rows.cell, occludee, plane);
            let asked: Projection = open.iter().map(on).fold(NOTHING, |a, b| around(&a, &b));
            if let Some(last) = last {
                all.reproject(&rows.cell, last, plane);
                let left = part.reproject_asked(&rows.cell, [last, plane], &asked);
                let moved = reference.reproject_asked(&rows.cell, [last, plane], &asked);
                assert_eq!(left, moved);
            }
            last = Some(plane);
            let shadows = rows.shadows(plane, edge);
            all.add(&shadows);
            let asked: Vec<Umbra> =
                shadows.iter().filter_map(|shadow| asked_part(shadow, &asked)).collect();
            part.add(&asked);
            reference.add(&asked);
            found.shadows[0] += all.len();
            found.shadows[1] += part.len();
            for p in open.iter().map(on) {
                let [whole, left] = [&all, &part].map(|horizon| horizon.test(&p, &mut 0));
                assert_eq!(left, reference.test(&p, &mut 0));
                found.hidden[0] += usize::from(whole == Verdict::Hidden);
                found.hidden[1] += usize::from(left == Verdict::Hidden);
                found.different += usize::from(whole != left);
            }
        }
    }
    found
}

#[test]
fn verdicts_on_what_is_asked_stay_and_shadows_become_few() {
    for edge in [Edge::Flat, Edge::Hull] {
        for ground in [Ground::Endless, Ground::Level, Ground::Hilly(6.0)] {
            for fusion in [Fusion::None, Fusion::HeightOrdered] {
                let Found { hidden: [whole, left], different, shadows } =
                    found(fusion, ground, edge);
                let told = format!("{fusion:?} {ground:?} {edge:?}: {whole} {left} {different}");
                assert!(whole > 300, "{told}");
                // Edges that become level and feet that become one join more.
                let is_plain = edge == Edge::Flat && !matches!(ground, Ground::Hilly(_));
                let is_exact = fusion == Fusion::None || is_plain;
                assert!(left >= whole && (different == 0 || !is_exact), "{told}");
                assert!(4 * shadows[1] < 3 * shadows[0], "{told} {shadows:?}");
            }
        }
    }
}
