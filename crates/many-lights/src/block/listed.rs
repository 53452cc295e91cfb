//! A few lights out of many, gathered side by side for the points that they are listed for.

use super::{
    BLOCK, Block, CUT, DIRECTIONAL, EVERYWHERE, FADED, Numbers, OMNI, ORIENTED, SPOT, hide, weigh,
    weighted,
};
use crate::{PackedNode, Point, World};
use glam::{DVec3, Vec3};
use multiversion::multiversion;

/// How far listed lights reach.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reached {
    /// Without end.
    Everywhere,
    /// All of it up to a distance whose square is given, and nothing beyond.
    Cut,
    /// (1 - (d / r)⁴)² of it, one over r² being given.
    Faded,
}

/// Lights of a list, by kind. It keeps its memory.
#[derive(Clone, Debug)]
pub(crate) struct Listed {
    kinds: [Kind; 4],
    reached: Reached,
    weights: Numbers,
}

#[derive(Clone, Debug, Default)]
struct Kind {
    blocks: Vec<Block>,
    lights: usize,
}

impl Listed {
    /// No light.
    pub(crate) fn new(reached: Reached) -> Self {
        let kinds = std::array::from_fn(|_| Kind::default());
        Self { kinds, reached, weights: [0.0; BLOCK] }
    }

    /// Forgets all lights.
    pub(crate) fn clear(&mut self) {
        self.kinds.iter_mut().for_each(|kind| kind.lights = 0);
    }

    /// Appends the leaf of a light; `reach_squared` where there is an end.
    #[inline]
    pub(crate) fn push(&mut self, leaf: &PackedNode, reach_squared: f32) {
        let reach = match self.reached {
            Reached::Everywhere => 0.0,
            Reached::Cut => reach_squared,
            Reached::Faded => 1.0 / reach_squared,
        };
        let kind = &mut self.kinds[(leaf.kind as usize).min(DIRECTIONAL)];
        let (block, place) = (kind.lights / BLOCK, kind.lights % BLOCK);
        if block == kind.blocks.len() {
            kind.blocks.push(Block::DARK);
        }
        kind.blocks[block].set(place, leaf, reach);
        kind.lights += 1;
    }

    /// What all of them give at a point, and the shadow rays that this took.
    pub(crate) fn light(
        &mut self,
        point: &Point,
        world: &World,
        clamp_squared: f32,
    ) -> (Vec3, u64) {
        let Self { kinds, reached, weights } = self;
        let mut receiver =
            Receiver { point, world, clamp_squared, weights, sum: DVec3::ZERO, rays: 0 };
        light(kinds, *reached, &mut receiver);
        let sum = (receiver.sum * std::f64::consts::FRAC_1_PI).as_vec3();
        (point.albedo * sum, receiver.rays)
    }
}

impl Kind {
    fn blocks(&self) -> &[Block] {
        &self.blocks[..self.lights.div_ceil(BLOCK)]
    }
}

/// A point, and what it has so far.
struct Receiver<'a> {
    point: &'a Point,
    world: &'a World,
    clamp_squared: f32,
    weights: &'a mut Numbers,
    sum: DVec3,
    rays: u64,
}

#[multiversion(targets(
    "x86_64+avx512f+avx512bw+avx512dq+avx512vl+avx2",
    "x86_64+avx2",
    "x86_64+sse4.1",
))]
fn light(kinds: &[Kind; 4], reached: Reached, receiver: &mut Receiver<'_>) {
    match reached {
        Reached::Everywhere => of_kinds::<EVERYWHERE>(kinds, receiver),
        Reached::Cut => of_kinds::<CUT>(kinds, receiver),
        Reached::Faded => of_kinds::<FADED>(kinds, receiver),
    }
}

#[inline(always)]
fn of_kinds<const REACHED: usize>(kinds: &[Kind; 4], receiver: &mut Receiver<'_>) {
    of_kind::<OMNI, REACHED>(kinds[OMNI].blocks(), receiver);
    of_kind::<ORIENTED, REACHED>(kinds[ORIENTED].blocks(), receiver);
    of_kind::<SPOT, REACHED>(kinds[SPOT].blocks(), receiver);
    of_kind::<DIRECTIONAL, REACHED>(kinds[DIRECTIONAL].blocks(), receiver);
}

#[inline(always)]
fn of_kind<const KIND: usize, const REACHED: usize>(blocks: &[Block], receiver: &mut Receiver<'_>) {
    let Receiver { point, world, clamp_squared, weights, .. } = receiver;
    for block in blocks {
        weigh::<KIND, REACHED>(block, point, *clamp_squared, weights);
        if world.occluders.is_some() {
            receiver.rays += hide(weights, block, point, world);
        }
        for (sum, intensity) in receiver.sum.as_mut().iter_mut().zip(&block.intensity) {
            *sum += f64::from(weighted(&weights[..block.used], &intensity[..block.used]));
        }
    }
}
