//! Visibility from a camera.
//!
//! Space: objects are stored in f32 relative to [`Objects::origin`] (f64, world); everything here is
//! in that *local* space unless said otherwise. Depth is reversed: `near / distance`, 1 at the near
//! plane, 0 at infinity, greater is nearer.

pub mod cells;
pub mod coverage;
pub mod gpu;
pub mod hierarchical_depth;
pub mod masked;
pub mod objects;
mod queue;
pub mod renderer;
pub mod settings;
pub mod software;
pub mod state;
pub mod techniques;
pub mod tree;
pub mod view;

pub use cells::{Cell, CellLimits, Cells, view_cells};
pub use coverage::exact_coverage;
pub use objects::{Bounds, Mask, Object, Objects, Template};
pub use renderer::{Image, Latency, Query, Readiness, Renderer, Work};
pub use settings::{Coverage, Results, Settings, Technique, TightBounds};
pub use state::{Frame, Memory, State};
pub use tree::{Node, Tree, city_keys};
pub use view::{Crossing, View};
