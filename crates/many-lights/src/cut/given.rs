//! What techniques that make cuts are made ready from, whatever their form.

use super::{lightcuts::Open, rule::Rule, starts::Starts};
use crate::{BoundForm, LightTree, Lightcuts, LightsError, Per, Selection, Technique, World};
use std::sync::Arc;

/// How a technique cuts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Every pixel by a rule that looks at one node.
    Rule(Rule, BoundForm),
    /// R4 once for the pixels of a tile.
    Tile {
        /// The largest bound over the tile that a node may have and stay whole.
        threshold: f64,
        /// How nodes are bounded.
        form: BoundForm,
    },
    /// The worst node first.
    Worst(Lightcuts),
}

impl Method {
    /// How a technique cuts, if it does.
    pub fn of(technique: &Technique) -> Option<Self> {
        match *technique {
            Technique::Lightcuts(settings) => Some(Self::Worst(settings)),
            Technique::Absolute(settings) if settings.per == Per::Tile => {
                Some(Self::Tile { threshold: settings.threshold, form: settings.bound })
            }
            _ => Rule::of(technique).map(|(rule, form)| Self::Rule(rule, form)),
        }
    }
}

/// What a technique is made ready from.
#[derive(Clone)]
pub struct Given {
    /// Lights and frames.
    pub world: Arc<World>,
    /// Of the world's lights.
    pub tree: Arc<LightTree>,
    /// Where walks begin.
    pub starts: Starts,
    /// How cuts are made.
    pub method: Method,
}

impl Given {
    /// With the tree's roots as starts.
    ///
    /// # Errors
    /// [`LightsError::Value`]: a technique that makes no cuts, or a tree of other lights.
    pub fn new(
        technique: &Technique,
        world: &Arc<World>,
        tree: &Arc<LightTree>,
    ) -> Result<Self, LightsError> {
        let Some(method) = Method::of(technique) else {
            return Err(LightsError::value(format!("{technique:?}"), "makes no cuts"));
        };
        tree.check_number(&world.lights)?;
        let (world, tree) = (Arc::clone(world), Arc::clone(tree));
        Ok(Self { starts: Starts::roots(&tree.roots), world, tree, method })
    }

    /// Room for the clusters of a cut of the worst node first: no cut can have more.
    pub fn open(&self) -> Open {
        let Method::Worst(settings) = self.method else {
            return Open::new(Selection::Scan, 0);
        };
        let most = (settings.most as usize).max(self.starts.most());
        Open::new(settings.selection, most.min(self.tree.nodes.len()))
    }

    /// Pixels of the largest frame.
    pub fn pixels(&self) -> usize {
        self.world.frames.iter().map(|frame| frame.points.len()).max().unwrap_or(0)
    }
}
