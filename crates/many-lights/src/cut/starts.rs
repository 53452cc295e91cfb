//! Where walks begin, by what a pixel shows.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 5.2.1 (precuts, one
//! list for all objects of a cell) and section 6.1 (future work: heights below which a cluster is
//! hidden).
//! Deviations: none; an object without a list of its own begins at the tree's roots.

use crate::LightsError;

/// Start nodes of every object. As two lists of `u32`, the form in which a device holds them too:
/// ranges, and nodes. Nodes may have heights: points at that height and below do not start there.
///
/// Made anew every frame in the memory it has: [`Starts::restart`], then lists ([`Starts::add`]), then
/// which objects have them ([`Starts::set`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Starts {
    ranges: Vec<[u32; 2]>,
    nodes: Vec<u32>,
    /// Local y, metres, one a node; empty where no node has one.
    hidden_below: Vec<f32>,
}

/// A list of start nodes of a [`Starts`], until that is restarted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StartList([u32; 2]);

/// The height of a node that is hidden from no point.
const NEVER: f32 = f32::NEG_INFINITY;

impl Starts {
    /// The roots for every object.
    pub fn roots(roots: &[u32]) -> Self {
        let mut starts = Self { ranges: Vec::new(), nodes: Vec::new(), hidden_below: Vec::new() };
        starts.restart(roots, 0);
        starts
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
        starts.restart(roots, lists.len());
        for (object, list) in lists.iter().enumerate() {
            if let Some(list) = list {
                starts.ranges[object + 1] = starts.add(list).0;
            }
        }
        starts.check(nodes)?;
        Ok(starts)
    }

    /// Empties it, memory kept: objects `0..objects` may be given lists, and all start at the roots.
    pub fn restart(&mut self, roots: &[u32], objects: usize) {
        self.nodes.clear();
        self.nodes.extend_from_slice(roots);
        self.hidden_below.clear();
        self.ranges.clear();
        self.ranges.resize(objects + 1, [0, roots.len() as u32]);
    }

    /// Adds a list, for as many objects as share it.
    pub fn add(&mut self, nodes: &[u32]) -> StartList {
        let first = self.nodes.len() as u32;
        self.nodes.extend_from_slice(nodes);
        if !self.hidden_below.is_empty() {
            self.hidden_below.resize(self.nodes.len(), NEVER);
        }
        StartList([first, nodes.len() as u32])
    }

    /// Adds a list whose nodes are hidden from points at `hidden_below` and below: local y in metres,
    /// one a node, minus infinity for never. Whoever rounds such heights rounds them down.
    ///
    /// # Errors
    /// [`LightsError::Value`]: another number of heights than of nodes, or one that is no number.
    pub fn add_below(
        &mut self,
        nodes: &[u32],
        hidden_below: &[f32],
    ) -> Result<StartList, LightsError> {
        let refuse = |limit: String| Err(LightsError::value("heights of starts", limit));
        if nodes.len() != hidden_below.len() {
            return refuse(format!("{} for {} nodes", hidden_below.len(), nodes.len()));
        }
        if let Some(place) = hidden_below.iter().position(|height| height.is_nan()) {
            return refuse(format!("that of node {} is not a number", nodes[place]));
        }
        self.hidden_below.resize(self.nodes.len(), NEVER);
        self.hidden_below.extend_from_slice(hidden_below);
        let first = self.nodes.len() as u32;
        self.nodes.extend_from_slice(nodes);
        Ok(StartList([first, nodes.len() as u32]))
    }

    /// Lets an object start at a list.
    ///
    /// # Errors
    /// [`LightsError::Value`]: an object beyond those of the last [`Starts::restart`], or a list from
    /// before it.
    pub fn set(&mut self, object: u32, list: StartList) -> Result<(), LightsError> {
        let objects = self.ranges.len() - 1;
        let StartList([first, number]) = list;
        if u64::from(first) + u64::from(number) > self.nodes.len() as u64 {
            let limit = "its list is one of earlier starts";
            return Err(LightsError::value(format!("object {object}"), limit));
        }
        match self.ranges.get_mut((object as usize).saturating_add(1)) {
            Some(range) => {
                *range = list.0;
                Ok(())
            }
            None => {
                let limit = format!("there are {objects} objects");
                Err(LightsError::value(format!("object {object}"), limit))
            }
        }
    }

