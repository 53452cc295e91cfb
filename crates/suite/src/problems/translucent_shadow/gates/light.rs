//! The crop of the light's map, and what maps shadow.

use super::{ALL, About, gate, input};
use crate::{
    SuiteError,
    verify::{Gate, GateContext, Tally},
};
use dapple_opacity_maps::lighting::{Light, OpaqueBy, Rules, Surface, Translucent, compose, shade};
use dapple_scene::{Aabb, Crop, LightView};
use glam::{DVec2, DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

pub fn gates() -> Vec<Gate> {
    let about = |name, statement, fault| About { technique: ALL, name, statement, fault };
    vec![
        gate(
            about(
                "P16 crop",
                "a crop maps its rectangle's corners to -1 and 1 exactly, and the full box to \
                 itself",
                "the shift's sign is lost",
            ),
            crop,
        ),
        gate(
            about(
                "row 6 focus",
                "a cropped map's coverage does not depend on how far the light's box reaches, and \
                 everything that casts is in it",
                "the map of the whole scene",
            ),
            focus,
        ),
        gate(
            about(
                "row 33 opaque",
                "opaque surfaces have Blinn-Phong of what arrives, by their flag, whatever their \
                 opacity",
                "what is opaque is told by an opacity of exactly 1",
            ),
            opaque,
        ),
        gate(
            about(
                "row 33 translucent",
                "translucent surfaces have light, attenuation and transmittance for diffuse, \
                 whatever their normal",
                "as printed: transmittance alone, without the light's colour",
            ),
            translucent,
        ),
        gate(
            about(
                "over",
                "surfaces of a pixel over each other keep 1 - Π(1 - α) of their light",
                "they are blended from the front",
            ),
            over,
        ),
    ]
}

fn crop(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "crop", case);
        let mut any = || DVec2::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0));
        let (a, b) = (any(), any());
        let full = case % 4 == 0;
        let (min, max) =
            if full { (DVec2::NEG_ONE, DVec2::ONE) } else { (a.min(b), a.max(b) + 0.01) };
        let crop = Crop::to(min, max)?;
        let what = || format!("{crop:?}");
        let shift = if faulty { -crop.shift() } else { crop.shift() };
        for (corner, expected) in [(crop.min, -1.0), (crop.max, 1.0)] {
            tally.check(crop.apply(corner) == DVec2::splat(expected), what);
            let by_matrix = crop.scale() * corner + shift;
            tally.within((by_matrix - expected).abs().max_element(), 1e-9, what);
        }
        if full {
            tally.check(crop.scale() == DVec2::ONE && shift.abs() == DVec2::ZERO, what);
        }
    }
    Ok(tally)
}

fn cuboid(rng: &mut Pcg64, reach: f64) -> Aabb {
    let mut any = || rng.random_range(-reach..reach);
    let (centre, half) = (DVec3::new(any(), any(), any()), DVec3::new(any(), any(), any()));
    let half = half.abs() + 0.1;
    Aabb { min: centre - half, max: centre + half }
}

fn focus(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "focus", case);
        let casters = cuboid(&mut rng, 2.0);
        let direction = DVec3::new(rng.random_range(-1.0..1.0), -1.0, rng.random_range(-1.0..1.0));
        let view = |reach: f64| {
            // Receivers all around, as far as the box reaches.
            let far = DVec3::splat(reach);
            let around = Aabb { min: -far, max: far };
            if faulty {
                LightView::fit_directional(direction, &around)
            } else {
                LightView::focused(direction, &casters, &around)
            }
        };
        let (near, far) = (view(10.0)?, view(20.0)?);
        let off = (near.side_m() / far.side_m() - 1.0).abs();
        tally.within(off, 1e-12, || format!("{} and {} m", near.side_m(), far.side_m()));
        let corners = casters.corners().map(|p| near.project(p));
        let inside = |p: &DVec3| (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y);
        tally.check(corners.iter().all(inside), || format!("{corners:?}"));
        let depths = corners.iter().all(|p| (0.0..=1.0).contains(&p.z));
        tally.check(depths, || format!("depths of {corners:?}"));
        let spread = |axis: usize| {
            let along = corners.map(|p| p[axis]);
            along.iter().copied().fold(f64::MIN, f64::max)
                - along.iter().copied().fold(f64::MAX, f64::min)
        };
        // The larger side fills the map but for a 512th.
        tally.within((spread(0).max(spread(1)) - 1.0).abs(), 4e-3, || format!("{corners:?}"));
    }
    Ok(tally)
}

