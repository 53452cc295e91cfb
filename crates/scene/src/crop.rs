//! Spending a light's map on what matters: the crop of a clip-space rectangle, and a parallel view
//! focused on where casters and receivers overlap.
//!
//! Based on: C. Voicu, "Real-time volumetric shadows for dynamic rendering", MSc thesis, Imperial
//! College London, 2011, section 3 (light matrix and crop).
//! Deviations: the thesis speaks of a box that contains both casters and receivers; here it is their
//! overlap, as only there a shadow can fall. Depth is planar and taken from all eight corners.
//!
//! Convention: column vectors, so a crop stands leftmost, `crop * projection * view * point`. The
//! thesis writes row vectors: the transposed factors in the opposite order.

use crate::light_view::axes;
use crate::{Aabb, LightView, LightViewError};
use glam::{DMat4, DVec2, DVec3, DVec4};

/// No side of a crop is narrower than this share of the other: one texel of the thesis's map.
const NARROWEST: f64 = 1.0 / 512.0;

/// A rectangle of light clip space, where x = 2u - 1 and y = 2v - 1 lie in -1..=1 and y grows
/// downwards, like v. It is mapped to the whole of -1..=1 in both; depth stays as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crop {
    /// Lower corner.
    pub min: DVec2,
    /// Upper corner, above `min` in both.
    pub max: DVec2,
}

impl Crop {
    /// The whole of clip space: crops nothing.
    pub const FULL: Self = Self { min: DVec2::NEG_ONE, max: DVec2::ONE };

    /// The crop to a rectangle. A side shorter than a 512th of the other (a blade of grass seen
    /// edge-on), or than a 512th of clip space where both have no length, is widened to that about
    /// its middle.
    ///
    /// # Errors
    /// [`LightViewError::Rectangle`] for corners out of order or not finite.
    pub fn to(min: DVec2, max: DVec2) -> Result<Self, LightViewError> {
        let side = max - min;
        if !(side.is_finite() && side.min_element() >= 0.0) {
            return Err(LightViewError::Rectangle { min, max });
        }
        let largest = side.max_element();
        let least = NARROWEST * if largest > 0.0 { largest } else { 2.0 };
        // A corner far from the origin still moves by a step of its own.
        let grow = |side: f64, far: f64| {
            let step = 4.0 * f64::EPSILON * far;
            if side >= least { 0.0 } else { (0.5 * (least - side)).max(step) }
        };
        let far = min.abs().max(max.abs());
        let by = DVec2::new(grow(side.x, far.x), grow(side.y, far.y));
        Ok(Self { min: min - by, max: max + by })
    }

    /// What clip coordinates are multiplied with: 2 / (max - min).
    pub fn scale(&self) -> DVec2 {
        2.0 / (self.max - self.min)
    }

    /// What is added after that: -(max + min) / (max - min).
    pub fn shift(&self) -> DVec2 {
        -(self.max + self.min) / (self.max - self.min)
    }

    /// A point of clip space in the cropped space: `scale * point + shift`, but exact at the
    /// rectangle's corners, which become -1 and 1.
    pub fn apply(&self, point: DVec2) -> DVec2 {
        ((point - self.min) - (self.max - point)) / (self.max - self.min)
    }

    /// The crop as a matrix for column vectors.
    pub fn matrix(&self) -> DMat4 {
        let (scale, shift) = (self.scale(), self.shift());
        DMat4::from_cols(
            DVec4::X * scale.x,
            DVec4::Y * scale.y,
            DVec4::Z,
            DVec4::new(shift.x, shift.y, 0.0, 1.0),
        )
    }
}

/// A box along three axes: (u, v, depth), metres from the world's origin.
fn along(axes: [DVec3; 3], bounds: &Aabb) -> Aabb {
    let corners = bounds.corners().map(|p| DVec3::from_array(axes.map(|axis| axis.dot(p))));
    corners.into_iter().fold(Aabb::EMPTY, Aabb::grow)
}

impl LightView {
    /// The rectangle of clip space (x = 2u - 1, y = 2v - 1) that holds a box: what a crop to that
    /// box crops to. For parallel light; the box must not be empty.
    pub fn clip_rectangle(&self, bounds: &Aabb) -> (DVec2, DVec2) {
        let corners = bounds.corners().map(|p| 2.0 * self.project(p).truncate() - 1.0);
        let first = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        corners.into_iter().fold(first, |(low, high), p| (low.min(p), high.max(p)))
    }

