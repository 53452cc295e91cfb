//! Gaps between boxes that no light passes: within the walls that neighbours share.
//!
//! Inscribed boxes of two buildings that share a wall do not touch, and shadows of boxes that do not
//! touch are never joined. Where the gap between them is proved to lie inside the two buildings, the
//! lower box is extended to the higher one.

use super::block::Walls;
use crate::region::Solid;
use glam::{DVec2, DVec3};

/// The widest gap looked at, metres: what a wall is askew by over its length, and more only where
/// inscribed boxes are much smaller than their buildings.
const WIDEST_M: f64 = 4.0;
/// What the proof keeps from walls, over the farthest coordinate: rounding of turned coordinates.
const ROUNDING: f64 = 1e-12;

/// A box and what it stands in.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// Turned space.
    pub solid: Solid,
    /// Index into [`Walls`].
    pub building: u32,
}

/// Walls in turned space.
pub struct Plan<'a> {
    /// Local space.
    pub walls: &'a Walls,
    /// Local (x, z) to turned.
    pub turn: &'a dyn Fn(DVec2) -> DVec2,
}

impl Placed {
    /// Its sides along an axis: 0 is x, 2 is z.
    pub fn side(&self, axis: usize) -> [f64; 2] {
        [self.solid.min[axis], self.solid.max[axis]]
    }

    /// Whether its height range holds the other's.
    pub fn stands_over(&self, other: &Self) -> bool {
        self.solid.min.y <= other.solid.min.y && self.solid.max.y >= other.solid.max.y
    }
}

/// What two ranges share.
pub fn shared(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].min(b[1])]
}

/// For each box, those that begin after it along `axis` and within reach of its end, nearest first.
pub fn followers(placed: &[Placed], axis: usize) -> Vec<Vec<u32>> {
    let mut order: Vec<u32> = (0..placed.len() as u32).collect();
    let begin = |i: u32| placed[i as usize].side(axis)[0];
    order.sort_by(|&a, &b| begin(a).total_cmp(&begin(b)).then(a.cmp(&b)));
    let across = 2 - axis;
    let of = |a: &Placed| {
        let [from, to] = a.side(axis);
        let first = order.partition_point(|&i| begin(i) <= from);
        let reached = order[first..].iter().take_while(|&&i| begin(i) <= to + WIDEST_M);
        let follows = |b: &Placed| {
            let [low, high] = shared(a.side(across), b.side(across));
            b.side(axis)[1] > to && low <= high
        };
        reached.copied().filter(|&i| follows(&placed[i as usize])).collect()
    };
    placed.iter().map(of).collect()
}

impl Plan<'_> {
    /// Whether all between two boxes along `axis`, over `range` across, is inside one of them or of
    /// their buildings: `range` lies within what both share across, or within `a` alone.
    pub fn is_solid(&self, a: &Placed, b: &Placed, axis: usize, range: [f64; 2]) -> bool {
        let (from, to) = (a.side(axis)[1], b.side(axis)[0]);
        if to <= from {
            return true;
        }
        if to - from > WIDEST_M || !self.walls.related(a.building, b.building) {
            return false;
        }
        let across = 2 - axis;
        let (mut min, mut max) = (DVec3::ZERO, DVec3::ZERO);
        (min[axis], max[axis]) = (from, to);
        (min[across], max[across]) = (range[0], range[1]);
        let (min, max) = (DVec2::new(min.x, min.z), DVec2::new(max.x, max.z));
        let kept = ROUNDING * min.abs().max(max.abs()).max_element();
        // One side of the gap lies in a building, and nothing leads out of the two.
        let mut border = self.walls.border(a.building, b.building);
        border.all(|wall| !meets(wall.map(self.turn), min - kept, max + kept))
    }

    /// Extends boxes to those beside them, where these are at least as high and what lies between is
    /// solid.
    pub fn close(&self, placed: &mut [Placed]) {
        for axis in [0, 2] {
            let before = placed.to_vec();
            for (i, followers) in followers(&before, axis).into_iter().enumerate() {
                let a = before[i];
                for j in followers {
                    let b = before[j as usize];
                    self.extend(placed, [i, j as usize], [a, b], axis);
                }
            }
        }
    }

    /// Extends the lower of `a` and `b`, which stand at `at`.
    fn extend(&self, placed: &mut [Placed], at: [usize; 2], [a, b]: [Placed; 2], axis: usize) {
        let (to, from) = (b.side(axis)[0], a.side(axis)[1]);
        if to <= from {
            return;
        }
        let range = |p: &Placed| p.side(2 - axis);
        if b.stands_over(&a) && self.is_solid(&a, &b, axis, range(&a)) {
            let max = &mut placed[at[0]].solid.max;
            max[axis] = max[axis].max(to);
        } else if a.stands_over(&b) && self.is_solid(&a, &b, axis, range(&b)) {
            let min = &mut placed[at[1]].solid.min;
            min[axis] = min[axis].min(from);
        }
    }
}

