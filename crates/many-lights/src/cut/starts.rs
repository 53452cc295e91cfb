//! Where walks begin, by what a pixel shows.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 5.2.1 (precuts).
//! Deviations: none; an object without a list of its own begins at the tree's roots.

use crate::LightsError;

/// Start nodes of every object. As two lists of `u32`, the form in which a device holds them too:
/// ranges, and nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Starts {
    ranges: Vec<[u32; 2]>,
    nodes: Vec<u32>,
}

impl Starts {
    /// The roots for every object.
    pub fn roots(roots: &[u32]) -> Self {
        Self { ranges: vec![[0, roots.len() as u32]], nodes: roots.to_vec() }
    }

    /// Lists of objects `0..lists.len()`, `None` where there is none, and so the roots; an empty list
    /// is an object that nothing lights. `nodes` is how many the tree has.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names the object: a node that the tree does not have.
    pub fn new(
        roots: &[u32],
        lists: &[Option<Vec<u32>>],
        nodes: usize,
    ) -> Result<Self, LightsError> {
        let mut starts = Self::roots(roots);
        let default = starts.ranges[0];
        for (object, list) in lists.iter().enumerate() {
            let Some(list) = list else {
                starts.ranges.push(default);
                continue;
            };
            if let Some(node) = list.iter().find(|&&node| node as usize >= nodes) {
                let limit = format!("starts at node {node} of a tree of {nodes}");
                return Err(LightsError::value(format!("object {object}"), limit));
            }
            let from = starts.nodes.len() as u32;
            starts.nodes.extend_from_slice(list);
            starts.ranges.push([from, list.len() as u32]);
        }
        Ok(starts)
    }

    /// Range in the nodes of what an object starts at: first and number.
    pub fn range(&self, object: u32) -> [u32; 2] {
        let own = self.ranges.get((object as usize).saturating_add(1));
        *own.unwrap_or(&self.ranges[0])
    }

    /// The nodes of a range.
    pub fn nodes(&self, [first, number]: [u32; 2]) -> &[u32] {
        &self.nodes[first as usize..][..number as usize]
    }

    /// What an object starts at.
    pub fn of(&self, object: u32) -> &[u32] {
        self.nodes(self.range(object))
    }

    /// As a device holds it: first and number for the roots, then for object 0, 1 and so on; and the
    /// nodes.
    /// An object beyond the ranges starts at the roots.
    pub fn lists(&self) -> (&[[u32; 2]], &[u32]) {
        (&self.ranges, &self.nodes)
    }

    /// Most nodes that any object starts at.
    pub fn most(&self) -> usize {
        self.ranges.iter().map(|[_, number]| *number as usize).max().unwrap_or(0)
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&*self.ranges) + size_of_val(&*self.nodes)) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_without_a_list_start_at_the_roots_and_empty_lists_stay_empty() {
        let starts = Starts::new(&[0, 9], &[Some(vec![3, 4]), None, Some(vec![])], 12).unwrap();
        assert_eq!(starts.of(0), [3, 4]);
        assert_eq!(starts.of(1), [0, 9]);
        assert!(starts.of(2).is_empty());
        assert_eq!(starts.of(3), [0, 9]);
        assert_eq!(starts.of(crate::NOTHING), [0, 9]);
        assert_eq!(starts.most(), 2);
        let (ranges, nodes) = starts.lists();
        assert_eq!(ranges, [[0, 2], [2, 2], [0, 2], [4, 0]]);
        assert_eq!(nodes, [0, 9, 3, 4]);
    }

    #[test]
    fn a_node_that_is_not_there_is_refused_by_name() {
        let error = Starts::new(&[0], &[None, Some(vec![12])], 12).unwrap_err();
        assert_eq!(error.to_string(), "object 1: starts at node 12 of a tree of 12");
    }
}
