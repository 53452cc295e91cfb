//! Fusion and reprojection in their clear form: trees of shadows, every one of which is looked at.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 4.2.4 (fusion)
//! and 4.2.5 (reprojection).
//! Deviations: as [`super`].

use super::join::{by_foot, by_height, by_left, is_real, join, meet, within};
use super::{
    Cuboid, Fusion, Projection, Umbra, Verdict, asked::is_endless, asked_part, query::overlaps,
    reproject,
};

/// A shadow and those inside its interval that hide more than it does.
#[derive(Clone, Debug, PartialEq)]
pub struct Shadow {
    /// What it hides.
    pub umbra: Umbra,
    /// Each at least as tall, with a foot at least as low.
    pub children: Vec<Self>,
}

/// [`super::Horizon`] with the same verdicts.
#[derive(Clone, Debug)]
pub struct Horizon {
    fusion: Fusion,
    /// In no particular order.
    roots: Vec<Shadow>,
}

impl Horizon {
    /// No shadows.
    pub fn new(fusion: Fusion) -> Self {
        Self { fusion, roots: Vec::new() }
    }

    /// Forgets all shadows.
    pub fn clear(&mut self) {
        self.roots.clear();
    }

    /// Whether nothing is hidden.
    pub fn is_empty(&self) -> bool {
        self.roots.is_empty()
    }

    /// Shadows on the current plane join what is there.
    pub fn add(&mut self, shadows: &[Umbra]) {
        let single = |&umbra: &Umbra| Shadow { umbra, children: Vec::new() };
        let shadows: Vec<Shadow> = shadows.iter().filter(|s| is_real(s)).map(single).collect();
        match self.fusion {
            Fusion::None => self.roots.extend(shadows),
            Fusion::Insertion => {
                shadows.into_iter().for_each(|shadow| self.insert(shadow, by_left));
            }
            Fusion::HeightOrdered => {
                let adds = |shadow: &Shadow| {
                    !self.roots.iter().any(|root| within(&shadow.umbra, &root.umbra))
                };
                let shadows = shadows.into_iter().filter(adds).collect();
                let mut anew = self.take_reached(shadows);
                anew.sort_by(|a, b| by_height(&a.umbra, &b.umbra));
                for shadow in anew {
                    if !self.roots.iter().any(|root| within(&shadow.umbra, &root.umbra)) {
                        self.insert(shadow, by_foot);
                    }
                }
            }
        }
    }

    /// Every shadow on its own, of the new ones and of all trees that they touch, directly or through
    /// others.
    fn take_reached(&mut self, mut reached: Vec<Shadow>) -> Vec<Shadow> {
        let mut next = 0;
        while next < reached.len() {
            let by = reached[next].umbra;
            next += 1;
            reached.extend(self.roots.extract_if(.., |root| meet(&root.umbra, &by)));
        }
        let mut single = Vec::new();
        while let Some(mut shadow) = reached.pop() {
            reached.append(&mut shadow.children);
            single.push(shadow);
        }
        single
    }

    /// Joins a shadow with a root for as long as there is one that it can be joined with, the first
    /// in an order.
    fn insert(&mut self, mut shadow: Shadow, order: fn(&Umbra, &Umbra) -> std::cmp::Ordering) {
        loop {
            let fusible = self.roots.iter().enumerate().filter_map(|(at, root)| {
                Some((at, &root.umbra, join(&shadow.umbra, &root.umbra)?))
            });
            let Some((at, _, umbra)) = fusible.min_by(|a, b| order(a.1, b.1)) else { break };
            let mut parent = Shadow { umbra, children: Vec::new() };
            for mut child in [self.roots.remove(at), shadow] {
                // What adds nothing to its parent is replaced by it.
                match within(&child.umbra, &umbra) {
                    true => parent.children.append(&mut child.children),
                    false => parent.children.push(child),
                }
            }
            shadow = parent;
        }
        self.roots.push(shadow);
    }

    /// Moves everything from one plane to a farther one; returns how many shadows are left.
    pub fn reproject(&mut self, cell: &Cuboid, from: f64, to: f64) -> u64 {
        self.moved(&|umbra| reproject(cell, umbra, from, to))
    }

    /// As [`super::Horizon::reproject_asked`].
    pub fn reproject_asked(
        &mut self,
        cell: &Cuboid,
        [from, to]: [f64; 2],
        asked: &Projection,
    ) -> u64 {
        self.moved(&|umbra| asked_part(&reproject(cell, umbra, from, to)?, asked))
    }

    fn moved(&mut self, by: &dyn Fn(&Umbra) -> Option<Umbra>) -> u64 {
        let roots = std::mem::take(&mut self.roots);
        self.roots = roots.into_iter().flat_map(|root| moved(root, None, by)).collect();
        self.nodes().len() as u64
    }

    /// Whether a projection lies in one shadow. Adds to `compared` the shadows there are.
    pub fn test(&self, p: &Projection, compared: &mut u64) -> Verdict {
        let nodes = self.nodes();
        *compared += nodes.len() as u64;
        if nodes.iter().any(|shadow| shadow.hides(p)) {
            Verdict::Hidden
        } else if nodes.iter().any(|shadow| overlaps(shadow, p)) {
            Verdict::Partial
        } else {
            Verdict::Free
        }
    }

    /// The trees.
    pub fn roots(&self) -> &[Shadow] {
        &self.roots
    }

    /// All shadows, parents before their children.
    pub fn nodes(&self) -> Vec<Umbra> {
        let mut open: Vec<&Shadow> = self.roots.iter().collect();
        let mut nodes = Vec::new();
        while let Some(shadow) = open.pop() {
            nodes.push(shadow.umbra);
            open.extend(&shadow.children);
        }
        nodes
    }
}

/// What is left of a tree below `parent`.
fn moved(
    shadow: Shadow,
    parent: Option<&Umbra>,
    by: &dyn Fn(&Umbra) -> Option<Umbra>,
) -> Vec<Shadow> {
    let left = by(&shadow.umbra).filter(|umbra| !parent.is_some_and(|p| within(umbra, p)));
    let below = |above: Option<&Umbra>, children: Vec<Shadow>| {
        children.into_iter().flat_map(|child| moved(child, above, by)).collect()
    };
    match left {
        None => below(parent, shadow.children),
        Some(umbra) if is_endless(&umbra) => vec![Shadow { umbra, children: Vec::new() }],
        Some(umbra) => vec![Shadow { umbra, children: below(Some(&umbra), shadow.children) }],
    }
}
