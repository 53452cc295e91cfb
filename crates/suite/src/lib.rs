//! dapple-suite
