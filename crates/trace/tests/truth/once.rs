//! Rays through shared edges and vertices, each surface counted once.

use crate::shapes::{cube, icosphere, level_patch, placed, rng, scene, unit_vector};
use dapple_trace::{Ray, Tracer};
use glam::{DAffine3, DQuat, DVec3};

fn counts(tracer: &Tracer, ray: &Ray) -> (usize, usize) {
    let (mut all, mut once) = (Vec::new(), Vec::new());
    tracer.all(ray, &mut all);
    tracer.all_once(ray, &mut once);
    assert!(once.iter().all(|hit| all.contains(hit)));
    (all.len(), once.len())
}

#[test]
fn a_tessellated_plane_is_met_once_at_every_edge_and_vertex() {
    let n = 8;
    let scene = placed(level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], n));
    let tracer = Tracer::build(&scene).unwrap();
    let mut doubled = 0;
    // Multiples of a quarter of a cell: vertices, both kinds of edges, diagonals, interiors.
    for i in 1..4 * n {
        for j in 1..4 * n {
            let at = |k: u32| -1.0 + f64::from(k) / f64::from(2 * n);
            for up in [1.0, -1.0] {
                let ray = Ray::new(DVec3::new(at(i), up, at(j)), DVec3::new(0.0, -up, 0.0));
                let (all, once) = counts(&tracer, &ray);
                assert_eq!(once, 1, "{i} {j}");
                doubled += usize::from(all > 1);
            }
        }
    }
    assert!(doubled > 600, "the rays meet edges: {doubled}");
}

#[test]
fn a_tilted_plane_is_met_once_along_slanted_rays() {
    let mut random = rng(4);
    let (mut tried, mut doubled) = (0, 0);
    for _ in 0..20 {
        let turn = DQuat::from_rotation_arc(DVec3::Y, unit_vector(&mut random));
        let patch = level_patch([-1.0, 1.0], 0.0, [-1.0, 1.0], 8);
        let scene = scene(vec![(patch, DAffine3::from_quat(turn))]);
        let tracer = Tracer::build(&scene).unwrap();
        let corners: Vec<_> = scene.world_triangles().map(|t| t.1).collect();
        for (k, [a, b, c]) in corners.iter().enumerate() {
            // Towards corners and middles of edges from a point off the plane.
            let from = turn * DVec3::new(0.3, 2.0, 0.1 * (k % 7) as f64);
            for target in [*a, *b, *c, (*a + *b) * 0.5, (*b + *c) * 0.5] {
                if (turn.inverse() * target).abs().max_element() > 0.9 {
                    continue;
                }
                let (all, once) = counts(&tracer, &Ray::new(from, target - from));
                assert_eq!(once, 1);
                tried += 1;
                doubled += usize::from(all > 1);
            }
        }
    }
    assert!(tried > 5000 && doubled > 100, "{doubled} of {tried}");
}

#[test]
fn a_closed_body_is_met_an_even_number_of_times() {
    let mut random = rng(7);
    for mesh in [cube(), icosphere(2)] {
        let corners: Vec<DVec3> = mesh.positions.iter().map(|p| p.as_dvec3()).collect();
        let scene = placed(mesh);
        let tracer = Tracer::build(&scene).unwrap();
        let mut met = 0;
        for corner in corners.iter().cycle().take(400) {
            let from = unit_vector(&mut random) * 5.0;
            let (_, once) = counts(&tracer, &Ray::new(from, *corner - from));
            assert_eq!(once % 2, 0);
            met += once;
        }
        assert!(met > 100, "{met}");
    }
}
