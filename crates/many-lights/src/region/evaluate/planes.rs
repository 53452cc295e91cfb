//! Where planes lie, and which occluders are projected on each.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, section 4.2.4.
//! Deviations: the thesis puts a plane at the next occluder and leaves open at which of its faces; here
//! it is the far one, where shadows of walls that touch do touch.

use super::super::{Direction, Planes, Solid};

/// Occluders of a turn in the order in which planes meet them in one direction.
#[derive(Debug)]
pub(super) struct Order {
    /// Index of the solid, by far face; equal faces by index.
    far: Vec<u32>,
    /// Far faces, in that order.
    far_w: Vec<f64>,
    /// Places in `far`, by near face.
    near: Vec<u32>,
    /// Near faces, in that order.
    near_w: Vec<f64>,
    /// The farthest far face of these and all whose near faces come before.
    reach: Vec<f64>,
}

/// Occluders before the current plane that were not yet behind the one before, and those to come.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// Places in [`Order::far`], in increasing order.
    active: Vec<u32>,
    /// The first of [`Order::near`] that no plane has met.
    next: usize,
}

impl Order {
    pub fn of(solids: &[Solid], direction: Direction) -> Self {
        let w = |i: u32| {
            let solid = &solids[i as usize];
            direction.cuboid(solid.min, solid.max).w
        };
        let mut far: Vec<u32> = (0..solids.len() as u32).filter(|&i| w(i)[0] <= w(i)[1]).collect();
        far.sort_by(|&a, &b| w(a)[1].total_cmp(&w(b)[1]));
        let far_w: Vec<f64> = far.iter().map(|&i| w(i)[1]).collect();
        let mut near: Vec<u32> = (0..far.len() as u32).collect();
        let near_of = |place: u32| w(far[place as usize])[0];
        near.sort_by(|&a, &b| near_of(a).total_cmp(&near_of(b)));
        let near_w = near.iter().map(|&place| near_of(place)).collect();
        let farthest = |reach: &mut f64, &place: &u32| {
            *reach = reach.max(far_w[place as usize]);
            Some(*reach)
        };
        let reach = near.iter().scan(f64::NEG_INFINITY, farthest).collect();
        Self { far, far_w, near, near_w, reach }
    }

    /// The plane after the one at `plane`, for a cell whose foremost surface is at `front`; `None`
    /// where no occluder is left.
    pub fn next(&self, front: f64, plane: f64, planes: Planes, least_step_m: f64) -> Option<f64> {
        let place = |far: f64| match planes {
            Planes::FarFaces => far,
            Planes::Behind(metres) => far + metres,
            Planes::Every(metres) => front + metres * ((far - front) / metres).ceil(),
        };
        let first = self.far_w.partition_point(|&far| far <= front);
        let ahead = &self.far_w[first..];
        let passed = |&far: &f64| {
            let at = place(far);
            at <= plane || at - plane < least_step_m
        };
        let next = ahead.get(ahead.partition_point(passed)).map(|&far| place(far));
        next.filter(|at| at.is_finite())
    }

    /// Bytes it takes.
    pub fn bytes(&self) -> u64 {
        let each = 2 * size_of::<u32>() + 3 * size_of::<f64>();
        (self.far.capacity() * each) as u64
    }
}

impl Sweep {
    /// Begins at a cell whose foremost surface is at `front`.
    pub fn start(&mut self, order: &Order, front: f64) {
        self.active.clear();
        self.next = order.reach.partition_point(|&reach| reach <= front);
    }

    /// Moves from one plane to a farther one. Afterwards [`Self::active`] are all occluders that have a
    /// part between them.
    pub fn advance(&mut self, order: &Order, from: f64, to: f64) {
        let behind = self.active.partition_point(|&place| order.far_w[place as usize] <= from);
        self.active.drain(..behind);
        let kept = self.active.len();
        while order.near_w.get(self.next).is_some_and(|&near| near <= to) {
            let place = order.near[self.next];
            if order.far_w[place as usize] > from {
                self.active.push(place);
            }
            self.next += 1;
        }
        if self.active.len() > kept {
            self.active.sort_unstable();
        }
    }

    /// Indices of solids, by far face.
    pub fn active<'a>(&'a self, order: &'a Order) -> impl Iterator<Item = u32> + 'a {
        self.active.iter().map(|&place| order.far[place as usize])
    }

    /// Bytes it takes.
    pub fn bytes(&self) -> u64 {
        (self.active.capacity() * size_of::<u32>()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn solid(near: f64, far: f64) -> Solid {
        Solid { min: DVec3::new(0.0, 0.0, near), max: DVec3::new(1.0, 1.0, far) }
    }

    /// Planes after `front`, with the occluders of each.
    fn sweep(
        solids: &[Solid],
        front: f64,
        planes: Planes,
        least_step_m: f64,
    ) -> Vec<(f64, Vec<u32>)> {
        let order = Order::of(solids, Direction::PlusZ);
        let mut sweep = Sweep::default();
        sweep.start(&order, front);
        let (mut at, mut all) = (front, vec![]);
        while let Some(next) = order.next(front, at, planes, least_step_m) {
            sweep.advance(&order, at, next);
            all.push((next, sweep.active(&order).collect()));
            at = next;
        }
        all
    }

    #[test]
    fn planes_lie_at_far_faces_and_meet_all_that_begins_before() {
        let solids =
            [solid(5.0, 9.0), solid(-3.0, 1.0), solid(0.0, 7.0), solid(5.0, 7.0), solid(9.0, 12.0)];
        let all = sweep(&solids, 1.0, Planes::FarFaces, 0.0);
        assert_eq!(all, [(7.0, vec![2, 3, 0]), (9.0, vec![0, 4]), (12.0, vec![4])]);
        let all = sweep(&solids, 2.0, Planes::FarFaces, 5.5);
        assert_eq!(all, [(9.0, vec![2, 3, 0, 4])]);
        let all = sweep(&solids, 8.0, Planes::Behind(2.0), 0.0);
        assert_eq!(all, [(11.0, vec![0, 4]), (14.0, vec![4])]);
        let all = sweep(&solids, 2.0, Planes::Every(4.0), 0.0);
        assert_eq!(all, [(10.0, vec![2, 3, 0, 4]), (14.0, vec![4])]);
        assert!(sweep(&solids, 12.0, Planes::FarFaces, 0.0).is_empty());
        assert!(sweep(&solids, 0.0, Planes::Behind(f64::INFINITY), 0.0).is_empty());
        assert!(sweep(&[], 0.0, Planes::FarFaces, 0.0).is_empty());
    }

    #[test]
    fn mirrored_directions_meet_occluders_the_other_way_round() {
        let solids = [solid(0.0, 4.0), solid(5.0, 9.0)];
        let order = Order::of(&solids, Direction::MinusZ);
        assert_eq!(order.next(-20.0, -20.0, Planes::FarFaces, 0.0), Some(-5.0));
        assert_eq!(order.next(-20.0, -5.0, Planes::FarFaces, 0.0), Some(0.0));
        assert_eq!(order.next(-20.0, 0.0, Planes::FarFaces, 0.0), None);
    }
}
