//! Whether shadows hide a projection.

use super::forest::{Forest, Group, LEVEL, Node};
use super::{Projection, Umbra, Verdict};

/// Whether a shadow and a projection have a point in common; borders belong to both. The shadow is
/// taken to be as high everywhere as its highest point.
pub(super) fn overlaps(shadow: &Umbra, p: &Projection) -> bool {
    let beside = p.u[0] <= shadow.u[1] && shadow.u[0] <= p.u[1];
    beside && p.h[0] <= shadow.highest() && shadow.foot <= p.h[1]
}

impl Forest {
    pub fn test(&self, p: &Projection, compared: &mut u64) -> Verdict {
        let mut verdict = Verdict::Free;
        let first = self.groups.partition_point(|group| group.u[1] < p.u[0]);
        for group in &self.groups[first..] {
            if group.u[0] > p.u[1] {
                break;
            }
            // What reaches beyond one group lies in no shadow of any.
            let within = group.u[0] <= p.u[0] && p.u[1] <= group.u[1];
            if verdict == Verdict::Partial && !within {
                break;
            }
            match self.test_group(group, p, compared) {
                Verdict::Hidden => return Verdict::Hidden,
                Verdict::Partial => verdict = Verdict::Partial,
                Verdict::Free => {}
            }
        }
        verdict
    }

    fn test_group(&self, group: &Group, p: &Projection, compared: &mut u64) -> Verdict {
        let mut partial = false;
        let mut at = group.start;
        while at < group.end {
            let node = &self.nodes[at as usize];
            *compared += 1;
            let [left, right] = node.u;
            if p.h[0] > node.highest || p.u[0] > right || p.u[1] < left {
                at += node.size;
                continue;
            }
            let within = left <= p.u[0] && p.u[1] <= right && p.h[1] <= node.highest;
            if within && self.hides(node, p) {
                return Verdict::Hidden;
            }
            let crest = if node.edge == LEVEL { node.top } else { node.highest };
            partial |= p.h[0] <= crest && node.foot <= p.h[1];
            at += if partial && !within { node.size } else { 1 };
        }
        if partial { Verdict::Partial } else { Verdict::Free }
    }

    /// Of a projection between its ends.
    fn hides(&self, node: &Node, p: &Projection) -> bool {
        match self.edges.get(node.edge as usize) {
            None => node.foot <= p.h[0] && p.h[1] <= node.top,
            Some(edge) => edge.hides(p),
        }
    }
}
