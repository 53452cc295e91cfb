//! A hierarchy that is given: paths such as block, building, facade, storey.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.1.
//! Deviations: a level at which a cluster has a single child is left out, for it would be visited
//! and bounded for nothing: a node has at least two children.

use super::shape::Place;
use crate::{Light, LightsError};

/// Most levels of a path.
pub const MOST_LEVELS: usize = 256;

pub(super) fn check(lights: &[Light], keys: &[Vec<u32>]) -> Result<(), LightsError> {
    if keys.len() != lights.len() {
        let limit = format!("{} for {} lights", keys.len(), lights.len());
        return Err(LightsError::value("keys of a light tree", limit));
    }
    match keys.iter().position(|key| key.len() > MOST_LEVELS) {
        None => Ok(()),
        Some(light) => {
            let limit = format!("{} levels of at most {MOST_LEVELS}", keys[light].len());
            Err(LightsError::value(format!("key of light {light}"), limit))
        }
    }
}

/// Sorts lights by their paths, equal ones by number.
pub(super) fn sort(keys: &[Vec<u32>], ids: &mut [u32]) {
    ids.sort_by(|&a, &b| keys[a as usize].cmp(&keys[b as usize]).then(a.cmp(&b)));
}

/// At least two lights, sorted, that agree in the first `level` keys, by their keys at the first level
/// from there on where they differ; that level. Those whose paths end there are each alone.
pub(super) fn groups<'a>(
    keys: &'a [Vec<u32>],
    ids: &'a [u32],
    level: usize,
) -> (impl Iterator<Item = &'a [u32]>, usize) {
    let path = |id: u32| &keys[id as usize][..];
    // They are sorted: all have in common what the first and the last have.
    let (first, last) = (path(ids[0]), path(ids[ids.len() - 1]));
    let rest = first.iter().zip(last).skip(level);
    let level = level + rest.take_while(|(a, b)| a == b).count();
    let groups = ids.chunk_by(move |&a, &b| match (path(a).get(level), path(b).get(level)) {
        (Some(a), Some(b)) => a == b,
        _ => false,
    });
    (groups, level)
}

/// The tree over `ids`, at least one. Children are in the order of their keys, after the lights whose
/// paths end at the node.
pub(super) fn build(keys: &[Vec<u32>], mut ids: Vec<u32>) -> Vec<Place> {
    sort(keys, &mut ids);
    let mut places = Vec::with_capacity(ids.len() + ids.len() / 2);
    append(keys, &ids, 0, &mut places);
    places
}

/// Appends the subtree of lights, sorted, that agree in the first `level` keys.
fn append(keys: &[Vec<u32>], ids: &[u32], level: usize, places: &mut Vec<Place>) {
    if let [id] = ids {
        places.push(Place::leaf(*id));
        return;
    }
    let node = places.len();
    places.push(Place::cluster(0));
    let (groups, level) = groups(keys, ids, level);
    for group in groups {
        append(keys, group, level + 1, places);
    }
    places[node].size = (places.len() - node) as u32;
}
