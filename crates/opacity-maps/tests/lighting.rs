//! Switches of the lighting: each changes what it says and nothing else.

use dapple_opacity_maps::lighting::{
    Light, OpaqueBy, Rules, Surface, Translucent, compose, luminance, shade,
};
use glam::Vec3;
use proptest::prelude::*;

const EYE: Vec3 = Vec3::Z;
const RED: Vec3 = Vec3::new(0.8, 0.1, 0.05);

fn light(transmittance: f32) -> Light {
    Light {
        towards: Vec3::new(0.6, 0.0, 0.8),
        diffuse: RED,
        specular: Vec3::splat(0.5),
        attenuation: 0.5,
        transmittance,
    }
}

fn leaf() -> Surface {
    Surface {
        normal: Vec3::Z,
        tangent: None,
        albedo: Vec3::new(0.3, 0.6, 0.2),
        specular: Vec3::ZERO,
        shininess: 32.0,
        alpha: 0.69,
        opaque: false,
    }
}

fn trunk() -> Surface {
    Surface { alpha: 1.0, opaque: true, ..leaf() }
}

fn lit(surface: &Surface, transmittance: f32, rules: &Rules) -> Vec3 {
    shade(surface, EYE, &[light(transmittance)], Vec3::ZERO, rules)
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).abs().max_element() < 1e-6
}

#[test]
fn opaque_surfaces_have_blinn_phong_of_their_light() {
    let expected = trunk().albedo * RED * (0.8 * 0.5);
    assert!(close(lit(&trunk(), 1.0, &Rules::default()), expected));
    assert!(close(lit(&trunk(), 0.25, &Rules::default()), expected * 0.25));
    // The highlight: half-way between light and eye, at the normal it is full.
    let half = (light(1.0).towards + EYE).normalize();
    let shiny = Surface { normal: half, albedo: Vec3::ZERO, specular: Vec3::ONE, ..trunk() };
    assert!(close(lit(&shiny, 1.0, &Rules::default()), Vec3::splat(0.25)));
    let off = Surface { normal: Vec3::Z, ..shiny };
    let cosine: f32 = half.z;
    assert!(close(lit(&off, 1.0, &Rules::default()), Vec3::splat(0.25 * cosine.powi(32))));
    // Behind the surface there is neither; opposite the eye there is no half-way direction.
    for towards in [-Vec3::Z, Vec3::new(0.6, 0.0, -0.8)] {
        let behind = Light { towards, ..light(1.0) };
        assert_eq!(shade(&shiny, EYE, &[behind], Vec3::ZERO, &Rules::default()), Vec3::ZERO);
    }
    let against = shade(&shiny, -light(1.0).towards, &[light(1.0)], Vec3::ZERO, &Rules::default());
    assert_eq!(against, Vec3::ZERO);
}

#[test]
fn a_surface_that_is_only_shadowed_looks_flat() {
    let tilted = |angle: f32, surface: Surface| Surface {
        normal: Vec3::new(angle.sin(), 0.0, angle.cos()),
        ..surface
    };
    let range = |surface: Surface| {
        let shades = (0..10)
            .map(|i| luminance(lit(&tilted(-0.1 * i as f32, surface), 0.7, &Rules::default())));
        shades.clone().fold(0.0, f32::max) - shades.fold(1.0, f32::min)
    };
    assert_eq!(range(leaf()), 0.0);
    assert!(range(trunk()) > 0.02);
}

#[test]
fn thickness_dims_translucent_surfaces_and_opaque_ones_only_by_their_shadow() {
    let transmittance = |omega: f32, kappa: f32| (-kappa * omega).exp();
    for surface in [trunk(), leaf()] {
        let at = |omega, kappa| lit(&surface, transmittance(omega, kappa), &Rules::default());
        assert_eq!(at(0.0, 1.0), at(0.0, 5.55), "nothing in front: κ has no say");
        assert!(luminance(at(1.0, 5.55)) < luminance(at(1.0, 1.0)));
    }
    // An opaque surface's own α and thickness have no part in its light.
    let other = Surface { alpha: 0.5, ..trunk() };
    assert_eq!(lit(&other, 1.0, &Rules::default()), lit(&trunk(), 1.0, &Rules::default()));
}

#[test]
fn printed_transmittance_ignores_colour_and_distance_of_the_light() {
    let printed = Rules { translucent: Translucent::Printed, ..Rules::default() };
    assert!(close(lit(&leaf(), 0.25, &printed), leaf().albedo * 0.25));
    assert!(close(lit(&leaf(), 0.25, &Rules::default()), leaf().albedo * RED * 0.125));
    assert_eq!(lit(&trunk(), 0.25, &printed), lit(&trunk(), 0.25, &Rules::default()));
    let dark = Light { diffuse: Vec3::ZERO, attenuation: 0.0, ..light(1.0) };
    let of = |rules: &Rules| shade(&leaf(), EYE, &[dark], Vec3::ZERO, rules);
    assert_eq!(of(&Rules::default()), Vec3::ZERO);
    assert!(close(of(&printed), leaf().albedo));
}