fn direction(rng: &mut Pcg64) -> Vec3 {
    let mut any = || rng.random_range(-1.0..1.0_f32);
    Vec3::new(any(), any(), any()).normalize_or(Vec3::Y)
}

fn colour(rng: &mut Pcg64) -> Vec3 {
    let mut any = || rng.random_range(0.05..1.0_f32);
    Vec3::new(any(), any(), any())
}

fn scene(rng: &mut Pcg64) -> (Surface, Light, Vec3) {
    let surface = Surface {
        normal: direction(rng),
        tangent: None,
        albedo: colour(rng),
        specular: colour(rng),
        shininess: rng.random_range(1.0..64.0),
        alpha: rng.random_range(0.1..0.9),
        opaque: false,
    };
    let light = Light {
        towards: direction(rng),
        diffuse: colour(rng),
        specular: colour(rng),
        attenuation: rng.random_range(0.1..1.0),
        transmittance: rng.random_range(0.1..1.0),
    };
    (surface, light, direction(rng))
}

/// Facing and highlight by the textbook.
fn blinn_phong(surface: &Surface, light: &Light, eye: Vec3) -> (f32, f32) {
    let facing = surface.normal.dot(light.towards).max(0.0);
    let half = (light.towards + eye).normalize_or_zero();
    let highlight = surface.normal.dot(half).max(0.0).powf(surface.shininess);
    (facing, if facing > 0.0 { highlight } else { 0.0 })
}

fn opaque(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let by = if faulty { OpaqueBy::Alpha } else { OpaqueBy::Flag };
    let rules = Rules { opaque_by: by, ..Rules::default() };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "opaque", case);
        let (leaf, light, eye) = scene(&mut rng);
        let trunk = Surface { opaque: true, ..leaf };
        let (facing, highlight) = blinn_phong(&trunk, &light, eye);
        let arriving = light.attenuation * light.transmittance;
        let expected = trunk.albedo * light.diffuse * (facing * arriving)
            + trunk.specular * light.specular * (highlight * arriving);
        let found = shade(&trunk, eye, &[light], Vec3::ZERO, &rules);
        let off = (found - expected).abs().max_element();
        tally.within(off.into(), 1e-6, || format!("{trunk:?}: {found} {expected}"));
    }
    Ok(tally)
}

fn translucent(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let translucent = if faulty { Translucent::Printed } else { Translucent::Coloured };
    let rules = Rules { translucent, ..Rules::default() };
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "translucent", case);
        let (leaf, light, eye) = scene(&mut rng);
        let dull = Surface { specular: Vec3::ZERO, ..leaf };
        let turned = Surface { normal: -dull.normal, ..dull };
        let arriving = light.attenuation * light.transmittance;
        let expected = dull.albedo * light.diffuse * arriving;
        for surface in [dull, turned] {
            let found = shade(&surface, eye, &[light], Vec3::ZERO, &rules);
            let off = (found - expected).abs().max_element();
            tally.within(off.into(), 1e-6, || format!("{surface:?}: {found} {expected}"));
        }
    }
    Ok(tally)
}

fn over(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for case in 0..context.cases {
        let mut rng = input::rng(context.seed, "over", case);
        let mut surfaces: Vec<(Vec3, f32)> = (0..rng.random_range(2..8))
            .map(|_| (colour(&mut rng), rng.random_range(0.1..0.9)))
            .collect();
        let background = colour(&mut rng);
        let (mut expected, mut through) = (Vec3::ZERO, 1.0);
        for (colour, alpha) in &surfaces {
            expected += *colour * (alpha * through);
            through *= 1.0 - alpha;
        }
        expected += background * through;
        if faulty {
            surfaces.reverse();
        }
        let found = compose(&surfaces, background);
        let off = (found - expected).abs().max_element();
        tally.within(off.into(), 1e-6, || format!("{surfaces:?}: {found} {expected}"));
    }
    Ok(tally)
}
