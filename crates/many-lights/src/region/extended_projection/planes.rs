//! Planes of a raster, and what stands before them.

use crate::region::{Cuboid, Direction, Solid};

/// The most planes, or nearly: far faces nearer than this part of the depth of all occluders are passed
/// over, save the last one. Each plane costs a whole map, while more of them help where touching
/// occluders' shadows touch only on planes that they reach.
const PLANES: f64 = 48.0;

/// Occluders behind a face, by their near sides.
#[derive(Default)]
pub(super) struct Planes {
    pub occluders: Vec<Cuboid>,
    /// w, increasing.
    pub planes: Vec<f64>,
}

impl Planes {
    /// What of the solids has a part behind `front` and before `last`, and the far faces that carry a
    /// plane.
    pub fn fill(&mut self, solids: &[Solid], direction: Direction, [front, last]: [f64; 2]) {
        self.occluders.clear();
        self.planes.clear();
        let in_space = solids.iter().map(|s| direction.cuboid(s.min, s.max));
        self.occluders.extend(in_space.filter(|o| o.w[1] > front && o.w[0] < last));
        self.occluders.sort_by(|a, b| a.w[0].total_cmp(&b.w[0]));
        let mut faces: Vec<f64> =
            self.occluders.iter().map(|o| o.w[1]).filter(|face| *face < last).collect();
        faces.sort_unstable_by(f64::total_cmp);
        let Some(&farthest) = faces.last() else { return };
        let step = (farthest - front) / PLANES;
        for face in faces {
            let is_next =
                self.planes.last().is_none_or(|before| face - before >= step && face > *before);
            if is_next {
                self.planes.push(face);
            }
        }
        if self.planes.last() < Some(&farthest) {
            self.planes.push(farthest);
        }
    }

    /// Bytes of it.
    pub fn bytes(&self) -> u64 {
        (self.occluders.capacity() * size_of::<Cuboid>() + self.planes.capacity() * 8) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn planes_lie_at_far_faces_apart_from_each_other_and_at_the_last() {
        let solid = |near: f64, far: f64| Solid {
            min: DVec3::new(near, f64::NEG_INFINITY, 0.0),
            max: DVec3::new(far, 9.0, 1.0),
        };
        let mut planes = Planes::default();
        let solids = [
            solid(5.0, 10.0),
            solid(-9.0, -8.0),
            solid(2.0, 3.0),
            solid(9.9, 10.1),
            solid(20.0, 100.0),
            solid(90.0, 99.0),
        ];
        planes.fill(&solids, Direction::PlusX, [0.0, 200.0]);
        assert_eq!(planes.planes, [3.0, 10.0, 99.0, 100.0]);
        assert_eq!(planes.occluders.len(), 5);
        // Nothing is behind a plane that lies behind the last light.
        planes.fill(&solids, Direction::PlusX, [0.0, 50.0]);
        assert_eq!(planes.planes, [3.0, 10.0, 10.1]);
        assert_eq!(planes.occluders.len(), 4);
        planes.fill(&[], Direction::PlusX, [0.0, 50.0]);
        assert!(planes.planes.is_empty());
    }
}
