//! Worlds, knobs and renderers at their limits.

use super::world::World;
use crate::OcclusionError;
use crate::camera::techniques::{self, oracle};
use crate::camera::{
    Bounds, Frame, Memory, Query, Renderer, Results, Settings, State, Technique, View,
};
use glam::{DVec3, Vec3};

/// Every technique, at both ends of its knobs and with answers that come at once or never in time.
fn all() -> Vec<(Settings, u32)> {
    let knobs = [(1, 0), (1, 60), (200, 0), (200, 60)];
    let settings = Technique::ALL.into_iter().flat_map(|technique| {
        knobs.map(|(batch, assumed_visible)| Settings {
            batch,
            assumed_visible,
            ..Settings::new(technique)
        })
    });
    settings.flat_map(|s| [(s, 0), (s, 1_000_000)]).collect()
}

fn check(world: &World, views: &[View]) {
    for (settings, latency) in all() {
        let played = world.play(&settings, latency, views);
        let faults = world.faults(&settings, views, &played);
        assert!(faults.is_empty(), "{settings:?} {latency}: {faults:?}");
        let late = Settings { results: Results::NextFrame, ..settings };
        if late.check().is_ok() {
            assert_eq!(world.play(&late, latency, views).len(), views.len());
        }
    }
}

#[test]
fn no_objects_and_one() {
    let nothing = World::boxes(&[]);
    check(&nothing, &nothing.walk(3));
    let one = World::boxes(&[(Vec3::new(-15.0, 0.0, -1.0), Vec3::splat(3.0))]);
    check(&one, &one.walk(20));
    let played = one.play(&Settings::new(Technique::Chc), 1, &one.walk(1));
    assert_eq!(played[0].frame.drawn, [0]);
}

#[test]
fn objects_of_no_size_and_all_in_one_place() {
    let place = Vec3::new(-10.0, 1.7, 0.0);
    let points = World::boxes(&[(place, Vec3::ZERO); 20]);
    check(&points, &points.walk(4));
    let same = World::boxes(&[(place, Vec3::ONE); 20]);
    check(&same, &same.walk(4));
    let flat =
        World::boxes(&[(place, Vec3::new(0.0, 2.0, 3.0)), (place, Vec3::new(3.0, 0.0, 3.0))]);
    check(&flat, &flat.walk(4));
}

#[test]
fn an_eye_inside_of_things() {
    // Nested shells around the eye, seen from the inside.
    let shells: Vec<(Vec3, Vec3)> =
        (1..20u8).map(|i| (Vec3::splat(-f32::from(i)), Vec3::splat(2.0 * f32::from(i)))).collect();
    let world = World::boxes(&shells);
    let views: Vec<View> =
        (0..8).map(|i| world.view(DVec3::ZERO, f64::from(i) * 0.8, 0.1)).collect();
    check(&world, &views);
}

#[test]
fn a_hundred_thousand_objects() {
    let cubes: Vec<(Vec3, Vec3)> = (0..100_000u32)
        .map(|i| {
            let at = Vec3::new((i % 316) as f32 - 158.0, 0.0, (i / 316) as f32 - 158.0) * 2.0;
            (at, Vec3::new(1.0, 1.0 + (i % 7) as f32, 1.0))
        })
        .collect();
    let world = World::boxes(&cubes);
    let views = world.walk(3);
    for technique in [Technique::Chc, Technique::ChcPlusPlus] {
        let settings = Settings::new(technique);
        let played = world.play(&settings, 50, &views);
        assert_eq!(world.faults(&settings, &views, &played), Vec::<String>::new());
        assert!(played.iter().all(|p| p.frame.drawn.len() < 2_000));
    }
}

#[test]
fn the_scale_of_a_world_does_not_matter() {
    let world = World::town(9, 50);
    for settings in Technique::ALL.map(Settings::new) {
        let drawn = |world: &World, views: &[View]| -> Vec<Frame> {
            world.play(&settings, 5, views).into_iter().map(|p| p.frame).collect()
        };
        let same = drawn(&world, &world.walk(6));
        for power in [-20, 20] {
            let scaled = world.scaled(2f32.powi(power));
            assert_eq!(drawn(&scaled, &scaled.walk(6)), same, "2^{power}");
        }
        // Ten million radii away, where f64 coordinates are still exact.
        let moved = world.moved(DVec3::new(2f64.powi(28), 0.0, -2f64.powi(28)));
        assert_eq!(drawn(&moved, &moved.walk(6)), same);
    }
}

