//! Cuts in f64, scalar: what the other forms are held against.

use super::{
    Starting, Starts,
    given::{Given, Method},
    lightcuts::{self, Member, Open},
    rule::{Receiver, Rule},
    tile,
    walk::walk,
};
use crate::{
    BoundForm, Light, LightTree, Lightcuts, Lighting, LightsError, Node, Point, Shaded, Times,
    Work,
    bound::{self, Region},
};
use glam::DVec3;
use std::sync::Arc;

/// One pixel's cut, summed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lit {
    pub(super) radiance: DVec3,
    pub(super) work: Work,
}

/// The reference form of all techniques that make cuts.
pub struct Reference {
    given: Given,
    open: Open,
    /// Nodes of a tile's cut, and the heights that what they were reached from is hidden below.
    nodes: Vec<(u32, f32)>,
    shaded: Shaded,
}

impl Reference {
    /// Made ready.
    pub fn new(given: Given) -> Self {
        let open = given.open();
        Self { open, nodes: Vec::new(), shaded: Shaded::default(), given }
    }

    fn receiver<'a>(&self, point: &'a Point, form: BoundForm) -> Receiver<'a> {
        Receiver { point, form, clamp_m: self.given.world.clamp_m }
    }

    /// What a pixel gets through a node of its cut.
    fn seen(&self, point: &Point, node: &Node, estimate: DVec3, work: &mut Work) -> DVec3 {
        let world = &self.given.world;
        if world.occluders.is_none() || estimate == DVec3::ZERO {
            return estimate;
        }
        work.rays += 1;
        if self.given.sees(point, node.light) { estimate } else { DVec3::ZERO }
    }

    /// R3, R4.
    fn by_rule(&self, rule: Rule, form: BoundForm, point: &Point) -> Lit {
        let receiver = self.receiver(point, form);
        let mut lit = Lit::default();
        walk(&self.given.tree, self.given.entries_of(point), |_, node| {
            let look = rule.look(node, &receiver);
            lit.work.look(node.is_leaf(), look.taken || matches!(rule, Rule::Relative(_)));
            if look.taken {
                lit.work.cut += 1;
                lit.radiance += self.seen(point, node, look.estimate, &mut lit.work);
            }
            look.taken
        });
        lit
    }

    /// R1, R2.
    fn by_worst(&self, settings: &Lightcuts, point: &Point, open: &mut Open) -> Lit {
        let Given { world, tree, .. } = &self.given;
        let mut work = Work::default();
        let evaluate = |index: u32| {
            let node = &tree.nodes[index as usize];
            work.look(node.is_leaf(), true);
            let estimate = bound::estimate(node, point, world.clamp_m);
            let estimate = self.seen(point, node, estimate, &mut work);
            let bound = if node.is_leaf() {
                0.0
            } else {
                bound::point(settings.bound, node, point, world.clamp_m)
            };
            Member { node: index, estimate, bound }
        };
        let size = |node: u32| tree.nodes[node as usize].size;
        let starts = self.given.entries_of(point);
        let found = lightcuts::cut(settings, starts, size, evaluate, |_| (), open);
        work.cut = found.nodes as u64;
        work.ended = u64::from(found.ended);
        Lit { radiance: found.radiance, work }
    }

    /// R4 over the pixels of a tile that start alike; each of them gets the nodes it took.
    fn by_tile(&mut self, threshold: f64, form: BoundForm, points: &[(usize, Point)]) -> Vec<Lit> {
        let Given { world, tree, .. } = &self.given;
        let Some((_, first)) = points.first() else { return Vec::new() };
        let Some(region) = Region::of(points.iter().map(|(_, point)| point)) else {
            return Vec::new();
        };
        let mut walked = Work::default();
        self.nodes.clear();
        let highest = points.iter().map(|(_, point)| point.position.y).fold(f32::MIN, f32::max);
        let entries = self.given.entries(self.given.starts.range(first.object));
        for (start, hidden_below) in entries.filter(|&(_, below)| highest > below) {
            walk(tree, [start], |index, node| {
                let bounded = || bound::region(form, node, &region, world.clamp_m);
                let is_split = !node.is_leaf() && bounded() > threshold;
                let taken = !is_split;
                walked.look(node.is_leaf(), false);
                if taken {
                    self.nodes.push((index, hidden_below));
                }
                taken
            });
        }
        let mut lit = Vec::with_capacity(points.len());
        for (lane, (_, point)) in points.iter().enumerate() {
            let mut one =
                Lit { work: Work { visits: walked.visits, ..Work::default() }, ..Lit::default() };
            // One bound serves all pixels.
            one.work.bounds = if lane == 0 { walked.bounds } else { 0 };
            for &(index, hidden_below) in &self.nodes {
                let node = &tree.nodes[index as usize];
                let is_hidden = point.position.y <= hidden_below;
                let whole = bound::estimate(node, point, world.clamp_m);
                let estimate = if is_hidden { DVec3::ZERO } else { whole };
                one.radiance += self.seen(point, node, estimate, &mut one.work);
                one.work.evaluate(node.is_leaf());
            }
            one.work.cut = self.nodes.len() as u64;
            lit.push(one);
        }
        lit
    }

    /// The pixels of a tile, each with what lights it.
    fn tile(&mut self, points: &[(usize, Point)]) -> Vec<Lit> {
        match self.given.method {
            Method::Rule(rule, form) => {
                points.iter().map(|(_, point)| self.by_rule(rule, form, point)).collect()
            }
            Method::Worst(settings) => {
                let mut open = std::mem::replace(&mut self.open, Open::new(settings.selection, 0));
                let one = |(_, point): &(usize, Point)| self.by_worst(&settings, point, &mut open);
                let lit = points.iter().map(one).collect();
                self.open = open;
                lit
            }
            Method::Tile { threshold, form } => {
                // Pixels of a tile that start alike share a cut.
                let mut lit = vec![Lit::default(); points.len()];
                let range = |point: &Point| self.given.starts.range(point.object);
                let mut ranges: Vec<_> = points.iter().map(|(_, point)| range(point)).collect();
                let of_lane = ranges.clone();
                ranges.sort_unstable();
                ranges.dedup();
                for range in ranges {
                    let lanes: Vec<_> =
                        (0..points.len()).filter(|&l| of_lane[l] == range).collect();
                    let alike: Vec<_> = lanes.iter().map(|&lane| points[lane]).collect();
                    for (&lane, one) in lanes.iter().zip(self.by_tile(threshold, form, &alike)) {
                        lit[lane] = one;
                    }
                }
                lit
            }
        }
    }
}

