//! What the camera sees, by rays: which objects own pixels, and how many of their triangles do.
//!
//! A pixel's owner is the object that the ray through its centre hits first. Rasterisers snap
//! vertices to 1/256 of a pixel, so an owner counts as *sure* only where four rays 1/64 of a pixel
//! away hit the same object: what is not drawn there is missing beyond any rounding. A regular grid of
//! further rays a pixel finds what is smaller than one.

use super::case::Frames;
use crate::{SuiteError, truth_cache::TruthCache};
use dapple_occlusion::camera::View;
use dapple_scene::{Camera, Projection};
use dapple_trace::{Ray, Tracer};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Changes with whatever changes the truth's values.
const TRUTH_VERSION: u32 = 1;

/// How far beside the centre its owner must be the same, pixels.
const SURE: f64 = 1.0 / 64.0;

/// No triangle.
pub const NOTHING: u32 = u32::MAX;

/// What one object owns of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Owned {
    /// The object.
    pub object: u32,
    /// Pixels whose centre it owns beyond rounding.
    pub sure: u32,
    /// Rays of the finer grid that it owns.
    pub samples: u32,
    /// Its triangles that own a ray of either kind.
    pub triangles: u32,
}

/// What every frame shows.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    /// By frame: the objects that own anything, in order.
    pub frames: Vec<Vec<Owned>>,
    /// Placed triangle at the centre of every pixel of the last frame, or [`NOTHING`].
    pub last: Vec<u32>,
}

impl Truth {
    /// Traces the path, or reads what was traced before.
    ///
    /// # Errors
    /// None of its own: a cache that cannot be used is passed over.
    pub fn of(key: &str, tracer: &Tracer, frames: &Frames<'_>) -> Result<Self, SuiteError> {
        let key = format!("camera-visibility v{TRUTH_VERSION} {key}");
        let words = TruthCache::from_environment().words(&key, || trace(tracer, frames).encode());
        Self::decode(&words, frames)
            .ok_or_else(|| SuiteError::Internal("a cached truth of another size".into()))
    }

    fn encode(&self) -> Vec<u32> {
        let frame = |owned: &Vec<Owned>| {
            let one = |o: &Owned| [o.object, o.sure, o.samples, o.triangles];
            std::iter::once(owned.len() as u32)
                .chain(owned.iter().flat_map(one))
                .collect::<Vec<_>>()
        };
        self.frames.iter().flat_map(frame).chain(self.last.iter().copied()).collect()
    }

    fn decode(words: &[u32], frames: &Frames<'_>) -> Option<Self> {
        let mut rest = words;
        let mut decoded = Vec::with_capacity(frames.cameras.len());
        for _ in frames.cameras {
            let (count, behind) = rest.split_first()?;
            let (owned, behind) = behind.split_at_checked(4 * *count as usize)?;
            let one = |w: &[u32; 4]| {
                let [object, sure, samples, triangles] = *w;
                Owned { object, sure, samples, triangles }
            };
            decoded.push(owned.as_chunks::<4>().0.iter().map(one).collect());
            rest = behind;
        }
        let pixels = frames.size[0] as usize * frames.size[1] as usize;
        (rest.len() == pixels).then(|| Self { frames: decoded, last: rest.to_vec() })
    }

    /// Objects that own anything in any frame.
    pub fn ever(&self) -> usize {
        let mut objects: Vec<u32> = self.frames.iter().flatten().map(|o| o.object).collect();
        objects.sort_unstable();
        objects.dedup();
        objects.len()
    }
}

fn trace(tracer: &Tracer, frames: &Frames<'_>) -> Truth {
    let mut truth = Truth::default();
    for (camera, view) in frames.cameras.iter().zip(frames.views) {
        let centres = centres(tracer, frames, camera, view);
        truth.frames.push(owned(tracer, frames, camera, view, &centres));
        truth.last = centres;
    }
    truth
}

