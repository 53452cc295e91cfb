//! Choosing λ: criteria against brute force and algebra, the state machine, the split texture.

mod criteria;
mod driver;
mod rays;
mod state;
