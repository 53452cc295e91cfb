//! What the cross-crate tests in `tests/` share.

pub mod golden;
pub mod inputs;
