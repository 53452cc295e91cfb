//! One graphics device for the workspace: adapter choice, soundness probes, buffers, pipelines,
//! timed frames, and read-back, with every failure a typed error.
//!
//! No other crate depends on wgpu; they use the re-export here.
//!
//! ```no_run
//! # fn main() -> Result<(), dapple_gpu::GpuError> {
//! use dapple_gpu::{AdapterChoice, Gpu};
//! let gpu = Gpu::open(&AdapterChoice::Auto)?;
//! let from = gpu.upload("from", &[1u32, 2, 3, 4])?;
//! let to = gpu.buffer("to", 16)?;
//! let pipeline = gpu.compute("gpu/copy.wgsl", "copy", &[])?;
//! let group = gpu.bind(&pipeline, 0, &[&from, &to]);
//! let mut frame = gpu.frame();
//! frame.compute("copy", |pass| {
//!     pass.set_pipeline(&pipeline);
//!     pass.set_bind_group(0, &group, &[]);
//!     pass.dispatch_workgroups(1, 1, 1);
//! });
//! let times = frame.finish()?;
//! assert_eq!(gpu.read::<u32>(&to, 0, 4)?, [1, 2, 3, 4]);
//! # let _ = times; Ok(()) }
//! ```

mod adapter;
pub mod bindings;
mod buffer;
mod copy_rate;
mod device;
mod error;
mod frame;
pub mod image;
pub mod light_space;
mod pipeline;
pub mod probe;
pub mod testing;

pub use adapter::{AdapterChoice, AdapterFacts, AdapterKind, adapters};
pub use copy_rate::copy_rate;
pub use device::Gpu;
pub use error::GpuError;
pub use frame::{Frame, FrameTimes, MAX_PASSES, Targets, TimestampFault};
pub use probe::Abilities;
pub use wgpu;
