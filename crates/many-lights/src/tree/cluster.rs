//! Likeness of lights, for trees that join what is most alike.
//!
//! Based on: B. Walter et al., "Lightcuts: a scalable approach to illumination", 2005, section 3,
//! Eq. 2.2 of Melino Conte, "Real-time Rendering of Cities at Night", 2018:
//! `I (α² + c² (1 - cos β)²)`, α the diagonal of the box, β half the opening of the cone of axes, c
//! the diagonal of the scene.
//! Deviations: cones of joined clusters are the smallest that hold both cones, not all axes, so that a
//! join costs the same however many lights there are (nodes have exact ones). c is the diagonal of the
//! box of the lights of a kind, and 0 for omni lights and for parallel ones, which are places on the
//! sphere of axes.

use super::median::place_of;
use crate::{Light, light::Emission};
use glam::DVec3;

/// What the metric has to know of a cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cluster {
    pub min: DVec3,
    pub max: DVec3,
    /// Summed luminance.
    pub intensity: f64,
    /// Of the cone of axes, unit length.
    pub axis: DVec3,
    /// Cosine and sine of half of the cone's half opening, β / 2 in 0..=π/2: angles are added without
    /// inverse functions.
    pub half: [f64; 2],
}

impl Cluster {
    pub fn of(light: &Light) -> Self {
        let at = place_of(light);
        // 0 is added so that no -0 remains: its bits would be out of order.
        let intensity = light.luminance() + 0.0;
        let axis = light.axis.normalize_or(DVec3::Y);
        Self { min: at, max: at, intensity, axis, half: [1.0, 0.0] }
    }

    /// Cosine of β.
    pub fn cosine(&self) -> f64 {
        let [cosine, sine] = self.half;
        cosine * cosine - sine * sine
    }

    /// Twice the middle of the box.
    pub fn middle(&self) -> DVec3 {
        self.min + self.max
    }

    /// Both together.
    pub fn joined(&self, other: &Self) -> Self {
        let (axis, half) = self.cone(other);
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            intensity: self.intensity + other.intensity,
            axis,
            half,
        }
    }

    /// The smallest cone that holds both.
    fn cone(&self, other: &Self) -> (DVec3, [f64; 2]) {
        let [a, b] = [self, other].map(|c| c.half[1].atan2(c.half[0]));
        let between = between(self.axis, other.axis);
        let apart = between[1].atan2(between[0]);
        // Quarters of openings: each angle here is half of what it stands for.
        let half = 0.5 * (a + b + apart);
        if half <= a {
            return (self.axis, self.half);
        }
        if half <= b {
            return (other.axis, other.half);
        }
        if half >= 0.5 * std::f64::consts::PI {
            return (self.axis, [0.0, 1.0]);
        }
        // From the first axis towards the second until the first cone just touches.
        let towards = (other.axis - self.axis * self.axis.dot(other.axis))
            .try_normalize()
            .unwrap_or_else(|| self.axis.any_orthonormal_vector());
        let (sine, cosine) = (2.0 * (half - a)).sin_cos();
        let axis = (self.axis * cosine + towards * sine).normalize_or(self.axis);
        let (sine, cosine) = half.sin_cos();
        (axis, [cosine, sine])
    }
}

/// Cosine and sine of half the angle between unit vectors, by their sum and difference: exact for
/// small angles and for nearly opposite vectors alike.
fn between(a: DVec3, b: DVec3) -> [f64; 2] {
    [0.5 * (a + b).length(), 0.5 * (a - b).length()]
}

/// What joining costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Metric {
    /// c².
    pub c_squared: f64,
}

