//! How shadows that have come near each other are joined into trees.

use super::forest::{Forest, Group, Node};
use super::join::{by_foot, by_height, by_left, join, within};
use super::{Fusion, Umbra};
use std::ops::Range;

/// No item.
const NONE: u32 = u32::MAX;

/// A shadow, or a run of whole subtrees that stay as they are.
#[derive(Clone, Copy, Debug)]
struct Item {
    umbra: Umbra,
    /// As a node without children, but for its highest point.
    node: Node,
    /// Nodes that are copied, for a run.
    run: Option<(u32, u32)>,
    first_child: u32,
    last_child: u32,
    /// Next among siblings, or among the roots of a bin.
    next: u32,
}

/// Roots whose intervals are connected. Nothing is looked for in bins of shadows that are not joined.
#[derive(Clone, Copy, Debug)]
struct Bin {
    u: [f64; 2],
    first: u32,
}

/// Shadows of one connected part of a plane while they are joined.
#[derive(Clone, Debug, Default)]
pub(super) struct Weave {
    items: Vec<Item>,
    /// From left to right; none has a point in common with another.
    bins: Vec<Bin>,
    /// Roots that a new shadow may be joined with.
    near: Vec<u32>,
    order: Vec<Ranked>,
    open: Vec<(u32, u32)>,
}

/// An item with what mostly decides its place in [`by_height`].
#[derive(Clone, Copy, Debug)]
struct Ranked {
    top: f64,
    left: f64,
    item: u32,
}

