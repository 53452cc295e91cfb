// Fourier series of a ray's absorption; source, reasons and reference in
// crates/opacity-maps/src/fourier.rs.
#import common/opacity_series.wgsl

const TAU = 6.283185307179586;

// Sine and cosine of the place on the circle of a share of the way. The argument is taken about
// the middle: far from 0 devices are rough.
fn on_circle(share: f32) -> vec2<f32> {
    let half_turn = TAU * (circle_place(share) - 0.5);
    return vec2(-sin(half_turn), -cos(half_turn));
}

// Place on the circle, in turns. A ray's two ends are kept apart.
fn circle_place(share: f32) -> f32 {
    if BOUNDED {
        let padding = 0.5 / f32(series.numbers + 1u);
        return padding + share * (1.0 - 2.0 * padding);
    }
    return share;
}

// Angles are added: from those of k - 1 and 1 to those of k.
fn next_harmonic(last: vec2<f32>, first: vec2<f32>) -> vec2<f32> {
    return vec2(last.x * first.y + last.y * first.x, last.y * first.y - last.x * first.x);
}
