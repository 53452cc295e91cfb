//! The problem end to end on small cases.
