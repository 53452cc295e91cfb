//! Records as CSV.