/// Whether a segment and a closed rectangle have a point in common (separating axes).
fn meets([p, q]: [DVec2; 2], min: DVec2, max: DVec2) -> bool {
    let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
    let (centre, reach) = (0.5 * (p + q) - middle, 0.5 * (q - p).abs());
    let across = (q - p).perp();
    let apart = (centre.abs() - reach - half).max_element() > 0.0
        || centre.dot(across).abs() > half.dot(across.abs());
    !apart
}

#[cfg(test)]
mod tests {
    use super::*;
    use dapple_scene::city::{Building, City, Footprint};
    use proptest::prelude::*;

    fn solid(x: [f64; 2], z: [f64; 2], top: f64) -> Solid {
        Solid { min: DVec3::new(x[0], f64::NEG_INFINITY, z[0]), max: DVec3::new(x[1], top, z[1]) }
    }

    /// Buildings over these rings.
    fn walls(rings: &[&[(f64, f64)]]) -> Walls {
        let building = |ring: &&[(f64, f64)]| {
            let outer: Vec<DVec2> = ring.iter().map(|&(x, z)| DVec2::new(x, z)).collect();
            let footprint = Footprint::new(&outer, &[], 0.0).unwrap();
            let outer = dapple_scene::Aabb::EMPTY;
            let (id, facades, roof, gables) = (String::new(), vec![], vec![], vec![]);
            let (base_m, eaves_m, storeys, inner) = (0.0, 3.0, 1, vec![]);
            Building {
                id,
                footprint,
                base_m,
                eaves_m,
                storeys,
                facades,
                roof,
                gables,
                outer,
                inner,
            }
        };
        let buildings = rings.iter().map(building).collect();
        Walls::of(&City { buildings, ..City::default() }, DVec3::ZERO)
    }

    #[test]
    fn a_gap_is_solid_where_a_shared_wall_lies_in_it_and_nothing_else() {
        // The second reaches along half of the first's right side only.
        let first = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (9.8, 10.0), (0.0, 10.0)];
        let second = [(10.0, 0.0), (20.0, 0.0), (20.0, 5.0), (10.0, 5.0)];
        let walls = walls(&[&first, &second]);
        let plan = Plan { walls: &walls, turn: &|p| p };
        let a = Placed { solid: solid([0.5, 9.5], [0.5, 9.5], 3.0), building: 0 };
        let b = Placed { solid: solid([10.5, 19.5], [0.5, 4.5], 3.0), building: 1 };
        assert!(plan.is_solid(&a, &b, 0, [0.5, 4.5]));
        assert!(!plan.is_solid(&a, &b, 0, [0.5, 9.5]), "there is a yard");
        assert!(!plan.is_solid(&a, &b, 0, [0.5, 5.0]), "the corner of the yard");
        // Where nothing is known of them, nothing is solid.
        let strange = Placed { building: super::super::block::NO_BUILDING, ..b };
        assert!(!plan.is_solid(&a, &strange, 0, [0.5, 4.5]));
        let far = Placed { solid: solid([9.5 + 1.01 * WIDEST_M, 19.5], [0.5, 4.5], 3.0), ..b };
        assert!(!plan.is_solid(&a, &far, 0, [0.5, 4.5]));
        // The first would reach into the yard; the second is extended unless it is the higher one.
        for (tops, expected) in [([3.0, 3.0], 9.5), ([3.0, 6.0], 10.5), ([6.0, 3.0], 9.5)] {
            let mut placed = [a, b];
            placed[0].solid.max.y = tops[0];
            placed[1].solid.max.y = tops[1];
            plan.close(&mut placed);
            assert_eq!((placed[0].solid.max.x, placed[1].solid.min.x), (9.5, expected), "{tops:?}");
        }
    }

    #[test]
    fn a_wall_that_differs_by_the_least_bit_is_a_crack() {
        let first = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (0.0, 5.0)];
        let second = |x: f64| [(x, 0.0), (20.0, 0.0), (20.0, 5.0), (x, 5.0)];
        let a = Placed { solid: solid([0.5, 9.5], [0.5, 4.5], 3.0), building: 0 };
        let b = Placed { solid: solid([10.5, 19.5], [0.5, 4.5], 3.0), building: 1 };
        for (x, expected) in [(10.0, true), (10.0f64.next_up(), false), (10.02, false)] {
            let walls = walls(&[&first, &second(x)]);
            let plan = Plan { walls: &walls, turn: &|p| p };
            assert_eq!(plan.is_solid(&a, &b, 0, [0.5, 4.5]), expected, "{x}");
        }
    }

    proptest! {
        #[test]
        fn segments_meet_rectangles_as_their_points_do(
            ends in prop::array::uniform4(-2.0..2.0f64), half in prop::array::uniform2(0.05..1.0f64),
        ) {
            let [p, q] = [DVec2::new(ends[0], ends[1]), DVec2::new(ends[2], ends[3])];
            let half = DVec2::from(half);
            let inside = |grown: f64| (0..=2000).any(|i| {
                p.lerp(q, f64::from(i) / 2000.0).abs().cmple(half + grown).all()
            });
            let met = meets([p, q], -half, half);
            prop_assert!(!inside(0.0) || met);
            prop_assert!(!met || inside(0.003));
        }
    }
}
