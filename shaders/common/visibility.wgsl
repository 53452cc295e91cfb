// From the statistics of a window to a visibility, one function an estimator; sources and
// reasons in crates/shadows/src/filtering/estimators/.
#import common/precise.wgsl

// Chebyshev's bound from a variance and the distance beyond the mean.
fn bounded(variance: f32, distance: f32, min_variance: f32) -> f32 {
    if !(distance > 0.0) {
        return 1.0;
    }
    let raised = max(variance, min_variance);
    if !(raised > 0.0) {
        return 0.0;
    }
    // Not variance / (variance + distance^2): the square of a far receiver overflows.
    let ratio = distance / sqrt(raised);
    return 1.0 / (1.0 + min(ratio, 1e18) * min(ratio, 1e18));
}

fn chebyshev(m: vec2<f32>, z: f32, min_variance: f32) -> f32 {
    return bounded(minus_square(m.y, m.x), z - m.x, min_variance);
}

const PI = 3.141592653589793;
const ERF_A = 0.14001228868666648; // 8 (pi - 3) / (3 pi (4 - pi))

// 1 - erf(x) for x >= 0 after Winitzki.
fn erfc_positive(x: f32) -> f32 {
    let square = min(x, 30.0) * min(x, 30.0);
    let y = square * (4.0 / PI + ERF_A * square) / (1.0 + ERF_A * square);
    return exp(-y) / (1.0 + sqrt(one_minus_exp(y)));
}

fn gaussian_cdf(m: vec2<f32>, z: f32, min_variance: f32) -> f32 {
    let distance = z - m.x;
    if !(distance > 0.0) {
        return 1.0;
    }
    let variance = max(minus_square(m.y, m.x), min_variance);
    if !(variance > 0.0) {
        return 0.0;
    }
    return erfc_positive(distance / sqrt(2.0 * variance));
}

// ln((z - least) / range) from the nearer end.
fn ln_share(z: f32, least: f32, most: f32, range: f32) -> f32 {
    let t = (z - least) / range;
    if t < 0.5 {
        return log(t);
    }
    return log_1p((z - most) / range);
}

fn power_cdf(unclamped_mean: f32, least: f32, most: f32, z: f32, degenerate_range: f32) -> f32 {
    let mean = min(max(unclamped_mean, least), most);
    if !(z > mean) {
        return 1.0;
    }
    let range = most - least;
    if !(range > degenerate_range) {
        return select(1.0, 0.0, z > most);
    }
    // eq. 7.6; a mean at the maximum never comes here: z > mean = most is dark.
    if z >= most || !(mean > least) {
        return 0.0;
    }
    let beta = (mean - least) / (most - mean);
    let numerator = one_minus_exp(-beta * ln_share(z, least, most, range));
    let denominator = one_minus_exp(-beta * ln_share(mean, least, most, range));
    return min(numerator / denominator, 1.0);
}

// Chebyshev's bound over warped depths, all divided by the larger of mean and receiver so that
// the squares stay finite. d(warp)/dz = 2 c |warp|.
fn warped_bound(m: vec2<f32>, warped: f32, c: f32, min_variance: f32) -> f32 {
    if !(warped > m.x) {
        return 1.0;
    }
    let largest = max(abs(warped), abs(m.x));
    let receiver = warped / largest;
    let mean = m.x / largest;
    let square = (m.y / largest) / largest;
    let slope = 2.0 * c * receiver;
    return bounded(minus_square(square, mean), receiver - mean, min_variance * slope * slope);
}

fn warped_visibility(m: vec4<f32>, both: bool, z: f32, c: f32, min_variance: f32) -> f32 {
    if z > 1.0 {
        return 0.0;
    }
    if z < 0.0 {
        return 1.0;
    }
    let x = 2.0 * z - 1.0;
    var v = warped_bound(m.xy, scaled_exp(1.0, c, x), c, min_variance);
    if both {
        v = min(v, warped_bound(m.zw, -scaled_exp(1.0, -c, x), c, min_variance));
    }
    return v;
}
