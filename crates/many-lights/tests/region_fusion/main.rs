//! Shadows that are joined and moved from plane to plane: what they hide is hidden, the fast form
//! finds what the clear one finds, and the trees are what they are said to be.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod asked;
mod examples;
mod rows;
mod skyline;
mod sound;
mod streams;
mod structure;
