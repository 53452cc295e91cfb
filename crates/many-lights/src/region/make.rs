//! Techniques of from-region visibility made ready.

use super::{
    Direction, FacadeCluster, Occluders, Precuts, RegionTechnique, Steps, ViewCell,
    evaluate::Evaluator, extended_projection::ExtendedProjection, reference::Reference,
    sampled::Rays,
};
use crate::{LightTree, LightsError, World};
use std::sync::Arc;

/// All lights, from everywhere.
struct Everything {
    tree: Arc<LightTree>,
    steps: Steps,
}

impl Precuts for Everything {
    fn precut(&mut self, cell: &ViewCell, direction: Direction, nodes: &mut Vec<u32>) {
        nodes.clear();
        if cell.face(direction).is_some() {
            nodes.extend_from_slice(&self.tree.roots);
            self.steps.evaluations += 1;
            self.steps.output += nodes.len() as u64;
        }
    }

    fn steps(&self) -> &Steps {
        &self.steps
    }

    fn bytes(&self) -> u64 {
        0
    }
}

/// A technique made ready for the lights of a world, clustered by `tree`, behind `occluders`;
/// `reference` asks for the clear and slow form where there are two.
///
/// # Errors
/// Settings that [`RegionTechnique::check`] refuses, a tree of another number of lights than the
/// world's.
pub fn make(
    technique: &RegionTechnique,
    reference: bool,
    world: &Arc<World>,
    tree: &Arc<LightTree>,
    occluders: &Arc<Occluders>,
) -> Result<Box<dyn Precuts>, LightsError> {
    technique.check()?;
    tree.check_number(&world.lights)?;
    let (tree, occluders) = (tree.clone(), occluders.clone());
    Ok(match *technique {
        RegionTechnique::Everything => Box::new(Everything { tree, steps: Steps::default() }),
        RegionTechnique::FacadeCluster(settings) => {
            facade_cluster(reference, tree, occluders, world.clamp_m, settings)
        }
        RegionTechnique::ExtendedProjection { texels } => {
            Box::new(ExtendedProjection::new(tree, occluders, world.clamp_m, texels)?)
        }
        RegionTechnique::Sampled(settings) => {
            Box::new(Rays::new(tree, Arc::clone(world), settings))
        }
    })
}

fn facade_cluster(
    reference: bool,
    tree: Arc<LightTree>,
    occluders: Arc<Occluders>,
    clamp_m: f64,
    settings: FacadeCluster,
) -> Box<dyn Precuts> {
    if reference {
        Box::new(Reference::new(tree, occluders, clamp_m, settings))
    } else {
        Box::new(Evaluator::new(tree, occluders, clamp_m, settings))
    }
}
