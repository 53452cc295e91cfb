//! Where errors of pixels come from: in sound modes nothing that is seen is missing.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod town_support;

use dapple_many_lights::{
    Shaded,
    region::{FacadeCluster, Fusion, RegionTechnique},
};
use dapple_night_city::{
    Drawer, Front, Night, Part, Pipeline, Town,
    decompose::{Parts, PointStarts, decompose},
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
    let mut seen = Front::new(town, &with(night, |s| s.threshold = 0.0), drawer()).unwrap();
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
            let starts = PointStarts {
                used: pipeline.front().starts().of(point.object),
                seen: seen.starts().of(point.object),
            };
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
        let starts = PointStarts { used: of_another, seen: of_another };
        culled += decompose(&lit, &town.lights, &night.cut, false, point, starts).culled;
    }
    assert!(culled > 100, "{culled}");
}
