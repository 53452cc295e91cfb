//! Which lights a face sees, by rays: what from-region visibility is judged by.
//!
//! A light counts as seen once any ray from a point of the face arrives; the points are the face's
//! corners, ends and middles of the gaps that occluders leave towards the light ([`gaps`]), and random
//! ones. So what is called seen is seen, and what is left over is hidden as far as anyone looked: a
//! culled light that is seen is a false cull ([`false_culls`]), and the share of the hidden ones that a
//! technique culls is how tight it is ([`Agreement`]).
//!
//! Based on: P. Wonka et al., "Guided visibility sampling", 2006 (rays guided by what is known of
//! occluders).
//! Deviations: guided by silhouettes of boxes rather than by triangles that rays met; a light is a
//! point, so that for a height and a depth of the face the gaps towards it are known exactly.

mod agreement;
mod gaps;
mod obstacles;
mod points;
mod search;

pub use agreement::{Agreement, kept};
pub use gaps::{Gap, gaps};
pub use obstacles::Obstacles;
pub use search::{FalseCulls, Seen, Sight, Sighting, false_culls, seen, seen_strongly};
