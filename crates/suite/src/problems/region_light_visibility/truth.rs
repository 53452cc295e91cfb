//! What some faces see of some lights, by rays.

use super::faces::Question;
use crate::{night::Night, truth_cache::TruthCache};
use dapple_many_lights::{
    BoundForm, bound,
    region::{
        OccluderMode,
        truth::{Obstacles, Sight, seen, seen_strongly},
    },
    sample::hash,
};
use glam::DVec3;

/// Changes with whatever changes the truth's values.
const TRUTH_VERSION: u32 = 2;

/// What a light is to a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sighted {
    /// No ray arrives.
    Hidden,
    /// Rays arrive, none of them as strong as the threshold: it may be kept or not.
    Weak,
    /// A ray arrives that matters: it must be kept.
    Strong,
}

/// What one face sees of its lights.
#[derive(Clone, Debug)]
pub struct FaceTruth {
    /// Index into the frame's questions.
    pub question: usize,
    /// Lights and what they are to it, in increasing order.
    pub lights: Vec<(u32, Sighted)>,
}

/// How much of the truth is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Sampling {
    /// Most faces of a frame.
    pub faces: usize,
    /// Most lights of a face.
    pub lights: usize,
    /// Points of a face that are tried for a light beside those at silhouettes.
    pub points: u32,
    /// Radiance of a white surface below which a light does not matter.
    pub threshold: f64,
    /// Another one chooses otherwise.
    pub seed: u64,
}

/// The truth of some of a frame's faces, computed or read.
pub fn of_frame(
    night: &Night,
    frame: usize,
    questions: &[Question],
    sampling: &Sampling,
) -> Vec<FaceTruth> {
    let seed = sampling.seed as u32 ^ hash((sampling.seed >> 32) as u32 ^ hash(frame as u32));
    let faces = least(0..questions.len() as u32, sampling.faces, seed);
    let chosen: Vec<(usize, Vec<u32>)> = faces
        .into_iter()
        .map(|face| {
            let lights = candidates(night, &questions[face as usize], sampling.threshold);
            (face as usize, least(lights.into_iter(), sampling.lights, seed ^ hash(face)))
        })
        .collect();
    let nodes: Vec<u32> = questions.iter().map(|q| 4 * q.node + q.direction as u32).collect();
    let key = format!(
        "region-light-visibility v{TRUTH_VERSION} {} frame {frame} {nodes:?} {sampling:?}",
        night.key
    );
    let compute = || {
        let face = |(question, lights): &(usize, Vec<u32>)| {
            look(night, &questions[*question], lights, sampling, seed)
        };
        chosen.iter().flat_map(face).collect()
    };
    let mut words: Vec<u32> = TruthCache::from_environment().words(&key, compute);
    if words.len() != chosen.iter().map(|(_, lights)| lights.len()).sum::<usize>() {
        // Damaged: not used.
        words = compute();
    }
    let mut words = words.into_iter().map(|word| match word {
        0 => Sighted::Hidden,
        1 => Sighted::Weak,
        _ => Sighted::Strong,
    });
    let face = |(question, lights): (usize, Vec<u32>)| FaceTruth {
        question,
        lights: lights.into_iter().zip(words.by_ref()).collect(),
    };
    chosen.into_iter().map(face).collect()
}

/// Lights in front of a face that could matter if nothing stood between.
fn candidates(night: &Night, question: &Question, threshold: f64) -> Vec<u32> {
    let (cell, direction) = question.asked();
    let Some(face) = cell.face(direction) else { return Vec::new() };
    let town = &night.town;
    let rear = face.cuboid(direction).w[0];
    let white = bound::Region { albedo: DVec3::ONE, ..face.region };
    let clamp_m = town.world(false).clamp_m;
    let could = |leaf: &u32| {
        let node = &town.lights.nodes[*leaf as usize];
        let at = cell.turn.to(node.position);
        let most = bound::region(BoundForm::Cheap, node, &white, clamp_m);
        direction.cuboid(at, at).w[0] > rear && most > 0.0 && most >= threshold
    };
    let lights = 0..town.lights.leaves.len() as u32;
    lights.filter(|light| could(&town.lights.leaves[*light as usize])).collect()
}

fn look(
    night: &Night,
    question: &Question,
    lights: &[u32],
    sampling: &Sampling,
    seed: u32,
) -> Vec<u32> {
    let (cell, direction) = question.asked();
    let world = night.town.world(true);
    let solids = night.town.occluders.turned(cell.turn, OccluderMode::Leaf);
    let sight = Sight::new(world, cell, direction, &solids.solids, Obstacles::Triangles(world));
    let Some(sight) = sight else { return vec![0; lights.len()] };
    let any = seen(&sight, lights, sampling.points, seed).sightings;
    let strong = seen_strongly(&sight, lights, sampling.threshold, sampling.points, seed).sightings;
    let word = |(any, strong): (&Option<_>, &Option<_>)| {
        u32::from(any.is_some()) + u32::from(strong.is_some())
    };
    any.iter().zip(&strong).map(word).collect()
}

/// Those of the least hashes, in increasing order.
fn least(all: impl Iterator<Item = u32>, most: usize, seed: u32) -> Vec<u32> {
    let mut hashed: Vec<(u32, u32)> = all.map(|one| (hash(one ^ seed), one)).collect();
    hashed.sort_unstable();
    hashed.truncate(most);
    let mut chosen: Vec<u32> = hashed.into_iter().map(|(_, one)| one).collect();
    chosen.sort_unstable();
    chosen
}
