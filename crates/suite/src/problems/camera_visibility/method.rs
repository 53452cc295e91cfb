//! How a technique decides what to draw, and what it remembers.

use super::{case::VisibilityCase, drawer::Drawer, settings};
use crate::{SuiteError, knob::Get, problem::Setting};
use dapple_occlusion::camera::{
    Coverage, Frame, Image, Settings, State, Technique, Tree,
    cells::{CellLimits, view_cells},
    exact_coverage,
    hierarchical_depth::{self, cpu},
    masked::{self, Occluders},
    software, techniques,
};
use std::rc::Rc;

/// Share of the image up to which a view cell is not divided: 16,384 pixels of 1200 x 900.
const CELL_SHARE: f64 = 16_384.0 / (1200.0 * 900.0);

/// A technique made ready.
pub enum Method {
    /// One that walks the tree and may ask.
    Asks {
        /// Its knobs.
        settings: Settings,
        /// The hierarchy.
        tree: Rc<Tree>,
        /// What it remembers.
        state: Box<State>,
    },
    /// What the truth says.
    Oracle,
    /// Two passes with a pyramid of depths, on the processor.
    Hierarchical {
        /// The hierarchy.
        tree: Rc<Tree>,
        /// Its knobs.
        settings: hierarchical_depth::Settings,
        /// What it remembers.
        state: Box<cpu::State>,
    },
    /// A buffer of occluders, asked on the processor.
    Masked {
        /// The hierarchy.
        tree: Rc<Tree>,
        /// The buffer.
        culler: Box<masked::Culler>,
    },
}

