//! Which triangles are one surface: those of an instance that are connected by shared corners.
//!
//! Corners are shared where their positions are bit-equal, whatever their indices: files split
//! vertices along seams of texture coordinates and normals.

use crate::tracer::{Leaf, Tracer, UNTRACED};
use glam::DVec3;
use rayon::prelude::*;

/// A label for each triangle; equal labels are connected.
pub(crate) struct Sheets {
    of_triangle: Vec<u32>,
}

impl Sheets {
    /// Labels the leaves of `instance_of`'s instances; untraced triangles stay alone.
    pub fn of(leaves: &[Leaf], triangles: usize, instance_of: impl Fn(u32) -> u32 + Sync) -> Self {
        let mut parent: Vec<u32> = (0..triangles as u32).collect();
        let corners_of = |leaf: &Leaf| {
            let (instance, id) = (instance_of(leaf.id), leaf.id);
            // Adding zero makes one zero of the two.
            leaf.corners.map(|corner| (instance, corner.map(|c| (c + 0.0).to_bits()), id))
        };
        let mut corners: Vec<_> = leaves.par_iter().flat_map_iter(corners_of).collect();
        // Equal corners come to lie side by side.
        corners.par_sort_unstable();
        for pair in corners.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            if (a.0, a.1) == (b.0, b.1) {
                let (a, b) = (root(&mut parent, a.2), root(&mut parent, b.2));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
        for triangle in 0..triangles as u32 {
            parent[triangle as usize] = root(&mut parent, triangle);
        }
        Self { of_triangle: parent }
    }

    fn label(&self, triangle: u32) -> u32 {
        self.of_triangle.get(triangle as usize).copied().unwrap_or(UNTRACED)
    }
}

fn root(parent: &mut [u32], mut triangle: u32) -> u32 {
    while parent[triangle as usize] != triangle {
        // Halving the path keeps the trees flat.
        parent[triangle as usize] = parent[parent[triangle as usize] as usize];
        triangle = parent[triangle as usize];
    }
    triangle
}

impl Tracer {
    /// Whether triangle `a` belongs to the surface of triangle `b` and turns the same side of its
    /// winding towards `direction`: the front and the back of a closed body are two surfaces.
    pub(crate) fn is_same_surface(&self, a: u32, b: u32, direction: DVec3) -> bool {
        if a == b {
            return true;
        }
        let sheets = self.sheets.get_or_init(|| {
            Sheets::of(&self.leaves, self.slot_of_triangle.len(), |triangle| {
                self.instance_starts.partition_point(|&start| start <= triangle) as u32
            })
        });
        let side = |triangle: u32| {
            let slot = self.slot_of_triangle.get(triangle as usize)?;
            let [a, b, c] = self.leaves.get(*slot as usize)?.corners.map(DVec3::from_array);
            Some((b - a).cross(c - a).dot(direction) > 0.0)
        };
        sheets.label(a) == sheets.label(b) && side(a) == side(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaf(id: u32, corners: [[f64; 3]; 3]) -> Leaf {
        Leaf { corners, id, cut_out: u32::MAX }
    }

    #[test]
    fn triangles_are_connected_by_equal_corners_of_one_instance() {
        let (a, b, c, d) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]);
        let [e, f, g] = [[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, -0.0]];
        let leaves = [
            leaf(0, [a, b, c]),
            leaf(1, [b, d, c]), // shares an edge with 0
            leaf(2, [e, f, g]), // alone
            leaf(3, [[5.0, 1.0, 0.0], d, [9.0, 9.0, 9.0]]), // joins 1 and 2: -0 is 0
            leaf(4, [a, b, c]), // the same corners in another instance
        ];
        let label = |leaves: &[Leaf]| {
            let sheets = Sheets::of(leaves, 6, |triangle| u32::from(triangle == 4));
            (0..6).map(|t| sheets.label(t)).collect::<Vec<_>>()
        };
        assert_eq!(label(&leaves), [0, 0, 0, 0, 4, 5]);
        let apart = [leaves[0], leaves[1], leaves[2], leaves[4]];
        assert_eq!(label(&apart), [0, 0, 2, 3, 4, 5]);
    }
}
