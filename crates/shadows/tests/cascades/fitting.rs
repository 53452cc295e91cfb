//! Regions: the overlap of slice and casters, no more than its square, and the margin.

use dapple_shadows::cascades::{Cascade, CascadeError, CasterBox, Fit, fit};
use proptest::prelude::*;

use crate::scene;

fn slice(least: [f64; 2], most: [f64; 2]) -> [[f64; 2]; 8] {
    let mut corners = [least; 8];
    for (i, corner) in corners.iter_mut().enumerate() {
        *corner = [[least, most][i % 2][0], [least, most][i / 2 % 2][1]];
    }
    corners
}

fn one(least: [f64; 2], most: [f64; 2], casters: &CasterBox, how: Fit) -> Cascade {
    fit(&[1.0, 2.0], &[slice(least, most)], casters, how).unwrap()[0]
}

const PLAIN: Fit = Fit { side: 64, margin_texels: 0 };

#[test]
fn a_full_box_is_the_whole_map_exactly() {
    let whole = one([0.0; 2], [1.0; 2], &CasterBox::WHOLE, PLAIN);
    assert_eq!(whole, Cascade::whole(1.0, 2.0));
    let beyond = one([-3.0, -1.0], [2.0, 9.0], &CasterBox::WHOLE, PLAIN);
    assert_eq!(beyond, whole);
    assert_eq!(whole.local([0.25, 0.75]), [0.25, 0.75]);
}

#[test]
fn a_region_by_hand() {
    let casters = CasterBox { least: [0.2, 0.2], most: [0.9, 0.9] };
    let got = one([0.1, 0.2], [0.5, 0.4], &casters, PLAIN);
    // The overlap is 0.3 x 0.2; v is widened by 0.05 either way.
    for (got, want) in [(got.scale, 0.3), (got.offset[0], 0.2), (got.offset[1], 0.15)] {
        assert!((got - want).abs() < 1e-15, "{got} {want}");
    }
    // 62 of 64 texels for the overlap.
    let wider = one([0.1, 0.2], [0.5, 0.4], &casters, Fit { side: 64, margin_texels: 1 });
    assert!((wider.scale - 0.3 * 64.0 / 62.0).abs() < 1e-15);
    let left = wider.local([0.2, 0.2])[0] * 64.0;
    assert!((left - 1.0).abs() < 1e-9, "{left}");
}

#[test]
fn slices_without_casters_stay_empty_and_touching_ones_do_not() {
    let casters = CasterBox { least: [0.5, 0.0], most: [1.0, 1.0] };
    let splits = [1.0, 2.0, 4.0, 8.0];
    let slices = [
        slice([0.0, 0.0], [0.4, 1.0]),
        slice([0.0, 0.0], [0.5, 1.0]),
        slice([0.0, 0.0], [0.6, 1.0]),
    ];
    let got = fit(&splits, &slices, &casters, PLAIN).unwrap();
    assert_eq!(got.iter().map(Cascade::is_empty).collect::<Vec<_>>(), [true, false, false]);
    assert_eq!(
        got.iter().map(|c| (c.near, c.far)).collect::<Vec<_>>(),
        [(1.0, 2.0), (2.0, 4.0), (4.0, 8.0)]
    );
}

#[test]
fn a_blade_edge_on_is_padded_to_a_texel() {
    let blade = CasterBox { least: [0.3, 0.3], most: [0.3, 0.3] };
    let got = one([0.0; 2], [1.0; 2], &blade, PLAIN);
    assert_eq!(got.scale, 1.0 / 64.0);
    let middle = got.local([0.3, 0.3]);
    assert!(middle.iter().all(|x| (x - 0.5).abs() < 1e-12), "{middle:?}");
}

#[test]
fn nearer_slices_get_finer_texels() {
    let cascades = scene::cascades(4, 0.5, 64, 1);
    assert!(cascades.windows(2).all(|pair| pair[0].scale < pair[1].scale), "{cascades:?}");
    // The control: one cascade has but one size.
    assert!(scene::cascades(1, 0.5, 64, 1)[0].scale > 4.0 * cascades[0].scale);
}

#[test]
fn bad_input_is_refused_by_name() {
    let whole = slice([0.0; 2], [1.0; 2]);
    let boxes = CasterBox::WHOLE;
    let refused = fit(&[1.0, 2.0], &[], &boxes, PLAIN);
    assert_eq!(refused, Err(CascadeError::Length { what: "slices", expected: 1, actual: 0 }));
    assert_eq!(fit(&[], &[], &boxes, PLAIN), Err(CascadeError::Count { count: 0 }));
    let mut broken = whole;
    broken[5][1] = f64::NAN;
    let refused = fit(&[1.0, 2.0, 3.0], &[whole, broken], &boxes, PLAIN);
    assert_eq!(refused, Err(CascadeError::Corner { slice: 1, corner: 5 }));
    for (least, most) in [([0.0; 2], [1.0, -0.1]), ([f64::NAN, 0.0], [1.0; 2])] {
        let refused = fit(&[1.0, 2.0], &[whole], &CasterBox { least, most }, PLAIN);
        assert!(matches!(refused, Err(CascadeError::Casters { .. })));
    }
    for (side, margin_texels) in [(0, 0), (4, 2), (1, u32::MAX)] {
        let refused = fit(&[1.0, 2.0], &[whole], &boxes, Fit { side, margin_texels });
        assert_eq!(refused, Err(CascadeError::Margin { margin_texels, side }));
    }
    let refused = fit(&[1.0, 1.0, 2.0], &[whole, whole], &boxes, PLAIN);
    assert!(matches!(refused, Err(CascadeError::Cascade { cascade: 0, .. })));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn regions_hold_the_overlap_and_no_more_than_its_square(
        slice_at in [-0.5..1.0f64, -0.5..1.0f64],
        slice_size in [0.01..1.5f64, 0.01..1.5f64],
        casters_at in [0.0..0.5f64, 0.0..0.5f64],
        casters_size in [0.01..0.5f64, 0.01..0.5f64],
        margin in 0..4u32,
    ) {
        let end = |at: [f64; 2], size: [f64; 2]| [at[0] + size[0], at[1] + size[1]];
        let casters = CasterBox { least: casters_at, most: end(casters_at, casters_size) };
        let how = Fit { side: 128, margin_texels: margin };
        let most = end(slice_at, slice_size);
        let got = one(slice_at, most, &casters, how);
        let low = [0, 1].map(|i| slice_at[i].max(casters.least[i]));
        let high = [0, 1].map(|i| most[i].min(casters.most[i]));
        let overlaps = low[0] <= high[0] && low[1] <= high[1];
        prop_assert_eq!(got.is_empty(), !overlaps);
        if overlaps {
            let (a, b) = (got.local(low), got.local(high));
            let kept = f64::from(margin) / 128.0;
            let inside = |x: f64| x > kept - 1e-9 && x < 1.0 - kept + 1e-9;
            prop_assert!(a.into_iter().chain(b).all(inside), "{:?} {:?}", a, b);
            // Tight along one axis at least, unless padded to a texel.
            let widest = (b[0] - a[0]).max(b[1] - a[1]);
            let padded = (high[0] - low[0]).max(high[1] - low[1]) < 1.0 / 128.0;
            prop_assert!(padded || (widest - (1.0 - 2.0 * kept)).abs() < 1e-9);
            // There and back.
            let back = got.base(a);
            prop_assert!((back[0] - low[0]).abs() < 1e-12 && (back[1] - low[1]).abs() < 1e-12);
        }
    }
}
