//! All shadows on one plane, the fast form: equal to [`super::reference`] in every verdict.

use super::forest::{Forest, Moving};
use super::join::is_real;
use super::weave::Weave;
use super::{Cuboid, Fusion, Projection, Umbra, Verdict, asked_part, reference::Shadow, reproject};

/// All shadows on one plane. It takes no memory once it has held as much before.
#[derive(Clone, Debug)]
pub struct Horizon {
    fusion: Fusion,
    forest: Forest,
    /// What the next one is built in.
    spare: Forest,
    /// New shadows, and their order from left to right.
    new: Vec<Umbra>,
    order: Vec<u32>,
    weave: Weave,
    moving: Moving,
}

impl Horizon {
    /// No shadows.
    pub fn new(fusion: Fusion) -> Self {
        Self {
            fusion,
            forest: Forest::default(),
            spare: Forest::default(),
            new: Vec::new(),
            order: Vec::new(),
            weave: Weave::default(),
            moving: Moving::default(),
        }
    }

    /// Forgets all shadows, keeps their memory.
    pub fn clear(&mut self) {
        self.forest.clear();
    }

    /// Whether nothing is hidden.
    pub fn is_empty(&self) -> bool {
        self.forest.nodes.is_empty()
    }

    /// How many shadows there are, joined ones with those that they hold.
    pub fn len(&self) -> usize {
        self.forest.nodes.len()
    }

    /// 14: shadows on the current plane join what is there. Empty ones, and what is not a number, are
    /// passed over.
    pub fn add(&mut self, shadows: &[Umbra]) {
        let Self { fusion, forest, spare, new, order, weave, .. } = self;
        new.clear();
        let adds = |shadow: &&Umbra| *fusion != Fusion::HeightOrdered || !forest.holds(shadow);
        new.extend(shadows.iter().filter(|shadow| is_real(shadow)).filter(adds));
        if new.is_empty() {
            return;
        }
        order.clear();
        order.extend(0..new.len() as u32);
        let left = |n: u32| new[n as usize].u[0];
        order.sort_unstable_by(|&a, &b| left(a).total_cmp(&left(b)).then(a.cmp(&b)));
        spare.nodes.clear();
        spare.groups.clear();
        // From left to right by connected parts.
        let (mut group, mut shadow) = (0, 0);
        loop {
            let (groups, shadows) = (group, shadow);
            let starts = [
                forest.groups.get(group).map(|group| group.u[0]),
                order.get(shadow).map(|&n| left(n)),
            ];
            let Some(mut reach) = starts.into_iter().flatten().reduce(f64::min) else { break };
            loop {
                if let Some(next) = forest.groups.get(group).filter(|next| next.u[0] <= reach) {
                    reach = reach.max(next.u[1]);
                    group += 1;
                } else if let Some(&next) = order.get(shadow).filter(|&&n| left(n) <= reach) {
                    reach = reach.max(new[next as usize].u[1]);
                    shadow += 1;
                } else {
                    break;
                }
            }
            if shadows == shadow {
                for group in &forest.groups[groups..group] {
                    spare.nodes.extend_from_slice(&forest.nodes[group.nodes()]);
                    spare.close_group();
                }
            } else {
                let arrived = &mut order[shadows..shadow];
                arrived.sort_unstable();
                let shadows = arrived.iter().map(|&n| &new[n as usize]);
                weave.cluster(*fusion, forest, groups..group, shadows, spare);
            }
        }
        std::mem::swap(&mut forest.nodes, &mut spare.nodes);
        std::mem::swap(&mut forest.groups, &mut spare.groups);
    }

    /// 13: moves everything from one plane to a farther one; returns how many shadows are left.
    pub fn reproject(&mut self, cell: &Cuboid, from: f64, to: f64) -> u64 {
        self.moved(|umbra| reproject(cell, umbra, from, to))
    }

    /// The same where all that is still asked, there and on farther planes, has its projections within
    /// `asked`: what that cannot touch is dropped ([`asked_part`]). No later verdict on it changes,
    /// save where there is less to join.
    pub fn reproject_asked(
        &mut self,
        cell: &Cuboid,
        [from, to]: [f64; 2],
        asked: &Projection,
    ) -> u64 {
        self.moved(|umbra| asked_part(&reproject(cell, umbra, from, to)?, asked))
    }

    fn moved(&mut self, by: impl Fn(&Umbra) -> Option<Umbra>) -> u64 {
        self.spare.clear();
        self.forest.moved(by, &mut self.spare, &mut self.moving);
        std::mem::swap(&mut self.forest, &mut self.spare);
        self.len() as u64
    }

    /// Whether a projection lies in one shadow. `compared` counts the shadows looked at.
    pub fn test(&self, p: &Projection, compared: &mut u64) -> Verdict {
        self.forest.test(p, compared)
    }

    /// The trees, from left to right.
    pub fn roots(&self) -> Vec<Shadow> {
        self.forest.groups.iter().flat_map(|group| self.forest.trees(group.nodes())).collect()
    }

    /// All shadows, parents before their children.
    pub fn nodes(&self) -> impl Iterator<Item = Umbra> + '_ {
        self.forest.nodes.iter().map(|node| self.forest.umbra(node))
    }

    /// Bytes of all of it.
    pub fn bytes(&self) -> u64 {
        let Self { forest, spare, new, order, weave, moving, .. } = self;
        let lists = new.capacity() * size_of::<Umbra>() + order.capacity() * size_of::<u32>();
        (forest.bytes() + spare.bytes() + weave.bytes() + moving.bytes() + lists) as u64
    }
}
