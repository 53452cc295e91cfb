//! Made worlds are what they say.

use dapple_many_lights::{
    Emission, Light, radiance,
    worlds::{Cloud, Facade, WINDOW, cloud, facade, plane},
};
use glam::DVec3;

fn mean(made: &dapple_many_lights::worlds::Made) -> f64 {
    let points = &made.world.frames[0].points;
    let there: Vec<_> = points.iter().filter(|p| p.is_there()).collect();
    there.iter().map(|p| made.world.truth(p).max_element()).sum::<f64>() / there.len() as f64
}

#[test]
fn clouds_are_valid_lit_alike_and_the_same_for_a_seed() {
    for lights in [0, 1, 2, 1000] {
        for emissions in [vec![Emission::Omni], vec![WINDOW, Emission::Oriented], vec![]] {
            let made = cloud(&Cloud { lights, emissions, frames: 2, ..Cloud::default() });
            made.world.check().unwrap();
            made.scene.validate().unwrap();
            assert_eq!(made.world.lights.len(), lights as usize);
            assert_eq!(made.world.frames.len(), 2);
            let points = &made.world.frames[0].points;
            let there = points.iter().filter(|p| p.is_there()).count();
            assert!(
                there > points.len() / 2 && there < points.len(),
                "{there} of {}",
                points.len()
            );
        }
    }
    let of = |seed| cloud(&Cloud { seed, ..Cloud::default() }).world.lights;
    assert_eq!(of(3), of(3));
    assert_ne!(of(3), of(4));
    let bright = |lights| {
        mean(&cloud(&Cloud { lights, emissions: vec![Emission::Omni], ..Cloud::default() }))
    };
    let (some, many) = (bright(1000), bright(4000));
    assert!(some > 0.1 && some < 2.0 && (some / many - 1.0).abs() < 0.3, "{some} {many}");
    let all = vec![Emission::Omni, Emission::Oriented, WINDOW, Emission::Directional];
    assert!(mean(&cloud(&Cloud { emissions: all, ..Cloud::default() })) > 0.1);
}

#[test]
fn walls_cast_shadows_and_the_origin_only_moves_them() {
    let near = Cloud { lights: 20, ..Cloud::default() };
    let open = mean(&cloud(&near));
    let shadowed = |made: dapple_many_lights::worlds::Made| {
        let scene = made.scene.clone();
        let world = made.with_shadows().unwrap();
        mean(&dapple_many_lights::worlds::Made { world, scene })
    };
    let dark = shadowed(cloud(&near));
    assert!(dark < 0.97 * open && dark > 0.2 * open, "{dark} of {open}");
    let far = shadowed(cloud(&Cloud { origin: DVec3::new(1000.0, 50.0, -2000.0), ..near }));
    assert!((far / dark - 1.0).abs() < 1e-3, "{far} {dark}");
}

#[test]
fn one_light_over_a_plane_gives_what_the_closed_form_says() {
    let light = Light {
        position: DVec3::Y * 2.0,
        axis: DVec3::NEG_Y,
        intensity: DVec3::ONE,
        emission: WINDOW,
    };
    let world = plane(vec![light], 4.0, [9, 9]).world;
    world.check().unwrap();
    for point in &world.frames[0].points {
        let r = f64::from(point.position.x).hypot(f64::from(point.position.z));
        let phi = (r / 2.0).atan();
        let share = (1.0 - phi / std::f64::consts::FRAC_PI_4).max(0.0);
        let expected = phi.cos().powi(3) / 4.0 * share / std::f64::consts::PI;
        let found = radiance(point, &light, world.clamp_m).x;
        assert!((found - expected).abs() < 1e-9, "{found} {expected} at {r} m");
    }
    let middle = world.frames[0].points[40];
    assert_eq!(middle.position, glam::Vec3::ZERO);
}

#[test]
fn storeys_stand_in_for_their_windows_far_too_brightly_at_their_middle() {
    let settings = Facade::default();
    let (made, keys) = facade(&settings);
    made.world.check().unwrap();
    assert_eq!(made.world.lights.len(), (settings.storeys * settings.windows) as usize);
    assert!(keys.iter().zip(&made.world.lights).all(|(k, l)| {
        k.len() == 2 && (l.position.y - 3.0 * (f64::from(k[0]) + 0.5)).abs() < 1e-12
    }));
    // Opposite of a storey's middle: all its windows as one, there, against each at its place.
    let y = 3.0 * 3.5;
    let points = &made.world.frames[0].points;
    let off = |p: &&dapple_many_lights::Point| p.position.distance(glam::vec3(0.0, y as f32, 0.0));
    let point = *points.iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
    let storey: Vec<_> =
        made.world.lights.iter().filter(|l| (l.position.y - y).abs() < 1e-9).collect();
    let truth: f64 = storey.iter().map(|l| radiance(&point, l, 0.1).x).sum();
    let one = Light {
        position: DVec3::new(0.0, y, settings.distance_m),
        intensity: storey[0].intensity * storey.len() as f64,
        ..*storey[0]
    };
    let estimate = radiance(&point, &one, 0.1).x;
    assert!(estimate > 2.0 * truth, "{estimate} for {truth}");
    assert!(made.with_shadows().unwrap().truth(&point).x > 0.0);
}

#[test]
fn scenes_are_seen_as_their_worlds_are() {
    let origin = DVec3::new(7.0, 0.5, -3.0);
    let made = cloud(&Cloud { frames: 3, origin, ..Cloud::default() });
    let path = &made.scene.paths[0];
    assert_eq!((made.scene.cameras.len(), path.frames), (1, 3));
    for frame in 0..3 {
        let eye = path.camera(frame).unwrap().position;
        let expected = origin + DVec3::new(0.25 * f64::from(frame), 7.0, 22.0);
        assert!(eye.distance(expected) < 1e-9, "frame {frame}: {eye}");
    }
    let (made, _) = facade(&Facade::default());
    let camera = &made.scene.cameras[0];
    let tracer = dapple_trace::Tracer::build(&made.scene).unwrap();
    let (from, direction) = camera.ray(0.5, 0.5, 1.0);
    // From between the wall and the facade, at the wall.
    let met = tracer.closest(&dapple_trace::Ray::new(from, direction)).unwrap();
    assert_eq!(met.triangle / 2, 0);
    assert!(made.scene.paths.is_empty());
}
