//! Correlation of neighbouring maps, in one pass and in two.
//!
//! Based on: Voicu, Real-time volumetric shadows for dynamic rendering, MSc thesis, Imperial
//! College London, 2011, equation 5.2.3.1, section 5.2.4 and appendix 12.
//!
//! Deviations: the one-pass sums are taken about a point near the mean, so that they do not cancel;
//! bytes are summed in integers, so that nothing is rounded at all. Two constant maps have C = 1
//! (the second tells nothing new), a constant and a varying one C = 0 (neither tells of the other);
//! the thesis divides 0 by 0 there.

/// C of two series by its definition: means first, then deviations. Series of unequal length are
/// compared as far as the shorter goes.
pub fn two_pass(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len()).max(1) as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - mean_a, y - mean_b);
        ab += x * y;
        aa += x * x;
        bb += y * y;
    }
    let constant = |s: &[f64]| s.windows(2).all(|w| w[0] == w[1]);
    coefficient(ab, if constant(a) { 0.0 } else { aa }, if constant(b) { 0.0 } else { bb })
}

/// E1 / sqrt(E2 E3), with constants as said above.
pub(super) fn coefficient(ab: f64, aa: f64, bb: f64) -> f64 {
    match (aa > 0.0, bb > 0.0) {
        // Two roots: the product may overflow or vanish where they do not.
        (true, true) => (ab / (aa.sqrt() * bb.sqrt())).clamp(-1.0, 1.0),
        (false, false) => 1.0,
        _ => 0.0,
    }
}

/// Sums of one map and of its product with the next, about `shift`s near the means.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub n: f64,
    pub x: f64,
    pub xx: f64,
    pub y: f64,
    pub yy: f64,
    pub xy: f64,
}

impl Sums {
    /// The one-pass form.
    pub fn correlation(&self) -> f64 {
        let n = self.n.max(1.0);
        let about = |product: f64, p: f64, q: f64| product - p * q / n;
        coefficient(
            about(self.xy, self.x, self.y),
            about(self.xx, self.x, self.x),
            about(self.yy, self.y, self.y),
        )
    }
}

/// C of two series from one pass over both.
pub fn one_pass(a: &[f64], b: &[f64]) -> f64 {
    let (Some(&shift_a), Some(&shift_b)) = (a.first(), b.first()) else {
        return 1.0;
    };
    let mut sums = Sums { n: a.len().min(b.len()) as f64, ..Sums::default() };
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - shift_a, y - shift_b);
        sums.x += x;
        sums.y += y;
        sums.xx += x * x;
        sums.yy += y * y;
        sums.xy += x * y;
    }
    sums.correlation()
}

/// The one-pass form without a shift in 32-bit floats: a deliberate fault. Where the mean is large
/// beside the deviation, it subtracts two numbers that agree in all their digits.
pub fn one_pass_cancelling(a: &[f32], b: &[f32]) -> f32 {
    let n = a.len().min(b.len()) as f32;
    let mut sums = [0.0f32; 5];
    for (&x, &y) in a.iter().zip(b) {
        for (sum, term) in sums.iter_mut().zip([x, y, x * x, y * y, x * y]) {
            *sum += term;
        }
    }
    let [x, y, xx, yy, xy] = sums;
    (xy - x * y / n) / ((xx - x * x / n) * (yy - y * y / n)).sqrt()
}

/// Integer sums of bytes: the largest, 255² over 2^32 texels, is below 2^48.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ByteSums {
    pub n: u64,
    pub x: u64,
    pub xx: u64,
    pub y: u64,
    pub yy: u64,
    pub xy: u64,
}

impl ByteSums {
    /// n Σxy - Σx Σy and its like are integers, hence exact.
    pub fn correlation(&self) -> f64 {
        let about = |product: u64, p: u64, q: u64| {
            (i128::from(self.n) * i128::from(product) - i128::from(p) * i128::from(q)) as f64
        };
        coefficient(
            about(self.xy, self.x, self.y),
            about(self.xx, self.x, self.x),
            about(self.yy, self.y, self.y),
        )
    }
}

/// C of two maps of bytes, as appendix 12 has it (one loop, 8-bit values), in integers.
pub fn bytes(a: &[u8], b: &[u8]) -> f64 {
    let mut sums = ByteSums { n: a.len().min(b.len()) as u64, ..ByteSums::default() };
    for (&x, &y) in a.iter().zip(b) {
        let (x, y) = (u64::from(x), u64::from(y));
        sums.x += x;
        sums.y += y;
        sums.xx += x * x;
        sums.yy += y * y;
        sums.xy += x * y;
    }
    sums.correlation()
}
