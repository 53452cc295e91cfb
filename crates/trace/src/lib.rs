//! dapple-trace
