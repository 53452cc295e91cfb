//! What is lit, by what, as techniques are given it.

use crate::{
    Eye, Light, LightsError,
    light::{Emission, FARTHEST_M},
};
use bytemuck::{Pod, Zeroable};
use dapple_trace::{Ray, Tracer};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// The least and the greatest [`World::clamp_m`]: f32 holds their squares, and what is over them.
pub const CLAMP_M: (f64, f64) = (1e-6, 1e6);

/// What points may lie below their surface because they are rounded to f32, over their farthest
/// coordinate: 2^-24 along each axis, times the root of 3, and as much again.
const ROUNDED: f64 = 1.0 / (1 << 22) as f64;

/// The object of a pixel that shows nothing.
pub const NOTHING: u32 = u32::MAX;

/// A receiver: what one pixel shows. 48 bytes, as on a device.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Point {
    /// Metres, relative to [`World::origin`].
    pub position: Vec3,
    /// What it lies on, or [`NOTHING`].
    pub object: u32,
    /// Unit length, towards the eye.
    pub normal: Vec3,
    /// Unused.
    pub pad: u32,
    /// Diffuse reflectance, linear RGB, each in 0..=1.
    pub albedo: Vec3,
    /// Unused.
    pub pad_behind: u32,
}

impl Point {
    /// A pixel that shows nothing.
    pub fn nothing() -> Self {
        Self { object: NOTHING, ..Self::default() }
    }

    /// Whether there is anything to be lit.
    pub fn is_there(&self) -> bool {
        self.object != NOTHING
    }
}

/// One frame: what its pixels show, and from where.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The eye.
    pub eye: Eye,
    /// One a pixel, rows top to bottom.
    pub points: Vec<Point>,
}

/// Lights and frames, shared by all techniques. Local space: metres relative to `origin`.
#[derive(Clone)]
pub struct World {
    /// World space.
    pub origin: DVec3,
    /// All lights.
    pub lights: Vec<Light>,
    /// Frames of a path, in order; at least one.
    pub frames: Vec<Frame>,
    /// Distances below this count as this, metres, more than 0.
    pub clamp_m: f64,
    /// What casts shadows (in world space); `None` where nothing does.
    pub occluders: Option<Arc<Tracer>>,
}

impl World {
    /// Refuses what techniques do not survive.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names the light, frame or point.
    pub fn check(&self) -> Result<(), LightsError> {
        if !(self.clamp_m >= CLAMP_M.0 && self.clamp_m <= CLAMP_M.1) {
            let limit = format!("has to be in {:e}..={:e} m", CLAMP_M.0, CLAMP_M.1);
            return Err(LightsError::value("clamp", limit));
        }
        for (index, light) in self.lights.iter().enumerate() {
            light.check(index)?;
        }
        if self.frames.is_empty() {
            return Err(LightsError::value("frames", "there has to be at least one"));
        }
        for (index, frame) in self.frames.iter().enumerate() {
            frame.check(index)?;
        }
        Ok(())
    }

    /// Frame `index`.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names the frame: there is none.
    pub fn frame(&self, index: usize) -> Result<&Frame, LightsError> {
        self.frames.get(index).ok_or_else(|| {
            let limit = format!("there are {}", self.frames.len());
            LightsError::value(format!("frame {index}"), limit)
        })
    }

    /// Whether nothing lies between a point and a light. Rays start off the surface by the tracer's
    /// rounding and the point's own, towards the side the normal shows, and end as far before the
    /// light.
    pub fn sees(&self, point: &Point, light: &Light) -> bool {
        let Some(tracer) = &self.occluders else { return true };
        let position = point.position.as_dvec3();
        let lift = lift_m(tracer, position);
        let from = self.origin + position + point.normal.as_dvec3() * lift;
        self.is_clear(tracer, from, light, [0.0, lift])
    }

    /// As [`Self::sees`] from any place of local space, on a surface or off it: the ray is that of the
    /// place itself, and only what lies within rounding of its start does not count.
    pub fn sees_from(&self, position: DVec3, light: &Light) -> bool {
        let Some(tracer) = &self.occluders else { return true };
        let lift = lift_m(tracer, position);
        self.is_clear(tracer, self.origin + position, light, [lift; 2])
    }

    /// Whether a ray from a place in world space meets nothing, but what is so near to its start and
    /// to the light, metres.
    fn is_clear(&self, tracer: &Tracer, from: DVec3, light: &Light, near: [f64; 2]) -> bool {
        if light.emission == Emission::Directional {
            return !tracer.any(&Ray { t_min: near[0], ..Ray::new(from, -light.axis) });
        }
        let to_light = self.origin + light.position - from;
        let distance = to_light.length();
        let (t_min, t_max) = (near[0], distance - near[1]);
        t_max <= t_min || !tracer.any(&Ray { t_min, t_max, ..Ray::new(from, to_light / distance) })
    }
}

/// How far rays from a place keep off what they start on, metres.
fn lift_m(tracer: &Tracer, position: DVec3) -> f64 {
    4.0 * tracer.epsilon_m() + ROUNDED * position.abs().max_element()
}

impl Frame {
    fn check(&self, index: usize) -> Result<(), LightsError> {
        let refuse = |what: String| Err(LightsError::value(format!("frame {index}"), what));
        if self.points.len() != self.width as usize * self.height as usize {
            return refuse(format!(
                "{} points for {} x {} pixels",
                self.points.len(),
                self.width,
                self.height
            ));
        }
        for (pixel, point) in self.points.iter().enumerate().filter(|(_, p)| p.is_there()) {
            if !point.position.is_finite() || !point.normal.is_finite() {
                return refuse(format!("pixel {pixel}: position or normal is not finite"));
            }
            if point.position.abs().as_dvec3().max_element() > FARTHEST_M {
                return refuse(format!("pixel {pixel}: a coordinate is beyond {FARTHEST_M:e} m"));
            }
            // Bounds give back no more than this.
            if !(point.normal.as_dvec3().length() - 1.0).abs().le(&1e-6) {
                return refuse(format!("pixel {pixel}: the normal is not of unit length"));
            }
            if !(point.albedo.min_element() >= 0.0 && point.albedo.max_element() <= 1.0) {
                return refuse(format!("pixel {pixel}: the albedo is outside 0..=1"));
            }
        }
        Ok(())
    }
}
