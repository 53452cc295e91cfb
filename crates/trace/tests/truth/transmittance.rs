//! Light through translucent surfaces, against products and areas.

use crate::shapes::{icosphere, level_patch, patch, rng};
use crate::translucent::{hair, layered, leaves, sheets, transformed};
use dapple_scene::{LightView, Mesh, Scene};
use dapple_trace::{
    Footprint, Hit, LEAST_TRANSMITTANCE, Law, LightPath, Opacities, Ray, Tracer, transmittance,
    transmittance_all,
};
use glam::{DAffine3, DVec3};
use rand::RngExt;

const LAWS: [Law; 2] = [Law::Product, Law::Exponential];

struct Traced {
    tracer: Tracer,
    opacities: Opacities,
    view: LightView,
}

impl Traced {
    fn lit_along(scene: &Scene, direction: DVec3) -> Self {
        let view = LightView::fit_directional(direction, &scene.bounds()).unwrap();
        Self::seen_by(scene, view)
    }

    fn seen_by(scene: &Scene, view: LightView) -> Self {
        let (tracer, opacities) = (Tracer::build(scene).unwrap(), Opacities::of(scene).unwrap());
        Self { tracer, opacities, view }
    }

    /// Receivers where light rays through random points of the map meet anything.
    fn paths(&self, rays: usize, seed: u64) -> Vec<LightPath> {
        let (mut rng, mut hits, mut paths) = (rng(seed), Vec::new(), Vec::new());
        for _ in 0..rays {
            let (origin, direction) = self.view.ray(rng.random(), rng.random());
            let ray = Ray { origin, direction, t_min: 0.0, t_max: 1.0 };
            self.tracer.all_once(&ray, &mut hits);
            paths.extend(hits.iter().map(|hit| self.path(&ray, hit)));
        }
        paths
    }

    fn path(&self, ray: &Ray, hit: &Hit) -> LightPath {
        let opaque = self.opacities.is_opaque(hit.triangle);
        LightPath { position: ray.at(hit.t), triangle: hit.triangle, opaque }
    }

    /// The first hit straight down from (x, y, z).
    fn below(&self, x: f64, y: f64, z: f64) -> LightPath {
        let ray = Ray::new(DVec3::new(x, y, z), DVec3::NEG_Y);
        self.path(&ray, &self.tracer.closest(&ray).unwrap())
    }

    fn all(&self, paths: &[LightPath], law: Law, footprint: Option<Footprint>) -> Vec<f64> {
        let Self { tracer, opacities, view } = self;
        transmittance_all(tracer, opacities, view, law, footprint, paths, 5)
    }

    fn at(&self, path: &LightPath, law: Law, footprint: Option<Footprint>) -> f64 {
        transmittance(&self.tracer, &self.opacities, &self.view, law, footprint, path, 5)
    }
}

#[test]
fn a_slab_of_sheets_steps_by_each_sheet() {
    let (count, alpha) = (20, 0.3_f32);
    let mut drawn: Vec<_> = (0..count).map(|i| (0.1 * f64::from(i), alpha)).collect();
    drawn.push((-1.0, 1.0));
    drawn.push((-2.0, 0.5));
    let scene = sheets(&drawn);
    let spot = LightView::fit_spot(DVec3::Y * 30.0, DVec3::NEG_Y, 0.02, &scene.bounds()).unwrap();
    let traced = [Traced::lit_along(&scene, DVec3::NEG_Y), Traced::seen_by(&scene, spot)];
    for traced in &traced {
        for law in LAWS {
            let step = match law {
                Law::Product => 1.0 - f64::from(alpha),
                Law::Exponential => (-f64::from(alpha)).exp(),
            };
            for i in 0..count {
                // A receiver never shadows itself: the topmost sheet is lit. On edges as well.
                for (x, z) in [(0.123, 0.2), (0.2, 0.2), (0.0, 0.0), (-0.3, 0.3)] {
                    let path = traced.below(x, 0.1 * f64::from(i) + 0.05, z);
                    let got = traced.at(&path, law, None);
                    let expected = step.powi(count - 1 - i);
                    assert!((got - expected).abs() < 1e-13, "{law:?} {i}: {got} {expected}");
                }
            }
            let floor = traced.below(0.1, -0.5, 0.2);
            assert!(floor.opaque);
            assert!((traced.at(&floor, law, None) - step.powi(count)).abs() < 1e-13);
            assert_eq!(traced.at(&traced.below(0.1, -1.5, 0.2), law, None), 0.0);
        }
    }
}

