//! What a light meets in each texel.

use crate::OpacityError;
use bytemuck::{Pod, Zeroable};

/// Depth of an opaque map's texel that nothing opaque covers.
pub const NO_OPAQUE: f32 = 2.0;

/// How opacities add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Model {
    /// ω = -ln(1 - α), so that e^-Σω = Π(1 - α), as alpha blending has it; α is clamped to
    /// 1 - 2^-10.
    #[default]
    ExpTau,
    /// ω = α, the thesis's: e^-Σα.
    ExpAlpha,
}

impl Model {
    /// The largest opacity of which [`Model::ExpTau`] takes the logarithm.
    pub const MOST_OPACITY: f64 = 1.0 - 1.0 / 1024.0;

    /// Optical thickness ω >= 0 of one surface of opacity `alpha` (0..=1).
    pub fn omega(self, alpha: f64) -> f64 {
        match self {
            // ln_1p keeps the digits of a small opacity.
            Self::ExpTau => -(-alpha.clamp(0.0, Self::MOST_OPACITY)).ln_1p(),
            Self::ExpAlpha => alpha.clamp(0.0, 1.0),
        }
    }
}

/// One translucent surface on a light's way. 8 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Fragment {
    /// Linear light depth, 0 near plane, 1 far plane.
    pub depth: f32,
    /// Optical thickness, >= 0 (see [`Model::omega`]).
    pub omega: f32,
}

/// The fragments of a light's texel grid, through the texels' centres, row-major from the top.
///
/// Translucent surfaces lie in `items`, texel after texel, within a texel in the order they are
/// drawn; of the opaque ones only the nearest counts. Translucent fragments behind the nearest
/// opaque one are left out, as a depth test against the opaque map leaves them out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fragments {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height + 1` places in `items`; texel t has `items[starts[t]..starts[t + 1]]`.
    pub starts: Vec<u32>,
    /// Translucent fragments.
    pub items: Vec<Fragment>,
    /// Depth of the nearest opaque surface of each texel, [`NO_OPAQUE`] where there is none.
    pub opaque: Vec<f32>,
}

impl Fragments {
    /// The translucent fragments of a texel.
    pub fn texel(&self, texel: usize) -> &[Fragment] {
        &self.items[self.starts[texel] as usize..self.starts[texel + 1] as usize]
    }

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Checks sizes, order of `starts`, and every number.
    ///
    /// # Errors
    /// [`OpacityError`] naming the first bad element.
    pub fn check(&self) -> Result<(), OpacityError> {
        let (width, height) = (self.width, self.height);
        if width == 0 || height == 0 {
            return Err(OpacityError::EmptyMap { width, height });
        }
        let texels = self.texels();
        let lengths = [
            ("starts", texels + 1, self.starts.len()),
            ("opaque", texels, self.opaque.len()),
            ("items", self.starts.last().map_or(0, |&s| s as usize), self.items.len()),
        ];
        if let Some(&(what, expected, actual)) = lengths.iter().find(|(_, e, a)| e != a) {
            return Err(OpacityError::Length { what, expected, actual });
        }
        if let Some(texel) = self.starts.windows(2).position(|w| w[0] > w[1]) {
            return Err(OpacityError::Starts { texel });
        }
        let good = |f: &Fragment| f.depth.is_finite() && f.omega.is_finite() && f.omega >= 0.0;
        if let Some(fragment) = self.items.iter().position(|f| !good(f)) {
            let Fragment { depth, omega } = self.items[fragment];
            return Err(OpacityError::Fragment { fragment, depth, omega });
        }
        match self.opaque.iter().position(|z| !z.is_finite()) {
            Some(texel) => Err(OpacityError::OpaqueDepth { texel, depth: self.opaque[texel] }),
            None => Ok(()),
        }
    }

    /// The same with each texel's fragments by depth (ties keep their order).
    #[must_use]
    pub fn sorted(&self) -> Self {
        let mut out = self.clone();
        for texel in 0..self.texels() {
            let range = self.starts[texel] as usize..self.starts[texel + 1] as usize;
            out.items[range].sort_by(|a, b| a.depth.total_cmp(&b.depth));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn omega_is_exact_where_opacity_is_small_and_finite_where_it_is_one() {
        assert_eq!(Model::ExpTau.omega(0.0), 0.0);
        assert!((Model::ExpTau.omega(1e-12) - 1e-12).abs() < 1e-24);
        assert!((Model::ExpTau.omega(1.0) - 1024f64.ln()).abs() < 1e-12);
        assert!(((-Model::ExpTau.omega(0.69)).exp() - 0.31).abs() < 1e-15);
        assert_eq!(Model::ExpAlpha.omega(0.69), 0.69);
    }

    #[test]
    fn bad_fragments_are_named() {
        let one = Fragment { depth: 0.5, omega: 1.0 };
        let good = Fragments {
            width: 2,
            height: 1,
            starts: vec![0, 1, 2],
            items: vec![one; 2],
            opaque: vec![NO_OPAQUE; 2],
        };
        good.check().unwrap();
        let broken = |change: fn(&mut Fragments)| {
            let mut bad = good.clone();
            change(&mut bad);
            bad.check().unwrap_err().to_string()
        };
        assert!(broken(|f| f.width = 0).contains("0 x 1"));
        assert!(broken(|f| f.starts = vec![0, 2]).contains("starts"));
        assert!(broken(|f| f.starts = vec![0, 3, 2]).contains("texel 1"));
        assert!(broken(|f| f.items[1].depth = f32::NAN).contains("fragment 1"));
        assert!(broken(|f| f.items[0].omega = -1.0).contains("fragment 0"));
        assert!(broken(|f| f.opaque[1] = f32::INFINITY).contains("texel 1"));
    }
}
