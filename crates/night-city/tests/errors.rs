//! Where errors of pixels come from: in sound modes nothing that is seen is missing.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod town_support;

use dapple_many_lights::{
    Point, Shaded,
    cut::walk,
    radiance,
    region::{FacadeCluster, Fusion, RegionTechnique},
};
use dapple_night_city::{
    Drawer, Front, Night, Part, Pipeline, Town,
    decompose::{Parts, PointStarts, at_height, decompose},
};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;
use std::sync::Arc;
use town_support::along;

fn with(night: &Night, change: impl Fn(&mut FacadeCluster)) -> Night {
    let mut night = *night;
    if let RegionTechnique::FacadeCluster(settings) = &mut night.region {
        change(settings);
    }
    night
}

/// Parts of `count` pixels by chance of every frame, with the pixel and what it was lit with.
fn parts(town: &Arc<Town>, night: &Night, count: usize) -> Vec<(Parts, DVec3)> {
    let drawer = || Drawer::new(&town.objects, None).unwrap();
    let whole = Night { heights: 0, ..with(night, |s| s.threshold = 0.0) };
    let mut seen = Front::new(town, &whole, drawer()).unwrap();
    let mut pipeline = Pipeline::new(town, night, None).unwrap();
    let (lit, mut shaded) = (town.lit(), Shaded::default());
    let mut rng = Pcg32::seed_from_u64(7);
    let mut found = Vec::new();
    for index in 0..town.views.len() {
        seen.prepare(index).unwrap();
        pipeline.frame(index, false).unwrap();
        pipeline.read(&mut shaded).unwrap();
        let points = &town.world(false).frames[index].points;
        let mut left = count;
        while left > 0 {
            let pixel = rng.random_range(0..points.len());
            let point = &points[pixel];
            if !point.is_there() {
                continue;
            }
            left -= 1;
            let [used, hidden] = at_height(pipeline.front().starts(), point);
            let starts =
                PointStarts { used: &used, seen: seen.starts().of(point.object), hidden: &hidden };
            let parts = decompose(&lit, &town.lights, &night.cut, night.shadow_rays, point, starts);
            found.push((parts, shaded.radiance[pixel].as_dvec3()));
        }
    }
    found
}

fn town() -> Arc<Town> {
    along("tour", 64, [4, 20, 40, 60, 80, 100, 125].into_iter())
}

/// Row 48: E_cull is 0, E_cut at most 2/255; parts add up.
#[test]
fn nothing_that_is_seen_is_missing() {
    let town = town();
    let mut checked = 0;
    for fusion in [Fusion::None, Fusion::Insertion, Fusion::HeightOrdered] {
        for (split, whole_boxes) in [(Part::Any, true), (Part::Facade, true), (Part::Storey, false)]
        {
            let night = Night { split, whole_boxes, ..Night::default() };
            let night = with(&night, |settings| settings.fusion = fusion);
            let mut worst = Parts::default();
            for (parts, lit) in parts(&town, &night, 60) {
                assert_eq!(parts.cull, DVec3::ZERO, "{fusion:?} {split:?}: {parts:?}");
                assert_eq!(parts.culled, 0);
                assert!(parts.cut.abs().max_element() <= 2.0 / 255.0, "{parts:?}");
                let told = parts.leak + parts.cut - parts.irradiance - parts.cull - parts.shadow;
                let error = parts.result - parts.truth;
                assert!((told - error).abs().max_element() < 1e-9, "{told} and {error}");
                // What was lit in f32 is what was taken apart, but where a bound is at its limit.
                let off = (parts.result - lit).abs().max_element();
                assert!(off < 4.0 * night.cut.threshold, "{off:e}: {parts:?} and {lit}");
                checked += usize::from(parts.truth != DVec3::ZERO);
                worst.leak = worst.leak.max(parts.leak);
                worst.irradiance = worst.irradiance.max(parts.irradiance);
                worst.cut = worst.cut.max(parts.cut.abs());
            }
            println!("{fusion:?} {split:?}: {worst:?}");
        }
    }
    assert!(checked > 2000, "{checked}");
}

