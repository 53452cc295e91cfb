//! A grid of extinctions and a march through it: volume rendering as offline renderers do it.

use crate::error::TraceError;
use crate::tracer::Ray;
use crate::volume::{Ball, ball_bounds};
use glam::{DVec3, UVec3};
use rayon::prelude::*;

/// The most voxels of a grid: 512 MiB of them.
pub const MAX_VOXELS: u64 = 1 << 27;

/// Points a side at which a voxel is sampled: its number is the mean over all of them.
const SAMPLES: u32 = 3;

/// Steps of a march within one voxel's side.
const STEPS_PER_VOXEL: f64 = 2.0;

/// Extinctions on a grid of cubes, trilinear between the cubes' centres, 0 outside.
#[derive(Clone, Debug)]
pub struct Voxels {
    /// Lower corner, world space, metres.
    pub origin: DVec3,
    /// Side of a voxel, metres.
    pub side_m: f64,
    /// Voxels along x, y and z.
    pub size: UVec3,
    /// Mean extinction of each voxel, per metre; x runs fastest, then y.
    pub extinction: Vec<f32>,
}

impl Voxels {
    /// A grid around some balls, with `along` voxels along their longest side and two empty ones
    /// around. Without balls it has no voxel.
    ///
    /// # Errors
    /// A bad ball ([`ball_bounds`]), `along` of 0, or more than [`MAX_VOXELS`].
    pub fn of(balls: &[Ball], along: u32) -> Result<Self, TraceError> {
        let bounds = ball_bounds(balls)?;
        if bounds.is_empty() {
            let (origin, size) = (DVec3::ZERO, UVec3::ZERO);
            return Ok(Self { origin, side_m: 1.0, size, extinction: Vec::new() });
        }
        let extent = bounds.max - bounds.min;
        let side_m = extent.max_element() / f64::from(along);
        // The cast saturates.
        let size = (extent / side_m - 1e-9).ceil().as_uvec3().saturating_add(UVec3::splat(4));
        let count = size.to_array().into_iter().map(u64::from).fold(1, u64::saturating_mul);
        if along == 0 || count > MAX_VOXELS {
            return Err(TraceError::Voxels { along, count, limit: MAX_VOXELS });
        }
        let origin = bounds.centre() - size.as_dvec3() * (0.5 * side_m);
        let mut grid = Self { origin, side_m, size, extinction: vec![0.0; count as usize] };
        let layer = size.x as usize * size.y as usize;
        let mut layers = std::mem::take(&mut grid.extinction);
        layers.par_chunks_mut(layer).enumerate().for_each(|(z, layer)| {
            for ball in balls {
                grid.add(ball, z as u32, layer);
            }
        });
        Ok(Self { extinction: layers, ..grid })
    }

    /// Adds a ball to the voxels of layer `z`.
    fn add(&self, ball: &Ball, z: u32, layer: &mut [f32]) {
        let voxel = |p: DVec3| ((p - self.origin) / self.side_m).floor();
        let (lo, hi) = (voxel(ball.centre - ball.radius), voxel(ball.centre + ball.radius));
        if f64::from(z) < lo.z || f64::from(z) > hi.z {
            return;
        }
        let last = self.size - 1;
        let (lo, hi) = (lo.as_uvec3().min(last), hi.as_uvec3().min(last));
        for y in lo.y..=hi.y {
            for x in lo.x..=hi.x {
                let corner = self.origin + UVec3::new(x, y, z).as_dvec3() * self.side_m;
                let index = x as usize + y as usize * self.size.x as usize;
                layer[index] += self.mean(ball, corner) as f32;
            }
        }
    }

    fn mean(&self, ball: &Ball, corner: DVec3) -> f64 {
        let step = self.side_m / f64::from(SAMPLES);
        let mut sum = 0.0;
        for i in 0..SAMPLES.pow(3) {
            let cell = UVec3::new(i % SAMPLES, i / SAMPLES % SAMPLES, i / SAMPLES / SAMPLES);
            sum += ball.extinction_at(corner + (cell.as_dvec3() + 0.5) * step);
        }
        sum / f64::from(SAMPLES.pow(3))
    }

    /// Extinction at a point, per metre.
    pub fn extinction_at(&self, point: DVec3) -> f64 {
        let place = (point - self.origin) / self.side_m - 0.5;
        let floor = place.floor();
        let (cell, part) = (floor.as_i64vec3(), place - floor);
        let at = |x: i64, y: i64, z: i64| {
            let size = self.size.as_i64vec3();
            let inside = (0..size.x).contains(&x) && (0..size.y).contains(&y);
            if !(inside && (0..size.z).contains(&z)) {
                return 0.0;
            }
            let index = x + size.x * (y + size.y * z);
            self.extinction.get(index as usize).map_or(0.0, |&e| f64::from(e))
        };
        let lerp = |a: f64, b: f64, s: f64| a + (b - a) * s;
        let row = |y: i64, z: i64| lerp(at(cell.x, y, z), at(cell.x + 1, y, z), part.x);
        let layer = |z: i64| lerp(row(cell.y, z), row(cell.y + 1, z), part.y);
        lerp(layer(cell.z), layer(cell.z + 1), part.z)
    }

    /// Extinction integrated over a ray's range, by steps of half a voxel's side.
    pub fn optical_depth(&self, ray: &Ray) -> f64 {
        let (lo, hi) = (self.origin, self.origin + self.size.as_dvec3() * self.side_m);
        let (mut from, mut to) = (ray.t_min, ray.t_max);
        for i in 0..3 {
            let (d, o) = (ray.direction[i], ray.origin[i]);
            let (a, b) = ((lo[i] - o) / d, (hi[i] - o) / d);
            if d != 0.0 {
                (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
            } else if !(lo[i]..=hi[i]).contains(&o) {
                return 0.0;
            }
        }
        let length = (to - from) * ray.direction.length();
        // False for what is not a number as well; the grid bounds the number of steps.
        let meets = length > 0.0 && length.is_finite();
        if !meets || self.extinction.is_empty() {
            return 0.0;
        }
        let steps = (length / self.side_m * STEPS_PER_VOXEL).ceil().max(1.0) as u32;
        let step = (to - from) / f64::from(steps);
        let sample = |i: u32| self.extinction_at(ray.at(from + step * (f64::from(i) + 0.5)));
        (0..steps).map(sample).sum::<f64>() * length / f64::from(steps)
    }

    /// The light that reaches each point through the volume, 0..=1, from a light that travels along
    /// `direction`; in parallel. 1 where a point or the direction is not finite.
    pub fn transmittance(&self, points: &[DVec3], direction: DVec3) -> Vec<f64> {
        let one = |&point: &DVec3| (-self.optical_depth(&Ray::new(point, -direction))).exp();
        points.par_iter().map(one).collect()
    }
}