impl Work {
    /// A node was looked at, with a bound unless it is a light; and maybe evaluated.
    pub(super) fn look(&mut self, leaf: bool, evaluated: bool) {
        self.visits += 1;
        self.bounds += u64::from(!leaf);
        if evaluated {
            self.evaluate(leaf);
        }
    }

    /// A node was evaluated.
    pub(super) fn evaluate(&mut self, leaf: bool) {
        self.lights += u64::from(leaf);
        self.clusters += u64::from(!leaf);
    }
}

impl Lighting for Reference {
    fn reset(&mut self, _seed: u32) -> Result<(), LightsError> {
        Ok(())
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        let world = Arc::clone(&self.given.world);
        let frame = world.frame(index)?;
        let mut shaded = std::mem::take(&mut self.shaded);
        shaded.clear(frame.points.len(), count);
        for (column, row) in tile::all(frame.width, frame.height) {
            let pixels = tile::pixels(frame.width, frame.height, column, row);
            let points: Vec<_> = pixels
                .map(|pixel| (pixel, frame.points[pixel]))
                .filter(|(_, point)| point.is_there())
                .collect();
            for ((pixel, _), lit) in points.iter().zip(self.tile(&points)) {
                shaded.radiance[*pixel] = lit.radiance.as_vec3();
                if count {
                    shaded.visits[*pixel] = lit.work.visits as u32;
                    let most_cut = lit.work.cut;
                    shaded.work += Work { pixels: 1, most_cut, ..lit.work };
                }
            }
        }
        if count {
            shaded.work.lane_visits = tile::lane_visits(frame.width, frame.height, &shaded.visits);
        }
        self.shaded = shaded;
        Ok(Times::new())
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        shaded.copy_from(&self.shaded);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let nodes = size_of_val(&*self.given.tree.nodes) as u64;
        nodes + self.given.starts.bytes() + self.open.bytes()
    }
}

impl Starting for Reference {
    fn start(&mut self, starts: &Starts) -> Result<u64, LightsError> {
        self.given.set_starts(starts)?;
        Ok(0)
    }

    fn replace_moving(&mut self, lights: &[Light], tree: &LightTree) -> Result<u64, LightsError> {
        self.given.set_moving(lights, tree)?;
        Arc::make_mut(&mut self.given.tree).replace_after(self.given.moving.fixed, tree);
        Ok(0)
    }

    fn starts(&self) -> Result<Starts, LightsError> {
        Ok(self.given.starts.clone())
    }
}