impl Weave {
    /// Joins the shadows of some groups of `old` with new ones, all of them connected, into one group
    /// of `out`. Edges of new shadows are put into `old`.
    pub fn cluster<'a>(
        &mut self,
        fusion: Fusion,
        old: &mut Forest,
        groups: Range<usize>,
        new: impl Iterator<Item = &'a Umbra>,
        out: &mut Forest,
    ) {
        self.items.clear();
        self.bins.clear();
        match fusion {
            Fusion::None | Fusion::Insertion => {
                for group in groups {
                    let group = old.groups[group];
                    self.keep(old, &group);
                }
                for umbra in new {
                    let first = self.leaf(old, umbra);
                    match fusion {
                        Fusion::None => self.bins.push(Bin { u: umbra.u, first }),
                        _ => self.insert(first, by_left),
                    }
                }
            }
            Fusion::HeightOrdered => {
                for group in groups {
                    let Group { start, end, .. } = old.groups[group];
                    for at in start..end {
                        let node = old.nodes[at as usize];
                        let umbra = old.umbra(&node);
                        self.push(umbra, Node { size: 1, highest: umbra.highest(), ..node });
                    }
                }
                for umbra in new {
                    self.leaf(old, umbra);
                }
                let mut order = std::mem::take(&mut self.order);
                order.clear();
                let ranked = |(item, Item { umbra, .. }): (u32, &Item)| Ranked {
                    top: umbra.lowest(),
                    left: umbra.u[0],
                    item,
                };
                order.extend((0..).zip(&self.items).map(ranked));
                order.sort_unstable_by(|a, b| {
                    let first = b.top.total_cmp(&a.top).then_with(|| a.left.total_cmp(&b.left));
                    first.then_with(|| by_height(self.umbra(a.item), self.umbra(b.item)))
                });
                for &Ranked { item, .. } in &order {
                    if !self.is_held(item) {
                        self.insert(item, by_foot);
                    }
                }
                self.order = order;
            }
        }
        self.emit(old, out);
    }

    pub fn bytes(&self) -> usize {
        let Self { items, bins, near, order, open } = self;
        items.capacity() * size_of::<Item>()
            + bins.capacity() * size_of::<Bin>()
            + near.capacity() * size_of::<u32>()
            + order.capacity() * size_of::<Ranked>()
            + open.capacity() * size_of::<(u32, u32)>()
    }

    fn push(&mut self, umbra: Umbra, node: Node) -> u32 {
        let (first_child, last_child, next) = (NONE, NONE, NONE);
        self.items.push(Item { umbra, node, run: None, first_child, last_child, next });
        self.items.len() as u32 - 1
    }

    fn leaf(&mut self, old: &mut Forest, umbra: &Umbra) -> u32 {
        let node = old.node(umbra);
        self.push(*umbra, node)
    }

    /// The trees of a group as they are, in a bin to the right of all others.
    fn keep(&mut self, old: &Forest, group: &Group) {
        let mut first = NONE;
        for root in old.roots(group) {
            let node = old.nodes[root as usize];
            let item = self.push(old.umbra(&node), Node { size: 1, ..node });
            if node.size > 1 {
                let run = self.push(old.umbra(&node), node);
                self.items[run as usize].run = Some((root + 1, root + node.size));
                self.add_child(item, run);
            }
            self.items[item as usize].next = first;
            first = item;
        }
        self.bins.push(Bin { u: group.u, first });
    }

    fn umbra(&self, item: u32) -> &Umbra {
        &self.items[item as usize].umbra
    }

    /// The bins that a shadow has points in common with.
    fn reached(&self, umbra: &Umbra) -> Range<usize> {
        let first = self.bins.partition_point(|bin| bin.u[1] < umbra.u[0]);
        let more = self.bins[first..].partition_point(|bin| bin.u[0] <= umbra.u[1]);
        first..first + more
    }

    fn members(&self, bin: &Bin) -> impl Iterator<Item = u32> + '_ {
        let next = |item: u32| Some(item).filter(|&item| item != NONE);
        std::iter::successors(next(bin.first), move |&at| next(self.items[at as usize].next))
    }

    /// Whether some root hides all that a shadow hides.
    fn is_held(&self, item: u32) -> bool {
        let umbra = self.umbra(item);
        let bins = &self.bins[self.reached(umbra)];
        bins.iter().any(|bin| self.members(bin).any(|root| within(umbra, self.umbra(root))))
    }

    /// Joins a shadow with a root for as long as there is one that it can be joined with, the first
    /// in an order.
    fn insert(&mut self, mut item: u32, order: fn(&Umbra, &Umbra) -> std::cmp::Ordering) {
        let bins = self.reached(self.umbra(item));
        let mut near = std::mem::take(&mut self.near);
        near.clear();
        near.extend(self.bins[bins.clone()].iter().flat_map(|bin| self.members(bin)));
        near.sort_unstable_by(|&a, &b| order(self.umbra(a), self.umbra(b)).then(a.cmp(&b)));
        let mut left = 0;
        while let Some((at, umbra)) = near[left..].iter().enumerate().find_map(|(n, &root)| {
            let umbra = join(self.umbra(item), self.umbra(root))?;
            Some((left + n, umbra))
        }) {
            // The rest keeps its order.
            near[left..=at].rotate_right(1);
            item = self.parent(near[left], item, umbra);
            left += 1;
        }
        // What was not joined stays beside it.
        let mut first = NONE;
        for &root in &near[left..] {
            self.items[root as usize].next = first;
            first = root;
        }
        self.near = near;
        let u = self.bins[bins.clone()]
            .iter()
            .fold(self.umbra(item).u, |u, bin| [u[0].min(bin.u[0]), u[1].max(bin.u[1])]);
        self.items[item as usize].next = first;
        self.bins.splice(bins, [Bin { u, first: item }]);
    }

    /// A shadow above two roots. What adds nothing to it is replaced by it.
    fn parent(&mut self, root: u32, item: u32, umbra: Umbra) -> u32 {
        let highest = |at: u32| self.items[at as usize].node.highest;
        let node = Node {
            u: umbra.u,
            top: umbra.lowest(),
            foot: umbra.foot,
            highest: highest(root).max(highest(item)),
            size: 1,
            edge: super::forest::LEVEL,
        };
        let parent = self.push(umbra, node);
        for child in [root, item] {
            if within(self.umbra(child), &umbra) {
                let mut next = self.items[child as usize].first_child;
                while next != NONE {
                    let at = next;
                    next = self.items[at as usize].next;
                    self.add_child(parent, at);
                }
            } else {
                self.add_child(parent, child);
            }
        }
        parent
    }

    fn add_child(&mut self, parent: u32, child: u32) {
        self.items[child as usize].next = NONE;
        let last = std::mem::replace(&mut self.items[parent as usize].last_child, child);
        match last {
            NONE => self.items[parent as usize].first_child = child,
            last => self.items[last as usize].next = child,
        }
    }

    /// All trees from left to right, as one group.
    fn emit(&mut self, old: &Forest, out: &mut Forest) {
        let mut roots = std::mem::take(&mut self.near);
        roots.clear();
        roots.extend(self.bins.iter().flat_map(|bin| self.members(bin)));
        roots.sort_unstable_by(|&a, &b| by_left(self.umbra(a), self.umbra(b)).then(a.cmp(&b)));
        for &root in &roots {
            self.open.clear();
            let mut at = Some(root);
            while let Some(now) = at {
                let item = &self.items[now as usize];
                at = Some(item.first_child).filter(|&child| child != NONE);
                if let Some((start, end)) = item.run {
                    out.nodes.extend_from_slice(&old.nodes[start as usize..end as usize]);
                } else {
                    self.open.push((now, out.nodes.len() as u32));
                    out.nodes.push(item.node);
                }
                at = at.or_else(|| next_open(&self.items, &mut self.open, now, out));
            }
        }
        self.near = roots;
        out.close_group();
    }
}

/// What follows an item whose subtree is complete, within its tree: completes those that end with it.
fn next_open(
    items: &[Item],
    open: &mut Vec<(u32, u32)>,
    mut at: u32,
    out: &mut Forest,
) -> Option<u32> {
    loop {
        if let Some(&(item, place)) = open.last()
            && item == at
        {
            out.nodes[place as usize].size = out.nodes.len() as u32 - place;
            open.pop();
        }
        let &(parent, _) = open.last()?;
        match items[at as usize].next {
            NONE => at = parent,
            next => return Some(next),
        }
    }
}
