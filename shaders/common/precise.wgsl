// Products and exponentials whose rounding errors would otherwise be magnified. Splitting by bit
// masks survives contraction to fused operations; a driver that also factors sums (Mesa does)
// folds parts of it back, and leaves the rounding of the plain formula.

// The upper 12 bits of the significand: products of two such values are exact in f32.
fn upper(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) & 0xfffff000u);
}

// a * a subtracted from b, without the rounding of a * a.
fn minus_square(b: f32, a: f32) -> f32 {
    let hi = upper(a);
    let lo = a - hi;
    return ((b - hi * hi) - 2.0 * hi * lo) - lo * lo;
}

// a * b - c * d without the rounding of the products.
fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let ah = upper(a);
    let bh = upper(b);
    let ch = upper(c);
    let dh = upper(d);
    let al = a - ah;
    let bl = b - bh;
    let cl = c - ch;
    let dl = d - dh;
    return (ah * bh - ch * dh) + ((ah * bl + al * bh) - (ch * dl + cl * dh)) + (al * bl - cl * dl);
}

const LOG2_E = 1.4426950408889634;
// ln 2 in two parts, the first short enough for n * LN2_HI to be exact.
const LN2_HI = 0.693359375;
const LN2_LO = -2.12194440054690583e-4;

fn power_of_two(n: i32) -> f32 {
    return bitcast<f32>(u32(n + 127) << 23u);
}

// scale * exp(c * z) for |c * z| <= 170 (beyond it saturates), with a relative error of a few ulp
// where exp(c * z) alone has that of the product c * z, |c * z| times as large.
fn scaled_exp(scale: f32, c: f32, z: f32) -> f32 {
    let n = clamp(round(c * z * LOG2_E), -250.0, 250.0);
    let c_hi = upper(c);
    let c_lo = c - c_hi;
    let z_hi = upper(z);
    let z_lo = z - z_hi;
    let small = (c_hi * z_lo + c_lo * z_hi) + c_lo * z_lo;
    let r = clamp((c_hi * z_hi - n * LN2_HI) + (small - n * LN2_LO), -0.5, 0.5);
    // |r| < 0.35: the rest of the series is below 6e-9. Drivers may be off by 1e-6 here.
    var series = 1.0 + r / 7.0;
    series = 1.0 + r / 6.0 * series;
    series = 1.0 + r / 5.0 * series;
    series = 1.0 + r / 4.0 * series;
    series = 1.0 + r / 3.0 * series;
    series = 1.0 + r / 2.0 * series;
    let half = i32(n) / 2;
    return ((scale * (1.0 + r * series)) * power_of_two(half)) * power_of_two(i32(n) - half);
}

// 1 - exp(-y) for y >= 0, with full relative precision near 0.
fn one_minus_exp(y: f32) -> f32 {
    if y < 0.4 {
        var s = 1.0 - y / 8.0;
        s = 1.0 - y / 7.0 * s;
        s = 1.0 - y / 6.0 * s;
        s = 1.0 - y / 5.0 * s;
        s = 1.0 - y / 4.0 * s;
        s = 1.0 - y / 3.0 * s;
        s = 1.0 - y / 2.0 * s;
        return y * s;
    }
    return 1.0 - exp(-y);
}

// ln(1 + x) for x > -1, with full relative precision near 0.
fn log_1p(x: f32) -> f32 {
    if abs(x) < 0.4 {
        // 2 artanh(x / (2 + x)).
        let s = x / (2.0 + x);
        let q = s * s;
        var sum = 1.0 / 9.0 + q * (1.0 / 11.0 + q / 13.0);
        sum = 1.0 / 5.0 + q * (1.0 / 7.0 + q * sum);
        return 2.0 * s * (1.0 + q * (1.0 / 3.0 + q * sum));
    }
    return log(1.0 + x);
}
