//! Everything of a frame before its pixels are lit: what is seen, its cells, and which lights may
//! reach them.

mod brightest;
mod evaluate;

pub use brightest::CellLight;

use crate::{
    Counts, Night, NightError, Town,
    cells::{Directions, Faced, NodeCell, WholeCells},
    coherence::{Keeping, Kept, Key},
    drawer::Drawer,
    heights::Heights,
    lists::List,
};
use dapple_many_lights::{
    cut::{StartList, Starts},
    region::{Direction, Many, RegionTechnique, Steps, ViewCell, make},
};
use dapple_occlusion::camera::{
    self, Cells, Coverage, State, cells::CellLimits, exact_coverage, software, techniques,
    view_cells,
};
use std::{sync::Arc, time::Instant};

/// Cells and their precuts, found frame by frame.
pub struct Front<'g> {
    town: Arc<Town>,
    night: Night,
    drawer: Drawer<'g>,
    state: State,
    drawn: camera::Frame,
    whole: WholeCells,
    many: Many,
    heights: Option<Heights>,
    /// Precuts found in a frame; kept for its memory.
    found: Vec<Vec<u32>>,
    /// Heights of their nodes, where these are asked for.
    below: Vec<Vec<f32>>,
    kept: Kept,
    list: List,
    starts: Starts,
    /// Of the last frame.
    cells: Cells,
    precomputing_ns: u64,
}

/// What was found for a frame, and how long that took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Prepared {
    /// What is seen.
    pub visibility_ns: u64,
    /// Its cells.
    pub cells_ns: u64,
    /// Their precuts and lists.
    pub region_ns: u64,
    /// How much of it there was.
    pub counts: Counts,
}

/// A cell of a frame.
struct Shown {
    /// Whose precuts its objects start at: that of the cell, or one above it.
    node: u32,
    /// Around all below the node: its turn and what its objects face.
    whole: Arc<NodeCell>,
    /// Around what is visible alone, where that is asked for.
    shrunk: Option<ViewCell>,
    /// Directions that its visible objects face.
    directions: Directions,
    /// Whether there are no precuts for it: its objects start at the roots.
    late: bool,
}

impl Shown {
    fn cell(&self) -> &ViewCell {
        self.shrunk.as_ref().unwrap_or(&self.whole.cell)
    }
}

