//! Lights that move, beside a city's own.

mod town_support;

use dapple_many_lights::{
    Absolute, Emission, Light, LightTree, Shaded, radiance,
    tree::{Build, Representative},
};
use dapple_night_city::{Night, Pipeline};
use glam::{DVec3, Vec3};
use town_support::along;

/// Row 32: a light that moves is lit in the next frame, where it is then, on top of all others.
#[test]
fn a_light_that_moves_is_lit_where_it_is_in_the_next_frame() {
    let town = along("tour", 40, std::iter::repeat_n(60, 4));
    let frame = &town.world(false).frames[0];
    // Without a threshold trees sum up to their lights.
    let cut = Absolute { threshold: 0.0, ..Night::default().cut };
    let mut pipeline = Pipeline::new(&town, &Night { cut, ..Night::default() }, None).unwrap();
    let mut shaded = Shaded::default();
    pipeline.frame(0, false).unwrap();
    pipeline.read(&mut shaded).unwrap();
    let without = shaded.radiance.clone();
    let middle = frame.points[frame.points.len() / 2];
    for (index, metres) in [(1, 1.0), (2, 2.5)] {
        let at = middle.position.as_dvec3() + middle.normal.as_dvec3() * metres;
        let one = |place: DVec3| Light {
            position: place,
            axis: DVec3::NEG_Y,
            intensity: DVec3::new(3.0, 2.0, 1.0),
            emission: Emission::Omni,
        };
        let lights = [one(at), one(at + DVec3::Y)];
        let tree = LightTree::build(&lights, Build::Median, Representative::Weighted).unwrap();
        pipeline.replace_moving(&lights, &tree).unwrap();
        pipeline.frame(index, false).unwrap();
        pipeline.read(&mut shaded).unwrap();
        let mut brighter = 0;
        for ((point, with), without) in frame.points.iter().zip(&shaded.radiance).zip(&without) {
            if !point.is_there() {
                assert_eq!(*with, Vec3::ZERO);
                continue;
            }
            let world = town.world(false);
            let added: DVec3 = lights.iter().map(|l| radiance(point, l, world.clamp_m)).sum();
            let expected = without.as_dvec3() + added;
            let off = (with.as_dvec3() - expected).abs().max_element();
            assert!(off <= 1e-4 * (1.0 + expected.max_element()), "{with} and {expected}");
            brighter += usize::from(added.max_element() > 0.01);
        }
        assert!(brighter > 100, "{brighter}");
    }
    pipeline.replace_moving(&[], &LightTree::default()).unwrap();
    pipeline.frame(3, false).unwrap();
    pipeline.read(&mut shaded).unwrap();
    assert!(shaded.radiance == without);
}
