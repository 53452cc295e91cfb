//! Masked software occlusion culling: a depth buffer of occluders drawn on the processor, which
//! keeps two depths and a mask for each 8 x 4 pixels instead of a depth for each.
//!
//! After Hasselgren, Andersson and Akenine-Möller, "Masked Software Occlusion Culling", High
//! Performance Graphics 2016, and Andersson, Hasselgren and Akenine-Möller, "Masked Depth Culling
//! for Graphics Hardware", ACM Transactions on Graphics 34(6), 2015; from the descriptions. What
//! differs:
//!
//! - Depth is reversed, greater is nearer, and cleared to 0; any depth that is linear on the image
//!   will do (`near / w`, `1 / w`, or parallel rays' own).
//! - Coverage is exact for vertices snapped to 1/256 of a pixel: the same pixels that a device with
//!   8 bits below the pixel draws, shared edges without cracks. See `triangle.rs`.
//! - A triangle's depth in a subtile is that of its plane at the subtile's farthest pixel centre,
//!   not farther than its farthest corner, rounded away by a bound on all errors, and by as much as
//!   its plane rises within the distance that a renderer may move it.
//! - A subtile holds three depths for a moment: the reference, the layer, the triangle. Two are kept
//!   exactly where they cover all of it; the original takes the nearer of them back even then, so
//!   that a wall far away spoils what stands half before it. Otherwise one is given up: the
//!   original compares how far apart they are, this one counts pixels too, and in octaves of depth.
//! - Occluders are chosen by size, see `occluders.rs`; the original takes them as they come.
//! - A question looks at the masks: a pixel of the working layer counts with that layer's depth.
//!   The original looks at the reference layer alone.
//! - One triangle at a time is set up; the original sets up as many as there are lanes.
//!
//! No occluder lowers a reference depth. So what is hidden stays hidden by more occluders, if the
//! question is about whole subtiles; a question about parts of them may look at a layer that is
//! given up later.

mod buffer;
mod connectivity;
mod culler;
mod fast;
mod occluders;
mod project;
mod question;
mod reference;
mod silhouette;
mod triangle;

pub use buffer::{Buffer, Form, Occluder};
pub use connectivity::Connectivity;
pub use culler::{Culler, Settings};
pub use occluders::{InnerBox, Occluders};
pub use silhouette::{Edges, MOVED};
pub use triangle::Facing;

#[cfg(test)]
mod tests;