#[test]
fn surfaces_at_one_depth_do_not_shadow_each_other() {
    let scene = sheets(&[(0.5, 0.5), (0.5, 0.5), (1.0, 0.25), (0.0, 0.5)]);
    let traced = Traced::lit_along(&scene, DVec3::NEG_Y);
    for path in traced.paths(50, 1) {
        let expected = match path.triangle / 2 {
            2 => 1.0,
            3 => 0.75 * 0.25,
            _ => 0.75,
        };
        assert!((traced.at(&path, Law::Product, None) - expected).abs() < 1e-14, "{path:?}");
    }
}

#[test]
fn what_is_nearly_dark_is_dark() {
    let stack = |count: usize| {
        let mut drawn: Vec<_> = (0..count).map(|i| (0.01 * i as f64, 0.5)).collect();
        drawn.push((-1.0, 0.5));
        let traced = Traced::lit_along(&sheets(&drawn), DVec3::NEG_Y);
        let got = traced.at(&traced.below(0.1, -0.5, 0.3), Law::Product, None);
        (got, 0.5_f64.powi(count as i32))
    };
    let (got, expected) = stack(29);
    assert!(expected > LEAST_TRANSMITTANCE && (got / expected - 1.0).abs() < 1e-13);
    let (got, expected) = stack(30);
    assert!(expected < LEAST_TRANSMITTANCE);
    assert_eq!(got, 0.0);
    assert_eq!(stack(300).0, 0.0);
}

/// The definition: sort, then multiply what lies in front.
fn sorted_product(traced: &Traced, path: &LightPath) -> f64 {
    let at = traced.view.project(path.position);
    let (origin, direction) = traced.view.ray(at.x, at.y);
    let mut hits = Vec::new();
    traced.tracer.all_brute_force(&Ray { origin, direction, t_min: 0.0, t_max: 1.0 }, &mut hits);
    let in_front = hits.iter().filter(|hit| hit.t < at.z - 1e-10 && hit.triangle != path.triangle);
    in_front.map(|hit| 1.0 - f64::from(traced.opacities.alpha(hit.triangle))).product()
}

#[test]
fn foliage_and_hair_agree_with_sorting_every_triangle() {
    let camera = DVec3::new(0.0, 2.0, 9.0);
    let trunk = (icosphere(1), 1.0);
    let scene =
        layered(vec![(leaves(300, 0.3, 2), 0.4), (hair(200, 8, 0.05, camera, 3), 0.275), trunk]);
    for direction in [DVec3::NEG_Y, DVec3::new(0.4, -1.0, 0.3), DVec3::X] {
        let traced = Traced::lit_along(&scene, direction);
        let (mut partial, mut dark) = (0, 0);
        let paths = traced.paths(600, 9);
        let together = traced.all(&paths, Law::Product, None);
        for (path, together) in paths.iter().zip(together) {
            let (got, expected) =
                (traced.at(path, Law::Product, None), sorted_product(&traced, path));
            assert_eq!(got, together, "{path:?}");
            assert!((got - expected).abs() < 1e-12, "{path:?}: {got} {expected}");
            partial += i32::from(expected > 0.0 && expected < 1.0);
            dark += i32::from(expected == 0.0);
        }
        assert!(partial > 150 && dark > 150, "{partial} {dark}");
    }
}

/// y = slope * x over x and z in -1..1, in n × n cells.
fn slanted(slope: f64, n: u32) -> Mesh {
    let corner = |x: f64, z: f64| DVec3::new(x, slope * x, z);
    patch([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], n)
}

