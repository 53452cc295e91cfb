//! A case: scene, view, size and the parameters that the truth depends on.

use crate::{SuiteError, knob::Knobs};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Environment variable that points at real test data.
pub const DATA_VARIABLE: &str = "DAPPLE_DATA";

/// One case of a problem, complete.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Problem id.
    pub problem: String,
    /// A generator's name, a file's path, or `data:PATH` below `DAPPLE_DATA`.
    pub scene: String,
    /// A camera's name, or empty for the first.
    pub view: String,
    /// Seed of generators and sampling.
    pub seed: u64,
    /// Every parameter the problem declares.
    pub parameters: Knobs,
}

impl Case {
    /// Name in tables: scene, view where it is not the first, and seed where it is not 0.
    pub fn name(&self) -> String {
        let mut name = self.scene.rsplit('/').next().unwrap_or(&self.scene).to_string();
        if !self.view.is_empty() {
            name = format!("{name}:{}", self.view);
        }
        if self.seed != 0 {
            name = format!("{name}#{}", self.seed);
        }
        name
    }
}

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A generator of `dapple-scene` or of the problem itself.
    Generated(String),
    /// A file.
    File(PathBuf),
    /// A file of the test data, which are not at hand.
    MissingData(String),
}

/// Reads a scene's name. A name with a dot or a slash is a file.
///
/// # Errors
/// [`SuiteError::Usage`] for an empty name.
pub fn source(name: &str) -> Result<Source, SuiteError> {
    if let Some(path) = name.strip_prefix("data:") {
        return Ok(match std::env::var_os(DATA_VARIABLE) {
            Some(root) => Source::File(PathBuf::from(root).join(path)),
            None => Source::MissingData(path.into()),
        });
    }
    if name.is_empty() {
        return Err(SuiteError::Usage("the scene's name is empty".into()));
    }
    let is_file = name.contains(['/', '\\', '.']);
    Ok(if is_file { Source::File(name.into()) } else { Source::Generated(name.into()) })
}

/// The error for test data that are not at hand.
pub fn missing_data(path: &str) -> SuiteError {
    SuiteError::MissingData { path: path.into(), variable: DATA_VARIABLE }
}
