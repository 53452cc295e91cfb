//! How much light a face may get at most, and which level of detail that is worth.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 6.1 (future work:
//! detail by the upper bound of what shines on a view cell).
//! Deviations: the thesis names no measure and no rule. Here the bound is the sum of the bounds of a
//! precut's clusters over the face, refined until none is above a threshold; and a level costs at most
//! a share of the light, which doubles from level to level.
//!
//! A precut is known only after the frame's visibility: what is chosen from it holds for the next
//! frame. A light that is switched on shows a coarse level for one frame.

use super::potential::{potential, white};
use crate::{LightTree, LightsError, bound::Region, cut::walk};
use std::f64::consts::PI;

/// The most that all lights of a precut together can give to a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Brightest {
    /// Radiance of a white surface, linear, largest channel.
    pub radiance: f64,
    /// Clusters that were bounded.
    pub bounds: u64,
}

impl Brightest {
    /// The irradiance, largest channel: a white surface sends it out evenly.
    pub fn irradiance(&self) -> f64 {
        PI * self.radiance
    }
}

/// The most that any point of `region` may get from what is below `nodes` (a precut, or a union of
/// some), whatever lies between them: clusters are divided while they may give more than `threshold`,
/// the radiance of a white surface, at least 0. Lights that a precut has left out as too weak are not
/// part of it.
pub fn brightest(
    tree: &LightTree,
    nodes: &[u32],
    region: &Region,
    clamp_m: f64,
    threshold: f64,
) -> Brightest {
    let white = white(region);
    let mut found = Brightest::default();
    walk(tree, nodes, |_, node| {
        let most = potential(node, &white, clamp_m);
        found.bounds += 1;
        let is_whole = node.is_leaf() || most <= threshold;
        if is_whole {
            found.radiance += most;
        }
        is_whole
    });
    found
}

/// Levels of detail, 0 the finest: what level `l` gets wrong is at most 2^l times what level 0 does, as
/// a share of the light. Where there is half the light, the next level is as good.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// The least radiance of a white surface that level 0 is for.
    finest_from: f64,
    /// The coarsest.
    coarsest: u32,
}

impl Levels {
    /// Level 0 from a radiance (of a white surface, linear) on; `coarsest` is the number of the last.
    ///
    /// # Errors
    /// [`LightsError::Value`]: a radiance that is not above 0, or not finite.
    pub fn new(finest_from: f64, coarsest: u32) -> Result<Self, LightsError> {
        if !(finest_from > 0.0 && finest_from.is_finite()) {
            let limit = format!("{finest_from} is not a number above 0");
            return Err(LightsError::value("radiance of the finest level", limit));
        }
        Ok(Self { finest_from, coarsest })
    }

    /// The coarsest level that is as good at this much light as level 0 is where it begins.
    pub fn level(&self, radiance: f64) -> u32 {
        // Not a number is not known to be dark.
        if radiance.is_nan() || radiance >= self.finest_from {
            return 0;
        }
        // Without any light the share is endless, and so is the level.
        let levels = (self.finest_from / radiance.max(0.0)).log2().floor();
        levels.min(f64::from(self.coarsest)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_worth_half_the_light_of_the_one_before() {
        let levels = Levels::new(0.5, 4).unwrap();
        let found = [9.0, 0.5, 0.49, 0.26, 0.25, 0.2, 0.125, 0.03125, 1e-9, 0.0, -1.0]
            .map(|radiance| levels.level(radiance));
        assert_eq!(found, [0, 0, 0, 0, 1, 1, 2, 4, 4, 4, 4]);
        assert_eq!([f64::INFINITY, f64::NAN].map(|radiance| levels.level(radiance)), [0, 0]);
        // What a level gets wrong is never more than level 0 may.
        for step in 1..200 {
            let radiance = f64::from(step) / 256.0;
            let level = levels.level(radiance);
            let cost = radiance * f64::from(1 << level);
            assert!(cost <= 0.5 || level == 0, "{radiance}: {level}");
            assert!(level == 4 || 2.0 * cost > 0.5, "{radiance}: {level} is too fine");
        }
    }

    #[test]
    fn levels_that_mean_nothing_are_refused() {
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = Levels::new(wrong, 3).unwrap_err().to_string();
            assert!(error.starts_with("radiance of the finest level:"), "{error}");
        }
        assert_eq!(Levels::new(1.0, 0).unwrap().level(0.0), 0);
    }
}