#[test]
fn a_translucent_edge_gives_a_ramp_on_opaque_ground_of_any_slope() {
    for slope in [0.0, 1.0, -2.0] {
        let roof = level_patch([-1.0, 0.1], 3.0, [-1.0, 1.0], 1);
        let traced =
            Traced::lit_along(&layered(vec![(slanted(slope, 9), 1.0), (roof, 0.6)]), DVec3::NEG_Y);
        let width_m = 0.4;
        let footprint = Footprint { width_uv: width_m / traced.view.side_m(), grid: 32 };
        for i in -8..=8 {
            let x = 0.1 + 0.05 * f64::from(i);
            let got = traced.at(&traced.below(x, 2.9, 0.03), Law::Product, Some(footprint));
            let covered = (0.5 - (x - 0.1) / width_m).clamp(0.0, 1.0);
            let expected = 1.0 - 0.6 * covered;
            // One column of 32 samples straddles the edge: 4 sigma, times the opacity.
            assert!((got - expected).abs() < 0.0067, "slope {slope}, x {x}: {got} {expected}");
        }
    }
}

#[test]
fn curved_ground_does_not_shadow_itself_under_a_wide_footprint() {
    // A ball under a sheet, with receivers all over the side that the light falls on.
    let sheet = level_patch([-2.0, 2.0], 2.0, [-2.0, 2.0], 1);
    let scene = layered(vec![(icosphere(4), 1.0), (sheet, 0.25)]);
    let traced = Traced::lit_along(&scene, DVec3::NEG_Y);
    let footprint = Footprint { width_uv: 0.3 / traced.view.side_m(), grid: 8 };
    let mut tried = 0;
    for i in -6..=6 {
        for j in -6..=6 {
            let (x, z) = (0.1 * f64::from(i), 0.1 * f64::from(j));
            if f64::hypot(x, z) < 0.7 {
                let got = traced.at(&traced.below(x, 1.9, z), Law::Product, Some(footprint));
                assert!((got - 0.75).abs() < 1e-12, "{x} {z}: {got}");
                tried += 1;
            }
        }
    }
    assert!(tried > 100, "{tried}");
    // A bowl rises in front of its tangent planes.
    let mut bowl = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 40);
    bowl.positions.iter_mut().for_each(|p| p.y = 0.5 * (p.x * p.x + p.z * p.z));
    let sheet = level_patch([-2.0, 2.0], 2.0, [-2.0, 2.0], 1);
    let hollow = Traced::lit_along(&layered(vec![(bowl, 1.0), (sheet, 0.25)]), DVec3::NEG_Y);
    for i in -5..=5 {
        let path = hollow.below(0.1 * f64::from(i), 1.9, 0.23);
        let got = hollow.at(&path, Law::Product, Some(footprint));
        assert!((got - 0.75).abs() < 1e-12, "{i}: {got}");
    }
    // The shaded side is dark behind the ball's own lit side.
    let ray = Ray::new(DVec3::new(0.1, -5.0, 0.2), DVec3::Y);
    let back = traced.path(&ray, &traced.tracer.closest(&ray).unwrap());
    assert_eq!(traced.at(&back, Law::Product, Some(footprint)), 0.0);
    assert_eq!(traced.at(&back, Law::Product, None), 0.0);
}

#[test]
fn a_translucent_receiver_stands_for_its_light_depth() {
    // A tilted blade of many pieces: the half of the square uphill lies in front.
    let traced = Traced::lit_along(&layered(vec![(slanted(1.0, 60), 0.5)]), DVec3::NEG_Y);
    let footprint = Footprint { width_uv: 0.5 / traced.view.side_m(), grid: 32 };
    let path = traced.below(0.013, 2.0, 0.02);
    let got = traced.at(&path, Law::Product, Some(footprint));
    assert!((got - 0.75).abs() < 0.01, "{got}");
    // Its own triangle does not count: of a single large one nothing else lies uphill.
    let large = Traced::lit_along(&layered(vec![(slanted(1.0, 1), 0.5)]), DVec3::NEG_Y);
    let within = large.below(0.5, 2.0, 0.5);
    assert_eq!(large.at(&within, Law::Product, Some(footprint)), 1.0);
    // As opaque ground it would not be shadowed, and a point of it is lit in either case.
    assert_eq!(traced.at(&path, Law::Product, None), 1.0);
    let ground = Traced::lit_along(&layered(vec![(slanted(1.0, 60), 1.0)]), DVec3::NEG_Y);
    let opaque = ground.below(0.013, 2.0, 0.02);
    assert_eq!(ground.at(&opaque, Law::Product, Some(footprint)), 1.0);
}