/// H5.12: the finer the cells, the less light leaks.
#[test]
fn finer_cells_leak_less() {
    let town = town();
    let leak = |tau_px: f64, split: Part| {
        let night = Night { tau_px, split, ..Night::default() };
        parts(&town, &night, 60).iter().map(|(parts, _)| parts.leak.element_sum()).sum::<f64>()
    };
    let leaks: Vec<f64> =
        [Part::Building, Part::Facade, Part::Storey].map(|split| leak(0.0, split)).to_vec();
    println!("leaks by building, facade, storey: {leaks:?}; undivided {}", leak(1e9, Part::Any));
    assert!(leaks[0] >= leaks[1] && leaks[1] >= leaks[2] && leaks[2] > 0.0);
}

/// Row 31 and H6.4: what is hidden from low points leaks less, nothing that is seen goes missing, and
/// no precut is found that was not found without.
#[test]
fn heights_stop_leaks_and_lose_nothing() {
    let town = town();
    for (split, tau_px) in [(Part::Any, 16_384.0), (Part::Facade, 0.0), (Part::Building, 0.0)] {
        let sums = [0, 2, 7].map(|heights| {
            let night = Night { split, tau_px, heights, ..Night::default() };
            let (mut leak, mut leaked, mut hidden) = (0.0, 0, 0);
            for (parts, lit) in parts(&town, &night, 60) {
                assert_eq!((parts.cull, parts.culled), (DVec3::ZERO, 0), "{heights}: {parts:?}");
                assert!(parts.cut.abs().max_element() <= 2.0 / 255.0, "{parts:?}");
                let off = (parts.result - lit).abs().max_element();
                assert!(off < 4.0 * night.cut.threshold, "{off:e}: {parts:?} and {lit}");
                leak += parts.leak.element_sum();
                leaked += parts.leaked;
                hidden += usize::from(parts.truth == DVec3::ZERO);
            }
            println!("{split:?}, {heights} heights: leak {leak}, {leaked} lights, {hidden} dark");
            (leak, leaked)
        });
        // What lies between two heights is only found with more of them: 7 are among them the 2.
        assert!(sums[0].0 > sums[1].0 && sums[0].1 > sums[1].1, "{split:?}: {sums:?}");
        assert!(sums[1].0 > sums[2].0 && sums[1].1 > sums[2].1, "{split:?}: {sums:?}");
    }
    let steps = |heights: u32| {
        let night = Night { heights, ..Night::default() };
        let drawer = Drawer::new(&town.objects, None).unwrap();
        let mut front = Front::new(&town, &night, drawer).unwrap();
        for index in 0..town.views.len() {
            front.prepare(index).unwrap();
        }
        assert_eq!(front.height_steps().evaluations > 0, heights > 0);
        println!("{heights}: {:?}", front.height_steps());
        front.steps()
    };
    assert_eq!(steps(0), steps(4));
}

/// A control: points far below what they are lose what they see.
#[test]
fn heights_that_are_too_great_lose_what_is_seen() {
    let town = town();
    let night = Night { heights: 4, tau_px: 0.0, split: Part::Facade, ..Night::default() };
    let night = with(&night, |settings| settings.threshold = 0.0);
    let mut front = Front::new(&town, &night, Drawer::new(&town.objects, None).unwrap()).unwrap();
    let (lit, mut culled) = (town.lit(), [0; 2]);
    for index in 0..town.views.len() {
        front.prepare(index).unwrap();
        let starts = front.starts();
        let points = &town.world(false).frames[index].points;
        for point in points.iter().filter(|p| p.is_there()).step_by(23) {
            for (metres, culled) in [0.0, 100.0].into_iter().zip(&mut culled) {
                let mut lower = *point;
                lower.position.y -= metres;
                let [used, hidden] = at_height(starts, &lower);
                let starts =
                    PointStarts { used: &used, seen: starts.of(point.object), hidden: &hidden };
                *culled += decompose(&lit, &town.lights, &night.cut, false, point, starts).culled;
            }
        }
    }
    assert!(culled[0] == 0 && culled[1] > 20, "{culled:?}");
}

