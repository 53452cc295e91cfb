//! Which edges of an occluder must be moved inwards, and the walk over its triangles.

use super::buffer::Occluder;
use super::project::{CLIPPED, OUTSIDE, Projection, Vertex};
use super::triangle::Triangle;
use crate::OcclusionError;

/// Which edges of an occluder are moved inwards, by as much as renderers may differ in where they
/// draw it.
#[derive(Clone, Copy, Debug)]
pub enum Edges<'a> {
    /// None: the buffer holds what a device with 8 bits below the pixel draws.
    Exact,
    /// All: what is covered is covered on any renderer. Leaves cracks between triangles.
    Inset,
    /// For later.
    #[doc(hidden)]
    Unused(&'a ()),
}

/// What is found out of an occluder's triangles; used again from one to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Silhouette {}

/// Hands on the triangles of an occluder that may cover a pixel.
#[inline(always)]
pub(super) fn each_triangle(
    occluder: &Occluder,
    projection: &Projection,
    size: [i32; 2],
    vertices: &mut Vec<Vertex>,
    _silhouette: &mut Silhouette,
    mut draw: impl FnMut(&Triangle),
) -> Result<(), OcclusionError> {
    if !projection.vertices(occluder.positions, vertices) {
        return Err(projection.refusal(occluder.positions));
    }
    let slack = 0.0;
    let facing = occluder.facing;
    let open = matches!(occluder.edges, Edges::Inset);
    for (index, indices) in occluder.triangles.iter().enumerate() {
        let corner = |i: usize| vertices.get(indices[i] as usize).copied();
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            let limit = format!("indices {indices:?}, there are {} corners", vertices.len());
            return Err(OcclusionError::value(format!("occluder triangle {index}"), limit));
        };
        if a.code & b.code & c.code & OUTSIDE != 0 {
            continue;
        }
        let open = [open; 3];
        if (a.code | b.code | c.code) & CLIPPED == 0 {
            if let Some(triangle) = Triangle::new([a, b, c], open, facing, slack, size) {
                draw(&triangle);
            }
            continue;
        }
        let at = |i: usize| occluder.positions[indices[i] as usize];
        projection.clipped([(at(0), a), (at(1), b), (at(2), c)], open, |corners, open| {
            if let Some(triangle) = Triangle::new(corners, open, facing, slack, size) {
                draw(&triangle);
            }
        });
    }
    Ok(())
}
