//! Work of from-region visibility, by the steps of the thesis's table.
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, Table 5.V (names and
//! numbers of the steps).
//! Deviations: what the table derives from differences is counted on its own too.

/// Calls of each step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps {
    /// 5: evaluations of a cell towards a direction.
    pub evaluations: u64,
    /// 6: planes, that is iterations over the clusters.
    pub iterations: u64,
    /// 7 and 8: upper bounds of clusters.
    pub potential: u64,
    /// Clusters too weak: culled by 7.
    pub potential_culled: u64,
    /// 9: last tests of clusters between two planes.
    pub last: u64,
    /// Culled by 9.
    pub last_culled: u64,
    /// Clusters hidden in part that were divided in 9.
    pub last_divided: u64,
    /// Nodes put out by 9.
    pub last_output: u64,
    /// 10: projections on a plane in 9.
    pub last_projected: u64,
    /// 11: early tests of clusters behind the next plane.
    pub early: u64,
    /// Culled by 11.
    pub early_culled: u64,
    /// 12: projections on a plane in 11.
    pub early_projected: u64,
    /// Clusters divided because a plane passes through them.
    pub straddling: u64,
    /// 13: horizons moved to the next plane.
    pub reprojections: u64,
    /// Shadows moved in 13.
    pub moved: u64,
    /// 14: planes that occluders were projected on.
    pub projections: u64,
    /// Occluders projected in 14.
    pub projected: u64,
    /// Shadows that projections of clusters were compared with, in 9 and 11.
    pub compared: u64,
    /// Nodes of all precuts.
    pub output: u64,
    /// Rays.
    pub rays: u64,
}

impl std::ops::AddAssign for Steps {
    fn add_assign(&mut self, other: Self) {
        self.evaluations += other.evaluations;
        self.iterations += other.iterations;
        self.potential += other.potential;
        self.potential_culled += other.potential_culled;
        self.last += other.last;
        self.last_culled += other.last_culled;
        self.last_divided += other.last_divided;
        self.last_output += other.last_output;
        self.last_projected += other.last_projected;
        self.early += other.early;
        self.early_culled += other.early_culled;
        self.early_projected += other.early_projected;
        self.straddling += other.straddling;
        self.reprojections += other.reprojections;
        self.moved += other.moved;
        self.projections += other.projections;
        self.projected += other.projected;
        self.compared += other.compared;
        self.output += other.output;
        self.rays += other.rays;
    }
}

impl Steps {
    /// Every cluster that is strong enough goes to exactly one of steps 9 and 11 (P11).
    pub fn is_consistent(&self) -> bool {
        self.potential - self.potential_culled == self.last + self.early
    }
}
