//! Light trees: shapes, sums, cones and what stands for clusters.

mod builds;
mod changes;
mod cities;
mod nodes;
mod properties;
mod shapes;
mod support;
