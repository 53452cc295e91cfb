//! An expanded sweep: which settings are measured on which cases, in which groups.

use crate::{case::Case, problem::Setting};
use serde::{Deserialize, Serialize};

/// Settings of one form measured side by side on one case, in one process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// The case.
    pub case: Case,
    /// The settings; the first is the one that ratios refer to.
    pub settings: Vec<Setting>,
    /// Whether the first setting is there for its ratio only and recorded by an earlier group.
    pub repeated_baseline: bool,
}

/// Everything a run measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The sweep's name.
    pub name: String,
    /// Timed repeats of every setting.
    pub repeats: u32,
    /// Seconds a group may take.
    pub limit_s: u64,
    /// The groups, in order.
    pub groups: Vec<Group>,
    /// What was left out, and why.
    pub notes: Vec<String>,
}

impl Plan {
    /// Rows the run will hold when finished.
    pub fn rows(&self) -> usize {
        self.groups.iter().map(Group::rows).sum()
    }

    /// Hash of all that decides which rows there are.
    pub fn hash(&self) -> String {
        // Serialising plain data to memory cannot fail; an empty text would only lose resumption.
        let text = serde_json::to_string(self).unwrap_or_default();
        blake3::hash(text.as_bytes()).to_hex()[..16].to_string()
    }
}

impl Group {
    /// Rows this group leaves.
    pub fn rows(&self) -> usize {
        self.settings.len() - usize::from(self.repeated_baseline)
    }

    /// A name for progress and logs.
    pub fn title(&self) -> String {
        let form = self.settings.first().map(|s| s.form.to_string()).unwrap_or_default();
        format!("{} {} {form}", self.case.problem, self.case.name())
    }
}
