//! What holds whatever the knobs, the latency and the path.

use super::world::{OneByOne, World, differences};
use crate::camera::queue::FrontToBack;
use crate::camera::software::owners;
use crate::camera::techniques::oracle;
use crate::camera::{
    Coverage, Frame, Memory, Results, Settings, State, Technique, TightBounds, View,
};
use glam::{DVec3, Vec3};
use proptest::prelude::*;

fn settings() -> impl Strategy<Value = Settings> {
    let flags = (any::<bool>(), any::<bool>(), any::<bool>());
    let coverage = prop::sample::select(vec![Coverage::Stale, Coverage::Summed, Coverage::Exact]);
    let technique = prop::sample::select(Technique::ALL.to_vec());
    let numbers = (1..=200u32, 0..=60u32, 0..=4u32, 1.0..=4.0f32, any::<u64>());
    let small = (prop::bool::ANY, 1..=6u32, 0..=4u32);
    (technique, flags, coverage, numbers, small).prop_map(
        |(technique, flags, coverage, (batch, assumed, depth, area, seed), small)| Settings {
            jitter: flags.0,
            visible_queue: flags.1,
            multiqueries: flags.2,
            batch: if small.0 { small.1 } else { batch },
            assumed_visible: if small.0 { small.2 } else { assumed },
            tight_bounds: TightBounds { depth, area },
            coverage,
            seed,
            ..Settings::new(technique)
        },
    )
}

fn latency() -> impl Strategy<Value = u32> {
    prop_oneof![Just(0), 1..30u32, Just(1_000_000)]
}

/// What the frustum holds and the nodes met, by a queue of all nodes, each tested in full.
fn by_queue(world: &World, view: &View) -> (Vec<u32>, u64) {
    let mut queue = FrontToBack::default();
    let (mut drawn, mut nodes) = (Vec::new(), 0);
    if !world.tree.nodes.is_empty() {
        queue.push(0.0, 0);
    }
    while let Some(index) = queue.pop() {
        nodes += 1;
        let node = &world.tree.nodes[index as usize];
        if view.sees(&node.bounds) {
            if world.tree.is_leaf(index) {
                drawn.extend_from_slice(world.tree.objects_of(index));
            }
            for child in node.children.clone() {
                queue.push(view.distance(&world.tree.nodes[child as usize].bounds), child);
            }
        }
    }
    (drawn, nodes)
}

#[test]
fn the_frustum_is_drawn_in_the_order_of_a_queue() {
    let (mut drawn, mut ties) = (0, 0);
    for seed in 0..60 {
        let mut world = World::town(seed, 70);
        if seed % 3 == 0 {
            // In a grid, many are equally far.
            let at = |i: u32| Vec3::new((i / 8) as f32 * 4.0 - 16.0, 0.0, (i % 8) as f32 * 4.0);
            let boxes: Vec<(Vec3, Vec3)> = (0..64).map(|i| (at(i), Vec3::splat(2.0))).collect();
            world = World::boxes(&boxes);
        }
        let mut views = world.jumps(seed, 8);
        views.push(world.view(DVec3::new(-20.0, 1.0, 1.0), 0.0, 0.0));
        let played = world.play(&Settings::new(Technique::Frustum), 0, &views);
        for (view, played) in views.iter().zip(&played) {
            let (list, nodes) = by_queue(&world, view);
            assert_eq!((&played.frame.drawn, played.frame.work.nodes), (&list, nodes));
            let distance = |o: &u32| view.distance(&world.objects.objects[*o as usize].bounds);
            drawn += list.len();
            ties += list.windows(2).filter(|w| distance(&w[0]) == distance(&w[1])).count();
        }
    }
    assert!(drawn > 3000 && ties > 100, "{drawn} {ties}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn the_image_is_that_of_everything(
        settings in settings(),
        latency in latency(),
        (seed, count) in (any::<u64>(), 0..70u32),
        jumps in any::<bool>(),
    ) {
        let world = World::town(seed, count);
        let views = if jumps { world.jumps(seed, 8) } else { world.walk(14) };
        let played = world.play(&settings, latency, &views);
        prop_assert!(settings.is_exact());
        prop_assert_eq!(world.faults(&settings, &views, &played), Vec::<String>::new());
    }

    #[test]
    fn no_member_of_a_group_that_showed_nothing_shows_anything(
        seed in any::<u64>(),
        latency in latency(),
    ) {
        let world = World::town(seed, 60);
        let settings = Settings { tight_bounds: TightBounds::OFF, ..Settings::new(Technique::ChcPlusPlus) };
        let mut renderer = OneByOne::new(world.renderer(latency));
        let (mut state, mut frame) = (State::new(&world.tree), Frame::default());
        for view in world.walk(8) {
            world.frame(&settings, &view, &mut state, &mut renderer, &mut frame).unwrap();
        }
        prop_assert_eq!(renderer.wrong, 0);
    }

    #[test]
    fn after_a_reset_nothing_is_remembered(
        settings in settings(),
        latency in latency(),
        seed in any::<u64>(),
        next_frame in any::<bool>(),
    ) {
        let world = World::town(seed, 40);
        let mut settings = settings;
        if next_frame && settings.technique != Technique::StopAndWait {
            settings.results = Results::NextFrame;
        }
        let mut renderer = world.renderer(latency);
        let mut state = State::new(&world.tree);
        let first = world.jumps(seed, 5);
        world.play_on(&settings, &mut state, &mut renderer, &first);
        state.reset(&mut renderer).unwrap();
        prop_assert_eq!(state.under_way(), 0);
        prop_assert!(state.nodes().iter().all(|n| *n == Memory::default()));
        let views = world.walk(6);
        let again = world.play_on(&settings, &mut state, &mut renderer, &views);
        prop_assert!(again == world.play(&settings, latency, &views));
    }

    #[test]
    fn one_by_one_and_without_options_the_revision_is_the_original(
        seed in any::<u64>(),
        latency in latency(),
        next_frame in any::<bool>(),
        jumps in any::<bool>(),
    ) {
        let world = World::town(seed, 50);
        let views = if jumps { world.jumps(seed, 8) } else { world.walk(10) };
        let results = if next_frame { Results::NextFrame } else { Results::SameFrame };
        let original = Settings { results, ..Settings::new(Technique::Chc) };
        let bare = Settings { technique: Technique::ChcPlusPlus, ..plain(original) };
        let of = |s| world.play(s, latency, &views);
        prop_assert!(of(&original) == of(&bare));
    }

    #[test]
    fn nothing_exact_draws_less_than_the_oracle(settings in settings(), seed in any::<u64>()) {
        let world = World::town(seed, 50);
        let views = world.walk(4);
        for (view, played) in views.iter().zip(world.play(&settings, 7, &views)) {
            let truth = world.truth(view);
            let pixels = owners(&truth, world.objects.objects.len());
            let owning: Vec<u32> =
                (0..pixels.len() as u32).filter(|&o| pixels[o as usize] > 0).collect();
            let mut renderer = world.renderer(0);
            let mut frame = Frame::default();
            oracle::frame(&owning, &world.objects, view, &mut renderer, &mut frame).unwrap();
            prop_assert_eq!(differences(&truth, renderer.image()), 0);
            prop_assert!(frame.work.triangles <= played.frame.work.triangles);
            prop_assert!(owning.iter().all(|o| played.frame.drawn.contains(o)));
        }
    }
}

