//! Visibility from a camera.
//!
//! Space: objects are stored in f32 relative to [`Objects::origin`] (f64, world); everything here is
//! in that *local* space unless said otherwise. Depth is reversed: `near / distance`, 1 at the near
//! plane, 0 at infinity, greater is nearer.

pub mod hierarchical_depth;
pub mod objects;
pub mod renderer;
pub mod tree;
pub mod view;

pub use objects::{Bounds, Mask, Object, Objects, Template};
pub use renderer::{Image, Latency, Query, Readiness, Renderer, Work};
pub use tree::{Node, Tree};
pub use view::View;
