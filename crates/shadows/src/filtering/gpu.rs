//! The filters as compute passes.
