//! What samplers give on the mean, and how far they scatter, by enumeration of all that they may draw.

use super::{
    descend::Draw,
    form::{Kind, pivot},
    lane::unshadowed,
    light_bvh, stochastic,
    walked::{Double, Single, Walked},
};
use crate::{
    Form, Frame, LightTree, LightsError, Point, Technique, World,
    cut::tile::{self, LANES},
};
use glam::DVec3;
use std::sync::Arc;

/// What one frame of a sampler is a draw of, by pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expected {
    /// Mean radiance, linear RGB.
    pub mean: Vec<DVec3>,
    /// Variance of one frame's radiance.
    pub variance: Vec<DVec3>,
}

/// Mean and variance of a sampler at every pixel of a frame, exactly: all lights at all pixels, so for
/// small worlds. In f32 chances and radiance are those of the f32 form.
///
/// # Errors
/// A technique that is no sampler of this module, a tree of other lights, the form on a device, or a
/// frame that there is not.
pub fn expected(
    form: Form,
    technique: &Technique,
    world: &World,
    tree: &Arc<LightTree>,
    frame: usize,
) -> Result<Expected, LightsError> {
    let kind = Kind::of(technique)?;
    let frame = world.frame(frame)?;
    tree.check_number(&world.lights)?;
    let clamp_m = world.clamp_m;
    match form {
        Form::Reference => {
            Ok(image(&Double { tree: Arc::clone(tree), clamp_m }, kind, world, frame))
        }
        Form::Cpu => Ok(image(&Single::new(tree.pack(), clamp_m), kind, world, frame)),
        Form::Gpu => Err(LightsError::value("expected", "is not computed on a device")),
    }
}

fn image(walked: &impl Walked, kind: Kind, world: &World, frame: &Frame) -> Expected {
    let mut expected = Expected {
        mean: vec![DVec3::ZERO; frame.points.len()],
        variance: vec![DVec3::ZERO; frame.points.len()],
    };
    for (column, row) in tile::all(frame.width, frame.height) {
        for pixel in tile::pixels(frame.width, frame.height, column, row) {
            let point = &frame.points[pixel];
            if !point.is_there() {
                continue;
            }
            let mut slots = Vec::new();
            let (mean, variance) = match kind {
                Kind::LightBvh(settings) => {
                    let one = [light_bvh::chances(walked, point)];
                    let (mean, variance) = moments(walked, world, point, &one);
                    (mean, variance / f64::from(settings.samples))
                }
                Kind::Stochastic(settings) if settings.real_time => {
                    // The mean does not depend on the cut, so variances of the cuts average.
                    let (mut mean, mut variance) = (DVec3::ZERO, DVec3::ZERO);
                    for start in 0..LANES as u32 {
                        let Some(at) = pivot(frame, column, row, start) else { continue };
                        let at = &frame.points[at];
                        stochastic::cut(walked, &settings, at, &mut slots, &mut 0);
                        let below = stochastic::chances(walked, &slots, point);
                        let found = moments(walked, world, point, &below);
                        mean += found.0 / LANES as f64;
                        variance += found.1 / LANES as f64;
                    }
                    (mean, variance)
                }
                Kind::Stochastic(settings) => {
                    stochastic::cut(walked, &settings, point, &mut slots, &mut 0);
                    let below = stochastic::chances(walked, &slots, point);
                    moments(walked, world, point, &below)
                }
            };
            (expected.mean[pixel], expected.variance[pixel]) = (mean, variance);
        }
    }
    expected
}

/// Mean and variance of a sum of independent draws, one of each group.
fn moments(
    walked: &impl Walked,
    world: &World,
    point: &Point,
    groups: &[Vec<Draw>],
) -> (DVec3, DVec3) {
    let (mut mean, mut variance) = (DVec3::ZERO, DVec3::ZERO);
    for group in groups {
        let (mut sum, mut squares) = (DVec3::ZERO, DVec3::ZERO);
        for draw in group {
            let radiance = walked.radiance(draw.leaf, point);
            let radiance = unshadowed(world, point, walked, draw.leaf, radiance);
            sum += radiance;
            squares += radiance * radiance / draw.probability;
        }
        mean += sum;
        // Rounding must not make it negative.
        variance += (squares - sum * sum).max(DVec3::ZERO);
    }
    (mean, variance)
}