impl Metric {
    /// The metric of lights of one kind; `spread` scales c.
    pub fn of(clusters: &[Cluster], kind: Emission, spread: f64) -> Self {
        if matches!(kind, Emission::Omni | Emission::Directional) {
            return Self { c_squared: 0.0 };
        }
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for cluster in clusters {
            (min, max) = (min.min(cluster.min), max.max(cluster.max));
        }
        let c_squared = (max - min).length_squared() * spread * spread;
        Self { c_squared: if c_squared.is_finite() { c_squared } else { 0.0 } }
    }

    /// Cost of joining two, at least 0. The order of the two changes nothing.
    pub fn cost(&self, a: &Cluster, b: &Cluster) -> f64 {
        let intensity = a.intensity + b.intensity;
        let diagonal = (a.max.max(b.max) - a.min.min(b.min)).length_squared();
        if self.c_squared == 0.0 {
            return intensity * diagonal;
        }
        intensity * (diagonal + self.turned(cosine(a, b)))
    }

    /// The part of the cost that a cone of this cosine gives.
    pub fn turned(&self, cosine: f64) -> f64 {
        let open = 1.0 - cosine;
        self.c_squared * (open * open)
    }
}

/// Cosine of half the opening of the smallest cone that holds both.
fn cosine(a: &Cluster, b: &Cluster) -> f64 {
    let ([ca, sa], [cb, sb]) = (a.half, b.half);
    let [cd, sd] = between(a.axis, b.axis);
    let (c, s) = (ca * cb - sa * sb, sa * cb + ca * sb);
    let (c, s) = (c * cd - s * sd, s * cd + c * sd);
    let both = if s < 0.0 { -1.0 } else { c };
    both.min(a.cosine()).min(b.cosine()).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::angle;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn cluster(axis: [f64; 3], opening: f64) -> Cluster {
        let axis = DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::X);
        let (sine, cosine) = (0.5 * opening).sin_cos();
        Cluster { min: DVec3::ZERO, max: DVec3::ZERO, intensity: 1.0, axis, half: [cosine, sine] }
    }

    fn opening(c: &Cluster) -> f64 {
        2.0 * c.half[1].atan2(c.half[0])
    }

    fn any() -> impl Strategy<Value = Cluster> {
        let opening = prop_oneof![Just(0.0), Just(PI), 0.0..PI];
        let axis = prop_oneof![
            Just([1.0, 0.0, 0.0]),
            Just([-1.0, 0.0, 0.0]),
            [-1.0..1.0, -1.0..1.0, -1.0..1.0]
        ];
        (axis, opening).prop_map(|(axis, opening)| cluster(axis, opening))
    }

    proptest! {
        #[test]
        fn a_joined_cone_is_the_smallest_that_holds_both(a in any(), b in any()) {
            let both = a.joined(&b);
            for part in [&a, &b] {
                let reach = (angle(both.axis, part.axis) + opening(part)).min(PI);
                prop_assert!(reach <= opening(&both) + 1e-7, "{reach} {}", opening(&both));
            }
            let least = 0.5 * (opening(&a) + opening(&b) + angle(a.axis, b.axis));
            let least = least.max(opening(&a)).max(opening(&b)).min(PI);
            prop_assert!((opening(&both) - least).abs() < 1e-7);
            prop_assert!((cosine(&a, &b) - least.cos()).abs() < 1e-9);
            prop_assert_eq!(cosine(&a, &b).to_bits(), cosine(&b, &a).to_bits());
        }
    }

    #[test]
    fn the_cost_is_that_of_the_paper() {
        let metric = Metric { c_squared: 4.0 };
        let a = cluster([1.0, 0.0, 0.0], 0.0);
        let b = Cluster { max: DVec3::new(3.0, 4.0, 0.0), ..cluster([0.0, 0.0, 1.0], 0.0) };
        // A diagonal of 5, a cone of 45 degrees.
        let open = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
        assert!((metric.cost(&a, &b) - 2.0 * (25.0 + 4.0 * open * open)).abs() < 1e-12);
        assert_eq!(Metric { c_squared: 0.0 }.cost(&a, &b), 50.0);
    }
}
