//! Upper bounds of what a cluster can give, at a point and over a region.
