//! The problem end to end.
