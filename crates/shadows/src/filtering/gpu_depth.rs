//! The depth map of light-space triangles by rasterisation.
