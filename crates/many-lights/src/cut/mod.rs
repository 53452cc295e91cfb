//! Cuts through light trees: which clusters stand for all lights at a pixel.
