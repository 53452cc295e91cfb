//! Based on: Marcel van Herk, "A fast algorithm for local minimum and maximum filters on
//! rectangular and octagonal kernels", Pattern Recognition Letters 13, 1992; Joseph Gil and
//! Michael Werman, "Computing 2-D min, median, and max filters", PAMI 15(5), 1993.
//!
//! Deviations: used for sums as well. The line is cut into blocks of the window's width; a window
//! is the tail of one block and the head of the next, each a running value from the cut. So a
//! texel costs two operations whatever the width, and because nothing is ever subtracted a sum
//! cannot drift: a window beside one that is e^80 times brighter keeps all its digits, which a
//! sum that slides by adding and subtracting would lose.
//!
//! Sixteen lines are filtered at a time, in f64.

use super::KernelShape;
use super::channels::Reduction;
use super::kernel::Kernel;

/// Lines filtered together.
pub const LANES: usize = 16;
/// One position of sixteen lines.
pub type Lanes = [f64; LANES];

/// Working memory for lines up to a given length, allocated once.
#[derive(Debug)]
pub struct Scratch {
    lines: Vec<Lanes>,
    tails: Vec<Lanes>,
}

impl Scratch {
    /// Room for lines of `length` with `radius` texels of border on either side.
    #[must_use]
    pub fn new(length: usize, radius: usize) -> Self {
        let padded = vec![[0.0; LANES]; length + 2 * radius];
        Self { lines: padded.clone(), tails: padded }
    }

    /// Places for the `length` texels of each line, without the border.
    pub fn inner(&mut self, length: usize, radius: usize) -> &mut [Lanes] {
        &mut self.lines[radius..radius + length]
    }

    /// Filters the lines laid into [`Scratch::inner`], the border repeating the end texels, and
    /// hands every result to `store` in order.
    ///
    /// For [`Reduction::LogMean`] the caller lays `exp(c x)` and takes the logarithm: the
    /// reduction is that of a mean.
    pub fn filter(
        &mut self,
        reduction: Reduction,
        kernel: &Kernel,
        length: usize,
        store: impl FnMut(usize, &Lanes),
    ) {
        let radius = kernel.radius();
        self.repeat_ends(length, radius);
        let (lines, tails) = (&self.lines[..length + 2 * radius], &mut self.tails[..]);
        match (reduction, kernel.shape()) {
            (Reduction::Min, _) => {
                blocks(lines, tails, kernel.support(), |a, b| if b < a { b } else { a }, store);
            }
            (Reduction::Max, _) => {
                blocks(lines, tails, kernel.support(), |a, b| if b > a { b } else { a }, store);
            }
            (Reduction::Mean | Reduction::LogMean, KernelShape::Box) => {
                let scale = 1.0 / kernel.support() as f64;
                let mut store = store;
                blocks(
                    lines,
                    tails,
                    kernel.support(),
                    |a, b| a + b,
                    |i, sum| {
                        store(i, &sum.map(|sum| sum * scale));
                    },
                );
            }
            (Reduction::Mean | Reduction::LogMean, KernelShape::Gaussian) => {
                weighted(lines, kernel.weights(), store);
            }
        }
    }

    fn repeat_ends(&mut self, length: usize, radius: usize) {
        let (first, last) = (self.lines[radius], self.lines[radius + length - 1]);
        self.lines[..radius].fill(first);
        self.lines[radius + length..radius + length + radius].fill(last);
    }
}

/// Reduces every window of `width` positions of `lines`.
fn blocks(
    lines: &[Lanes],
    tails: &mut [Lanes],
    width: usize,
    combine: impl Fn(f64, f64) -> f64,
    mut store: impl FnMut(usize, &Lanes),
) {
    let merge = |a: &Lanes, b: &Lanes| -> Lanes { std::array::from_fn(|l| combine(a[l], b[l])) };
    // tails[i]: from i to the end of its block.
    for (block, tails) in lines.chunks(width).zip(tails.chunks_mut(width)) {
        let mut running = block[block.len() - 1];
        tails[block.len() - 1] = running;
        for i in (0..block.len() - 1).rev() {
            running = merge(&block[i], &running);
            tails[i] = running;
        }
    }
    // head: from the start of the block to the window's last position.
    let mut head = lines[0];
    for (last, line) in lines.iter().enumerate() {
        head = if last.is_multiple_of(width) { *line } else { merge(&head, line) };
        if last + 1 >= width {
            let first = last + 1 - width;
            if first.is_multiple_of(width) {
                store(first, &head);
            } else {
                store(first, &merge(&tails[first], &head));
            }
        }
    }
}

