//! Trees of shadows as one array, and how they move from plane to plane.

use super::Umbra;
use super::asked::is_endless;
use super::join::within;
use super::reference::Shadow;
use std::ops::Range;

/// A shadow and, right behind it, the `size - 1` shadows below it; 48 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub u: [f64; 2],
    /// Top of the level part.
    pub top: f64,
    pub foot: f64,
    /// The highest point of it and of what is below it.
    pub highest: f64,
    pub size: u32,
    /// Where its edge is kept if it is not level, which leaves alone have, else [`LEVEL`].
    pub edge: u32,
}

pub(super) const LEVEL: u32 = u32::MAX;

/// Trees whose intervals are connected. No other group has a point in common with theirs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub u: [f64; 2],
    pub highest: f64,
    pub start: u32,
    pub end: u32,
}

#[derive(Clone, Debug, Default)]
pub(super) struct Forest {
    pub nodes: Vec<Node>,
    /// From left to right; together they hold all nodes in order.
    pub groups: Vec<Group>,
    /// Shadows whose edge is not level.
    pub edges: Vec<Umbra>,
}

/// What is needed for a while.
#[derive(Clone, Debug, Default)]
pub(super) struct Moving {
    /// End of the old subtree and place of the new node of those that hold the current one.
    open: Vec<(u32, u32)>,
    /// Trees of one old group.
    roots: Vec<u32>,
    nodes: Vec<Node>,
}

impl Group {
    pub fn nodes(&self) -> Range<usize> {
        self.start as usize..self.end as usize
    }
}

impl Moving {
    pub fn bytes(&self) -> usize {
        let Self { open, roots, nodes } = self;
        open.capacity() * size_of::<(u32, u32)>()
            + roots.capacity() * size_of::<u32>()
            + nodes.capacity() * size_of::<Node>()
    }
}

impl Forest {
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.groups.clear();
        self.edges.clear();
    }

    /// A shadow of its own.
    pub fn node(&mut self, umbra: &Umbra) -> Node {
        let edge = match umbra.is_flat() {
            true => LEVEL,
            false => {
                self.edges.push(*umbra);
                self.edges.len() as u32 - 1
            }
        };
        let (top, highest) = (umbra.lowest(), umbra.highest());
        Node { u: umbra.u, top, foot: umbra.foot, highest, size: 1, edge }
    }

    pub fn umbra(&self, node: &Node) -> Umbra {
        match self.edges.get(node.edge as usize) {
            None => Umbra::flat(node.u, node.foot, node.top),
            Some(edge) => *edge,
        }
    }

    /// Starts of the trees of a group.
    pub fn roots(&self, group: &Group) -> impl Iterator<Item = u32> + '_ {
        let end = group.end;
        std::iter::successors(Some(group.start), move |&at| {
            Some(at + self.nodes[at as usize].size).filter(|&next| next < end)
        })
    }

    /// Whether some root hides all that a shadow hides.
    pub fn holds(&self, shadow: &Umbra) -> bool {
        let first = self.groups.partition_point(|group| group.u[1] < shadow.u[1]);
        self.groups.get(first).is_some_and(|group| {
            group.u[0] <= shadow.u[0]
                && self
                    .roots(group)
                    .any(|root| within(shadow, &self.umbra(&self.nodes[root as usize])))
        })
    }

    /// Trees of their own, of nodes that are whole trees.
    pub fn trees(&self, nodes: Range<usize>) -> Vec<Shadow> {
        // From the last to the first: children are complete before their parents.
        let mut done: Vec<(usize, Shadow)> = Vec::new();
        for at in nodes.rev() {
            let node = &self.nodes[at];
            let end = at + node.size as usize;
            let below =
                done.iter().rposition(|&(start, _)| start >= end).map_or(0, |last| last + 1);
            let children = done.drain(below..).rev().map(|(_, child)| child).collect();
            done.push((at, Shadow { umbra: self.umbra(node), children }));
        }
        done.into_iter().rev().map(|(_, tree)| tree).collect()
    }

    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.groups.capacity() * size_of::<Group>()
            + self.edges.capacity() * size_of::<Umbra>()
    }

    /// Closes a group over all nodes behind the last one.
    pub fn close_group(&mut self) {
        let start = self.groups.last().map_or(0, |group| group.end);
        let end = self.nodes.len() as u32;
        let nothing =
            Group { u: [f64::INFINITY, f64::NEG_INFINITY], highest: f64::NEG_INFINITY, start, end };
        let group = self.roots(&nothing).fold(nothing, |mut group, root| {
            let node = &self.nodes[root as usize];
            group.u = [group.u[0].min(node.u[0]), group.u[1].max(node.u[1])];
            group.highest = group.highest.max(node.highest);
            group
        });
        self.groups.push(group);
    }

    /// What becomes of everything on another plane, into `out`, which is empty. Nodes of which nothing
    /// is left leave their children, and so do those that their parents hold.
    pub fn moved(
        &self,
        by: impl Fn(&Umbra) -> Option<Umbra>,
        out: &mut Self,
        scratch: &mut Moving,
    ) {
        for group in &self.groups {
            let first = out.nodes.len();
            scratch.roots.clear();
            let mut next = group.start;
            while next < group.end {
                let at = next;
                let node = &self.nodes[at as usize];
                next += 1;
                let Some(umbra) = by(&self.umbra(node)) else { continue };
                out.close(&mut scratch.open, at);
                if let Some(&(_, parent)) = scratch.open.last()
                    && within(&umbra, &out.umbra(&out.nodes[parent as usize]))
                {
                    continue;
                }
                if is_endless(&umbra) {
                    next = at + node.size;
                }
                let new = out.node(&umbra);
                if scratch.open.is_empty() {
                    scratch.roots.push(out.nodes.len() as u32);
                }
                scratch.open.push((at + node.size, out.nodes.len() as u32));
                out.nodes.push(new);
            }
            out.close(&mut scratch.open, group.end);
            match scratch.roots.len() {
                0 => {}
                1 => out.close_group(),
                _ => out.regroup(first, &mut scratch.roots, &mut scratch.nodes),
            }
        }
    }

    /// Completes nodes whose old subtrees end at or before `at`.
    fn close(&mut self, open: &mut Vec<(u32, u32)>, at: u32) {
        while let Some(&(end, place)) = open.last()
            && end <= at
        {
            open.pop();
            self.nodes[place as usize].size = self.nodes.len() as u32 - place;
            if let Some(&(_, parent)) = open.last() {
                let highest = self.nodes[place as usize].highest;
                let parent = &mut self.nodes[parent as usize];
                parent.highest = parent.highest.max(highest);
            }
        }
    }

    /// Sorts the trees from `first` on from left to right and closes groups over those that connect.
    fn regroup(&mut self, first: usize, roots: &mut [u32], nodes: &mut Vec<Node>) {
        nodes.clear();
        nodes.extend_from_slice(&self.nodes[first..]);
        self.nodes.truncate(first);
        let tree = |root: u32| {
            let start = root as usize - first;
            start..start + nodes[start].size as usize
        };
        let left = |root: u32| nodes[root as usize - first].u[0];
        roots.sort_unstable_by(|&a, &b| left(a).total_cmp(&left(b)).then(a.cmp(&b)));
        let mut reach = f64::NEG_INFINITY;
        for (n, &root) in roots.iter().enumerate() {
            if n > 0 && left(root) > reach {
                self.close_group();
            }
            reach = reach.max(nodes[root as usize - first].u[1]);
            self.nodes.extend_from_slice(&nodes[tree(root)]);
        }
        self.close_group();
    }
}
