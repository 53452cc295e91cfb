//! dapple-shadows
