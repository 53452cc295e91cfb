//! Which occluders are drawn, at any budget, scale and place.

use super::culling::{everything, inner_boxes, play, same, settings, views};
use super::*;
use crate::camera::techniques::tests::world::World;
use crate::camera::{Frame, View};
use glam::DVec3;

fn limited(occluders: Occluders, most_triangles: u64) -> Settings {
    Settings { most_triangles, ..settings(occluders, None) }
}

/// Looks along x from the origin.
fn ahead(world: &World) -> View {
    world.view(DVec3::ZERO, 0.0, 0.0)
}

/// The lesser depths that are held for each subtile.
fn references(world: &World, settings: Settings, view: &View) -> Vec<f32> {
    let mut culler = Culler::new(settings, &world.objects, &inner_boxes(world)).unwrap();
    let mut frame = Frame::default();
    culler.frame(&world.objects, &world.tree, view, &mut world.renderer(0), &mut frame).unwrap();
    assert!(culler.occluder_triangles() <= settings.most_triangles);
    culler.buffer().tiles.iter().flat_map(|t| t.reference).collect()
}

#[test]
fn the_largest_is_taken_before_the_nearest() {
    let world = World::boxes(&[
        (Vec3::new(2.0, 0.4, 0.4), Vec3::splat(0.2)),
        (Vec3::new(6.0, -4.0, -5.0), Vec3::new(1.0, 8.0, 4.0)),
        (Vec3::new(9.0, -1.0, -3.0), Vec3::ONE),
    ]);
    for occluders in [Occluders::Meshes, Occluders::InnerBoxes] {
        let drawn = |most| play(&world, limited(occluders, most), &ahead(&world)).0.drawn;
        assert_eq!(drawn(12), [0, 1], "{occluders:?}");
        // The control: without any, all are drawn.
        assert_eq!(drawn(11), [0, 1, 2], "{occluders:?}");
    }
}

#[test]
fn what_is_hidden_costs_no_triangles() {
    let mut boxes = vec![
        (Vec3::new(4.0, -4.0, 0.5), Vec3::new(0.5, 8.0, 4.0)),
        (Vec3::new(20.0, -8.0, -9.0), Vec3::new(1.0, 16.0, 8.0)),
        (Vec3::new(30.0, -1.0, -6.0), Vec3::ONE),
    ];
    boxes.extend(
        (0..20u8)
            .map(|i| (Vec3::new(6.0 + 0.25 * f32::from(i), -2.0, 1.5), Vec3::new(0.1, 4.0, 2.0))),
    );
    let world = World::boxes(&boxes);
    for occluders in [Occluders::Meshes, Occluders::InnerBoxes] {
        let drawn = |most| play(&world, limited(occluders, most), &ahead(&world)).0.drawn;
        assert_eq!(drawn(24), [0, 1], "{occluders:?}");
        assert!(drawn(12).contains(&2), "{occluders:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn more_triangles_lower_no_reference(seed: u64, count in 1..120u32, meshes: bool) {
        let world = World::town(seed, count);
        let occluders = if meshes { Occluders::Meshes } else { Occluders::InnerBoxes };
        for view in views(&world, seed) {
            let mut before: Option<Vec<f32>> = None;
            for most in [0, 24, 60, 240, 600, u64::MAX] {
                let here = references(&world, limited(occluders, most), &view);
                if let Some(before) = before {
                    prop_assert!(before.iter().zip(&here).all(|(a, b)| a <= b), "{most}");
                }
                before = Some(here);
            }
        }
    }

    #[test]
    fn any_budget_shows_everything(seed: u64, count in 0..120u32, most in 0..1500u64, meshes: bool) {
        let world = World::town(seed, count);
        let occluders = if meshes { Occluders::Meshes } else { Occluders::InnerBoxes };
        for view in views(&world, seed) {
            let image = play(&world, limited(occluders, most), &view).1;
            prop_assert!(same(&image, &everything(&world, &view)));
        }
    }

    #[test]
    fn at_any_scale_and_place_everything_shows(
        seed: u64,
        power in -6.0..=6.0f32,
        place in (-1.0..1.0f64, -1.0..1.0f64),
        columns in prop::option::of(8..200u32),
        meshes: bool,
    ) {
        let scale = 10f32.powf(power);
        let far = 1e7 * 30.0 * f64::from(scale);
        let by = DVec3::new(place.0 * far, 0.0, place.1 * far);
        let world = World::town(seed, 60).scaled(scale).moved(by);
        let occluders = if meshes { Occluders::Meshes } else { Occluders::InnerBoxes };
        for view in world.walk(6) {
            let image = play(&world, settings(occluders, columns), &view).1;
            prop_assert!(same(&image, &everything(&world, &view)));
        }
    }
}

/// Powers of two change no digit, so the same is drawn.
#[test]
fn the_scale_of_a_world_does_not_matter() {
    for occluders in [Occluders::Meshes, Occluders::InnerBoxes] {
        for columns in [None, Some(96)] {
            let settings = settings(occluders, columns);
            let drawn = |world: &World| -> Vec<Frame> {
                world.walk(6).iter().map(|view| play(world, settings, view).0).collect()
            };
            let world = World::town(9, 50);
            let same = drawn(&world);
            assert!(same.iter().any(|f| f.drawn.len() < 40));
            for power in [-20, 20] {
                assert_eq!(drawn(&world.scaled(2f32.powi(power))), same, "2^{power}");
            }
            // Ten million radii away, where f64 coordinates are still exact.
            let moved = world.moved(DVec3::new(2f64.powi(28), 0.0, -2f64.powi(28)));
            assert_eq!(drawn(&moved), same);
        }
    }
}
