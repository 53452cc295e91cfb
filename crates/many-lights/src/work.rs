//! Hardware-independent work.

/// Work of one frame, or summed over some.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Pixels that show anything.
    pub pixels: u64,
    /// Nodes of light trees looked at.
    pub visits: u64,
    /// Bounds evaluated.
    pub bounds: u64,
    /// Single lights evaluated at a pixel.
    pub lights: u64,
    /// Clusters evaluated at a pixel by their representative.
    pub clusters: u64,
    /// Nodes that cuts of the pixels hold, summed (a tile's cut counts once a pixel).
    pub cut: u64,
    /// Most nodes that any one cut holds.
    pub most_cut: u64,
    /// Cuts that were ended by their greatest size.
    pub ended: u64,
    /// 64 times the most visits of any pixel of an 8 x 8 tile, summed over tiles: what lanes that
    /// wait for each other pay. Over `visits`, the divergence D.
    pub lane_visits: u64,
    /// Lights drawn by chance.
    pub samples: u64,
    /// Shadow rays.
    pub rays: u64,
    /// Reservoirs of other pixels or frames that were looked at.
    pub reused: u64,
    /// Entries of light lists (clusters of space, tiles).
    pub entries: u64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.pixels += other.pixels;
        self.visits += other.visits;
        self.bounds += other.bounds;
        self.lights += other.lights;
        self.clusters += other.clusters;
        self.cut += other.cut;
        self.most_cut = self.most_cut.max(other.most_cut);
        self.ended += other.ended;
        self.lane_visits += other.lane_visits;
        self.samples += other.samples;
        self.rays += other.rays;
        self.reused += other.reused;
        self.entries += other.entries;
    }
}

impl Work {
    /// Divergence: visits that lanes of 8 x 8 tiles wait through, over visits; at least 1.
    pub fn divergence(&self) -> f64 {
        if self.visits == 0 { 1.0 } else { self.lane_visits as f64 / self.visits as f64 }
    }
}
