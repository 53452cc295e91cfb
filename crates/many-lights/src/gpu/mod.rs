//! The same techniques on a device.

mod scene;

pub use scene::Scene;
