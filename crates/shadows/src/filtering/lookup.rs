//! Which texels a receiver looks at, and with which depth it is compared.
//!
//! Everything here is f32 in every form, the reference included: a texel index and a comparison
//! are decisions, and forms that round differently before a decision cannot be held against each
//! other.

use super::{Lookup, Receiver, Settings};

/// Texels whose windows a receiver reads, and the share of the second ones.
///
/// The four are (x0, y0), (x1, y0), (x0, y1), (x1, y1); where `x0 == x1` the share is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Left texel.
    pub x0: u32,
    /// Right texel.
    pub x1: u32,
    /// Upper texel.
    pub y0: u32,
    /// Lower texel.
    pub y1: u32,
    /// Share of the right texel, 0..1.
    pub fx: f32,
    /// Share of the lower texel, 0..1.
    pub fy: f32,
}

impl Footprint {
    /// The footprint of a receiver that is in the map ([`Receiver::in_map`]).
    #[must_use]
    pub fn new(receiver: &Receiver, lookup: Lookup, width: u32, height: u32) -> Self {
        let (x0, x1, fx) = axis(receiver.u, lookup, width);
        let (y0, y1, fy) = axis(receiver.v, lookup, height);
        Self { x0, x1, y0, y1, fx, fy }
    }

    /// The four texels with their shares, which sum to 1.
    #[must_use]
    pub fn corners(&self) -> [((u32, u32), f32); 4] {
        let Self { x0, x1, y0, y1, fx, fy } = *self;
        [
            ((x0, y0), (1.0 - fx) * (1.0 - fy)),
            ((x1, y0), fx * (1.0 - fy)),
            ((x0, y1), (1.0 - fx) * fy),
            ((x1, y1), fx * fy),
        ]
    }
}

fn axis(coordinate: f32, lookup: Lookup, texels: u32) -> (u32, u32, f32) {
    let last = texels - 1;
    match lookup {
        // The cast floors what is not negative and u = 1 belongs to the last texel.
        Lookup::Nearest => {
            let texel = ((coordinate * texels as f32) as u32).min(last);
            (texel, texel, 0.0)
        }
        Lookup::Bilinear => {
            let place = coordinate * texels as f32 - 0.5;
            let floor = place.floor();
            if floor < 0.0 {
                (0, 0, 0.0)
            } else if floor as u32 >= last {
                (last, last, 0.0)
            } else {
                (floor as u32, floor as u32 + 1, place - floor)
            }
        }
    }
}

/// The depth that is compared: less the bias and, for pre-filtered maps with `plane_bias`, less
/// the plane's change over half a texel along both axes.
#[must_use]
pub fn biased_depth(receiver: &Receiver, s: &Settings, width: u32, height: u32) -> f32 {
    let z = receiver.z - s.bias;
    if s.plane_bias && s.prefiltered() {
        let (du, dv) = slopes(receiver);
        z - 0.5 * (du.abs() / width as f32 + dv.abs() / height as f32)
    } else {
        z
    }
}

/// The gradients, 0 where they are not finite.
#[must_use]
pub fn slopes(receiver: &Receiver) -> (f32, f32) {
    let finite = |slope: f32| if slope.is_finite() { slope } else { 0.0 };
    (finite(receiver.dz_du), finite(receiver.dz_dv))
}

#[cfg(test)]
mod tests {
    use super::super::{Estimator, Settings};
    use super::*;

    #[test]
    fn nearest_by_hand() {
        let at = |u| axis(u, Lookup::Nearest, 4).0;
        assert_eq!([at(0.0), at(0.24), at(0.25), at(0.999), at(1.0)], [0, 0, 1, 3, 3]);
    }

    #[test]
    fn bilinear_by_hand() {
        let at = |u| axis(u, Lookup::Bilinear, 4);
        assert_eq!(at(0.0), (0, 0, 0.0));
        assert_eq!(at(0.125), (0, 1, 0.0));
        assert_eq!(at(0.25), (0, 1, 0.5));
        assert_eq!(at(0.875), (3, 3, 0.0));
        assert_eq!(at(1.0), (3, 3, 0.0));
        assert_eq!(axis(0.5, Lookup::Bilinear, 1), (0, 0, 0.0));
    }

    #[test]
    fn plane_bias_is_half_a_texel_of_slope() {
        let mut s = Settings::new(Estimator::GaussianCdf);
        s.bias = 0.125;
        let r = Receiver::new(0.5, 0.5, 0.75).with_slope(-0.5, 2.0);
        assert_eq!(biased_depth(&r, &s, 4, 8), 0.625);
        s.plane_bias = true;
        assert_eq!(biased_depth(&r, &s, 4, 8), 0.625 - 0.5 * (0.125 + 0.25));
        s.estimator = Estimator::Hard;
        assert_eq!(biased_depth(&r, &s, 4, 8), 0.625);
        let r = r.with_slope(f32::NAN, f32::INFINITY);
        assert_eq!(slopes(&r), (0.0, 0.0));
    }
}