    /// A square parallel view along `direction`, cropped to where the boxes of casters and
    /// receivers overlap as seen by the light: the rectangle's larger side fills the map but for a
    /// margin of a 512th, its texels stay square. Where they do not overlap, or one box is empty,
    /// the view holds both. Depth begins at the casters and ends behind both, with a margin of 1 %
    /// of the range at each end: a receiver in front of all casters has a depth below 0, and no
    /// shadow.
    ///
    /// # Errors
    /// [`LightViewError::Direction`] without a usable direction, [`LightViewError::EmptyBounds`]
    /// where both boxes are empty.
    pub fn focused(
        direction: DVec3,
        casters: &Aabb,
        receivers: &Aabb,
    ) -> Result<Self, LightViewError> {
        let (right, down, forward) = axes(direction)?;
        let axes = [right, down, forward];
        let boxes = [casters, receivers].into_iter().filter(|b| !b.is_empty());
        let boxes: Vec<Aabb> = boxes.map(|b| along(axes, b)).collect();
        let Some(first) = boxes.first() else { return Err(LightViewError::EmptyBounds) };
        let union = boxes.iter().fold(Aabb::EMPTY, |all, b| all.grow(b.min).grow(b.max));
        let whole = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        let overlap = boxes
            .iter()
            .fold(whole, |all, b| Aabb { min: all.min.max(b.min), max: all.max.min(b.max) });
        let meet = overlap.min.x <= overlap.max.x && overlap.min.y <= overlap.max.y;
        let focus = if meet { overlap } else { union };
        let size = focus.max - focus.min;
        // A scene without width or depth still needs a positive range, one that tells its ends apart.
        let far_out = union.min.abs().max(union.max.abs()).max_element();
        let least = (1e-3 * union.radius()).max(1e-9 * far_out).max(f64::MIN_POSITIVE);
        let half_extent = (0.5 * size.x.max(size.y) * (1.0 + NARROWEST)).max(least);
        let (near, far) = (first.min.z, union.max.z);
        let margin = (0.01 * (far - near)).max(least);
        let centre = focus.centre();
        Ok(Self {
            origin: right * centre.x + down * centre.y + forward * (near - margin),
            right,
            down,
            forward,
            half_extent,
            near_m: 0.0,
            far_m: far - near + 2.0 * margin,
            perspective: false,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cuboid(min: [f64; 3], max: [f64; 3]) -> Aabb {
        Aabb { min: min.into(), max: max.into() }
    }

    #[test]
    fn crops_that_are_no_rectangle_are_refused() {
        for (min, max) in [
            (DVec2::ONE, DVec2::ZERO),
            (DVec2::new(0.0, 1.0), DVec2::new(1.0, 0.0)),
            (DVec2::NAN, DVec2::ONE),
            (DVec2::ZERO, DVec2::INFINITY),
        ] {
            let error = Crop::to(min, max).unwrap_err();
            assert!(error.to_string().contains("must be finite"), "{error}");
        }
    }

    #[test]
    fn the_full_box_is_left_as_it_is() {
        let full = Crop::to(DVec2::NEG_ONE, DVec2::ONE).unwrap();
        assert_eq!(full, Crop::FULL);
        assert_eq!((full.scale(), full.shift()), (DVec2::ONE, DVec2::ZERO));
        assert_eq!(full.matrix(), DMat4::IDENTITY);
        for p in [DVec2::new(0.25, -0.75), DVec2::new(-3.0, 0.0)] {
            assert_eq!(full.apply(p), p);
        }
    }

    #[test]
    fn a_side_without_length_is_widened_to_a_512th_of_the_other() {
        let crop = Crop::to(DVec2::new(0.25, -0.5), DVec2::new(0.25, 0.5)).unwrap();
        assert_eq!(crop.max - crop.min, DVec2::new(1.0 / 512.0, 1.0));
        assert_eq!(0.5 * (crop.max + crop.min), DVec2::new(0.25, 0.0));
        let point = Crop::to(DVec2::ZERO, DVec2::ZERO).unwrap();
        assert_eq!(point.max - point.min, DVec2::splat(2.0 / 512.0));
        // A wide enough side stays.
        let kept = Crop::to(DVec2::ZERO, DVec2::new(1.0, 0.01)).unwrap();
        assert_eq!(kept.max, DVec2::new(1.0, 0.01));
        let far = Crop::to(DVec2::splat(1e18), DVec2::splat(1e18)).unwrap();
        assert!(far.scale().is_finite() && far.apply(DVec2::splat(1e18)).is_finite());
    }

    fn config() -> ProptestConfig {
        let cases = std::env::var("PROPTEST_CASES").ok().and_then(|c| c.parse().ok());
        ProptestConfig::with_cases(cases.unwrap_or(64))
    }

    proptest! {
        #![proptest_config(config())]
        #[test]
        fn the_rectangles_corners_become_those_of_clip_space_exactly(
            x in -50.0..50.0f64, y in -50.0..50.0f64, w in 0.0..20.0f64, h in 0.0..20.0f64,
        ) {
            let crop = Crop::to(DVec2::new(x, y), DVec2::new(x + w, y + h)).unwrap();
            prop_assert_eq!(crop.apply(crop.min), DVec2::NEG_ONE);
            prop_assert_eq!(crop.apply(crop.max), DVec2::ONE);
            // Scale, shift and matrix are the same map, to rounding.
            let p = DVec2::new(x + 0.3 * w, y + 0.8 * h);
            let by_parts = crop.scale() * p + crop.shift();
            let by_matrix = crop.matrix() * p.extend(0.3).extend(1.0);
            let bound = 1e-12 * (1.0 + crop.shift().abs().max_element());
            prop_assert!(crop.apply(p).distance(by_parts) <= bound);
            prop_assert!(by_matrix.truncate().truncate().distance(by_parts) <= bound);
            prop_assert_eq!((by_matrix.z, by_matrix.w), (0.3, 1.0));
        }

        #[test]
        fn a_focused_view_holds_the_overlap_and_all_depths_of_casters(
            x in -1.0..1.0f64, y in -1.0..1.0f64, z in -1.0..1.0f64, at in -3.0..3.0f64,
        ) {
            let direction = DVec3::new(x, y, z);
            prop_assume!(direction.length() > 0.1);
            let casters = cuboid([-1.0, 2.0, -1.0], [1.0, 4.0, 1.0]);
            let receivers = cuboid([at - 2.0, 0.0, -2.0], [at + 2.0, 0.0, 2.0]);
            let view = LightView::focused(direction, &casters, &receivers).unwrap();
            for p in casters.corners() {
                let z = view.project(p).z;
                prop_assert!(z > 0.0 && z < 1.0, "{}", z);
            }
            for p in receivers.corners() {
                prop_assert!(view.project(p).z < 1.0);
            }
            // A point in both rectangles is on the map; a union holds everything.
            let (low, high) = view.clip_rectangle(&casters);
            let (least, most) = view.clip_rectangle(&receivers);
            let (low, high) = (low.max(least), high.min(most));
            if low.cmple(high).all() {
                prop_assert!(low.min_element() > -1.0 && high.max_element() < 1.0);
                let filled = 0.5 * (high - low).max_element();
                prop_assert!((filled - 512.0 / 513.0).abs() < 1e-9, "fills {}", filled);
            } else {
                for p in casters.corners().into_iter().chain(receivers.corners()) {
                    let q = view.project(p);
                    prop_assert!(q.x > 0.0 && q.x < 1.0 && q.y > 0.0 && q.y < 1.0, "{}", q);
                }
            }
        }
    }

    #[test]
    fn the_smaller_of_casters_and_receivers_decides() {
        let small = cuboid([-1.0, 3.0, -0.5], [1.0, 4.0, 0.5]);
        let wide = cuboid([-8.0, 0.0, -8.0], [8.0, 0.0, 8.0]);
        let focused = |c, r| LightView::focused(DVec3::NEG_Y, c, r).unwrap();
        let grass = focused(&small, &wide);
        assert!((grass.half_extent - 513.0 / 512.0).abs() < 1e-12);
        // From the casters' top at y = 4 to the ground, 1 % more at each end.
        assert!((grass.far_m - 4.0 * 1.02).abs() < 1e-12, "{}", grass.far_m);
        assert!((grass.project(DVec3::Y * 4.0).z - 0.01 / 1.02).abs() < 1e-12);
        // The other way round nothing is in front of the casters.
        let canopy = focused(&wide, &small);
        assert!((canopy.half_extent - 513.0 / 512.0).abs() < 1e-12);
        assert!(canopy.project(DVec3::Y * 4.0).z < 0.0);
    }

    #[test]
    fn boxes_apart_empty_or_without_extent_give_a_usable_view() {
        let (left, right) =
            (cuboid([-5.0, 1.0, 0.0], [-4.0, 2.0, 1.0]), cuboid([4.0, 0.0, 0.0], [5.0, 0.0, 1.0]));
        let apart = LightView::focused(DVec3::NEG_Y, &left, &right).unwrap();
        assert!((apart.half_extent - 5.0 * 513.0 / 512.0).abs() < 1e-12);
        let one = LightView::focused(DVec3::NEG_Y, &Aabb::EMPTY, &right).unwrap();
        assert!((one.half_extent - 0.5 * 513.0 / 512.0).abs() < 1e-12 && one.far_m > 0.0);
        let none = LightView::focused(DVec3::NEG_Y, &Aabb::EMPTY, &Aabb::EMPTY);
        assert_eq!(none, Err(LightViewError::EmptyBounds));
        let nowhere = LightView::focused(DVec3::ZERO, &left, &right);
        assert_eq!(nowhere, Err(LightViewError::Direction(DVec3::ZERO)));
        // One blade edge-on, one point, along every axis.
        for direction in [DVec3::X, DVec3::Y, DVec3::NEG_Y, DVec3::Z] {
            for flat in
                [cuboid([0.0, 0.0, 0.0], [1.0, 1.0, 0.0]), cuboid([2.0, 2.0, 2.0], [2.0, 2.0, 2.0])]
            {
                let view = LightView::focused(direction, &flat, &flat).unwrap();
                let p = view.project(flat.centre());
                assert!(view.half_extent > 0.0 && view.far_m > 0.0);
                assert!(p.distance(DVec3::splat(0.5)) < 1e-6, "{p}");
            }
        }
    }

    /// Share of a 64 x 64 map's texel centres that a plate covers, cropped or not.
    fn coverage(view: &LightView, crop: &Crop, plate: [DVec3; 4]) -> usize {
        let [a, b, _, d] = plate.map(|p| crop.apply(2.0 * view.project(p).truncate() - 1.0));
        let (ab, ad) = (b - a, d - a);
        let centre = |i: usize| (i as f64 + 0.5) / 32.0 - 1.0;
        let inside = |p: DVec2| {
            let (s, t) = (p.perp_dot(ad) / ab.perp_dot(ad), ab.perp_dot(p) / ab.perp_dot(ad));
            (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t)
        };
        let texels = (0..64 * 64).map(|i| DVec2::new(centre(i % 64), centre(i / 64)));
        texels.filter(|&p| inside(p - a)).count()
    }

    #[test]
    fn a_crop_undoes_a_wider_light_and_without_it_coverage_falls() {
        let at = |x: f64, z: f64| DVec3::new(0.7 + 3.0 * x, 1.0, 3.0 * z - 0.4);
        let plate = [at(0.0, 0.31), at(0.23, 0.0), at(1.0, 0.69), at(0.77, 1.0)];
        let bounds = plate.into_iter().fold(Aabb::EMPTY, Aabb::grow);
        let fitted = LightView::fit_directional(DVec3::NEG_Y, &bounds).unwrap();
        let shares = [10.0, 20.0].map(|half_extent| {
            let view = LightView { half_extent, ..fitted };
            let (min, max) = view.clip_rectangle(&bounds);
            let crop = Crop::to(min, max).unwrap();
            [Crop::FULL, crop].map(|c| coverage(&view, &c, plate))
        });
        let [[near, near_cropped], [far, far_cropped]] = shares;
        assert!(far > 0 && near > 3 * far && near < 5 * far, "{near} then {far}");
        assert_eq!(near_cropped, far_cropped);
        // Of its box the plate takes 0.23 * 0.69 + 0.31 * 0.77 = 0.3974, by hand.
        assert!(near_cropped.abs_diff(1628) <= 32, "{near_cropped}");
    }
}