impl<'g> Front<'g> {
    /// Made ready; finds all precuts where they are asked for before the first frame.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn new(town: &Arc<Town>, night: &Night, drawer: Drawer<'g>) -> Result<Self, NightError> {
        night.check()?;
        let lit = Arc::new(town.lit());
        let many = Many::new(|| make(&night.region, false, &lit, &town.lights, &town.occluders))?;
        let keeping = match night.precomputed {
            true => Keeping { validity: None, capacity_bytes: None, ..night.keeping },
            false => night.keeping,
        };
        let heights = match night.region {
            RegionTechnique::FacadeCluster(settings) if night.heights > 0 => {
                Some(Heights::new(town, &settings, night.heights))
            }
            _ => None,
        };
        let mut front = Self {
            state: State::new(&town.tree),
            drawn: camera::Frame::default(),
            whole: WholeCells::default(),
            kept: Kept::new(keeping),
            starts: Starts::roots(&town.lights.roots),
            town: Arc::clone(town),
            night: *night,
            precomputing_ns: 0,
            drawer,
            many,
            heights,
            found: Vec::new(),
            below: Vec::new(),
            list: List::default(),
            cells: Cells::default(),
        };
        front.precompute()?;
        Ok(front)
    }

    /// Forgets every earlier frame, but what was found before the first.
    ///
    /// # Errors
    /// The device's.
    pub fn reset(&mut self) -> Result<(), NightError> {
        self.state.reset(self.drawer.renderer())?;
        if !self.night.precomputed {
            self.kept.reset();
        }
        Ok(())
    }

    /// Finds what frame `index` starts at.
    ///
    /// # Errors
    /// A frame that there is not, or the device's.
    pub fn prepare(&mut self, index: usize) -> Result<Prepared, NightError> {
        let begun = Instant::now();
        self.see(index)?;
        let seen = Instant::now();
        let tau_px = self.night.tau_of(self.town.size(index));
        let coverage = self.state.coverage();
        let cells = divide(&self.town, &self.night, coverage, &self.drawn.drawn, tau_px)?;
        let mut shown = self.shown(&cells);
        let divided = Instant::now();
        self.kept.begin();
        let budget = self.night.budget.map_or(usize::MAX, |most| most as usize);
        let mut counts = Counts {
            drawn: self.drawn.drawn.len() as u64,
            cells: cells.cells.len() as u64,
            evaluations: self.evaluate(&cells, &shown, budget),
            late: self.fall_back(&cells, &mut shown),
            ..Counts::default()
        };
        self.list(&cells, &shown, &mut counts)?;
        self.kept.end();
        self.cells = cells;
        counts.kept = self.kept.len() as u64;
        counts.kept_bytes = self.kept.bytes();
        counts.list_bytes = self.starts.bytes();
        let ns = |from: Instant, to: Instant| (to - from).as_nanos() as u64;
        Ok(Prepared {
            visibility_ns: ns(begun, seen),
            cells_ns: ns(seen, divided),
            region_ns: divided.elapsed().as_nanos() as u64,
            counts,
        })
    }

    /// What the last frame that was prepared starts at.
    pub fn starts(&self) -> &Starts {
        &self.starts
    }

    /// Objects that the last frame drew.
    pub fn drawn(&self) -> &[u32] {
        &self.drawn.drawn
    }

    /// Work of what is seen, last frame.
    pub fn visibility_work(&self) -> camera::Work {
        self.drawn.work
    }

    /// Work of all evaluations so far.
    pub fn steps(&self) -> Steps {
        self.many.steps()
    }

    /// Work of finding heights so far: no part of [`Front::steps`].
    pub fn height_steps(&self) -> Steps {
        self.heights.as_ref().map(Heights::steps).unwrap_or_default()
    }

    /// Precuts that are kept.
    pub fn kept(&self) -> &Kept {
        &self.kept
    }

    /// How long it took to find all precuts before the first frame; 0 where that was not asked for.
    pub fn precomputing_ns(&self) -> u64 {
        self.precomputing_ns
    }

    /// Bytes of what is remembered and kept, and of what finds it.
    pub fn bytes(&self) -> u64 {
        let heights = self.heights.as_ref().map_or(0, Heights::bytes);
        let found = self.kept.bytes() + self.whole.bytes() + self.many.bytes() + heights;
        found + self.state.bytes() + self.starts.bytes() + self.town.bytes()
    }

    fn see(&mut self, index: usize) -> Result<(), NightError> {
        let Self { town, night, drawer, state, drawn, .. } = self;
        let Some(view) = town.views.get(index) else {
            let limit = format!("there are {}", town.views.len());
            return Err(NightError::value(format!("frame {index}"), limit));
        };
        let (settings, objects) = (&night.visibility, &town.objects);
        techniques::frame(settings, objects, &town.tree, view, state, drawer.renderer(), drawn)?;
        if settings.coverage == Coverage::Exact {
            let pixels = software::owners(&drawer.image()?, objects.objects.len());
            exact_coverage(&town.tree, &pixels, state.coverage_mut())?;
        }
        Ok(())
    }

    fn shown(&mut self, cells: &Cells) -> Vec<Shown> {
        let mut shown = Vec::with_capacity(cells.cells.len());
        for (index, cell) in cells.cells.iter().enumerate() {
            let whole = self.whole.of(&self.town, cell.node);
            let objects = cells.objects_of(index);
            let directions = whole.directions_of(objects);
            let shrunk = match self.night.whole_boxes {
                true => None,
                false => Some(whole.shrunk(&self.town.surfaces, objects)),
            };
            shown.push(Shown { node: cell.node, whole, shrunk, directions, late: false });
        }
        shown
    }

    /// Gives every visible object its list: objects of a cell whose surfaces face the same directions
    /// share one. An object that no light could be found for begins at the roots.
    fn list(
        &mut self,
        cells: &Cells,
        shown: &[Shown],
        counts: &mut Counts,
    ) -> Result<(), NightError> {
        let Self { town, starts, kept, list, .. } = self;
        starts.restart(&town.lights.roots, town.objects.objects.len());
        let mut lists: Vec<(Faced, StartList)> = Vec::new();
        for (index, shown) in shown.iter().enumerate().filter(|(_, shown)| !shown.late) {
            lists.clear();
            for object in cells.objects_of(index) {
                let faced = shown.whole.faced(*object);
                if faced.all() == 0 {
                    continue;
                }
                let known = lists.iter().find(|(known, _)| *known == faced);
                let made = match known {
                    Some((_, made)) => *made,
                    None => {
                        let precuts = Direction::ALL.map(|direction| {
                            kept.get(Key { node: shown.node, direction }).unwrap_or_default()
                        });
                        list.make(&town.lights, shown.cell(), faced, precuts);
                        counts.lists += 1;
                        counts.list_nodes += list.nodes.len() as u64;
                        let made = match list.hidden_below.is_empty() {
                            true => starts.add(&list.nodes),
                            false => starts.add_below(&list.nodes, &list.hidden_below)?,
                        };
                        lists.push((faced, made));
                        made
                    }
                };
                starts.set(*object, made)?;
                counts.listed += 1;
            }
        }
        Ok(())
    }

    /// Finds the precuts of every cell that any frame may have.
    fn precompute(&mut self) -> Result<(), NightError> {
        if !self.night.precomputed {
            return Ok(());
        }
        let begun = Instant::now();
        let all: Vec<u32> = (0..self.town.objects.objects.len() as u32).collect();
        let cells = divide(&self.town, &self.night, self.state.coverage(), &all, 0)?;
        let shown = self.shown(&cells);
        self.evaluate(&cells, &shown, usize::MAX);
        self.precomputing_ns = begun.elapsed().as_nanos() as u64;
        Ok(())
    }
}

/// The cells of what is visible.
fn divide(
    town: &Town,
    night: &Night,
    coverage: &[u32],
    visible: &[u32],
    tau_px: u32,
) -> Result<Cells, NightError> {
    let limits = CellLimits { tau_px, most_level: town.most_level(night.split) };
    Ok(view_cells(&town.tree, coverage, town.levels(), visible, limits)?)
}
