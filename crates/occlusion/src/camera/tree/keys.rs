//! A hierarchy that is given: paths such as block, building, facade, storey.

use super::{Objects, Tree, check};
use crate::OcclusionError;
use std::ops::Range;

impl Tree {
    /// By a given hierarchy: objects with equal leading keys share a node at that level; levels of
    /// a single child are left out. Leaves of one object. `keys` has one path an object, of any
    /// length; objects whose paths end at a node are leaves right below it. Children follow each
    /// other in the order of their keys, after those whose paths end.
    ///
    /// # Errors
    /// Another number of keys than objects, more than 2^31 of them, bounds that are not finite.
    pub fn by_keys(objects: &Objects, keys: &[Vec<u32>]) -> Result<Self, OcclusionError> {
        check_keys(keys, objects.objects.len())?;
        check(objects)?;
        let count = keys.len() as u32;
        let mut tree = Self { nodes: Vec::new(), objects: (0..count).collect() };
        if count == 0 {
            return Ok(tree);
        }
        tree.objects.sort_by_key(|&o| &keys[o as usize]);
        tree.nodes.push(Self::node(0, 0..count));
        let mut open = vec![(0_u32, 0_usize)];
        while let Some((index, level)) = open.pop() {
            let range = tree.nodes[index as usize].objects.clone();
            if range.len() == 1 {
                continue;
            }
            let (groups, level) = groups(&tree.objects, keys, &range, level);
            let first = tree.nodes.len() as u32;
            tree.nodes[index as usize].children = first..first + groups.len() as u32;
            // The first child is taken first.
            open.extend((first..first + groups.len() as u32).rev().map(|child| (child, level + 1)));
            tree.nodes.extend(groups.into_iter().map(|range| Self::node(index, range)));
        }
        tree.fit(objects);
        Ok(tree)
    }

    /// Number of leading keys that all objects below a node share: 1 for a node of one block, and
    /// so on, whatever levels were left out.
    ///
    /// # Errors
    /// Another number of keys than objects.
    pub fn path_lengths(&self, keys: &[Vec<u32>]) -> Result<Vec<u32>, OcclusionError> {
        check_keys(keys, self.objects.len())?;
        let common = |index: u32| {
            let mut paths = self.objects_of(index).iter().map(|&o| &keys[o as usize][..]);
            let first = paths.next().unwrap_or(&[]);
            paths.fold(first.len(), |common, path| common.min(shared(first, path))) as u32
        };
        Ok((0..self.nodes.len() as u32).map(common).collect())
    }
}

fn check_keys(keys: &[Vec<u32>], objects: usize) -> Result<(), OcclusionError> {
    if keys.len() == objects {
        return Ok(());
    }
    let limit = format!("{} for {objects} objects", keys.len());
    Err(OcclusionError::value("keys of the tree", limit))
}

/// Number of leading keys in common.
fn shared(a: &[u32], b: &[u32]) -> usize {
    a.iter().zip(b).take_while(|(a, b)| a == b).count()
}

/// The objects of `range`, at least two, by their keys at the first level from `level` on where
/// they differ; that level. Those whose paths end there are each a group of their own.
fn groups(
    objects: &[u32],
    keys: &[Vec<u32>],
    range: &Range<u32>,
    level: usize,
) -> (Vec<Range<u32>>, usize) {
    let path = |place: u32| &keys[objects[place as usize] as usize];
    // They are sorted: all have in common what the first and the last have.
    let level = level.max(shared(path(range.start), path(range.end - 1)));
    let mut groups: Vec<Range<u32>> = Vec::new();
    let mut before = None;
    for place in range.clone() {
        let key = path(place).get(level).copied();
        match groups.last_mut() {
            Some(group) if key.is_some() && key == before => group.end = place + 1,
            _ => groups.push(place..place + 1),
        }
        before = key;
    }
    (groups, level)
}
