//! Radiance at surface points from one to a million lights, as a plain library.
//!
//! A [`World`] holds lights and what each frame shows; a [`LightTree`] clusters the lights; a
//! [`Technique`] with its settings, made ready in one [`Form`] by [`make`], lights frames. Nothing
//! here knows that it is measured: counting is asked for where it is wanted.

mod block;
pub mod bound;
pub mod brute;
pub mod capped;
pub mod clustered;
pub mod cut;
mod error;
mod exact;
mod eye;
pub mod gpu;
mod light;
mod lighting;
mod pool;
pub mod region;
pub mod sample;
mod settings;
pub mod tree;
mod work;
mod world;
pub mod worlds;

pub use error::LightsError;
pub use exact::radiance;
pub use eye::Eye;
pub use light::{Emission, Light, luminance};
pub use lighting::{Form, Lighting, Shaded, Times, make};
pub use settings::{
    Absolute, BoundForm, Capped, Clustered, LightBvh, Lightcuts, Per, Relative, Reservoirs,
    Selection, StochasticLightcuts, Technique,
};
pub use tree::{LightTree, Node, PackedNode, PackedTree};
pub use work::Work;
pub use world::{Frame, NOTHING, Point, World};
