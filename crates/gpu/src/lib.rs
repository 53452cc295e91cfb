//! dapple-gpu
