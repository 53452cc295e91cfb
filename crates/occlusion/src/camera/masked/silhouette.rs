//! Which edges of an occluder are moved inwards, and the walk over its triangles.
//!
//! A renderer may draw each corner a little elsewhere than the buffer does. Where a sheet of
//! triangles all face the same way on the image, moving its corners uncovers pixels along its
//! border alone: the number of times that the border winds around a pixel changes only where the
//! border passes over it. So the border is moved inwards and inner edges are not, which leaves no
//! cracks. At an inner edge the neighbour's depth may come to be seen instead; the neighbour must
//! not be steep there, or the edge counts as border, and depths are taken farther by what steepness
//! is allowed. A triangle that touches the border with a corner only has one edge there moved too,
//! which keeps all of it away from that corner.

use super::buffer::Occluder;
use super::connectivity::{Connectivity, NONE};
use super::project::{CLIPPED, OUTSIDE, Projection, Vertex};
use super::triangle::{Care, Facing, Plane, Triangle, doubled_area};
use crate::OcclusionError;

/// How far renderers may differ in where they draw a corner, steps of 1/256 pixel: their snapping
/// and the buffer's, half a step each, and the rounding of positions, which at sides up to 16384
/// pixels is less than two.
pub const MOVED: u32 = 3;
/// Most steps that an edge is moved: sixteen pixels.
const MOST_INSET: u32 = 4096;

/// Which edges of an occluder are moved inwards, and by how many steps of 1/256 pixel.
#[derive(Clone, Copy, Debug)]
pub enum Edges<'a> {
    /// None: the buffer holds what a device with 8 bits below the pixel draws.
    Exact,
    /// All: what is covered is covered on any renderer that draws corners so near. Leaves cracks
    /// between triangles.
    Inset(u32),
    /// Those of the silhouette: the same without the cracks, and depths a little farther.
    Silhouette(u32, &'a Connectivity),
}

/// What is found out of an occluder's triangles; used again from one to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Silhouette {
    /// Of each triangle: which way it faces, 0 where that is not known or not the same nearby.
    faces: Vec<Face>,
    /// Of each triangle: bit i for the edge from corner i to the next.
    open: Vec<u8>,
    /// Of each place: whether an open edge ends there.
    border: Vec<bool>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Face {
    sign: i8,
    steep: bool,
}

impl Silhouette {
    fn find(&mut self, occluder: &Occluder, of: &Connectivity, vertices: &[Vertex], care: Care) {
        self.faces.clear();
        self.faces
            .extend(occluder.triangles.iter().map(|t| face(t, vertices, occluder.facing, care)));
        self.border.clear();
        self.border.resize(of.count, false);
        self.open.clear();
        for (index, face) in self.faces.iter().enumerate() {
            let mut open = 0;
            for i in 0..3 {
                let across = of.neighbours[index][i];
                let joined = across != NONE && {
                    let other = self.faces[across as usize];
                    face.sign != 0 && other.sign == face.sign && !other.steep
                };
                if !joined {
                    open |= 1 << i;
                    let places = of.places[index];
                    self.border[places[i] as usize] = true;
                    self.border[places[(i + 1) % 3] as usize] = true;
                }
            }
            self.open.push(open);
        }
        for (open, places) in self.open.iter_mut().zip(&of.places) {
            let found = *open;
            for (i, &place) in places.iter().enumerate() {
                let both = 1 << i | 1 << ((i + 2) % 3);
                if self.border[place as usize] && found & both == 0 {
                    *open |= 1 << i;
                }
            }
        }
    }
}

fn face(triangle: &[u32; 3], vertices: &[Vertex], facing: Facing, care: Care) -> Face {
    let corner = |i: usize| vertices.get(triangle[i] as usize).copied();
    let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
        return Face::default();
    };
    if (a.code | b.code | c.code) & CLIPPED != 0 {
        return Face::default();
    }
    let area = doubled_area([a, b, c]);
    let drawn = facing.draws(area);
    let sign = if drawn { area.signum() as i8 } else { 0 };
    let steep = sign != 0 && {
        let plane = Plane::new([a, b, c], area.unsigned_abs() as f64, care);
        let farthest = f64::from(a.z.min(b.z).min(c.z));
        plane.steepness() * f64::from(care.inset) > 256.0 * care.slack * farthest
    };
    Face { sign, steep }
}

/// Hands on the triangles of an occluder that may cover a pixel.
#[inline(always)]
pub(super) fn each_triangle(
    occluder: &Occluder,
    projection: &Projection,
    size: [i32; 2],
    vertices: &mut Vec<Vertex>,
    silhouette: &mut Silhouette,
    mut draw: impl FnMut(&Triangle),
) -> Result<(), OcclusionError> {
    if !projection.vertices(occluder.positions, vertices) {
        return Err(projection.refusal(occluder.positions));
    }
    let (all, care) = match occluder.edges {
        Edges::Exact => (0, Care { inset: MOVED as i32, slack: 0.0 }),
        Edges::Inset(steps) => (7, Care { inset: inset(steps)?, slack: 0.0 }),
        Edges::Silhouette(steps, connectivity) => {
            if connectivity.places.len() != occluder.triangles.len() {
                let (has, of) = (connectivity.places.len(), occluder.triangles.len());
                let limit = format!("{has} triangles, where the mesh has {of}");
                return Err(OcclusionError::value("occluder's connectivity", limit));
            }
            // A pixel away from a centre costs more depth than a few steps do.
            let slack = f64::from(steps) / 4096.0;
            let care = Care { inset: inset(steps)?, slack };
            silhouette.find(occluder, connectivity, vertices, care);
            (0, care)
        }
    };
    let along_silhouette = matches!(occluder.edges, Edges::Silhouette(..));
    let facing = occluder.facing;
    for (index, indices) in occluder.triangles.iter().enumerate() {
        let corner = |i: usize| vertices.get(indices[i] as usize).copied();
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
            let limit = format!("indices {indices:?}, there are {} corners", vertices.len());
            return Err(OcclusionError::value(format!("occluder triangle {index}"), limit));
        };
        if a.code & b.code & c.code & OUTSIDE != 0 {
            continue;
        }
        let bits = if along_silhouette { silhouette.open[index] } else { all };
        let open = [bits & 1 != 0, bits & 2 != 0, bits & 4 != 0];
        if (a.code | b.code | c.code) & CLIPPED == 0 {
            if let Some(triangle) = Triangle::new([a, b, c], open, facing, care, size) {
                draw(&triangle);
            }
            continue;
        }
        let at = |i: usize| occluder.positions[indices[i] as usize];
        projection.clipped([(at(0), a), (at(1), b), (at(2), c)], open, |corners, open| {
            // Without insets there are none along the cut either.
            let open = if bits == 0 { [false; 3] } else { open };
            if let Some(triangle) = Triangle::new(corners, open, facing, care, size) {
                draw(&triangle);
            }
        });
    }
    Ok(())
}

fn inset(steps: u32) -> Result<i32, OcclusionError> {
    if steps > MOST_INSET {
        let limit = format!("{steps} steps, at most {MOST_INSET} are allowed");
        return Err(OcclusionError::value("occluder's inset", limit));
    }
    Ok(steps as i32)
}
