//! Searches over maps.
