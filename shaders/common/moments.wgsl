// Four power moments of d = 2 z - 1, and their form in 16-bit storage: polynomials that fill
// 0..=1. Written after Peters and Klein 2015 and Peters et al. 2017; reference in
// crates/shadows/src/filtering/estimators/moments.rs.
#import common/channels.wgsl
#import common/precise.wgsl
#import common/visibility.wgsl

const ROOT_3 = 1.7320508075688772;

fn stored_moments(z: f32) -> vec4<f32> {
    let d = 2.0 * z - 1.0;
    let square = d * d;
    let cube = square * d;
    let fourth = square * square;
    if FORMAT == FORMAT_F32 {
        return vec4(d, square, cube, fourth);
    }
    return vec4(
        1.5 * d - 2.0 * cube + 0.5,
        4.0 * (square - fourth),
        ROOT_3 * (0.5 * d - 2.0 / 9.0 * cube) + 0.5,
        0.5 * (square + fourth),
    );
}

fn moments_of(s: vec4<f32>) -> vec4<f32> {
    if FORMAT == FORMAT_F32 {
        return s;
    }
    let odd = s.x - 0.5;
    let odd3 = ROOT_3 * (s.z - 0.5);
    return vec4(
        odd3 - odd / 3.0,
        s.w + 0.125 * s.y,
        0.75 * (odd3 - odd),
        s.w - 0.125 * s.y,
    );
}

// Upper bound of the share of depths at or beyond z. Moments are moved by `bias` towards
// (0, target, 0, target) and taken about their mean, both inside the differences that cancel.
fn moment_visibility(b: vec4<f32>, z: f32, bias: f32, bias_target: f32) -> f32 {
    if z > 1.0 {
        return 0.0;
    }
    if z < 0.0 {
        return 1.0;
    }
    let keep = 1.0 - bias;
    let mean = keep * b.x;
    let x = (2.0 * z - 1.0) - mean;
    let m2 = keep * (minus_square(b.y, b.x) + bias * b.x * b.x) + bias * bias_target;
    let b3_cross = keep * (-difference_of_products(b.x, b.y, b.z, 1.0)
        + bias * b.x * (b.y - bias_target));
    let b4_cross = keep * (minus_square(b.w, b.y) + bias * b.y * (b.y - 2.0 * bias_target))
        + bias * bias_target * (1.0 - bias * bias_target);
    let minor = difference_of_products(b4_cross, m2, b3_cross, b3_cross);
    if m2 > 0.0 && minor > 0.0 {
        // Third moment about the mean, over the second.
        let skew = difference_of_products(b3_cross, 1.0, 2.0 * mean, m2) / m2;
        let c2 = (x * x - m2 - skew * x) / (minor / m2);
        let c1 = x / m2 - skew * c2;
        let c0 = 1.0 - c2 * m2;
        let half_p = 0.5 * c1 / c2;
        let root = sqrt(max(half_p * half_p - c0 / c2, 0.0));
        let low = -half_p - root;
        let high = -half_p + root;
        var shadow = 0.0;
        if x > high {
            shadow = 1.0 - (low * high + m2) / ((x - low) * (x - high));
        } else if x > low {
            shadow = (x * high + m2) / ((high - low) * (x - low));
        }
        // Infinities and NaN fail this test too.
        if abs(shadow) < 1e30 {
            return 1.0 - clamp(shadow, 0.0, 1.0);
        }
    }
    return bounded(m2, x, 0.0);
}
