//! Many points bounded at once.

use crate::{Point, light::angle};
use glam::DVec3;
use std::f64::consts::PI;

/// Points of a tile or a view cell: every point's position, normal and albedo lies within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Lower corner of the positions' box, metres.
    pub min: DVec3,
    /// Its upper corner.
    pub max: DVec3,
    /// Middle of the normals, unit length.
    pub normal_axis: DVec3,
    /// The normals' greatest angle from it, radians; π where there may be any.
    pub normal_spread_rad: f64,
    /// The greatest albedo of each channel.
    pub albedo: DVec3,
}

impl Region {
    /// A single point.
    pub fn at(point: &Point) -> Self {
        let position = point.position.as_dvec3();
        Self {
            min: position,
            max: position,
            normal_axis: point.normal.as_dvec3(),
            normal_spread_rad: 0.0,
            albedo: point.albedo.as_dvec3(),
        }
    }

    /// The least region around all points that show anything; `None` without any.
    pub fn of<'a>(points: impl Iterator<Item = &'a Point> + Clone) -> Option<Self> {
        let there = points.filter(|p| p.is_there()).map(Self::at);
        let mut region = there.clone().reduce(|a, b| Self {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
            normal_axis: a.normal_axis + b.normal_axis,
            normal_spread_rad: 0.0,
            albedo: a.albedo.max(b.albedo),
        })?;
        match region.normal_axis.try_normalize() {
            Some(axis) => {
                let from_axis = |p: Self| angle(axis, p.normal_axis);
                region.normal_axis = axis;
                region.normal_spread_rad = there.map(from_axis).fold(0.0, f64::max);
            }
            None => {
                region.normal_axis = DVec3::Z;
                region.normal_spread_rad = PI;
            }
        }
        Some(region)
    }
}
