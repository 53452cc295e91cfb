//! How pictures of errors are coloured, the same in files, pages and terminals.

/// White where right, orange where too light, blue where too dark: a pair that stays apart for
/// the colour-blind. `error` is result less truth, -1..=1; beyond is as at the end, NaN is black:
/// no colour of the scale.
pub fn signed_colour(error: f32) -> [u8; 3] {
    if error.is_nan() {
        return [0; 3];
    }
    let strength = error.abs().min(1.0).sqrt();
    let full = if error > 0.0 { [230.0, 97.0, 1.0] } else { [38.0, 87.0, 184.0_f32] };
    full.map(|channel| (255.0 + (channel - 255.0) * strength).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::signed_colour;

    #[test]
    fn no_error_is_white_and_signs_differ() {
        assert_eq!(signed_colour(0.0), [255; 3]);
        assert_eq!(signed_colour(1.0), [230, 97, 1]);
        assert_eq!(signed_colour(-1.0), [38, 87, 184]);
    }

    #[test]
    fn beyond_the_ends_is_as_at_the_ends_and_what_is_no_number_is_black() {
        assert_eq!(signed_colour(f32::INFINITY), signed_colour(1.0));
        assert_eq!(signed_colour(-7.0), signed_colour(-1.0));
        assert_eq!(signed_colour(f32::NAN), [0; 3]);
    }
}
