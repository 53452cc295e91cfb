//! Whole frames of a small city: nothing that is kept, divided, shared or overlapped changes what they
//! show beyond what it is stated to.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod town_support;

use dapple_many_lights::{
    Absolute, Shaded,
    cut::Starts,
    region::{FacadeCluster, RegionTechnique},
};
use dapple_night_city::{Counts, Drawer, Front, Night, Part, Pipeline, coherence::Keeping};
use glam::Vec3;
use std::sync::Arc;
use town_support::{along, images, lit, small};

fn kept_for(validity: Option<u32>) -> Night {
    let keeping = Keeping { validity, seed: 5, ..Keeping::default() };
    Night { keeping, ..Night::default() }
}

fn counts(town: &Arc<dapple_night_city::Town>, night: &Night) -> Vec<Counts> {
    let mut pipeline = Pipeline::new(town, night, None).unwrap();
    (0..town.views.len()).map(|index| pipeline.frame(index, false).unwrap().counts).collect()
}

/// The greatest difference of a channel.
fn furthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}

/// P12, on a walk.
#[test]
fn images_do_not_depend_on_how_long_precuts_are_kept() {
    let town = small(48, 40, 1);
    let every = images(&town, &kept_for(Some(1)), None);
    assert!(every.iter().any(|image| lit(image) > 500));
    let evaluations =
        |night: &Night| counts(&town, night).iter().map(|counts| counts.evaluations).sum::<u64>();
    let mut before = evaluations(&kept_for(Some(1)));
    for validity in [Some(3), Some(50), None] {
        assert!(images(&town, &kept_for(validity), None) == every, "{validity:?}");
        let evaluated = evaluations(&kept_for(validity));
        println!("validity {validity:?}: {evaluated} evaluations, {before} before");
        assert!(evaluated < before);
        before = evaluated;
    }
}

/// Row 27: whoever stands still evaluates a tenth of every frame's, and less.
#[test]
fn whoever_stands_evaluates_less_than_a_tenth() {
    let town = along("tour", 48, std::iter::repeat_n(40, 120));
    let sum = |validity| {
        counts(&town, &kept_for(validity)).iter().map(|counts| counts.evaluations).sum::<u64>()
    };
    let (every, kept, ever) = (sum(Some(1)), sum(Some(50)), sum(None));
    println!("evaluations in 120 frames: {every}, kept for 50 {kept}, for ever {ever}");
    assert!(kept * 10 <= every && ever < kept && ever > 0);
}

#[test]
fn memory_may_be_bounded_and_what_it_forgets_is_found_again() {
    let town = small(40, 12, 8);
    let free = kept_for(None);
    let most = counts(&town, &free).iter().map(|c| c.kept_bytes).max().unwrap();
    let keeping = Keeping { capacity_bytes: Some(most / 4), ..free.keeping };
    let bounded = Night { keeping, ..free };
    assert!(images(&town, &bounded, None) == images(&town, &free, None));
    let sum = |night: &Night| counts(&town, night).iter().map(|c| c.evaluations).sum::<u64>();
    assert!(sum(&bounded) >= sum(&free));
    let last = *counts(&town, &bounded).last().unwrap();
    assert!(last.kept_bytes < most, "{} of {most}", last.kept_bytes);
}

/// Row 27: of every cell, all lists at once are many more bytes than those of what is seen.
#[test]
fn a_precomputed_city_evaluates_nothing_in_its_frames_and_keeps_more() {
    let town = small(40, 5, 1);
    let precomputed = Night { precomputed: true, split: Part::Facade, ..kept_for(None) };
    let on_demand = Night { tau_px: 0.0, split: Part::Facade, ..kept_for(Some(50)) };
    assert!(images(&town, &precomputed, None) == images(&town, &on_demand, None));
    let (before, during) = (counts(&town, &precomputed), counts(&town, &on_demand));
    assert!(before.iter().all(|c| c.evaluations == 0));
    assert!(during[0].evaluations > 0);
    let (all, some) = (before[0].kept_bytes, during.last().unwrap().kept_bytes);
    println!("precomputed {all} bytes, kept {some} bytes");
    assert!(all > 4 * some, "{all} and {some}");
    let front = Front::new(&town, &precomputed, Drawer::new(&town.objects, None).unwrap());
    assert!(front.unwrap().precomputing_ns() > 0);
}

