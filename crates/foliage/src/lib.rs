//! Foliage techniques as plain libraries.
//!
//! [`partition`] turns a level-of-detail factor per cell of a crown into a compact list of leaves
//! to draw: kept counts, exclusive prefix offsets and index generation, in every mapping of work
//! to threads that the literature suggests.

pub mod partition;
