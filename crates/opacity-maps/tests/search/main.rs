//! Choosing λ: criteria against brute force and algebra, the state machine, the split texture.

mod criteria;
mod driver;
mod layers;
mod rays;
mod state;