/// Weighs every window; cost grows with the number of weights.
fn weighted(lines: &[Lanes], weights: &[f64], mut store: impl FnMut(usize, &Lanes)) {
    for (i, window) in lines.windows(weights.len()).enumerate() {
        let mut sum = [0.0; LANES];
        for (values, weight) in window.iter().zip(weights) {
            for (sum, value) in sum.iter_mut().zip(values) {
                *sum += weight * value;
            }
        }
        store(i, &sum);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(reduction: Reduction, kernel: &Kernel, line: &[f64]) -> Vec<f64> {
        let mut scratch = Scratch::new(line.len(), kernel.radius());
        for (slot, &x) in scratch.inner(line.len(), kernel.radius()).iter_mut().zip(line) {
            *slot = std::array::from_fn(|l| x + l as f64);
        }
        let mut out = vec![f64::NAN; line.len()];
        scratch.filter(reduction, kernel, line.len(), |i, lanes| {
            // Every lane on its own: sums of the same line plus 15.
            let slack = 1e-9 * lanes[0].abs().max(1.0);
            assert!((lanes[15] - lanes[0] - 15.0).abs() < slack);
            out[i] = lanes[0];
        });
        out
    }

    #[test]
    fn three_texels_by_hand() {
        let kernel = Kernel::new(KernelShape::Box, 3);
        let line = [1.0, 5.0, 3.0, 9.0];
        assert_eq!(run(Reduction::Min, &kernel, &line), [1.0, 1.0, 3.0, 3.0]);
        assert_eq!(run(Reduction::Max, &kernel, &line), [5.0, 5.0, 9.0, 9.0]);
        let mean = run(Reduction::Mean, &kernel, &line);
        for (mean, sum) in mean.iter().zip([7.0, 9.0, 17.0, 21.0]) {
            assert!((mean - sum / 3.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_sum_beside_a_huge_one_keeps_its_digits() {
        let mut line = vec![1.0; 64];
        line[20] = 80.0f64.exp();
        let mean = run(Reduction::Mean, &Kernel::new(KernelShape::Box, 5), &line);
        assert!((mean[10] - 1.0).abs() < 1e-12 && (mean[40] - 1.0).abs() < 1e-12);
        assert!(mean[20] > 1e33);
    }

    #[test]
    fn every_width_equals_the_plain_window() {
        let line: Vec<f64> = (0..23).map(|i| f64::from((i * 37 + 11) % 101) / 101.0).collect();
        for shape in [KernelShape::Box, KernelShape::Gaussian] {
            for width in (1..=31).chain([61, 101]).filter(|w| w % 2 == 1) {
                let kernel = Kernel::new(shape, width);
                let r = kernel.radius() as i64;
                let at = |i: i64| line[i.clamp(0, 22) as usize];
                for (reduction, start, fold) in [
                    (Reduction::Min, f64::INFINITY, f64::min as fn(f64, f64) -> f64),
                    (Reduction::Max, f64::NEG_INFINITY, f64::max),
                ] {
                    let out = run(reduction, &kernel, &line);
                    for x in 0..23 {
                        let plain = (x - r..=x + r).map(at).fold(start, fold);
                        assert_eq!(out[x as usize], plain, "{reduction:?} {width} at {x}");
                    }
                }
                let out = run(Reduction::Mean, &kernel, &line);
                for x in 0..23 {
                    let plain: f64 =
                        (-r..=r).map(|o| kernel.weights()[(o + r) as usize] * at(x + o)).sum();
                    assert!((out[x as usize] - plain).abs() < 1e-12, "{shape:?} {width} at {x}");
                }
            }
        }
    }
}
