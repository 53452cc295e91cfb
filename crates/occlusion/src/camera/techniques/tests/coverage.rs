//! Coverage is an upper estimate of the pixels that nodes own.

use super::world::World;
use crate::camera::software::owners;
use crate::camera::{Coverage, Settings, State, Technique, Tree, exact_coverage};
use glam::{DVec3, Vec3};
use proptest::prelude::*;

/// Pixels that each node owns in the image last drawn.
fn pixels(world: &World, image: &crate::camera::Image) -> Vec<u32> {
    let mut pixels = vec![0; world.tree.nodes.len()];
    let per_object = owners(image, world.objects.objects.len());
    exact_coverage(&world.tree, &per_object, &mut pixels).unwrap();
    pixels
}

/// Nodes said to cover less than they own; of leaves only, or of all.
fn too_low(tree: &Tree, coverage: &[u32], pixels: &[u32], all: bool) -> usize {
    (0..tree.nodes.len())
        .filter(|&n| all || tree.is_leaf(n as u32))
        .filter(|&n| coverage[n] < pixels[n])
        .count()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn what_was_asked_in_this_frame_covers_at_least_what_it_owns(
        seed in any::<u64>(),
        latency in 0..30u32,
        technique in prop::sample::select(vec![Technique::StopAndWait, Technique::Chc]),
        summed in any::<bool>(),
    ) {
        let world = World::town(seed, 50);
        let coverage = if summed { Coverage::Summed } else { Coverage::Stale };
        let settings = Settings { coverage, ..Settings::new(technique) };
        let mut renderer = world.renderer(latency);
        let mut state = State::new(&world.tree);
        for view in world.jumps(seed, 6) {
            let played = world.play_on(&settings, &mut state, &mut renderer, &[view]);
            let owned = pixels(&world, &played[0].image);
            prop_assert_eq!(too_low(&world.tree, state.coverage(), &owned, summed), 0);
        }
    }

    #[test]
    fn old_answers_cover_again_what_is_owned_once_the_view_rests(
        seed in any::<u64>(),
        latency in 0..30u32,
        assumed_visible in 0..8u32,
    ) {
        let world = World::town(seed, 50);
        let settings = Settings {
            assumed_visible,
            coverage: Coverage::Summed,
            ..Settings::new(Technique::ChcPlusPlus)
        };
        let mut renderer = world.renderer(latency);
        let mut state = State::new(&world.tree);
        let mut views = world.walk(5);
        views.extend(vec![views[4].clone(); assumed_visible as usize + 3]);
        let played = world.play_on(&settings, &mut state, &mut renderer, &views);
        let owned = pixels(&world, &played.last().unwrap().image);
        prop_assert_eq!(too_low(&world.tree, state.coverage(), &owned, true), 0);
    }
}

/// Negative control: the largest child instead of the sum of all.
#[test]
fn a_wrong_sum_is_caught() {
    let world = World::town(4, 50);
    let settings = Settings { coverage: Coverage::Summed, ..Settings::new(Technique::Chc) };
    let mut renderer = world.renderer(5);
    let mut state = State::new(&world.tree);
    let played = world.play_on(&settings, &mut state, &mut renderer, &world.walk(3));
    let owned = pixels(&world, &played[2].image);
    assert_eq!(too_low(&world.tree, state.coverage(), &owned, true), 0);
    let mut wrong = state.coverage().to_vec();
    for node in (0..wrong.len()).rev().filter(|&n| !world.tree.is_leaf(n as u32)) {
        let children = world.tree.nodes[node].children.clone();
        wrong[node] = children.map(|c| wrong[c as usize]).max().unwrap();
    }
    assert!(too_low(&world.tree, &wrong, &owned, true) > 0);
}

#[test]
fn what_leaves_the_view_covers_nothing_and_what_cannot_be_asked_everything() {
    let cube = |x: f32| (Vec3::new(x, 0.0, -1.0), Vec3::splat(2.0));
    // The eye stands just above a slab, near enough for the near plane to cut it.
    let slab = (Vec3::new(-1.0, -1.0, -1.0), Vec3::new(2.0, 1.95, 2.0));
    let world = World::boxes(&[cube(10.0), cube(-10.0), slab]);
    for technique in [Technique::StopAndWait, Technique::Chc, Technique::ChcPlusPlus] {
        let settings = Settings::new(technique);
        let mut renderer = world.renderer(1);
        let mut state = State::new(&world.tree);
        let leaf = |object: u32| {
            let is = |n: &u32| world.tree.is_leaf(*n) && world.tree.objects_of(*n) == [object];
            (0..world.tree.nodes.len() as u32).find(is).unwrap() as usize
        };
        let eye = DVec3::new(0.0, 1.0, 0.0);
        for (heading, ahead, behind) in [(0.0, 0, 1), (std::f64::consts::PI, 1, 0)] {
            let views = [world.view(eye, heading, 0.0)];
            world.play_on(&settings, &mut state, &mut renderer, &views);
            let coverage = state.coverage();
            assert!(coverage[leaf(ahead)] > 0, "{technique:?}");
            assert_eq!(coverage[leaf(behind)], 0, "{technique:?}");
            assert_eq!(coverage[leaf(2)], 48 * 32, "{technique:?}");
        }
    }
}

#[test]
fn exact_coverage_is_the_callers() {
    let world = World::town(4, 30);
    let settings = Settings { coverage: Coverage::Exact, ..Settings::new(Technique::ChcPlusPlus) };
    let mut renderer = world.renderer(5);
    let mut state = State::new(&world.tree);
    let views = world.walk(3);
    let played = world.play_on(&settings, &mut state, &mut renderer, &views);
    assert!(state.coverage().iter().all(|&c| c == 0), "answers are not stored");
    let owned = pixels(&world, &played[2].image);
    state.coverage_mut().copy_from_slice(&owned);
    world.play_on(&settings, &mut state, &mut renderer, &views);
    assert_eq!(state.coverage(), owned);
    let drawn = played[2].image.ids.iter().filter(|id| id[0] > 0).count();
    assert_eq!(owned[0] as usize, drawn);
}