    /// Refuses starts at nodes that a tree of so many nodes does not have.
    ///
    /// # Errors
    /// [`LightsError::Value`] that names the node, and the first object that starts there.
    pub fn check(&self, nodes: usize) -> Result<(), LightsError> {
        let Some(place) = self.nodes.iter().position(|&node| node as usize >= nodes) else {
            return Ok(());
        };
        let holds = |[first, number]: [u32; 2]| {
            (first as usize..first as usize + number as usize).contains(&place)
        };
        // The first range is the roots'.
        let name = match self.ranges.iter().position(|&range| holds(range)) {
            Some(0) => "objects without a list".into(),
            Some(range) => format!("object {}", range - 1),
            None => "a list of no object".into(),
        };
        let limit = format!("starts at node {} of a tree of {nodes}", self.nodes[place]);
        Err(LightsError::value(name, limit))
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

    /// The nodes of a range with the heights that they are hidden below.
    pub fn with_heights(&self, range: [u32; 2]) -> impl Iterator<Item = (u32, f32)> + Clone {
        let heights = self.hidden_below.get(range[0] as usize..).unwrap_or_default();
        let heights = heights.iter().copied().chain(std::iter::repeat(NEVER));
        self.nodes(range).iter().copied().zip(heights)
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

    /// Height of each node of [`Starts::lists`] at which, and below, points do not start there: local
    /// y, metres, minus infinity for never. Empty where no node has one.
    pub fn hidden_below(&self) -> &[f32] {
        &self.hidden_below
    }

    /// Of what a device holds.
    pub(crate) fn of_lists(ranges: Vec<[u32; 2]>, nodes: Vec<u32>, hidden_below: Vec<f32>) -> Self {
        Self { ranges, nodes, hidden_below }
    }

    /// Most nodes that any object starts at.
    pub fn most(&self) -> usize {
        self.ranges.iter().map(|[_, number]| *number as usize).max().unwrap_or(0)
    }

    /// Becomes the same as another, in the memory it has.
    pub fn copy_from(&mut self, other: &Self) {
        self.ranges.clone_from(&other.ranges);
        self.nodes.clone_from(&other.nodes);
        self.hidden_below.clone_from(&other.hidden_below);
    }

    /// Bytes.
    pub fn bytes(&self) -> u64 {
        let heights = size_of_val(&*self.hidden_below);
        (size_of_val(&*self.ranges) + size_of_val(&*self.nodes) + heights) as u64
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
        let error = Starts::roots(&[0, 3]).check(3).unwrap_err();
        assert_eq!(error.to_string(), "objects without a list: starts at node 3 of a tree of 3");
        assert!(Starts::roots(&[0, 3]).check(4).is_ok());
    }

    #[test]
    fn objects_share_lists_and_a_restart_forgets_them() {
        let mut starts = Starts::roots(&[0]);
        starts.restart(&[0], 3);
        let list = starts.add(&[4, 7]);
        [0, 2].iter().for_each(|&object| starts.set(object, list).unwrap());
        let expected = Starts::new(&[0], &[Some(vec![4, 7]), None, Some(vec![4, 7])], 8).unwrap();
        (0..4).for_each(|object| assert_eq!(starts.of(object), expected.of(object)));
        // Two objects, one copy.
        assert_eq!(starts.lists(), (&[[0, 1], [1, 2], [0, 1], [1, 2]][..], &[0, 4, 7][..]));
        let error = starts.set(3, list).unwrap_err();
        assert_eq!(error.to_string(), "object 3: there are 3 objects");
        assert!(starts.set(u32::MAX, list).is_err());
        starts.restart(&[0, 9], 1);
        assert_eq!(starts, Starts::new(&[0, 9], &[None], 10).unwrap());
        assert_eq!(
            starts.set(0, list).unwrap_err().to_string(),
            "object 0: its list is one of earlier starts"
        );
    }

    #[test]
    fn nodes_without_a_height_are_hidden_from_none() {
        let mut starts = Starts::roots(&[0]);
        starts.restart(&[0], 3);
        let plain = starts.add(&[4, 7]);
        starts.set(0, plain).unwrap();
        assert!(starts.hidden_below().is_empty());
        let high = starts.add_below(&[5, 6], &[2.5, NEVER]).unwrap();
        starts.set(1, high).unwrap();
        let behind = starts.add(&[3]);
        starts.set(2, behind).unwrap();
        let of = |object| starts.with_heights(starts.range(object)).collect::<Vec<_>>();
        assert_eq!(of(0), [(4, NEVER), (7, NEVER)]);
        assert_eq!(of(1), [(5, 2.5), (6, NEVER)]);
        assert_eq!(of(2), [(3, NEVER)]);
        assert_eq!(of(9), [(0, NEVER)]);
        assert_eq!(starts.hidden_below().len(), starts.lists().1.len());
        let error = starts.add_below(&[5, 6], &[1.0]).unwrap_err();
        assert_eq!(error.to_string(), "heights of starts: 1 for 2 nodes");
        let error = starts.add_below(&[5, 6], &[1.0, f32::NAN]).unwrap_err();
        assert_eq!(error.to_string(), "heights of starts: that of node 6 is not a number");
    }
}