/// Row 14, and what has no list of its own begins at the roots.
#[test]
fn every_visible_object_has_a_list_or_begins_at_the_roots() {
    let town = small(48, 8, 16);
    for split in [Part::Any, Part::Storey, Part::Facade, Part::Building] {
        for whole_boxes in [true, false] {
            let night = Night { split, whole_boxes, ..Night::default() };
            let mut front =
                Front::new(&town, &night, Drawer::new(&town.objects, None).unwrap()).unwrap();
            let mut seen_and_listed = 0;
            for index in 0..town.views.len() {
                let counts = front.prepare(index).unwrap().counts;
                assert_eq!(counts.listed, counts.drawn);
                assert!(counts.cells > 0 && counts.lists <= counts.drawn);
                let roots = Starts::roots(&town.lights.roots);
                for point in &town.world(false).frames[index].points {
                    if front.drawn().contains(&point.object) {
                        seen_and_listed += 1;
                    } else {
                        assert_eq!(front.starts().of(point.object), roots.of(0));
                    }
                }
            }
            assert!(seen_and_listed > 2000, "{seen_and_listed}");
        }
    }
}

/// H5.8: cells fall as the threshold rises; H5.12: evaluations rise as it falls.
#[test]
fn finer_cells_are_more_evaluations() {
    let town = small(64, 1, 1);
    let mut before = Counts { cells: u64::MAX, evaluations: u64::MAX, ..Counts::default() };
    for power in [8, 11, 14, 17, 19] {
        let night = Night { tau_px: f64::from(1 << power), ..Night::default() };
        let now = counts(&town, &night)[0];
        println!("tau 2^{power}: {now:?}");
        assert!(now.cells <= before.cells && now.evaluations <= before.evaluations);
        before = now;
    }
}

#[test]
fn overlapping_changes_no_image() {
    let town = small(40, 6, 4);
    let night = Night::default();
    let expected = images(&town, &night, None);
    let mut pipeline = Pipeline::new(&town, &night, None).unwrap();
    let mut shaded = Shaded::default();
    let mut lit = Vec::new();
    pipeline
        .overlapped(0..town.views.len(), |index, times, lighting| {
            assert_eq!(index, lit.len());
            assert!(times.wall_ns >= times.shading_ns && times.counts.cells > 0);
            lighting.read(&mut shaded)?;
            lit.push(shaded.radiance.clone());
            Ok(())
        })
        .unwrap();
    assert!(lit == expected);
    let empty = pipeline.overlapped(3..3, |_, _, _| panic!("there is no frame"));
    empty.unwrap();
    assert!(pipeline.overlapped(5..7, |_, _, _| Ok(())).is_err());
}

#[test]
fn a_frame_after_a_reset_is_the_first_again() {
    let town = small(40, 3, 10);
    let mut pipeline = Pipeline::new(&town, &Night::default(), None).unwrap();
    let first = pipeline.frame(0, false).unwrap().counts;
    pipeline.frame(1, false).unwrap();
    pipeline.frame(2, false).unwrap();
    pipeline.reset().unwrap();
    assert_eq!(pipeline.frame(0, false).unwrap().counts, first);
    assert!(pipeline.frame(3, false).is_err());
}

/// Row 44.
#[test]
fn precuts_spare_most_visits() {
    let town = along("tour", 48, [20, 40, 60].into_iter());
    let mut pipeline = Pipeline::new(&town, &Night::default(), None).unwrap();
    let mut shaded = Shaded::default();
    for index in 0..town.views.len() {
        pipeline.frame(index, true).unwrap();
        pipeline.read(&mut shaded).unwrap();
        let culled = shaded.work.visits;
        pipeline.whole_tree(index).unwrap();
        pipeline.read(&mut shaded).unwrap();
        println!("frame {index}: {} visits, {culled} with precuts", shaded.work.visits);
        assert!(culled * 2 < shaded.work.visits);
    }
}

#[test]
fn all_lights_for_everything_is_the_whole_tree() {
    let town = along("tour", 32, [20, 60].into_iter());
    // What lies in front of one face and beside another is divided: without a threshold of the cut
    // that changes no sum.
    let cut = Absolute { threshold: 0.0, ..Night::default().cut };
    let night = Night { region: RegionTechnique::Everything, cut, ..Night::default() };
    let mut pipeline = Pipeline::new(&town, &night, None).unwrap();
    let (mut shaded, mut whole) = (Shaded::default(), Shaded::default());
    for index in 0..town.views.len() {
        pipeline.frame(index, false).unwrap();
        pipeline.read(&mut shaded).unwrap();
        pipeline.whole_tree(index).unwrap();
        pipeline.read(&mut whole).unwrap();
        assert!(lit(&whole.radiance) > 400);
        let difference = furthest(&shaded.radiance, &whole.radiance);
        assert!(difference < 1e-6, "{difference:e}");
    }
    let none = FacadeCluster { threshold: 1e30, ..FacadeCluster::default() };
    let dark = Night { region: RegionTechnique::FacadeCluster(none), ..night };
    let image = &images(&town, &dark, None)[0];
    assert!(lit(image) < lit(&whole.radiance) / 10, "{} lit", lit(image));
}
