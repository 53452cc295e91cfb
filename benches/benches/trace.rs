//! Closest-hit rate of the ground-truth tracer beside plain obvhs BVH2 on the same rays: the same
//! build preset and thread counts, obvhs with its own f32 triangle test and triangles in leaf order.
//!
//! Both are checked against each other before anything is timed.
#![allow(missing_docs, reason = "criterion_group! writes an undocumented function")]
#![allow(clippy::print_stderr, reason = "a bench reports what it checked")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dapple_scene::{Instance, Material, Mesh, Scene};
use dapple_trace::{Ray, Tracer};
use glam::{DAffine3, Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Duration;

const SIDE: u32 = 188;
const RAYS: u32 = 1 << 16;

/// A bumpy square of 2 * 188^2 = 70 688 triangles.
fn terrain() -> Mesh {
    let height = |x: f32, z: f32| {
        let octave = |f: f32| (x * f + 0.3 * f).sin() * (z * f * 1.1).cos() / f;
        octave(3.0) + octave(7.0) + octave(17.0) + octave(41.0)
    };
    let at = |i: u32| 2.0 * i as f32 / SIDE as f32 - 1.0;
    let rows = (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| (at(x), at(z))));
    let positions = rows.map(|(x, z)| Vec3::new(x, 0.5 * height(x, z), z)).collect();
    let cells = (0..SIDE).flat_map(|z| (0..SIDE).map(move |x| z * (SIDE + 1) + x));
    let triangles =
        cells.flat_map(|i| [[i, i + SIDE + 1, i + 1], [i + 1, i + SIDE + 1, i + SIDE + 2]]);
    Mesh { positions, triangles: triangles.collect(), ..Mesh::default() }
}

/// (origin, direction) pairs that f32 holds exactly: a camera's image, or rays between points of
/// the scene's box in no order.
fn rays(coherent: bool) -> Vec<(Vec3, Vec3)> {
    let side = f64::from(RAYS).sqrt() as u32;
    // Weyl sequences of the plastic number's powers: fixed, even, and without visible order.
    let weyl = |i: u32, k: u32| {
        let step = [0.819_172_5, 0.671_043_6, 0.549_700_5, 0.450_299_5, 0.368_877_1][k as usize];
        ((f64::from(i) * step).fract() * 2.0 - 1.0) as f32
    };
    let ray = |i: u32| {
        if coherent {
            let pixel = |p: u32| 2.0 * (p as f32 + 0.5) / side as f32 - 1.0;
            let (x, y) = (pixel(i % side), pixel(i / side));
            let origin = Vec3::new(0.0, 1.5, 2.5);
            (origin, Vec3::new(0.5 * x, 0.35 * y - 0.6, -1.0).normalize())
        } else {
            let origin = Vec3::new(weyl(i, 0), 0.6, weyl(i, 1));
            (origin, Vec3::new(weyl(i, 2), -0.6, weyl(i, 3)).normalize())
        }
    };
    (0..side * side).map(ray).collect()
}

struct Plain {
    bvh: Bvh2,
    triangles: Vec<Triangle>,
}

impl Plain {
    fn build(mesh: &Mesh) -> Self {
        let corner = |v: u32| Vec3A::from(mesh.positions[v as usize]);
        let triangle =
            |t: &[u32; 3]| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) };
        let mut triangles: Vec<Triangle> = mesh.triangles.iter().map(triangle).collect();
        let parameters = BvhBuildParams::medium_build();
        let bvh = build_bvh2_from_tris(&triangles, parameters, &mut Duration::default());
        triangles = bvh.primitive_indices.iter().map(|&i| triangles[i as usize]).collect();
        Self { bvh, triangles }
    }

    fn closest(&self, &(o, d): &(Vec3, Vec3)) -> Option<f64> {
        let mut hit = RayHit::none();
        let ray = obvhs::ray::Ray::new_inf(o.into(), d.into());
        self.bvh.ray_traverse(ray, &mut hit, |ray, slot| self.triangles[slot].intersect(ray));
        hit.t.is_finite().then(|| f64::from(hit.t))
    }
}

fn ours(tracer: &Tracer, (o, d): &(Vec3, Vec3)) -> Option<f64> {
    tracer.closest(&Ray::new(o.as_dvec3(), d.as_dvec3())).map(|hit| hit.t)
}

/// Both see the same surface: ours misses nothing the other hits, and all but rays at edges agree.
fn check(tracer: &Tracer, plain: &Plain, rays: &[(Vec3, Vec3)], name: &str) {
    let (mut both, mut only_ours, mut only_plain, mut apart) = (0, 0, 0, 0);
    for ray in rays {
        match (ours(tracer, ray), plain.closest(ray)) {
            (Some(a), Some(b)) => {
                both += 1;
                apart += i32::from((a - b).abs() > 1e-4);
            }
            (Some(_), None) => only_ours += 1,
            (None, Some(_)) => only_plain += 1,
            (None, None) => {}
        }
    }
    let at_edges = rays.len() as i32 / 1000;
    eprintln!(
        "{name}: {} rays, hit by both {both}, by ours alone {only_ours}, by obvhs alone \
         {only_plain}, distances apart {apart}",
        rays.len()
    );
    assert!(both > rays.len() as i32 / 4, "too few hits to compare");
    assert!(only_ours <= at_edges && only_plain <= at_edges && apart <= at_edges);
}

fn closest(c: &mut Criterion) {
    let mesh = terrain();
    let plain = Plain::build(&mesh);
    let scene = Scene {
        meshes: vec![mesh],
        materials: vec![Material::default()],
        instances: vec![Instance { mesh: 0, transform: DAffine3::IDENTITY }],
        ..Scene::default()
    };
    let Ok(tracer) = Tracer::build(&scene) else {
        unreachable!("the terrain is finite");
    };
    for (name, coherent) in [("camera", true), ("scattered", false)] {
        let rays = rays(coherent);
        check(&tracer, &plain, &rays, name);
        let mut group = c.benchmark_group(format!("trace/closest/{name}"));
        group.throughput(Throughput::Elements(rays.len() as u64)).sample_size(15);
        group.warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
        for threads in [1, rayon::current_num_threads()] {
            let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else {
                continue;
            };
            let count = |closest: &(dyn Fn(&(Vec3, Vec3)) -> Option<f64> + Sync)| {
                let chunk = |c: &[(Vec3, Vec3)]| c.iter().filter_map(closest).count();
                pool.install(|| rays.par_chunks(1024).map(chunk).sum::<usize>())
            };
            group.bench_function(BenchmarkId::new("dapple f64", threads), |b| {
                b.iter(|| black_box(count(&|ray| ours(&tracer, ray))));
            });
            group.bench_function(BenchmarkId::new("obvhs f32", threads), |b| {
                b.iter(|| black_box(count(&|ray| plain.closest(ray))));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, closest);
criterion_main!(benches);
