//! What a technique that asks is told: which it is, and its knobs.

use crate::OcclusionError;

/// How what to draw is decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Technique {
    /// Everything, in the order of the objects.
    None,
    /// What the frustum holds, front to back.
    Frustum,
    /// Every node is asked, and waited for.
    StopAndWait,
    /// Coherent hierarchical culling.
    Chc,
    /// Its revision, with queues, groups and assumed visibility.
    ChcPlusPlus,
}

/// When an answer counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Results {
    /// In the frame that asked: what an answer would show is drawn in that frame.
    #[default]
    SameFrame,
    /// In the next frame. Nothing waits within a frame, and what comes into sight is missing for a
    /// frame: approximate.
    NextFrame,
}

/// Where the pixels that a node covers come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Coverage {
    /// The latest answer about the node, however old.
    #[default]
    Stale,
    /// The same for what was asked; an inner node in sight has the sum of its children.
    Summed,
    /// The caller counts ids ([`exact_coverage`](super::exact_coverage)); answers are not stored.
    Exact,
}

/// How closely the boxes of a query of an inner node follow what is below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TightBounds {
    /// Levels below the node that are looked at; 0 asks the node's own box.
    pub depth: u32,
    /// Most surface of the boxes together, in surfaces of the node's own box.
    pub area: f32,
}

/// A technique and its knobs. Those that a technique does not know of change nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// How what to draw is decided.
    pub technique: Technique,
    /// Queries of a batch, at most: [`BATCH`](Self::BATCH). CHC++.
    pub batch: u32,
    /// Frames for which a leaf that an answer showed is drawn without being asked:
    /// [`ASSUMED_VISIBLE`](Self::ASSUMED_VISIBLE). CHC++.
    pub assumed_visible: u32,
    /// The first of these spans is drawn at random between none and all of them, so that leaves
    /// that came into sight together are not asked together. CHC++.
    pub jitter: bool,
    /// Leaves in sight are asked while there is nothing else to do, and nothing waits for them.
    /// Otherwise they are asked with the others, and the frame waits. CHC++.
    pub visible_queue: bool,
    /// Nodes that are likely to stay hidden are asked together. CHC++.
    pub multiqueries: bool,
    /// How closely boxes follow what is below. CHC++.
    pub tight_bounds: TightBounds,
    /// Samples that a hidden node may show, at most: [`THRESHOLD_PX`](Self::THRESHOLD_PX). More
    /// than 0 is approximate. All that ask.
    pub threshold_px: u32,
    /// When an answer counts. CHC and CHC++.
    pub results: Results,
    /// Where the pixels that a node covers come from. All that ask.
    pub coverage: Coverage,
    /// Seed of the jitter.
    pub seed: u64,
}

impl Technique {
    /// All, simplest first.
    pub const ALL: [Self; 5] =
        [Self::None, Self::Frustum, Self::StopAndWait, Self::Chc, Self::ChcPlusPlus];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Frustum => "frustum",
            Self::StopAndWait => "stop-and-wait",
            Self::Chc => "chc",
            Self::ChcPlusPlus => "chcpp",
        }
    }

    /// Whether it asks the renderer what would show.
    pub fn asks(self) -> bool {
        match self {
            Self::None | Self::Frustum => false,
            Self::StopAndWait | Self::Chc | Self::ChcPlusPlus => true,
        }
    }

    /// The technique of that name.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.name() == name)
    }
}

impl TightBounds {
    /// A query of a node asks its own box.
    pub const OFF: Self = Self { depth: 0, area: 1.0 };
}

impl Default for TightBounds {
    /// As CHC++ was published.
    fn default() -> Self {
        Self { depth: 3, area: 1.4 }
    }
}

impl Settings {
    /// Allowed queries of a batch.
    pub const BATCH: std::ops::RangeInclusive<u32> = 1..=200;
    /// Allowed frames of assumed visibility.
    pub const ASSUMED_VISIBLE: std::ops::RangeInclusive<u32> = 0..=60;
    /// Allowed samples of a hidden node.
    pub const THRESHOLD_PX: std::ops::RangeInclusive<u32> = 0..=1000;
    /// Allowed levels of tight bounds.
    pub const TIGHT_DEPTH: std::ops::RangeInclusive<u32> = 0..=4;
    /// Allowed surface of tight bounds, in surfaces of the node's own box.
    pub const TIGHT_AREA: std::ops::RangeInclusive<f32> = 1.0..=10.0;

    /// The defaults for `technique`.
    pub fn new(technique: Technique) -> Self {
        Self {
            technique,
            batch: 50,
            assumed_visible: 5,
            jitter: true,
            visible_queue: true,
            multiqueries: true,
            tight_bounds: TightBounds::default(),
            threshold_px: 0,
            results: Results::SameFrame,
            coverage: Coverage::Stale,
            seed: 0,
        }
    }

    /// Whether the image must equal that of drawing everything.
    pub fn is_exact(&self) -> bool {
        !self.technique.asks() || self.threshold_px == 0 && self.results == Results::SameFrame
    }

    /// Whether these can be run.
    ///
    /// # Errors
    /// A knob out of its range, or answers of the next frame for a technique that waits for each.
    pub fn check(&self) -> Result<(), OcclusionError> {
        let within = |name, value: u32, range: std::ops::RangeInclusive<u32>| {
            let (least, most) = (range.start(), range.end());
            match range.contains(&value) {
                true => Ok(()),
                false => {
                    Err(OcclusionError::value(name, format!("{value} is not in {least}..={most}")))
                }
            }
        };
        within("batch", self.batch, Self::BATCH)?;
        within("assumed_visible", self.assumed_visible, Self::ASSUMED_VISIBLE)?;
        within("threshold_px", self.threshold_px, Self::THRESHOLD_PX)?;
        within("tight_bounds.depth", self.tight_bounds.depth, Self::TIGHT_DEPTH)?;
        let (area, range) = (self.tight_bounds.area, Self::TIGHT_AREA);
        if !range.contains(&area) {
            let (least, most) = (range.start(), range.end());
            let limit = format!("{area} is not in {least}..={most}");
            return Err(OcclusionError::value("tight_bounds.area", limit));
        }
        if self.technique == Technique::StopAndWait && self.results == Results::NextFrame {
            let limit = "answers of the next frame, where each is waited for";
            return Err(OcclusionError::value("results", limit));
        }
        Ok(())
    }
}
