//! Mutual information of neighbouring maps, from joint histograms.
//!
//! The thesis speaks of mutual information but measures correlation, which sees straight lines
//! alone. This is the quantity itself, I = Σ p(a, b) ln(p(a, b) / (p(a) p(b))), in nats.

/// Levels a value is sorted into.
pub const LEVELS: usize = 64;

/// Cells of a joint histogram.
pub(super) const CELLS: usize = LEVELS * LEVELS;

/// Level of a value in 0..=`most`.
pub(super) fn level(value: f32, most: f32) -> usize {
    // A cast of a negative number or NaN is 0.
    ((value / most * LEVELS as f32) as usize).min(LEVELS - 1)
}

/// Mutual information of a joint histogram of [`LEVELS`] rows and columns; 0 where it is empty.
pub fn mutual_information(joint: &[u32]) -> f64 {
    let total: f64 = joint.iter().map(|&n| f64::from(n)).sum();
    let (mut rows, mut columns) = ([0.0f64; LEVELS], [0.0f64; LEVELS]);
    for (cell, &n) in joint.iter().enumerate() {
        rows[cell / LEVELS % LEVELS] += f64::from(n);
        columns[cell % LEVELS] += f64::from(n);
    }
    let term = |(cell, &n): (usize, &u32)| {
        let n = f64::from(n);
        n / total * (n * total / (rows[cell / LEVELS % LEVELS] * columns[cell % LEVELS])).ln()
    };
    joint.iter().enumerate().filter(|(_, n)| **n > 0).map(term).sum::<f64>().max(0.0)
}
