//! The truths that all techniques are held against: sorted fragments, light rays, volumes.

use super::{ALL, About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::{
    Model,
    exact::{self, Exact},
};
use dapple_scene::{Instance, LightView, Material, Mesh, Scene};
use dapple_trace::{
    Ball, Law, LightPath, Opacities, Profile, Ray, Tracer, Voxels, optical_depth, volume_fragments,
};
use glam::{DAffine3, DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "sorted fragments",
                "the uncompressed deep shadow map sums what lies strictly in front",
                "what lies level is counted too",
            ),
            prefix,
        ),
        gate(
            about(
                "row 4 slab",
                "n even fragments of one thickness are within 1/n of the slab's exponential",
                "the last fragment is lost",
            ),
            slab,
        ),
        gate(
            about(
                "models",
                "thickness of an opacity is -ln(1 - α) up to 1 - 2^-10, or α itself",
                "the other model",
            ),
            models,
        ),
        gate(
            about(
                "law of rays",
                "light rays multiply 1 - α, or e to the minus α, of what lies in front; behind an \
                 opaque surface they bring nothing",
                "the other law",
            ),
            |context, faulty| rays(context, faulty, false),
        ),
        gate(
            about(
                "rays and maps",
                "a light ray through a texel's centre brings what the texel's sorted fragments let \
                 through",
                "the map's thickness is of the other model",
            ),
            |context, faulty| rays(context, faulty, true),
        ),
        gate(
            about(
                "row 5 voxels",
                "a march through voxels is within 1 % of the chords of a homogeneous sphere",
                "the sphere's extinction is 3 % greater",
            ),
            voxels,
        ),
        gate(
            about(
                "row 38 volumes",
                "slices of metaballs add up to the exact optical depth of every light ray",
                "balls are drawn as surfaces: two fragments of one opacity each",
            ),
            volumes,
        ),
    ]
}

fn prefix(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "prefix", case);
        let fragments = input::fragments(&mut rng);
        let exact = Exact::of(&fragments);
        for texel in 0..fragments.texels() {
            let mut depths: Vec<f32> = (0..10).map(|_| rng.random_range(-0.1..1.1)).collect();
            depths.extend(fragments.texel(texel).iter().map(|f| f.depth));
            for depth in depths {
                let seen = if faulty { depth.next_up() } else { depth };
                let expected = input::prefix(&fragments, texel, |z| z < depth);
                let found = exact.omega(texel, seen);
                let what = || format!("texel {texel} at {depth}: {found} {expected}");
                tally.within((found - expected).abs(), 1e-12, what);
            }
        }
    }
    Ok(tally)
}

fn slab(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "slab", case);
        let (n, sigma) = (rng.random_range(4..200_usize), rng.random_range(0.2..2.0_f64));
        let one = |i: usize| {
            let depth = (i as f64 + 0.5) / n as f64;
            (depth as f32, (sigma / n as f64) as f32)
        };
        let mut fragments = input::map(1, &[(0..n).map(one).collect()]);
        if faulty {
            // At the end it lacks a whole slice, not half.
            fragments = input::without_last(&input::without_last(&fragments));
        }
        let exact = Exact::of(&fragments);
        for i in 0..=40_u8 {
            let depth = f32::from(i) / 40.0;
            let expected = (-sigma * f64::from(depth)).exp();
            let off = (exact.transmittance(0, depth) - expected).abs() / sigma.max(1.0);
            // Half a slice, of a slope of at most sigma.
            let bound = 0.51 / n as f64 * sigma.min(1.0);
            tally.within(off, bound, || format!("{n} fragments of sigma {sigma} at {depth}"));
        }
    }
    Ok(tally)
}

fn models(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let [tau, raw] = match faulty {
        false => [Model::ExpTau, Model::ExpAlpha],
        true => [Model::ExpAlpha, Model::ExpTau],
    };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "models", case);
        let opacities = [0.0, 1.0 / 255.0, 0.999, 1.0, rng.random_range(0.0..1.0_f64)];
        for alpha in opacities {
            let left = (1.0 - alpha).max(1.0 / 1024.0);
            let off = ((-tau.omega(alpha)).exp() - left).abs();
            tally.within(off, 1e-12, || format!("-ln(1 - {alpha})"));
            tally.within((raw.omega(alpha) - alpha).abs(), 0.0, || format!("{alpha}"));
        }
    }
    Ok(tally)
}

/// Level sheets over -1..1 in x and z, one a (height, opacity).
fn sheets(heights: &[(f64, f32)]) -> Scene {
    let mut scene = Scene { name: "sheets".into(), ..Scene::default() };
    for (i, &(y, opacity)) in (0..).zip(heights) {
        let corner = |x: f32, z: f32| Vec3::new(x, y as f32, z);
        scene.meshes.push(Mesh {
            positions: vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: i,
            ..Mesh::default()
        });
        scene.materials.push(Material { opacity, ..Material::default() });
        scene.instances.push(Instance { mesh: i, transform: DAffine3::IDENTITY });
    }
    scene
}

