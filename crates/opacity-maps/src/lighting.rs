//! Light on what the maps shadow: Blinn-Phong on opaque surfaces, transmittance in place of the
//! diffuse term on translucent ones, Kajiya-Kay on strands; and a pixel's surfaces over each other.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, section 5.3 and appendix 10; Blinn, Models of light reflection for computer
//! synthesized pictures, SIGGRAPH 1977; Kajiya and Kay, Rendering fur with three dimensional
//! textures, SIGGRAPH 1989.
//!
//! Deviations: a flag says what is opaque, not α = 1 exactly; transmittance is coloured and
//! attenuated by its light; each light brings its own transmittance (the printed loop counts lights
//! by two indices). The printed forms of the first two are kept ([`Rules`]).
//!
//! All colours are linear RGB; all directions are of unit length and point away from the surface.

use glam::Vec3;

/// A light as a surface sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Towards the light.
    pub towards: Vec3,
    /// Colour of the diffuse term.
    pub diffuse: Vec3,
    /// Colour of the specular term.
    pub specular: Vec3,
    /// By distance, 0..=1.
    pub attenuation: f32,
    /// Share of light that arrives, 0..=1, as the maps tell.
    pub transmittance: f32,
}

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Normal, on the camera's side.
    pub normal: Vec3,
    /// Along the strand, if it is one.
    pub tangent: Option<Vec3>,
    /// Share of diffuse light given back.
    pub albedo: Vec3,
    /// Share of specular light given back.
    pub specular: Vec3,
    /// Exponent p of the highlight, > 0; the thesis's default is 32.
    pub shininess: f32,
    /// Opacity α, 0..=1.
    pub alpha: f32,
    /// Whether it is shaded as opaque.
    pub opaque: bool,
}

/// The diffuse term of translucent surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Translucent {
    /// c_d a T: the light's colour, its attenuation, its transmittance.
    #[default]
    Coloured,
    /// T alone, as printed: a red light far away lights foliage white and in full.
    Printed,
}

/// What tells opaque surfaces from translucent ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OpaqueBy {
    /// [`Surface::opaque`].
    #[default]
    Flag,
    /// α = 1 exactly, as printed: rounding of a texture makes trunks translucent.
    Alpha,
}

/// How surfaces are lit. Default: the repaired forms, without Kajiya-Kay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rules {
    /// The diffuse term of translucent surfaces.
    pub translucent: Translucent,
    /// Who counts as opaque.
    pub opaque_by: OpaqueBy,
    /// Whether translucent surfaces with a tangent are lit as strands.
    pub strands: bool,
}

/// Light towards `eye`, not multiplied by α.
pub fn shade(surface: &Surface, eye: Vec3, lights: &[Light], ambient: Vec3, rules: &Rules) -> Vec3 {
    let opaque = match rules.opaque_by {
        OpaqueBy::Flag => surface.opaque,
        OpaqueBy::Alpha => surface.alpha == 1.0,
    };
    let (mut diffuse, mut specular) = (ambient, Vec3::ZERO);
    for light in lights {
        let arriving = light.attenuation * light.transmittance;
        let strand = surface.tangent.filter(|_| rules.strands && !opaque);
        let (facing, highlight) = match strand {
            Some(tangent) => kajiya_kay(tangent, light.towards, eye, surface.shininess),
            None => blinn_phong(surface.normal, light.towards, eye, surface.shininess),
        };
        diffuse += match (opaque, rules.translucent) {
            (true, _) => light.diffuse * facing * arriving,
            (false, _) if strand.is_some() => light.diffuse * facing * arriving,
            (false, Translucent::Coloured) => light.diffuse * arriving,
            (false, Translucent::Printed) => Vec3::splat(light.transmittance),
        };
        specular += light.specular * highlight * arriving;
    }
    surface.albedo * diffuse + surface.specular * specular
}

/// max(N·L, 0) and (N·H)^p, which is 0 where the light is behind.
fn blinn_phong(normal: Vec3, light: Vec3, eye: Vec3, shininess: f32) -> (f32, f32) {
    let facing = normal.dot(light);
    if facing <= 0.0 {
        return (0.0, 0.0);
    }
    // Opposite directions have no half-way one, and no highlight.
    let half = (light + eye).normalize_or_zero();
    (facing, normal.dot(half).max(0.0).powf(shininess))
}

/// sin(T, L), and the highlight around the cone of directions that make the mirrored angle with
/// the strand: cos^p of the angle to it.
fn kajiya_kay(tangent: Vec3, light: Vec3, eye: Vec3, shininess: f32) -> (f32, f32) {
    let sine = |cosine: f32| (1.0 - cosine * cosine).max(0.0).sqrt();
    let (along_light, along_eye) = (tangent.dot(light), tangent.dot(eye));
    // Both directions point away from the strand, hence the minus: the mirrored cosine is -T·L.
    let mirrored = sine(along_light) * sine(along_eye) - along_light * along_eye;
    (sine(along_light), mirrored.max(0.0).powf(shininess))
}

/// A pixel's surfaces, front to back as (light towards the eye, α), over `background`: blended from
/// the back as premultiplied colours (ONE, 1 - SRC_ALPHA).
pub fn compose(front_to_back: &[(Vec3, f32)], background: Vec3) -> Vec3 {
    front_to_back.iter().rev().fold(background, |behind, &(colour, alpha)| {
        let alpha = alpha.clamp(0.0, 1.0);
        colour * alpha + behind * (1.0 - alpha)
    })
}

/// Luminance of linear RGB (Rec. 709): the grey of a picture.
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
