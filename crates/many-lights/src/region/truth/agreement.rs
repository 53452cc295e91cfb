//! A technique's lists beside the truth.

use crate::LightTree;

/// Lights counted by whether they are seen and whether they are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Agreement {
    /// Seen and kept: right.
    pub seen_kept: u64,
    /// Seen, and yet culled: false culls.
    pub seen_culled: u64,
    /// Hidden, and yet kept: what is lost in tightness.
    pub hidden_kept: u64,
    /// Hidden and culled: right.
    pub hidden_culled: u64,
}

impl Agreement {
    /// Counts pairs of (seen, kept).
    pub fn of(lights: impl IntoIterator<Item = (bool, bool)>) -> Self {
        let mut counted = Self::default();
        for (seen, kept) in lights {
            *match (seen, kept) {
                (true, true) => &mut counted.seen_kept,
                (true, false) => &mut counted.seen_culled,
                (false, true) => &mut counted.hidden_kept,
                (false, false) => &mut counted.hidden_culled,
            } += 1;
        }
        counted
    }

    /// Share of the hidden lights that are culled, 0..=1; 1 where none is hidden.
    pub fn tightness(&self) -> f64 {
        share(self.hidden_culled, self.hidden_kept).unwrap_or(1.0)
    }

    /// Share of the seen lights that are culled, 0..=1; 0 where none is seen.
    pub fn false_hidden(&self) -> f64 {
        share(self.seen_culled, self.seen_kept).unwrap_or(0.0)
    }

    /// Share of the hidden lights that are kept, 0..=1; 0 where none is hidden.
    pub fn false_visible(&self) -> f64 {
        share(self.hidden_kept, self.hidden_culled).unwrap_or(0.0)
    }
}

impl std::ops::AddAssign for Agreement {
    fn add_assign(&mut self, other: Self) {
        self.seen_kept += other.seen_kept;
        self.seen_culled += other.seen_culled;
        self.hidden_kept += other.hidden_kept;
        self.hidden_culled += other.hidden_culled;
    }
}

fn share(part: u64, rest: u64) -> Option<f64> {
    let whole = part + rest;
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// Of each light, whether a precut holds it. Nodes outside the tree hold none.
pub fn kept(tree: &LightTree, precut: &[u32]) -> Vec<bool> {
    let mut kept = vec![false; tree.leaves.len()];
    for &node in precut {
        let Some(size) = tree.nodes.get(node as usize).map(|n| n.size) else { continue };
        for below in &tree.nodes[node as usize..(node + size) as usize] {
            if below.is_leaf()
                && let Some(light) = kept.get_mut(below.light as usize)
            {
                *light = true;
            }
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_hidden_and_of_the_seen() {
        let pairs = [(true, true), (true, true), (true, false), (false, false), (false, true)];
        let mut counted = Agreement::of(pairs);
        assert_eq!(counted.false_hidden(), 1.0 / 3.0);
        assert_eq!((counted.tightness(), counted.false_visible()), (0.5, 0.5));
        counted += Agreement::of([(false, false); 2]);
        assert_eq!((counted.tightness(), counted.false_visible()), (0.75, 0.25));
        let nothing = Agreement::default();
        assert_eq!(
            (nothing.tightness(), nothing.false_hidden(), nothing.false_visible()),
            (1.0, 0.0, 0.0)
        );
    }
}
