//! Where the time of an evaluation goes.

use std::time::Instant;

/// Parts of an evaluation, by the steps of the thesis's Table 5.V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// 4: start nodes, and occluders in order.
    Sorting,
    /// 7 and 8, with the division of clusters that planes pass through.
    Potential,
    /// 9 and 10.
    Last,
    /// 11 and 12.
    Early,
    /// 13.
    Reprojection,
    /// 14, with fusion.
    Projection,
}

/// Nanoseconds of each part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// 4: start nodes, and occluders in order.
    pub sorting_ns: u64,
    /// 7 and 8, with the division of clusters that planes pass through.
    pub potential_ns: u64,
    /// 9 and 10.
    pub last_ns: u64,
    /// 11 and 12.
    pub early_ns: u64,
    /// 13.
    pub reprojection_ns: u64,
    /// 14, with fusion.
    pub projection_ns: u64,
}

/// A clock that only runs where it is asked for.
#[derive(Debug, Default)]
pub(super) struct Clock {
    since: Option<Instant>,
    pub parts: Parts,
}

impl Parts {
    /// All parts.
    pub fn total_ns(&self) -> u64 {
        self.clusters_ns() + self.sorting_ns + self.reprojection_ns + self.projection_ns
    }

    /// 6: everything that is done with clusters.
    pub fn clusters_ns(&self) -> u64 {
        self.potential_ns + self.last_ns + self.early_ns
    }
}

impl Clock {
    /// Starts or stops it.
    pub fn run(&mut self, running: bool) {
        self.since = running.then(Instant::now);
    }

    /// Begins anew without booking what went by.
    pub fn begin(&mut self) {
        if self.since.is_some() {
            self.since = Some(Instant::now());
        }
    }

    /// Books the time since the last call.
    pub fn book(&mut self, part: Part) {
        let Some(since) = self.since else { return };
        let now = Instant::now();
        let ns = (now - since).as_nanos() as u64;
        self.since = Some(now);
        *match part {
            Part::Sorting => &mut self.parts.sorting_ns,
            Part::Potential => &mut self.parts.potential_ns,
            Part::Last => &mut self.parts.last_ns,
            Part::Early => &mut self.parts.early_ns,
            Part::Reprojection => &mut self.parts.reprojection_ns,
            Part::Projection => &mut self.parts.projection_ns,
        } += ns;
    }
}
