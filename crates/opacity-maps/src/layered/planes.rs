//! Where the planes of an opacity shadow map lie.
//!
//! After Kim and Neumann, Opacity shadow maps, Rendering Techniques 2001, §3 (even, density-based
//! and growing slicing), as Voicu (2011) names them in §3.1.

use super::{
    boundaries::{Boundaries, geometric},
    placement::{Bounds, Placement},
};
use crate::{Fragment, Fragments, Opaque, Slicing, cpu};
use rayon::prelude::*;

/// Factor from gap to gap of [`Slicing::Growing`].
pub const GROWTH: f64 = 1.15;

/// Planes from the first to the last translucent fragment of the map; 0 and 1 where there is none.
/// `sorted` is used where opacities must be ordered, and keeps its room.
pub fn place(
    slicing: Slicing,
    layers: usize,
    fragments: &Fragments,
    opaque: Opaque,
    sorted: &mut Vec<Fragment>,
) -> Placement {
    let bounds = range(fragments, opaque);
    let (from, to) = (f64::from(bounds.first), f64::from(bounds.last));
    let uneven = match slicing {
        Slicing::Uniform => None,
        Slicing::Growing => Some(geometric(from, to, layers, GROWTH)),
        Slicing::Density => {
            sorted.clear();
            sorted.extend_from_slice(&fragments.items);
            if opaque.stretches_bounds() {
                sorted.extend(weights(fragments, opaque));
            }
            sorted.par_sort_unstable_by(|a, b| {
                a.depth.total_cmp(&b.depth).then(a.omega.total_cmp(&b.omega))
            });
            quantiles(sorted, layers)
        }
    };
    let uneven = uneven.filter(|_| to - from >= f64::from(super::placement::THINNEST));
    Placement::Planes { bounds, uneven: uneven.map(Boundaries) }
}

fn weights(fragments: &Fragments, opaque: Opaque) -> impl Iterator<Item = Fragment> + '_ {
    fragments.opaque.iter().filter_map(move |&depth| cpu::weighted(opaque, depth))
}

/// First and last fragment of the map; opaque ones where they stretch bounds or are alone.
fn range(fragments: &Fragments, opaque: Opaque) -> Bounds {
    let nothing = (f32::INFINITY, f32::NEG_INFINITY);
    let join = |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1));
    let chunks = fragments.items.par_chunks(1 << 16);
    let items = chunks
        .map(|chunk| chunk.iter().fold(nothing, |b, f| join(b, (f.depth, f.depth))))
        .reduce(|| nothing, join);
    let with_opaque = opaque.stretches_bounds() || fragments.items.is_empty();
    let (first, last) = if with_opaque {
        weights(fragments, opaque).fold(items, |b, f| join(b, (f.depth, f.depth)))
    } else {
        items
    };
    if first <= last { Bounds { first, last } } else { Bounds { first: 0.0, last: 1.0 } }
}

/// Planes at equal shares of all thickness; none where there is no thickness at all. A plane lies
/// at the fragment that reaches its share.
fn quantiles(sorted: &[Fragment], layers: usize) -> Option<Vec<f32>> {
    let total: f64 = sorted.iter().map(|f| f64::from(f.omega)).sum();
    let (first, last) = (sorted.first()?.depth, sorted.last()?.depth);
    if total <= 0.0 {
        return None;
    }
    let mut planes = vec![first];
    let mut sum = 0.0;
    for f in sorted {
        sum += f64::from(f.omega);
        while planes.len() < layers && sum * layers as f64 >= total * planes.len() as f64 {
            planes.push(f.depth);
        }
    }
    // Sums that round just below the total leave planes over.
    planes.resize(layers, last);
    planes.push(last);
    Some(planes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NO_OPAQUE;

    fn map(items: &[(f32, f32)], opaque: f32) -> Fragments {
        Fragments {
            width: 1,
            height: 1,
            starts: vec![0, items.len() as u32],
            items: items.iter().map(|&(depth, omega)| Fragment { depth, omega }).collect(),
            opaque: vec![opaque],
        }
    }

    fn planes(slicing: Slicing, layers: usize, fragments: &Fragments) -> Vec<f32> {
        let weight = Opaque::Weight { weight: 3.0, in_bounds: true };
        match place(slicing, layers, fragments, weight, &mut Vec::new()) {
            Placement::Planes { uneven: Some(Boundaries(planes)), .. } => planes,
            Placement::Planes { bounds, .. } => vec![bounds.first, bounds.last],
            other => unreachable!("{other:?}"),
        }
    }

    #[test]
    fn density_puts_equal_thickness_between_planes() {
        let items: Vec<(f32, f32)> =
            (0..1000).map(|i| ((i as f32 / 1000.0).powi(3), 0.01)).collect();
        let fragments = map(&items, NO_OPAQUE);
        let at = planes(Slicing::Density, 8, &fragments);
        assert_eq!(at.len(), 9);
        for k in 0..8 {
            let inside = items.iter().filter(|i| i.0 >= at[k] && i.0 < at[k + 1]).count();
            assert!(inside.abs_diff(125) <= 1, "layer {k}: {inside}");
        }
        // Even planes do not: the control.
        let even = items.iter().filter(|i| i.0 < 0.125).count();
        assert!(even > 400);
    }

    #[test]
    fn planes_span_the_map_and_never_run_backwards() {
        let items = [(0.3, 0.5), (0.2, 0.0), (0.9, 4.0), (0.3, 0.1)];
        for slicing in [Slicing::Uniform, Slicing::Density, Slicing::Growing] {
            for layers in [1, 2, 5, 33, 256] {
                let at = planes(slicing, layers, &map(&items, NO_OPAQUE));
                assert_eq!((at[0], at[at.len() - 1]), (0.2, 0.9), "{slicing:?}");
                assert!(at.windows(2).all(|w| w[0] <= w[1]));
                let empty = planes(slicing, layers, &map(&[], NO_OPAQUE));
                assert_eq!((empty[0], empty[empty.len() - 1]), (0.0, 1.0));
                let stretched = planes(slicing, layers, &map(&items, 0.95));
                assert_eq!(stretched[stretched.len() - 1], 0.95);
            }
        }
    }
}
