//! Halves along the longest axis.
//!
//! Deviations: none from the usual median split; lights of equal place go by their index, so that
//! any lights at all, coincident ones too, are halved.

use super::shape::Place;
use crate::{Light, light::Emission};
use glam::DVec3;

/// Fewer lights are not worth another thread.
const PARALLEL: usize = 4096;

/// Where a light counts as being: parallel light has no position, but a place on the sphere of axes.
pub(super) fn place_of(light: &Light) -> DVec3 {
    if light.emission == Emission::Directional { light.axis } else { light.position }
}

/// The tree over `ids`, at least one, whose order is lost.
pub(super) fn build(lights: &[Light], ids: &mut [u32]) -> Vec<Place> {
    let mut places = vec![Place::leaf(0); 2 * ids.len() - 1];
    split(&|id| place_of(&lights[id as usize]), ids, &mut places);
    places
}

fn split(at: &(impl Fn(u32) -> DVec3 + Sync), ids: &mut [u32], places: &mut [Place]) {
    if let [id] = ids {
        places[0] = Place::leaf(*id);
        return;
    }
    places[0] = Place::cluster(places.len() as u32);
    let parallel = ids.len() >= PARALLEL;
    let (left, right) = halve(at, ids);
    // A binary tree over n lights has 2 n - 1 nodes.
    let (left_places, right_places) = places[1..].split_at_mut(2 * left.len() - 1);
    if parallel {
        rayon::join(|| split(at, left, left_places), || split(at, right, right_places));
    } else {
        split(at, left, left_places);
        split(at, right, right_places);
    }
}

/// Two halves of at least two, the greater first, apart along the longest axis of their places; equal
/// ones by index.
pub(super) fn halve<'i>(
    at: &impl Fn(u32) -> DVec3,
    ids: &'i mut [u32],
) -> (&'i mut [u32], &'i mut [u32]) {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &id in &*ids {
        (min, max) = (min.min(at(id)), max.max(at(id)));
    }
    let axis = longest(max - min);
    let middle = ids.len().div_ceil(2);
    ids.select_nth_unstable_by(middle, |&a, &b| {
        at(a)[axis].total_cmp(&at(b)[axis]).then(a.cmp(&b))
    });
    ids.split_at_mut(middle)
}

/// The first of the axes along which `extent` is greatest.
pub(super) fn longest(extent: DVec3) -> usize {
    let [x, y, z] = extent.to_array();
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}
