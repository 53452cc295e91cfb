//! Choosing λ: by scores of the maps of eleven trial values, for a whole map or tile by tile.
//!
//! [`criteria`] judges maps, [`state`] says which λ a frame tries, [`Search`] renders and scores.

pub mod correlation;
pub mod criteria;
mod driver;
pub mod information;
mod layers;
pub mod oracle;
pub mod state;
mod texture;

pub use criteria::{Precision, Scorer, Scoring};
pub(crate) use driver::cumulative;
pub use driver::{Plan, Report, Search};
pub use layers::{Layers, Region};
pub use state::{Cycle, Shown, Steps};
pub use texture::{SplitCode, SplitTexture, with_lambda};
