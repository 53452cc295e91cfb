//! Light trees: shapes, sums, cones and what stands for clusters.

mod nodes;
mod properties;
mod shapes;
mod support;
