//! dapple-foliage
