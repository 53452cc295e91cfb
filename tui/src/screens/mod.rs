//! One module a screen: its state, `update` (what a key or message changes) and `view` (pure).

pub mod claims;
pub mod compare;
pub mod front;
pub mod live;
pub mod overview;
pub mod runs;
pub mod stress;
pub mod technique;

use crate::{jobs::Jobs, store::Store, theme::Theme};
use dapple_records::{
    Index,
    catalogue::{Catalogue, ProblemInfo},
    front::Key,
    index::SettingName,
};
use ratatui_image::picker::Picker;
use std::sync::Arc;

/// Which screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Screen {
    /// One row a problem.
    #[default]
    Overview,
    /// Error against time.
    Front,
    /// One technique: pictures, knobs, curves.
    Technique,
    /// A knob turned, an image following.
    Live,
    /// Techniques against extremes.
    Stress,
    /// Claims with verdicts.
    Claims,
    /// Two runs.
    Compare,
    /// Jobs.
    Runs,
}

impl Screen {
    /// All, in the order of tabs.
    pub const ALL: [Self; 8] = [
        Self::Overview,
        Self::Front,
        Self::Technique,
        Self::Live,
        Self::Stress,
        Self::Claims,
        Self::Compare,
        Self::Runs,
    ];

    /// The tab's text.
    pub fn title(self) -> &'static str {
        match self {
            Self::Overview => "Overview",
            Self::Front => "Front",
            Self::Technique => "Technique",
            Self::Live => "Live",
            Self::Stress => "Stress",
            Self::Claims => "Claims",
            Self::Compare => "Compare",
            Self::Runs => "Runs",
        }
    }
}

/// What all screens share and none changes but through the app.
#[derive(Clone, Debug)]
pub struct World {
    /// The records.
    pub store: Arc<Store>,
    /// What the program declares, once it has told.
    pub catalogue: Option<Arc<Catalogue>>,
    /// Why it has not, if so.
    pub catalogue_trouble: Option<String>,
    /// Jobs.
    pub jobs: Jobs,
    /// Styles.
    pub theme: Theme,
    /// Milliseconds since 1970.
    pub now_ms: i64,
    /// The problem that screens are about.
    pub problem: String,
    /// The technique that screens are about.
    pub technique: String,
    /// The setting that was last selected on a screen, if any.
    pub focus: Option<Focus>,
    /// How this terminal shows pictures.
    pub picker: Picker,
    /// Number of the next request of any screen.
    pub request: u64,
    /// Whether the records were read for the first time.
    pub loaded: bool,
    /// The user leaves: children are being ended.
    pub leaving: bool,
}

/// One measured setting, by what does not change when records are read again.
#[derive(Clone, Debug, PartialEq)]
pub struct Focus {
    /// What it shares with its rivals: case, machine, adapter.
    pub key: Key,
    /// Technique, variant and form.
    pub setting: SettingName,
    /// The row's identity.
    pub identity: u64,
}

impl Focus {
    /// Of the row at a position of the index.
    pub fn of(index: &Index, at: usize) -> Option<Self> {
        let entry = index.entries.get(at)?;
        Some(Self {
            key: index.key(entry).clone(),
            setting: index.setting(entry).clone(),
            identity: entry.identity,
        })
    }
}

impl World {
    /// The declaration of the current problem.
    pub fn info(&self) -> Option<&ProblemInfo> {
        self.catalogue.as_ref()?.problems.iter().find(|p| p.id == self.problem)
    }

    /// Ids of all problems: declared, else found in records.
    pub fn problems(&self) -> Vec<String> {
        if let Some(catalogue) = &self.catalogue {
            return catalogue.problems.iter().map(|p| p.id.clone()).collect();
        }
        let mut ids: Vec<_> = self.store.index.keys.iter().map(|k| k.problem.clone()).collect();
        ids.sort();
        ids.dedup();
        ids
    }

    /// A number no request had.
    pub fn next_request(&mut self) -> u64 {
        self.request += 1;
        self.request
    }
}
