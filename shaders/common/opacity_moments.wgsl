// Share of a ray's absorption in front of a depth, from 4 or 6 power moments; source, reasons and
// reference in crates/opacity-maps/src/moments/.

// `own` of the absorption at x itself counts. `m` are moments over the zeroth, biased.
fn share_from_four(b: array<f32, 7>, x: f32, bias: f32, own: f32) -> f32 {
    let m1 = b[1];
    // The matrix of moments as L D L'; no pivot of a biased one is less than the bias makes it.
    let d1 = max(b[2] - m1 * m1, bias * 0.375);
    let m2 = m1 * m1 + d1;
    let l21 = (b[3] - m1 * m2) / d1;
    let d2 = max(b[4] - m2 * m2 - l21 * l21 * d1, bias * 0.234375);
    // Orthogonal polynomials at x and their slopes.
    let p1 = x - m1;
    let p2 = x * x - m2 - l21 * p1;
    let slope2 = 2.0 * x - l21;
    let c0 = 1.0 + p1 * p1 / d1 + p2 * p2 / d2;
    let c1 = p1 / d1 + p2 * slope2 / d2;
    let roots = quadratic_roots(c0, c1, p2 / d2);
    let moments = vec3(m1 - x, m2 - 2.0 * x * m1 + x * x, 0.0);
    return mean_of_steps(moments, vec3(roots, 0.0), own);
}

fn share_from_six(b: array<f32, 7>, x: f32, bias: f32, own: f32) -> f32 {
    let m1 = b[1];
    let m3 = b[3];
    let d1 = max(b[2] - m1 * m1, bias * 0.48);
    let m2 = m1 * m1 + d1;
    let l21 = (m3 - m1 * m2) / d1;
    let below4 = m2 * m2 + l21 * l21 * d1;
    let d2 = max(b[4] - below4, bias * 0.2206);
    let m4 = below4 + d2;
    let l31 = (m4 - m1 * m3) / d1;
    let l32 = (b[5] - m2 * m3 - l31 * l21 * d1) / d2;
    let d3 = max(b[6] - m3 * m3 - l31 * l31 * d1 - l32 * l32 * d2, bias * 0.026247917);
    let p1 = x - m1;
    let p2 = x * x - m2 - l21 * p1;
    let p3 = x * x * x - m3 - l31 * p1 - l32 * p2;
    let slope2 = 2.0 * x - l21;
    let slope3 = 3.0 * x * x - l31 - l32 * slope2;
    let bend3 = 3.0 * x - l32;
    let w = vec3(p1 / d1, p2 / d2, p3 / d3);
    let c0 = 1.0 + p1 * w.x + p2 * w.y + p3 * w.z;
    let c1 = w.x + slope2 * w.y + slope3 * w.z;
    let c2 = w.y + bend3 * w.z;
    let roots = cubic_roots(c1 / c0, c2 / c0, w.z / c0);
    let second = m2 - 2.0 * x * m1 + x * x;
    let third = m3 - 3.0 * x * m2 + 3.0 * x * x * m1 - x * x * x;
    return mean_of_steps(vec3(m1 - x, second, third), roots, own);
}

// Real roots of c0 s^2 + c1 s + c2, c0 > 0, the larger magnitude first.
fn quadratic_roots(c0: f32, c1: f32, c2: f32) -> vec2<f32> {
    let root = sqrt(max(0.25 * c1 * c1 - c0 * c2, 0.0));
    let sum = 0.5 * c1 + select(root, -root, c1 < 0.0);
    if sum == 0.0 {
        return vec2(0.0);
    }
    return vec2(-sum / c0, -c2 / sum);
}

const THIRD_OF_TURN = 2.0943951023931953;

// Real roots of s^3 + a s^2 + b s + c, by falling magnitude.
fn cubic_roots(a: f32, b: f32, c: f32) -> vec3<f32> {
    let third = a / 3.0;
    let radius = sqrt(max(third * third - b / 3.0, 0.0));
    let half_q = third * third * third - 0.5 * third * b + 0.5 * c;
    let cube = radius * radius * radius;
    var cosine = 1.0;
    if cube > 0.0 {
        cosine = clamp(-half_q / cube, -1.0, 1.0);
    }
    let angle = acos(cosine) / 3.0;
    let angles = vec3(angle, angle + THIRD_OF_TURN, angle + 2.0 * THIRD_OF_TURN);
    let roots = 2.0 * radius * cos(angles) - third;
    var largest = roots.x;
    largest = select(largest, roots.y, abs(roots.y) > abs(largest));
    largest = select(largest, roots.z, abs(roots.z) > abs(largest));
    // Devices are rough at acos: one step more than in f32 elsewhere.
    largest = polished(polished(largest, a, b, c), a, b, c);
    if largest == 0.0 {
        return vec3(0.0);
    }
    let left = -c / largest;
    let rest = quadratic_roots(1.0, (left - b) / largest, left);
    return vec3(largest, polished(rest.x, a, b, c), polished(rest.y, a, b, c));
}

// One step of Newton's method where it is a small one.
fn polished(s: f32, a: f32, b: f32, c: f32) -> f32 {
    let value = ((s + a) * s + b) * s + c;
    let slope = (3.0 * s + 2.0 * a) * s + b;
    if abs(value) < 0.1 * abs(s * slope) {
        return s - value / slope;
    }
    return s;
}

// (f_i - f_j) / (y_i - y_j) with y = 1 / s.
fn divided(fi: f32, fj: f32, si: f32, sj: f32) -> f32 {
    if si == sj {
        return 0.0;
    }
    return (fi - fj) * (si * sj) / (sj - si);
}

// A point too far for its place to matter must not overflow.
fn place_of(s: f32) -> f32 {
    if abs(s) < 1e-15 {
        return 0.0;
    }
    return 1.0 / s;
}

// The mean of the function that is `own` at 0, 1 at points 1/s < 0 and 0 at points 1/s > 0.
fn mean_of_steps(moments: vec3<f32>, s: vec3<f32>, own: f32) -> f32 {
    let f = select(vec3(0.0), vec3(1.0), s < vec3(0.0));
    let f01 = (f.x - own) * s.x;
    let f12 = divided(f.y, f.x, s.y, s.x);
    let f012 = (f12 - f01) * s.y;
    let f23 = divided(f.z, f.y, s.z, s.y);
    let f123 = divided(f23, f12, s.z, s.x);
    let f0123 = (f123 - f012) * s.z;
    let y1 = place_of(s.x);
    let y2 = place_of(s.y);
    let cubic = moments.z - (y1 + y2) * moments.y + y1 * y2 * moments.x;
    return own + f01 * moments.x + f012 * (moments.y - y1 * moments.x) + f0123 * cubic;
}