#[test]
fn scale_and_place_do_not_matter() {
    let scene = layered(vec![(leaves(300, 0.3, 2), 0.4), (slanted(0.3, 4), 1.0)]);
    let direction = DVec3::new(0.3, -1.0, 0.2);
    let base = Traced::lit_along(&scene, direction);
    let paths = base.paths(150, 3);
    assert!(paths.len() > 300);
    let footprint = Footprint { width_uv: 0.02, grid: 4 };
    for (scale, shift) in [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e5)] {
        let map = DAffine3::from_translation(DVec3::splat(shift))
            * DAffine3::from_scale(DVec3::splat(scale));
        let moved = Traced::lit_along(&transformed(scene.clone(), map), direction);
        let mut differ = 0;
        for path in &paths {
            let there = LightPath { position: map.transform_point3(path.position), ..*path };
            for window in [None, Some(footprint)] {
                let (a, b) =
                    (base.at(path, Law::Product, window), moved.at(&there, Law::Product, window));
                differ += usize::from((a - b).abs() > 1e-9);
            }
        }
        // At an edge the last bit may decide.
        assert!(differ * 200 <= paths.len(), "scale {scale}, shift {shift}: {differ}");
    }
}

#[test]
fn results_depend_neither_on_threads_nor_on_neighbours() {
    let scene = layered(vec![(leaves(300, 0.3, 2), 0.4), (slanted(0.3, 4), 1.0)]);
    let traced = Traced::lit_along(&scene, DVec3::new(0.3, -1.0, 0.2));
    let paths = traced.paths(20, 3);
    let footprint = Some(Footprint { width_uv: 0.05, grid: 3 });
    let all = |paths: &[LightPath], seed| {
        let Traced { tracer, opacities, view } = &traced;
        transmittance_all(tracer, opacities, view, Law::Product, footprint, paths, seed)
    };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| all(&paths, 11))
    };
    assert_eq!(with(1), with(3));
    assert_eq!(all(&paths[..7], 11), with(2)[..7]);
    assert_ne!(all(&paths, 12), with(2));
}

#[test]
fn nowhere_is_lit_and_a_single_triangle_does_not_shadow_itself() {
    let scene = layered(vec![(leaves(1, 0.5, 1), 0.9)]);
    let traced = Traced::lit_along(&scene, DVec3::NEG_Y);
    let footprint = Some(Footprint { width_uv: 0.01, grid: 0 });
    for path in traced.paths(40, 1) {
        assert_eq!(traced.at(&path, Law::Product, None), 1.0);
        for position in [DVec3::NAN, DVec3::INFINITY, DVec3::Y * 1e9] {
            for opaque in [false, true] {
                let nowhere = LightPath { position, opaque, ..path };
                assert_eq!(traced.at(&nowhere, Law::Product, None), 1.0);
                let filtered = traced.at(&nowhere, Law::Product, footprint);
                assert!((0.0..=1.0).contains(&filtered));
            }
        }
        let unknown = LightPath { triangle: u32::MAX, opaque: true, ..path };
        assert!((0.0..=1.0).contains(&traced.at(&unknown, Law::Product, footprint)));
    }
    let nothing = Traced::seen_by(&Scene::default(), traced.view);
    let path = LightPath { position: DVec3::ZERO, triangle: 0, opaque: false };
    assert_eq!(nothing.at(&path, Law::Product, None), 1.0);
}

#[test]
fn light_along_the_up_vector_and_along_a_blade_is_no_exception() {
    // Blades seen exactly edge-on stop nothing.
    let blade = patch(
        [(-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.25)),
        3,
    );
    let floor = level_patch([-1.0, 1.0], -1.0, [-1.0, 1.0], 1);
    let traced = Traced::lit_along(&layered(vec![(blade, 0.5), (floor, 1.0)]), DVec3::NEG_Y);
    for x in [-0.5, 0.0, 0.7] {
        for z in [0.25, 0.25 + 1e-9, 0.25 - 1e-9] {
            assert_eq!(traced.at(&traced.below(x, -0.5, z), Law::Product, None), 1.0);
        }
    }
}