fn rays(context: &GateContext<'_>, faulty: bool, against_map: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(16) {
        let mut rng = input::rng(context.seed, "rays", case);
        let count = rng.random_range(1..12);
        let mut all: Vec<(f64, f32)> =
            (0..count).map(|i| (0.1 * f64::from(i), rng.random_range(0.05..0.9))).collect();
        // An opaque sheet below, and a translucent one that nothing reaches.
        all.extend([(-1.0, 1.0), (-2.0, 0.5)]);
        let scene = sheets(&all);
        let down = DVec3::new(rng.random_range(-0.1..0.1), -1.0, rng.random_range(-0.1..0.1));
        let view = LightView::fit_directional(down, &scene.bounds())?;
        let (tracer, opacities) = (Tracer::build(&scene)?, Opacities::of(&scene)?);
        let side = 8;
        let map = dapple_trace::light_fragments(&tracer, &view, side, side)?;
        for (law, model) in [(Law::Product, Model::ExpTau), (Law::Exponential, Model::ExpAlpha)] {
            let other = faulty != (law == Law::Exponential);
            let model = match (against_map, other) {
                (false, _) => model,
                (true, false) => Model::ExpTau,
                (true, true) => Model::ExpAlpha,
            };
            let fragments = exact::collect(side, side, &map.starts, model, |i| {
                let triangle = map.triangle[i];
                (map.depth[i], opacities.alpha(triangle), opacities.is_opaque(triangle))
            });
            let exact = Exact::of(&fragments);
            for (i, (y, alpha)) in all.iter().enumerate() {
                // Just above where the light ray through a texel's centre meets the sheet.
                let (column, row) = (rng.random_range(2..6_u32), rng.random_range(2..6_u32));
                let centre = |at: u32| (f64::from(at) + 0.5) / f64::from(side);
                let (origin, direction) = view.ray(centre(column), centre(row));
                let above = y + 1e-4;
                let position = origin + direction * ((above - origin.y) / direction.y);
                let opaque = *alpha >= 1.0;
                let path = LightPath { position, triangle: u32::MAX, opaque };
                let found =
                    dapple_trace::transmittance(&tracer, &opacities, &view, law, None, &path, 0);
                let in_front: Vec<f64> =
                    all.iter().filter(|s| s.0 > *y).map(|s| f64::from(s.1)).collect();
                let dark = in_front.iter().any(|a| *a >= 1.0);
                let expected = if dark {
                    0.0
                } else if against_map {
                    let texel = (row * side + column) as usize;
                    exact.transmittance(texel, view.project(position).z as f32)
                } else if other {
                    in_front.iter().map(|a| (-a).exp()).product()
                } else {
                    in_front.iter().map(|a| 1.0 - a).product()
                };
                let what = || format!("{law:?}, sheet {i} of {all:?}: {found} {expected}");
                tally.within((found - expected).abs(), 1e-6, what);
            }
        }
    }
    Ok(tally)
}

fn ball(rng: &mut Pcg64, profile: Profile) -> Ball {
    let mut any = || rng.random_range(-1.0..1.0_f64);
    let centre = DVec3::new(any(), any(), any());
    Ball { centre, radius: 0.7 + 0.3 * any(), extinction: 1.0 + 0.8 * any(), profile }
}

fn voxels(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases.min(4) {
        let mut rng = input::rng(context.seed, "voxels", case);
        let ball = ball(&mut rng, Profile::Homogeneous);
        let thicker = if faulty { 1.03 } else { 1.0 };
        let drawn = Ball { extinction: thicker * ball.extinction, ..ball };
        let grid = Voxels::of(&[drawn], 64)?;
        for _ in 0..30 {
            let mut any = || rng.random_range(-1.0..1.0_f64);
            let direction = DVec3::new(any(), any(), any()).normalize_or(DVec3::NEG_Y);
            let beside = direction.any_orthonormal_vector() * (0.8 * ball.radius * any());
            let ray = Ray::new(ball.centre + beside - direction * 10.0, direction);
            let (found, expected) = (grid.optical_depth(&ray), ball.optical_depth(&ray));
            let what = || format!("{found}, chord {expected}");
            tally.within((found / expected - 1.0).abs(), 0.01, what);
        }
    }
    Ok(tally)
}

fn volumes(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (side, slices) = (12, 6);
    for case in 0..context.cases.min(16) {
        let mut rng = input::rng(context.seed, "volumes", case);
        let profiles = [Profile::Homogeneous, Profile::Soft];
        let balls: Vec<Ball> = (0..4).map(|i| ball(&mut rng, profiles[i % 2])).collect();
        let bounds = dapple_trace::ball_bounds(&balls)?;
        let view = LightView::fit_directional(DVec3::new(0.3, -1.0, 0.2), &bounds)?;
        let found = volume_fragments(&balls, &view, side, side, slices)?;
        for texel in 0..(side * side) as usize {
            let centre = |at: u32| (f64::from(at) + 0.5) / f64::from(side);
            let (origin, direction) =
                view.ray(centre(texel as u32 % side), centre(texel as u32 / side));
            let ray = Ray { origin, direction, t_min: 0.0, t_max: 1.0 };
            let sum: f64 = if faulty {
                // As thick as the ball's mean chord, wherever the ray passes.
                let met = balls.iter().filter(|b| b.chord(&ray).is_some());
                met.map(|b| 4.0 / 3.0 * b.radius * b.extinction).sum()
            } else {
                found.thickness[found.range(texel)].iter().map(|&t| f64::from(t)).sum()
            };
            let expected = optical_depth(&balls, &ray);
            tally.within((sum - expected).abs(), 1e-5, || format!("texel {texel}: {sum}"));
        }
    }
    Ok(tally)
}