#[test]
fn frames_are_counted_without_end() {
    let world = World::town(2, 40);
    for technique in [Technique::Chc, Technique::ChcPlusPlus] {
        for results in [Results::SameFrame, Results::NextFrame] {
            let settings = Settings { results, ..Settings::new(technique) };
            let mut renderer = world.renderer(1_000_000);
            let mut state = State::new(&world.tree);
            let views = world.walk(6);
            world.play_on(&settings, &mut state, &mut renderer, &views[..3]);
            state.frame = u32::MAX;
            let played = world.play_on(&settings, &mut state, &mut renderer, &views[3..]);
            assert_eq!(state.frames(), 3);
            let faults = world.faults(&settings, &views[3..], &played);
            assert!(!settings.is_exact() || faults.is_empty(), "{settings:?} {faults:?}");
        }
    }
}

#[test]
fn states_and_trees_of_something_else_are_named() {
    let (world, other) = (World::town(1, 10), World::town(1, 20));
    let view = &world.walk(1)[0];
    let mut renderer = world.renderer(0);
    let settings = Settings::new(Technique::Chc);
    let mut frame = |objects, tree, state: &mut State, settings| {
        let mut out = Frame::default();
        techniques::frame(settings, objects, tree, view, state, &mut renderer, &mut out)
            .unwrap_err()
            .to_string()
    };
    let wrong = frame(&world.objects, &world.tree, &mut State::new(&other.tree), &settings);
    assert_eq!(wrong, "state: 39 nodes, where the tree has 19");
    let wrong = frame(&world.objects, &other.tree, &mut State::new(&other.tree), &settings);
    assert_eq!(wrong, "tree: 20 objects, where there are 10");
    let settings = Settings { batch: 0, ..settings };
    let wrong = frame(&world.objects, &world.tree, &mut State::new(&world.tree), &settings);
    assert_eq!(wrong, "batch: 0 is not in 1..=200");
    let wrong = oracle::frame(
        &[3, 10],
        &world.objects,
        view,
        &mut world.renderer(0),
        &mut Frame::default(),
    );
    assert_eq!(wrong.unwrap_err().to_string(), "owner 10: not among 10 objects");
}

/// Gives up at one call, or forgets an answer.
struct Broken<R> {
    inner: R,
    calls_left: u32,
    forgets: bool,
}

impl<R: Renderer> Broken<R> {
    fn call(&mut self) -> Result<&mut R, OcclusionError> {
        if self.calls_left == 0 {
            return Err(OcclusionError::value("device", "lost"));
        }
        self.calls_left -= 1;
        Ok(&mut self.inner)
    }
}

impl<R: Renderer> Renderer for Broken<R> {
    fn begin(&mut self, view: &View) -> Result<(), OcclusionError> {
        self.call()?.begin(view)
    }

    fn draw(&mut self, objects: &[u32]) -> Result<(), OcclusionError> {
        self.call()?.draw(objects)
    }

    fn ask(&mut self, boxes: &[Bounds], queries: &[Query]) -> Result<(), OcclusionError> {
        self.call()?.ask(boxes, queries)
    }

    fn ready(&mut self) -> Result<bool, OcclusionError> {
        self.call()?.ready()
    }

    fn collect(&mut self, counts: &mut Vec<u32>) -> Result<(), OcclusionError> {
        self.call()?.collect(counts)?;
        if self.forgets {
            counts.pop();
        }
        Ok(())
    }

    fn end(&mut self) -> Result<(), OcclusionError> {
        self.call()?.end()
    }
}

#[test]
fn after_a_failure_a_reset_leaves_nothing_behind() {
    let world = World::town(3, 40);
    let views = world.walk(4);
    for settings in Technique::ALL.map(Settings::new) {
        let fresh = world.play(&settings, 5, &views);
        let mut failures = 0;
        for calls_left in 0..60 {
            let mut renderer = Broken { inner: world.renderer(5), calls_left, forgets: false };
            let mut state = State::new(&world.tree);
            let mut out = Frame::default();
            for view in &views {
                if world.frame(&settings, view, &mut state, &mut renderer, &mut out).is_err() {
                    failures += 1;
                    break;
                }
            }
            renderer.calls_left = u32::MAX;
            state.reset(&mut renderer).unwrap();
            assert!(state.nodes().iter().all(|n| *n == Memory::default()));
            let again = world.play_on(&settings, &mut state, &mut renderer.inner, &views);
            assert!(again == fresh, "{settings:?} {calls_left}");
        }
        assert!(failures > 3);
    }
}

#[test]
fn a_renderer_that_forgets_an_answer_is_named() {
    let world = World::town(3, 40);
    let mut renderer = Broken { inner: world.renderer(5), calls_left: u32::MAX, forgets: true };
    let mut state = State::new(&world.tree);
    let settings = Settings::new(Technique::StopAndWait);
    let mut out = Frame::default();
    // From far off, so that the first node can be asked.
    let view = world.view(DVec3::new(-60.0, 2.0, 0.0), 0.0, 0.0);
    let error = world.frame(&settings, &view, &mut state, &mut renderer, &mut out).unwrap_err();
    assert_eq!(error.to_string(), "renderer: 0 answers to 1 queries");
}