#[test]
fn a_flag_and_not_an_opacity_of_exactly_one_makes_a_surface_opaque() {
    let by_alpha = Rules { opaque_by: OpaqueBy::Alpha, ..Rules::default() };
    let nearly = Surface { alpha: 254.0 / 255.0, ..trunk() };
    assert_eq!(lit(&nearly, 1.0, &Rules::default()), lit(&trunk(), 1.0, &Rules::default()));
    assert!(lit(&nearly, 1.0, &by_alpha) != lit(&trunk(), 1.0, &by_alpha));
    let thick = Surface { alpha: 1.0, ..leaf() };
    assert_eq!(lit(&thick, 1.0, &Rules::default()), lit(&leaf(), 1.0, &Rules::default()));
    assert_eq!(lit(&thick, 1.0, &by_alpha), lit(&trunk(), 1.0, &by_alpha));
}

#[test]
fn strands_are_lit_across_and_shine_around_the_mirrored_cone() {
    let rules = Rules { strands: true, ..Rules::default() };
    let hair = Surface { tangent: Some(Vec3::X), specular: Vec3::ONE, ..leaf() };
    let at = |towards: Vec3, eye: Vec3, surface: &Surface| {
        shade(surface, eye, &[Light { towards, ..light(1.0) }], Vec3::ZERO, &rules)
    };
    let matt = Surface { specular: Vec3::ZERO, ..hair };
    assert!(close(at(Vec3::Y, EYE, &matt), hair.albedo * RED * 0.5));
    assert!(close(at(Vec3::X, EYE, &matt), Vec3::ZERO));
    // Eyes all around the strand at the mirrored angle see the full highlight, others less.
    let shiny = Surface { albedo: Vec3::ZERO, ..hair };
    let towards = Vec3::new(0.6, 0.8, 0.0);
    let eye = |along: f32, turn: f32| {
        let across = (1.0 - along * along).sqrt();
        Vec3::new(along, across * turn.cos(), across * turn.sin())
    };
    for turn in 0..6 {
        let full = at(towards, eye(-0.6, turn as f32), &shiny);
        assert!(close(full, Vec3::splat(0.25)), "{full}");
        for along in [-0.8, -0.4, 0.0, 0.6] {
            assert!(at(towards, eye(along, turn as f32), &shiny).x < 0.2);
        }
    }
    // Off, without a tangent, or opaque: as before.
    let off = Rules::default();
    assert_eq!(lit(&matt, 0.5, &off), lit(&leaf(), 0.5, &off));
    assert_eq!(lit(&leaf(), 0.5, &rules), lit(&leaf(), 0.5, &off));
    let pole = Surface { tangent: Some(Vec3::Y), ..trunk() };
    assert_eq!(lit(&pole, 0.5, &rules), lit(&trunk(), 0.5, &off));
}

#[test]
fn each_light_brings_its_own_shadow_and_ambient_light_has_none() {
    let (near, far) = (light(0.2), Light { towards: Vec3::Z, ..light(0.9) });
    let of = |lights: &[Light], ambient| shade(&trunk(), EYE, lights, ambient, &Rules::default());
    let both = of(&[near, far], Vec3::ZERO);
    assert!(close(both, of(&[near], Vec3::ZERO) + of(&[far], Vec3::ZERO)));
    let swapped = [
        Light { transmittance: far.transmittance, ..near },
        Light { transmittance: near.transmittance, ..far },
    ];
    assert!(!close(both, of(&swapped, Vec3::ZERO)));
    assert!(close(of(&[], Vec3::splat(0.1)), trunk().albedo * 0.1));
}

#[test]
fn surfaces_hide_what_lies_behind_them_by_their_opacity() {
    let (red, green) = (Vec3::X, Vec3::Y);
    assert_eq!(compose(&[], Vec3::Z), Vec3::Z);
    assert_eq!(compose(&[(red, 1.0), (green, 0.5)], Vec3::Z), red);
    assert_eq!(compose(&[(red, 0.0)], Vec3::Z), Vec3::Z);
    assert_eq!(compose(&[(red, 0.5), (green, 0.5)], Vec3::Z), Vec3::new(0.5, 0.25, 0.25));
    assert_ne!(
        compose(&[(green, 0.5), (red, 0.5)], Vec3::Z),
        compose(&[(red, 0.5), (green, 0.5)], Vec3::Z)
    );
    assert!((luminance(Vec3::ONE) - 1.0).abs() < 1e-6);
}

proptest! {
    #[test]
    fn one_colour_over_itself_is_that_colour_and_the_order_of_blending_is_no_matter(
        layers in prop::collection::vec((0.0f32..2.0, 0.0f32..=1.0), 0..30),
        colour in 0.0f32..2.0,
    ) {
        let flat: Vec<(Vec3, f32)> =
            layers.iter().map(|&(_, alpha)| (Vec3::splat(colour), alpha)).collect();
        let over = compose(&flat, Vec3::splat(colour));
        prop_assert!((over - Vec3::splat(colour)).abs().max_element() < 1e-5);
        // From the front, with what is left of the background's light carried along.
        let (mut sum, mut left) = (0.0, 1.0);
        for &(grey, alpha) in &layers {
            sum += left * alpha * grey;
            left *= 1.0 - alpha;
        }
        let stack: Vec<(Vec3, f32)> = layers.iter().map(|&(g, a)| (Vec3::splat(g), a)).collect();
        prop_assert!((compose(&stack, Vec3::ONE).x - (sum + left)).abs() < 1e-5);
    }
}