/// The placed triangle that a ray through image point (x, y), in pixels, hits first.
fn hit(tracer: &Tracer, frames: &Frames<'_>, camera: &Camera, view: &View, x: f64, y: f64) -> u32 {
    let [width, height] = frames.size.map(f64::from);
    let (origin, direction) = camera.ray(x / width, y / height, width / height);
    let t_min = match camera.projection {
        Projection::Perspective { .. } => view.near_m / direction.dot(view.forward),
        Projection::Orthographic { .. } => 0.0,
    };
    let ray = Ray { t_min, ..Ray::new(origin, direction) };
    tracer.closest(&ray).map_or(NOTHING, |hit| hit.triangle)
}

fn centres(tracer: &Tracer, frames: &Frames<'_>, camera: &Camera, view: &View) -> Vec<u32> {
    let [width, height] = frames.size;
    let row = |y: u32| {
        (0..width)
            .map(move |x| hit(tracer, frames, camera, view, f64::from(x) + 0.5, f64::from(y) + 0.5))
    };
    (0..height).into_par_iter().flat_map_iter(row).collect()
}

fn owned(
    tracer: &Tracer,
    frames: &Frames<'_>,
    camera: &Camera,
    view: &View,
    centres: &[u32],
) -> Vec<Owned> {
    let [width, height] = frames.size;
    let object = |triangle: u32| {
        if triangle == NOTHING { NOTHING } else { frames.owners[triangle as usize][0] }
    };
    // All eight neighbours of the same object: then so is whatever is 1/64 of a pixel away, but for
    // what is thinner than that.
    let inside = |x: u32, y: u32, own: u32| {
        (-1..=1).all(|dy| {
            (-1..=1).all(|dx| {
                let at = |p: u32, d: i32, n: u32| p.checked_add_signed(d).filter(|q| *q < n);
                match (at(x, dx, width), at(y, dy, height)) {
                    (Some(x), Some(y)) => object(centres[(y * width + x) as usize]) == own,
                    _ => true,
                }
            })
        })
    };
    let grid = frames.samples;
    let row = |y: u32| {
        // By placed triangle: sure pixels of its object, rays of the finer grid, any ray at all.
        let mut found: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
        for x in 0..width {
            let (px, py) = (f64::from(x), f64::from(y));
            let centre = centres[(y * width + x) as usize];
            let own = object(centre);
            if own != NOTHING {
                let beside = |dx: f64, dy: f64| {
                    let (x, y) = (px + 0.5 + dx * SURE, py + 0.5 + dy * SURE);
                    object(hit(tracer, frames, camera, view, x, y)) == own
                };
                let sure = inside(x, y, own)
                    || [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
                        .into_iter()
                        .all(|(dx, dy)| beside(dx, dy));
                found.entry(centre).or_default()[0] += u32::from(sure);
            }
            for s in 0..grid * grid {
                let at = |i: u32| (f64::from(i) + 0.5) / f64::from(grid);
                let triangle =
                    hit(tracer, frames, camera, view, px + at(s % grid), py + at(s / grid));
                if triangle != NOTHING {
                    found.entry(triangle).or_default()[1] += 1;
                }
            }
        }
        found
    };
    let rows: Vec<BTreeMap<u32, [u32; 2]>> = (0..height).into_par_iter().map(row).collect();
    let mut triangles: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
    for (triangle, [sure, samples]) in rows.into_iter().flatten() {
        let sum = triangles.entry(triangle).or_default();
        sum[0] += sure;
        sum[1] += samples;
    }
    let mut objects: BTreeMap<u32, Owned> = BTreeMap::new();
    for (triangle, [sure, samples]) in triangles {
        let object = object(triangle);
        let owned = objects.entry(object).or_insert(Owned { object, ..Owned::default() });
        owned.sure += sure;
        owned.samples += samples;
        owned.triangles += 1;
    }
    objects.into_values().collect()
}
