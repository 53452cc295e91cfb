//! Which triangles of a mesh share edges.

use glam::Vec3;
use std::collections::HashMap;

/// Stands for no triangle.
pub(super) const NONE: u32 = u32::MAX;

/// Neighbours of a mesh's triangles. Corners at the same place are one.
#[derive(Clone, Debug, Default)]
pub struct Connectivity {
    /// Across the edge from each corner to the next: the triangle that runs along it the other way,
    /// where there is exactly one such and none that runs the same way.
    pub(super) neighbours: Vec<[u32; 3]>,
    /// Places of the corners.
    pub(super) places: Vec<[u32; 3]>,
    /// Number of places.
    pub(super) count: usize,
}

impl Connectivity {
    /// Of indexed triangles. Indices of no corner have no neighbours.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let mut known = HashMap::new();
        let mut place = |corner: u32| {
            // 0 and -0 are one place.
            let at = positions
                .get(corner as usize)
                .map(|p| (*p + Vec3::ZERO).to_array().map(f32::to_bits));
            let next = known.len() as u32;
            *known.entry(at).or_insert(next)
        };
        let places: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(&mut place)).collect();
        let count = known.len();
        let mut edges: HashMap<[u32; 2], Vec<u32>> = HashMap::new();
        for (triangle, t) in places.iter().enumerate() {
            for i in 0..3 {
                edges.entry([t[i], t[(i + 1) % 3]]).or_default().push(triangle as u32);
            }
        }
        let across = |from: u32, to: u32| match (edges.get(&[from, to]), edges.get(&[to, from])) {
            (Some(here), Some(there)) if here.len() == 1 && there.len() == 1 => there[0],
            _ => NONE,
        };
        let neighbours =
            places.iter().map(|t| std::array::from_fn(|i| across(t[i], t[(i + 1) % 3]))).collect();
        Self { neighbours, places, count }
    }
}
