//! The rules that look at one node alone.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 3.2 (the relative rule
//! that was rejected, the absolute one that was kept).
//! Deviations: radiance is compared linear and by its largest channel; the thesis does not say which.

use crate::{Absolute, BoundForm, Node, Point, Relative, Technique, bound};
use glam::DVec3;

/// Whether a node is split, by its own bound and estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// R3: while the bound exceeds the estimate by more than this share of it.
    Relative(f64),
    /// R4: while the bound exceeds this radiance.
    Absolute(f64),
}

/// What a point makes of the nodes that it looks at.
#[derive(Clone, Copy, Debug)]
pub struct Receiver<'a> {
    /// Who is lit.
    pub point: &'a Point,
    /// How nodes are bounded.
    pub form: BoundForm,
    /// As [`crate::World::clamp_m`].
    pub clamp_m: f64,
}

/// What a rule found at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Whether the node stands for its lights.
    pub taken: bool,
    /// The node's estimate, exact for a leaf; 0 where the rule did not need it and the node is split.
    pub estimate: DVec3,
    /// Bound of what its lights can give, largest channel; 0 for a leaf, which has no error.
    pub bound: f64,
}

impl Rule {
    /// The rule of a technique that has one, and the form of its bounds.
    pub fn of(technique: &Technique) -> Option<(Self, BoundForm)> {
        match *technique {
            Technique::Relative(Relative { epsilon, bound }) => {
                Some((Self::Relative(epsilon), bound))
            }
            Technique::Absolute(Absolute { threshold, bound, .. }) => {
                Some((Self::Absolute(threshold), bound))
            }
            _ => None,
        }
    }

    /// The largest bound that a node with an estimate (its largest channel) may have and stay whole.
    pub fn limit(self, estimate: f64) -> f64 {
        match self {
            Self::Relative(epsilon) => estimate + epsilon * estimate,
            Self::Absolute(threshold) => threshold,
        }
    }

    /// Looks at a node in f64.
    pub fn look(self, node: &Node, receiver: &Receiver<'_>) -> Look {
        let Receiver { point, form, clamp_m } = *receiver;
        let estimate = || bound::estimate(node, point, clamp_m);
        if node.is_leaf() {
            return Look { taken: true, estimate: estimate(), bound: 0.0 };
        }
        let bound = bound::point(form, node, point, clamp_m);
        match self {
            Self::Absolute(threshold) if bound > threshold => {
                Look { taken: false, estimate: DVec3::ZERO, bound }
            }
            Self::Absolute(_) => Look { taken: true, estimate: estimate(), bound },
            Self::Relative(_) => {
                let estimate = estimate();
                let is_split = bound > self.limit(estimate.max_element());
                Look { taken: !is_split, estimate, bound }
            }
        }
    }
}
