//! Lights, and what leaves them in a direction.
//!
//! Based on: B. Walter et al., "Lightcuts: a scalable approach to illumination", 2005, section 3
//! (omni, oriented and directional lights), and Melino Conte, "Real-time Rendering of Cities at Night",
//! 2018, section 5.1 (spot lights that fall linearly to 0 at 45 degrees).
//! Deviations: linear in the *angle*, which the thesis leaves open.

use crate::{LightsError, PackedNode};
use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

/// How the intensity of a light depends on the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emission {
    /// The same to all sides.
    Omni,
    /// max(cos φ, 0) of the angle φ from the axis: a small patch.
    Oriented,
    /// 1 - φ / half angle, at least 0: a window, a lamp with a shade.
    Spot {
        /// Where it reaches 0, radians, in (0, π].
        half_angle_rad: f64,
    },
    /// Parallel light that travels along the axis and does not weaken with distance: the intensity
    /// is then an irradiance, and the position has no meaning.
    Directional,
}

/// The farthest coordinate of lights and points from the world's origin, metres.
pub const FARTHEST_M: f64 = 1e9;

/// The greatest intensity of a light.
pub const BRIGHTEST: f64 = 1e15;

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Metres, relative to [`crate::World::origin`].
    pub position: DVec3,
    /// Unit length; any for [`Emission::Omni`].
    pub axis: DVec3,
    /// Radiant intensity along the axis (or irradiance), linear RGB, at least 0.
    pub intensity: DVec3,
    /// How it depends on the direction.
    pub emission: Emission,
}

/// A single light in 48 bytes, in the order of [`crate::World::lights`]; `Light` of
/// `common/lights_frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PackedLight {
    /// Metres, local.
    pub position: Vec3,
    /// Where its cone ends, radians.
    pub half_angle_rad: f32,
    /// Linear RGB.
    pub intensity: Vec3,
    /// [`crate::Emission::code`].
    pub kind: u32,
    /// Unit length.
    pub axis: Vec3,
    /// Unused.
    pub pad: u32,
}

impl Emission {
    /// Share of the intensity that leaves at `angle_rad` from the axis.
    pub fn falloff(&self, angle_rad: f64) -> f64 {
        match self {
            Self::Omni | Self::Directional => 1.0,
            // Beyond a right angle the cosine is negative.
            Self::Oriented => angle_rad.cos().max(0.0),
            Self::Spot { half_angle_rad } => (1.0 - angle_rad / half_angle_rad).clamp(0.0, 1.0),
        }
    }

    /// Place among the kinds, as nodes and shaders number them.
    pub fn code(&self) -> u32 {
        match self {
            Self::Omni => 0,
            Self::Oriented => 1,
            Self::Spot { .. } => 2,
            Self::Directional => 3,
        }
    }

    /// The kind of that code; the angle is a spot's.
    pub fn of(code: u32, half_angle_rad: f64) -> Self {
        match code {
            1 => Self::Oriented,
            2 => Self::Spot { half_angle_rad },
            3 => Self::Directional,
            _ => Self::Omni,
        }
    }

    /// Where light stops, radians from the axis: π where it does not.
    pub fn half_angle_rad(&self) -> f64 {
        match self {
            Self::Omni | Self::Directional => std::f64::consts::PI,
            Self::Oriented => std::f64::consts::FRAC_PI_2,
            Self::Spot { half_angle_rad } => *half_angle_rad,
        }
    }
}

/// The angle between two unit vectors, radians, in 0..=π; exact to rounding near 0 and π too, where
/// the arc cosine of their product is not.
pub fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

impl Light {
    /// Refuses what no sum survives.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names light `index`: a number that is not finite, a position
    /// beyond [`FARTHEST_M`] or an intensity beyond [`BRIGHTEST`] (their squares, sums and quotients
    /// have to be numbers in f32), a negative intensity, an axis that is not of unit length (to
    /// 1e-6), a half angle outside (0, π].
    pub fn check(&self, index: usize) -> Result<(), LightsError> {
        let refuse = |what: &str| Err(LightsError::value(format!("light {index}"), what));
        if !self.position.is_finite() || !self.axis.is_finite() || !self.intensity.is_finite() {
            return refuse("position, axis and intensity have to be finite numbers");
        }
        if self.position.abs().max_element() > FARTHEST_M {
            return refuse(&format!("a coordinate is beyond {FARTHEST_M:e} m"));
        }
        if self.intensity.max_element() > BRIGHTEST {
            return refuse(&format!("the intensity is above {BRIGHTEST:e}"));
        }
        if self.intensity.min_element() < 0.0 {
            return refuse("the intensity is negative");
        }
        if self.emission != Emission::Omni && (self.axis.length() - 1.0).abs() > 1e-6 {
            return refuse("the axis is not of unit length");
        }
        if let Emission::Spot { half_angle_rad } = self.emission
            && !(half_angle_rad > 0.0 && half_angle_rad <= std::f64::consts::PI)
        {
            return refuse("the cone's half angle has to be in (0, π] radians");
        }
        Ok(())
    }

    /// The light in f32.
    pub fn pack(&self) -> PackedLight {
        PackedLight {
            position: self.position.as_vec3(),
            half_angle_rad: self.emission.half_angle_rad() as f32,
            intensity: self.intensity.as_vec3(),
            kind: self.emission.code(),
            axis: self.axis.normalize_or(DVec3::Z).as_vec3(),
            pad: 0,
        }
    }

    /// Luminance of the intensity (Rec. 709).
    pub fn luminance(&self) -> f64 {
        luminance(self.intensity)
    }
}

impl PackedLight {
    /// Light `index` as the leaf that it is in trees.
    #[inline(always)]
    pub(crate) fn leaf(&self, index: u32) -> PackedNode {
        PackedNode {
            position: self.position,
            cone_rad: 0.0,
            intensity: self.intensity,
            size: 1,
            axis: self.axis,
            half_angle_rad: self.half_angle_rad,
            min: self.position,
            light: index,
            max: self.position,
            kind: self.kind,
        }
    }
}

/// Luminance of linear RGB (Rec. 709).
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// [`luminance`] in f32, as `common/lights.wgsl` has it.
#[inline(always)]
pub(crate) fn luminance_f32(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}
