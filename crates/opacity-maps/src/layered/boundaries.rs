//! Layer boundaries that no formula gives at once: planes of unequal distance, growing layers.

/// Rising depths d_0 ..= d_K; layer k lies between d_k and d_(k + 1).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boundaries(pub Vec<f32>);

impl Boundaries {
    /// Layer coordinate of a depth: the layer it lies in plus its share of that layer, 0..=K. A
    /// boundary belongs to the layer behind it; layers of no depth are stepped over.
    #[inline]
    pub fn coordinate(&self, depth: f32) -> f32 {
        let layers = self.0.len().saturating_sub(1);
        let behind = self.0.partition_point(|&d| d <= depth);
        if behind == 0 || layers == 0 {
            return 0.0;
        }
        if behind > layers {
            return layers as f32;
        }
        let (from, to) = (self.0[behind - 1], self.0[behind]);
        (behind - 1) as f32 + (depth - from) / (to - from)
    }

    /// The same in `f64`, between the same boundaries.
    pub fn coordinate_f64(&self, depth: f64) -> f64 {
        let last = self.0.len().saturating_sub(1);
        let mut coordinate = 0.0;
        for (k, pair) in self.0.windows(2).enumerate() {
            let (from, to) = (f64::from(pair[0]), f64::from(pair[1]));
            if depth >= to {
                coordinate = (k + 1) as f64;
            } else if depth >= from {
                coordinate = k as f64 + (depth - from) / (to - from);
            }
        }
        f64::min(coordinate, last as f64)
    }
}

/// Boundaries from `from` to `to`, each gap `growth` >= 1 times the one before.
pub fn geometric(from: f64, to: f64, layers: usize, growth: f64) -> Vec<f32> {
    let share = |k: usize| {
        if growth == 1.0 {
            return k as f64 / layers as f64;
        }
        // exp_m1 keeps the digits where growth is near 1.
        let log = growth.ln();
        (k as f64 * log).exp_m1() / (layers as f64 * log).exp_m1()
    };
    (0..=layers)
        .map(|k| if k == layers { to } else { from + (to - from) * share(k) } as f32)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_count_layers_and_step_over_empty_ones() {
        let boundaries = Boundaries(vec![0.0, 1.0, 1.0, 3.0]);
        for (depth, expected) in
            [(-1.0, 0.0), (0.0, 0.0), (0.5, 0.5), (1.0, 2.0), (2.0, 2.5), (3.0, 3.0), (9.0, 3.0)]
        {
            assert_eq!(boundaries.coordinate(depth), expected, "{depth}");
            assert_eq!(boundaries.coordinate_f64(f64::from(depth)), f64::from(expected), "{depth}");
        }
        assert_eq!(Boundaries(vec![]).coordinate(0.5), 0.0);
        assert_eq!(Boundaries(vec![0.5; 4]).coordinate(0.5), 3.0);
        assert_eq!(boundaries.coordinate(f32::NAN), 0.0);
    }

    #[test]
    fn gaps_grow_by_their_factor() {
        for (layers, growth) in [(1, 2.0), (4, 1.0), (7, 1.15), (16, 1.5), (5, 4.0)] {
            let at = geometric(0.2, 0.8, layers, growth);
            assert_eq!((at[0], at[layers]), (0.2, 0.8));
            for w in at.windows(3) {
                let ratio = f64::from((w[2] - w[1]) / (w[1] - w[0]));
                assert!((ratio - growth).abs() < 2e-2 * growth, "{layers} {growth}: {ratio}");
            }
        }
        // Layers thinner than the depths' digits collapse, and stay in order.
        let at = geometric(0.0, 10.0, 256, 4.0);
        assert!(at.windows(2).all(|w| w[0] <= w[1]) && at[256] == 10.0);
    }
}
