// Thickness that a stored number stands for.

// Whether numbers are 1 - Π(1 - α) instead of sums.
override OPACITIES: bool = false;

// Largest opacity of which the logarithm is taken.
const MOST_OPACITY = 0.9990234375;

// Beyond it nothing is left to tell apart, and no infinity is interpolated.
const MOST_THICKNESS = 1e30;

// `scale`: stored numbers per thickness.
fn thickness_of(number: f32, scale: f32) -> f32 {
    if OPACITIES {
        return -log(1.0 - min(number, MOST_OPACITY));
    }
    return min(number / scale, MOST_THICKNESS);
}