impl Method {
    /// The technique that a setting asks for.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn of(case: &VisibilityCase<'_>, setting: &Setting) -> Result<Self, SuiteError> {
        let tree = || case.tree(setting.knobs.word("tree").unwrap_or("auto"));
        Ok(match setting.technique.as_str() {
            "oracle" => Self::Oracle,
            "hierarchical-depth" => {
                let tree = tree()?;
                let settings = settings::hierarchical(setting)?;
                let state = Box::new(cpu::State::new(case.objects(), &tree));
                Self::Hierarchical { tree, settings, state }
            }
            "masked" => {
                let settings = settings::masked(setting)?;
                let boxes = case.inner().unwrap_or_default();
                if settings.occluders == Occluders::InnerBoxes && boxes.is_empty() {
                    return Err(SuiteError::Usage(format!(
                        "scene {}: no boxes are known to lie inside of anything, so variant `boxes` \
                         has no occluders; `meshes` has",
                        case.scene()
                    )));
                }
                let culler = Box::new(masked::Culler::new(settings, case.objects(), boxes)?);
                Self::Masked { tree: tree()?, culler }
            }
            name => {
                let technique = Technique::by_name(name)
                    .ok_or_else(|| SuiteError::Internal(format!("no method for {name}")))?;
                let tree = tree()?;
                let settings = settings::asks(setting, technique, case.seed())?;
                Self::Asks { settings, state: Box::new(State::new(&tree)), tree }
            }
        })
    }

    /// Forgets every earlier frame.
    ///
    /// # Errors
    /// The device's.
    pub fn reset(&mut self, drawer: &mut Drawer<'_>) -> Result<(), SuiteError> {
        match self {
            Self::Asks { state, .. } => state.reset(drawer.renderer()?)?,
            Self::Hierarchical { state, .. } => match drawer {
                Drawer::Culler { culler, .. } => culler.reset(),
                _ => state.reset(),
            },
            // The latter remembers nothing.
            Self::Oracle | Self::Masked { .. } => {}
        }
        Ok(())
    }

    /// Draws one frame.
    ///
    /// # Errors
    /// The renderer's.
    pub fn frame(
        &mut self,
        case: &VisibilityCase<'_>,
        index: usize,
        drawer: &mut Drawer<'_>,
        out: &mut Frame,
    ) -> Result<(), SuiteError> {
        let (objects, view) = (case.objects(), &case.views()[index]);
        match self {
            Self::Asks { settings, tree, state } => {
                techniques::frame(settings, objects, tree, view, state, drawer.renderer()?, out)?;
                if settings.coverage == Coverage::Exact {
                    let pixels = software::owners(&drawer.image()?, objects.objects.len());
                    exact_coverage(tree, &pixels, state.coverage_mut())?;
                }
            }
            Self::Oracle => {
                let owners: Vec<u32> =
                    case.truth().frames[index].iter().map(|owned| owned.object).collect();
                techniques::oracle::frame(&owners, objects, view, drawer.renderer()?, out)?;
            }
            Self::Masked { tree, culler } => {
                culler.frame(objects, tree, view, drawer.renderer()?, out)?;
            }
            Self::Hierarchical { tree, settings, state } => {
                if let Drawer::Culler { culler, passes } = drawer {
                    *passes = culler.frame(view)?.passes;
                } else if let Some(renderer) = drawer.showing_depth() {
                    cpu::frame(settings, objects, tree, view, state, renderer, out)?;
                }
            }
        }
        Ok(())
    }

    /// Reads back what a device drew that decides by itself.
    ///
    /// # Errors
    /// The device's.
    pub fn collect(&self, drawer: &Drawer<'_>, out: &mut Frame) -> Result<(), SuiteError> {
        if let Drawer::Culler { culler, .. } = drawer {
            culler.collect(out)?;
        }
        Ok(())
    }

    /// Whether the image must be that of drawing everything.
    pub fn is_exact(&self) -> bool {
        match self {
            Self::Asks { settings, .. } => settings.is_exact(),
            Self::Hierarchical { .. } | Self::Masked { .. } => true,
            // By rays: what no ray meets is left out, though a rasteriser may show it.
            Self::Oracle => false,
        }
    }

    /// Whether the truth itself says what to draw.
    pub fn is_told(&self) -> bool {
        matches!(self, Self::Oracle)
    }

    /// Stored coverage of the leaves of objects that own pixels of the last frame, and those pixels.
    pub fn coverage(&self, case: &VisibilityCase<'_>, image: &Image) -> Option<(u64, u64)> {
        let Self::Asks { settings, tree, state } = self else { return None };
        if !settings.technique.asks() {
            return None;
        }
        let pixels = software::owners(image, case.objects().objects.len());
        let (mut stored, mut owned) = (0, 0);
        for (index, node) in tree.nodes.iter().enumerate() {
            if !node.children.is_empty() {
                continue;
            }
            let own: u64 =
                tree.objects_of(index as u32).iter().map(|o| u64::from(pixels[*o as usize])).sum();
            if own > 0 {
                owned += own;
                stored += u64::from(state.coverage()[index]);
            }
        }
        Some((stored, owned))
    }

    /// View cells of the last frame: what was `drawn`, cut where a node covers more than the
    /// threshold's share of the image.
    ///
    /// # Errors
    /// None for what this technique itself drew.
    pub fn cells(
        &self,
        case: &VisibilityCase<'_>,
        drawn: &[u32],
    ) -> Result<Option<u64>, SuiteError> {
        let Self::Asks { settings, tree, state } = self else { return Ok(None) };
        if !settings.technique.asks() {
            return Ok(None);
        }
        let [width, height] = case.size().map(f64::from);
        let tau_px = (CELL_SHARE * width * height).round() as u32;
        let limits = CellLimits { tau_px, most_level: u32::MAX };
        let cells = view_cells(tree, state.coverage(), &tree.levels(), drawn, limits)?;
        Ok(Some(cells.cells.len() as u64))
    }

    /// Bytes of what is remembered and of the hierarchy.
    pub fn bytes(&self) -> u64 {
        let tree_bytes =
            |tree: &Tree| (size_of_val(&tree.nodes[..]) + size_of_val(&tree.objects[..])) as u64;
        match self {
            Self::Asks { tree, state, .. } => tree_bytes(tree) + state.bytes(),
            // A flag an object and a node.
            Self::Hierarchical { tree, .. } => tree_bytes(tree) + tree.nodes.len() as u64,
            Self::Masked { tree, culler } => tree_bytes(tree) + culler.buffer().bytes() as u64,
            Self::Oracle => 0,
        }
    }
}
