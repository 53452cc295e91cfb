//! Split from the top, where both sides promise the least.
//!
//! Based on: A. Conty Estevez and C. Kulla, "Importance sampling of many lights with adaptive tree
//! splitting", 2018, section 4.4 (the surface area orientation heuristic, 12 bins an axis).
//! Deviations: lights are points, so that rows and planes of them are common: where the box of all
//! has no surface its diagonal counts instead. One greatest angle of emission for all lights of a
//! kind; directions count for nothing where light goes to all sides, and for parallel light, which is
//! split by its place on the sphere of axes. What cannot be told apart by place, and what lies deeper
//! than 64 levels, is halved.

use super::{
    cluster::Cluster,
    median::{self, halve},
    shape::Place,
};
use crate::{Light, light::Emission};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Bins an axis.
const BINS: usize = 12;
/// Levels below which lights are only halved.
const DEEPEST: u32 = 64;
/// Fewer lights are not worth another thread.
const PARALLEL: usize = 1024;

/// The tree over `ids`, at least one.
pub(super) fn build(lights: &[Light], ids: &[u32]) -> Vec<Place> {
    let of_kind = || ids.iter().map(|&id| &lights[id as usize]);
    let clusters: Vec<Cluster> = of_kind().map(Cluster::of).collect();
    let emitted = of_kind().map(|light| match light.emission {
        Emission::Omni | Emission::Directional => None,
        emission => Some(emission.half_angle_rad()),
    });
    let splitter = Splitter { clusters, emitted_rad: emitted.fold(None, |a, b| a.max_with(b)) };
    let mut numbers: Vec<u32> = (0..ids.len() as u32).collect();
    let mut places = vec![Place::leaf(0); 2 * ids.len() - 1];
    splitter.split(&mut numbers, &mut places, 0);
    for place in places.iter_mut().filter(|place| place.is_leaf()) {
        place.light = ids[place.light as usize];
    }
    places
}

trait MaxWith {
    fn max_with(self, other: Self) -> Self;
}

impl MaxWith for Option<f64> {
    fn max_with(self, other: Self) -> Self {
        Some(self.unwrap_or(0.0).max(other?))
    }
}

struct Splitter {
    clusters: Vec<Cluster>,
    /// The greatest angle of emission from an axis, where directions count.
    emitted_rad: Option<f64>,
}

impl Splitter {
    fn split(&self, ids: &mut [u32], places: &mut [Place], depth: u32) {
        if let [id] = ids {
            places[0] = Place::leaf(*id);
            return;
        }
        places[0] = Place::cluster(places.len() as u32);
        let parallel = ids.len() >= PARALLEL;
        let (left, right) = match self.plane(ids).filter(|_| depth < DEEPEST) {
            Some((axis, bins, bin)) => {
                let middle = partition(ids, |id| bins.of(self.at(id), axis) <= bin);
                ids.split_at_mut(middle)
            }
            None => halve(&|id| self.at(id), ids),
        };
        let (left_places, right_places) = places[1..].split_at_mut(2 * left.len() - 1);
        if parallel {
            rayon::join(
                || self.split(left, left_places, depth + 1),
                || self.split(right, right_places, depth + 1),
            );
        } else {
            self.split(left, left_places, depth + 1);
            self.split(right, right_places, depth + 1);
        }
    }

    fn at(&self, id: u32) -> DVec3 {
        self.clusters[id as usize].min
    }

    /// The best plane: an axis, and the last bin on its near side. `None` where all are in one place.
    fn plane(&self, ids: &[u32]) -> Option<(usize, Bins, usize)> {
        let bins = Bins::of_all(ids.iter().map(|&id| self.at(id)));
        let extent = bins.max - bins.min;
        let longest = extent[median::longest(extent)];
        let flat = surface(extent) == 0.0;
        let mut best: Option<(f64, usize, usize)> = None;
        for axis in (0..3).filter(|&axis| extent[axis] > 0.0) {
            let mut sums: [Option<Cluster>; BINS] = [None; BINS];
            for &id in ids {
                let sum = &mut sums[bins.of(self.at(id), axis)];
                *sum = add(*sum, Some(self.clusters[id as usize]));
            }
            let mut behind = [None; BINS];
            for bin in (1..BINS).rev() {
                behind[bin - 1] = add(behind[bin], sums[bin]);
            }
            let mut before = None;
            for bin in 0..BINS - 1 {
                before = add(before, sums[bin]);
                let (Some(left), Some(right)) = (&before, &behind[bin]) else { continue };
                let cost = self.measure(left, flat) + self.measure(right, flat);
                let cost = cost * (longest / extent[axis]);
                if best.is_none_or(|best| cost < best.0) {
                    best = Some((cost, axis, bin));
                }
            }
        }
        best.map(|(_, axis, bin)| (axis, bins, bin))
    }

    /// Intensity times surface times directions; of a side of a `flat` node with its diagonal.
    fn measure(&self, cluster: &Cluster, flat: bool) -> f64 {
        let extent = cluster.max - cluster.min;
        let size = if flat { extent.length() } else { surface(extent) };
        let directions = self.emitted_rad.map_or(1.0, |emitted| directions(cluster, emitted));
        cluster.intensity * size * directions
    }
}

fn add(a: Option<Cluster>, b: Option<Cluster>) -> Option<Cluster> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.joined(&b)),
        (a, b) => a.or(b),
    }
}

fn surface(extent: DVec3) -> f64 {
    2.0 * (extent.x * extent.y + extent.y * extent.z + extent.z * extent.x)
}

/// The paper's measure of directions: of the cone of axes, and, weighted by the cosine, of what is
/// emitted beyond it.
fn directions(cluster: &Cluster, emitted_rad: f64) -> f64 {
    let opening = 2.0 * cluster.half[1].atan2(cluster.half[0]);
    let whole = (opening + emitted_rad).min(PI);
    let (sine, cosine) = opening.sin_cos();
    let beyond = 2.0 * whole * sine - (opening - 2.0 * whole).cos() - 2.0 * opening * sine + cosine;
    TAU * (1.0 - cosine) + FRAC_PI_2 * beyond
}

/// Equal slices of a box.
struct Bins {
    min: DVec3,
    max: DVec3,
}

impl Bins {
    fn of_all(all: impl Iterator<Item = DVec3>) -> Self {
        let none = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };
        all.fold(none, |bins, at| Self { min: bins.min.min(at), max: bins.max.max(at) })
    }

    /// The bin of a place along an axis with an extent.
    fn of(&self, at: DVec3, axis: usize) -> usize {
        let share = (at[axis] - self.min[axis]) / (self.max[axis] - self.min[axis]);
        ((share * BINS as f64) as usize).min(BINS - 1)
    }
}

/// Puts what `is_first` before the rest; how many they are.
fn partition(ids: &mut [u32], is_first: impl Fn(u32) -> bool) -> usize {
    let mut first = 0;
    for i in 0..ids.len() {
        if is_first(ids[i]) {
            ids.swap(i, first);
            first += 1;
        }
    }
    first
}
