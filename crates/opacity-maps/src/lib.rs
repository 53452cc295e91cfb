//! Light inside hair, foliage and smoke, as plain libraries: nothing here knows that it is measured.
//!
//! Every technique turns the [`Fragments`] that a light meets in a texel into a few stored numbers
//! ([`code::TexelCode::encode`]) and reads the transmittance in front of a depth back from them
//! ([`code::TexelCode::decode`]). [`reference`] says in `f64` what each of them means, [`cpu`] runs
//! them in parallel, [`gpu`] rasterises and shades on a graphics device.

pub mod adaptive;
pub mod auto_layers;
pub mod binary;
pub mod code;
pub mod cpu;
pub mod deep;
mod error;
pub mod exact;
pub mod faults;
pub mod fourier;
mod fragments;
mod gather;
pub mod gpu;
pub mod layered;
pub mod lighting;
pub mod moments;
mod receiver;
pub mod reference;
pub mod search;
mod settings;
pub mod stochastic;
pub mod taps;

pub use error::OpacityError;
pub use fragments::{Fragment, Fragments, Model, NO_OPAQUE};
pub use receiver::Receiver;
pub use settings::{
    Adaptive, Bins, Blend, Blur, Code, Criterion, Deep, EndMap, Format, Fourier, Layered, Layout,
    Lookup, Moments, Opaque, Order, Packing, Settings, Slicing, Split, SplitKind, Stochastic,
    Storage, Taps,
};