/// The same without batches, queues, groups, tight bounds and assumptions.
pub fn plain(settings: Settings) -> Settings {
    Settings {
        batch: 1,
        assumed_visible: 0,
        jitter: false,
        visible_queue: false,
        multiqueries: false,
        tight_bounds: TightBounds::OFF,
        ..settings
    }
}

#[test]
fn groups_are_formed_and_hidden() {
    let world = World::town(3, 60);
    let settings = Settings::new(Technique::ChcPlusPlus);
    let mut renderer = OneByOne::new(world.renderer(10));
    let (mut state, mut frame) = (State::new(&world.tree), Frame::default());
    for view in world.walk(12) {
        world.frame(&settings, &view, &mut state, &mut renderer, &mut frame).unwrap();
    }
    assert!(renderer.groups > 10, "{}", renderer.groups);
    assert_eq!(renderer.wrong, 0);
}

/// Negative control: a renderer that looks at the first box of a query only.
#[test]
fn members_that_are_left_out_of_a_group_are_caught() {
    let world = World::town(3, 60);
    let settings = Settings::new(Technique::ChcPlusPlus);
    let mut renderer = OneByOne::new(world.renderer(10));
    renderer.first_box_only = true;
    let (mut state, mut frame) = (State::new(&world.tree), Frame::default());
    for view in world.walk(12) {
        world.frame(&settings, &view, &mut state, &mut renderer, &mut frame).unwrap();
    }
    assert!(renderer.wrong > 0);
}

/// Negative control: answers of the next frame in what has to be exact.
#[test]
fn answers_of_the_next_frame_are_caught_where_the_view_jumps() {
    for technique in [Technique::Chc, Technique::ChcPlusPlus] {
        let world = World::town(5, 60);
        let late = Settings { results: Results::NextFrame, ..Settings::new(technique) };
        assert!(!late.is_exact());
        let views = world.jumps(5, 12);
        let played = world.play(&late, 5, &views);
        let faults = world.faults(&late, &views, &played);
        assert!(faults.iter().any(|f| f.contains("pixels differ")), "{technique:?}");
        assert!(faults.iter().all(|f| f.contains("pixels differ")), "{faults:?}");
        // What the view keeps showing is there from the frame after on, and in the first frame.
        let still = vec![views[3].clone(); 5];
        let played = world.play(&late, 5, &still);
        assert_eq!(world.faults(&late, &still, &played), Vec::<String>::new());
    }
}

/// Negative control: what shows less than the threshold through a slit.
#[test]
fn a_threshold_is_caught_where_something_shows_through_a_slit() {
    // Two walls with a slit of two centimetres between them, and a house behind.
    let world = World::boxes(&[
        (Vec3::new(5.0, 0.0, -10.0), Vec3::new(0.5, 5.0, 9.9)),
        (Vec3::new(5.0, 0.0, 0.1), Vec3::new(0.5, 5.0, 9.9)),
        (Vec3::new(9.0, 0.3, -4.0), Vec3::new(3.0, 4.0, 8.0)),
    ]);
    let views = vec![world.view(DVec3::new(0.0, 1.7, 0.013), 0.0, 0.0); 3];
    for technique in [Technique::StopAndWait, Technique::Chc, Technique::ChcPlusPlus] {
        let exact = Settings::new(technique);
        let played = world.play(&exact, 5, &views);
        assert_eq!(world.faults(&exact, &views, &played), Vec::<String>::new());
        assert!(played.iter().all(|p| p.frame.drawn.contains(&2)));
        let coarse = Settings { threshold_px: 1000, ..exact };
        assert!(!coarse.is_exact());
        let played = world.play(&coarse, 5, &views);
        assert!(!world.faults(&coarse, &views, &played).is_empty(), "{technique:?}");
    }
}