/// Cells that have to wait for their precuts leak more, and lose nothing.
#[test]
fn a_budget_loses_nothing() {
    let town = along("tour", 64, 40..48);
    let sums = [None, Some(12), Some(1)].map(|budget| {
        let night = Night { budget, tau_px: 2048.0, ..Night::default() };
        let mut leak = 0.0;
        for (parts, _) in parts(&town, &night, 40) {
            assert_eq!((parts.cull, parts.culled), (DVec3::ZERO, 0), "{budget:?}: {parts:?}");
            leak += parts.leak.element_sum();
        }
        let mut pipeline = Pipeline::new(&town, &night, None).unwrap();
        let all: Vec<_> =
            (0..town.views.len()).map(|i| pipeline.frame(i, false).unwrap().counts).collect();
        let evaluations: Vec<u64> = all.iter().map(|c| c.evaluations).collect();
        let late: Vec<u64> = all.iter().map(|c| c.late).collect();
        println!("{budget:?}: leak {leak}, evaluations {evaluations:?}, late {late:?}");
        assert!(budget.is_none_or(|most| evaluations.iter().all(|e| *e <= u64::from(most))));
        assert_eq!(late[0] > 0, budget.is_some());
        assert!(budget.is_none() || late.last() < late.first(), "{late:?}");
        leak
    });
    assert!(sums[0] < sums[1] && sums[1] < sums[2], "{sums:?}");
}

/// Row 47: no point gets more light from what its cell starts at than the bound of the cell.
#[test]
fn no_point_is_brighter_than_its_cells_bound() {
    let town = town();
    let night = Night::default();
    let mut front = Front::new(&town, &night, Drawer::new(&town.objects, None).unwrap()).unwrap();
    let (mut tightest, mut checked) = (0.0_f64, 0);
    for index in 0..town.views.len() {
        front.prepare(index).unwrap();
        let bounds = front.brightest(1.0 / 1020.0);
        assert!(bounds.windows(2).any(|pair| pair[0].radiance != pair[1].radiance));
        let drawn = front.drawn().to_vec();
        let below = |node: u32| town.tree.objects_of(node);
        for point in town.world(false).frames[index].points.iter().step_by(37) {
            if !drawn.contains(&point.object) {
                continue;
            }
            let bound = bounds.iter().find(|c| below(c.node).contains(&point.object)).unwrap();
            let white = Point { albedo: glam::Vec3::ONE, ..*point };
            let mut sum = DVec3::ZERO;
            walk(&town.lights, front.starts().of(point.object), |_, node| {
                if node.is_leaf() {
                    let light = &town.world(false).lights[node.light as usize];
                    sum += radiance(&white, light, town.world(false).clamp_m);
                }
                node.is_leaf()
            });
            assert!(sum.max_element() <= bound.radiance, "{sum} and {bound:?}");
            tightest = tightest.max(sum.max_element() / bound.radiance);
            checked += 1;
        }
    }
    println!("{checked} points, at most {tightest} of the bound");
    assert!(checked > 200 && tightest > 0.05);
}

/// The knob that buys leaks back.
#[test]
fn shadow_rays_on_the_cut_stop_most_leaks() {
    let town = town();
    let sums = |shadow_rays: bool| {
        let night = Night { shadow_rays, ..Night::default() };
        let mut sum = [0.0; 2];
        for (parts, lit) in parts(&town, &night, 60) {
            assert!((parts.result - lit).abs().max_element() < 1e-3, "{parts:?} and {lit}");
            sum[0] += parts.leak.element_sum();
            sum[1] += (parts.result - parts.truth).abs().element_sum();
        }
        sum
    };
    let (without, with) = (sums(false), sums(true));
    println!("leak and error without rays {without:?}, with {with:?}");
    assert!(with[0] < 0.5 * without[0] && with[1] < 0.5 * without[1]);
}

/// A control: lists that leave lights out show up as E_cull.
#[test]
fn lists_of_another_cell_lose_what_is_seen() {
    let town = along("tour", 64, [60].into_iter());
    let night = Night::default();
    let mut front = Front::new(&town, &night, Drawer::new(&town.objects, None).unwrap()).unwrap();
    front.prepare(0).unwrap();
    let points = &town.world(false).frames[0].points;
    let lit = town.lit();
    let of_another = front.starts().of(points.iter().find(|p| p.is_there()).unwrap().object);
    let mut culled = 0;
    for point in points.iter().filter(|p| p.is_there()).step_by(31) {
        let starts = PointStarts { used: of_another, seen: of_another, hidden: &[] };
        culled += decompose(&lit, &town.lights, &night.cut, false, point, starts).culled;
    }
    assert!(culled > 100, "{culled}");
}
