//! What techniques that make cuts are made ready from, whatever their form.

use super::{lightcuts::Open, moving::Moving, rule::Rule, starts::Starts};
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
    /// What comes after the world's lights and their tree.
    pub(crate) moving: Moving,
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
        Self::of(method, world, tree)
    }

    /// The same of a method.
    ///
    /// # Errors
    /// [`LightsError::Value`]: a tree of other lights.
    pub fn of(
        method: Method,
        world: &Arc<World>,
        tree: &Arc<LightTree>,
    ) -> Result<Self, LightsError> {
        tree.check_number(&world.lights)?;
        let (world, tree) = (Arc::clone(world), Arc::clone(tree));
        let (starts, moving) = (Starts::roots(&tree.roots), Moving::none(&tree));
        Ok(Self { starts, world, tree, method, moving })
    }

    /// Room for the clusters of a cut of the worst node first: no cut can have more.
    pub fn open(&self) -> Open {
        let Method::Worst(settings) = self.method else {
            return Open::new(Selection::Scan, 0);
        };
        Open::new(settings.selection, self.most_open(&settings))
    }

    /// Most clusters of a cut of the worst node first: starts are members even beyond its most, and no
    /// cut has more nodes than the tree.
    pub(crate) fn most_open(&self, settings: &Lightcuts) -> usize {
        let starts = self.starts.most() + self.moving.roots.len();
        (settings.most as usize).max(starts).min(self.moving.fixed.nodes + self.moving.nodes)
    }

    /// Walks begin there from here on.
    pub(crate) fn set_starts(&mut self, starts: &Starts) -> Result<(), LightsError> {
        starts.check(self.moving.fixed.nodes)?;
        self.starts.copy_from(starts);
        Ok(())
    }

    /// Pixels of the largest frame.
    pub fn pixels(&self) -> usize {
        self.world.frames.iter().map(|frame| frame.points.len()).max().unwrap_or(0)
    }
}
