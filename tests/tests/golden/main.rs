//! Golden images. Each is compared only after its result has passed against a truth that no golden
//! takes part in, so that a wrong picture cannot be blessed.

mod cities;
mod harness;
mod lights;
mod night;
mod partition;
mod regions;
mod shadow_truth;
mod shadows;
mod translucent;
