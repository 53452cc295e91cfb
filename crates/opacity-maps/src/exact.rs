//! The uncompressed deep shadow map: every fragment of a texel, sorted, with the sum in front of it.
//!
//! Lokovic and Veach, *Deep Shadow Maps*, SIGGRAPH 2000, section 3, without the compression: the
//! truth of what any technique on the same texel grid tries to say.

use crate::{Fragments, Model, NO_OPAQUE};
use rayon::prelude::*;

/// Sorted fragments with running sums, `f64`.
#[derive(Clone, Debug)]
pub struct Exact {
    starts: Vec<u32>,
    depths: Vec<f32>,
    /// Thickness of a texel's fragments up to and including this one.
    sums: Vec<f64>,
}

impl Exact {
    /// Sorts a copy of the fragments, texel by texel, in parallel.
    pub fn of(fragments: &Fragments) -> Self {
        let sorted = fragments.sorted();
        let mut sums = vec![0.0; sorted.items.len()];
        let mut rest = sums.as_mut_slice();
        let mut parts = Vec::with_capacity(sorted.texels());
        for texel in 0..sorted.texels() {
            let (part, after) = rest.split_at_mut(sorted.texel(texel).len());
            parts.push(part);
            rest = after;
        }
        parts.into_par_iter().enumerate().for_each(|(texel, part)| {
            let mut sum = 0.0;
            for (slot, fragment) in part.iter_mut().zip(sorted.texel(texel)) {
                sum += f64::from(fragment.omega);
                *slot = sum;
            }
        });
        let depths = sorted.items.iter().map(|f| f.depth).collect();
        Self { starts: sorted.starts, depths, sums }
    }

    /// Thickness strictly in front of `depth`: equal depths do not shadow each other.
    pub fn omega(&self, texel: usize, depth: f32) -> f64 {
        let (first, last) = self.range(texel);
        let before = self.depths[first..last].partition_point(|&d| d < depth);
        if before == 0 { 0.0 } else { self.sums[first + before - 1] }
    }

    /// Transmittance just before `depth`.
    pub fn transmittance(&self, texel: usize, depth: f32) -> f64 {
        (-self.omega(texel, depth)).exp()
    }

    /// Nearest and farthest fragment of a texel, `None` without any.
    pub fn ends(&self, texel: usize) -> Option<(f32, f32)> {
        let (first, last) = self.range(texel);
        (first < last).then(|| (self.depths[first], self.depths[last - 1]))
    }

    /// The depth range that holds every texel's own: how deep layers that start at a texel's first
    /// fragment must reach.
    pub fn deepest_span(&self) -> f32 {
        let spans = (0..self.starts.len().saturating_sub(1)).filter_map(|t| self.ends(t));
        spans.map(|(near, far)| far - near).fold(0.0, f32::max)
    }

    fn range(&self, texel: usize) -> (usize, usize) {
        (self.starts[texel] as usize, self.starts[texel + 1] as usize)
    }
}

/// Fragments from surfaces as they come: all of a texel, in the order drawn, by depth, opacity and
/// whether opaque. Those behind the texel's nearest opaque one are left out.
pub fn collect(
    width: u32,
    height: u32,
    starts: &[u32],
    model: Model,
    surface: impl Fn(usize) -> (f32, f32, bool),
) -> Fragments {
    let texels = width as usize * height as usize;
    let mut out = Fragments {
        width,
        height,
        starts: Vec::with_capacity(texels + 1),
        items: Vec::new(),
        opaque: vec![NO_OPAQUE; texels],
    };
    out.starts.push(0);
    for texel in 0..texels {
        let range = starts[texel] as usize..starts[texel + 1] as usize;
        let opaque = range.clone().map(&surface).filter(|s| s.2).map(|s| s.0);
        let nearest = opaque.fold(NO_OPAQUE, f32::min);
        out.opaque[texel] = nearest;
        let translucent = range.map(&surface).filter(|s| !s.2 && s.0 < nearest);
        out.items.extend(translucent.map(|(depth, alpha, _)| crate::Fragment {
            depth,
            omega: model.omega(f64::from(alpha)) as f32,
        }));
        out.starts.push(out.items.len() as u32);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fragment, reference};

    #[test]
    fn sums_are_those_strictly_in_front_and_ties_do_not_shadow_each_other() {
        let f = |depth, omega| Fragment { depth, omega };
        let items = vec![f(0.5, 1.0), f(0.2, 0.25), f(0.5, 0.5), f(0.9, 2.0)];
        let opaque = vec![NO_OPAQUE; 2];
        let fragments = Fragments { width: 2, height: 1, starts: vec![0, 4, 4], items, opaque };
        let exact = Exact::of(&fragments);
        for (depth, omega) in
            [(0.1, 0.0), (0.2, 0.0), (0.3, 0.25), (0.5, 0.25), (0.6, 1.75), (1.0, 3.75)]
        {
            assert_eq!(exact.omega(0, depth), omega, "{depth}");
            let slow = reference::exact(fragments.texel(0), depth);
            assert!((exact.transmittance(0, depth) - slow).abs() < 1e-15);
        }
        assert_eq!(exact.omega(1, 1.0), 0.0);
        assert_eq!((exact.ends(0), exact.ends(1)), (Some((0.2, 0.9)), None));
        assert!((exact.deepest_span() - 0.7).abs() < 1e-6);
    }

    #[test]
    fn what_lies_behind_an_opaque_surface_is_left_out() {
        let surfaces = [(0.3, 0.5, false), (0.6, 1.0, true), (0.7, 0.5, false), (0.4, 1.0, true)];
        let fragments = collect(1, 1, &[0, 4], Model::ExpAlpha, |i| surfaces[i]);
        fragments.check().unwrap();
        assert_eq!(fragments.opaque, [0.4]);
        assert_eq!(fragments.items, [Fragment { depth: 0.3, omega: 0.5 }]);
    }
}
