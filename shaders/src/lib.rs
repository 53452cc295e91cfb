//! dapple-shaders
