//! What tags say in numbers.

/// A length in metres: `12`, `12.5 m`, `40 ft`, `40'`, `6'3"`. `None` for anything else, and beyond
/// (0, 1000].
pub fn length_m(text: &str) -> Option<f64> {
    const FOOT_M: f64 = 0.3048;
    let text = text.trim();
    let metres = if let Some((feet, inches)) = text.split_once('\'') {
        let inches = inches.trim().trim_end_matches('"');
        let inches = if inches.is_empty() { 0.0 } else { number(inches)? };
        (number(feet)? + inches / 12.0) * FOOT_M
    } else if let Some(feet) = text.strip_suffix("ft") {
        number(feet)? * FOOT_M
    } else {
        number(text.strip_suffix('m').unwrap_or(text))?
    };
    (metres > 0.0 && metres <= 1000.0).then_some(metres)
}

/// A number of storeys in (0, 400]; halves occur. The largest of several (`4;5`).
pub fn levels(text: &str) -> Option<f64> {
    let all = text.split(';').map(number).collect::<Option<Vec<f64>>>()?;
    let most = all.into_iter().fold(0.0, f64::max);
    (most > 0.0 && most <= 400.0).then_some(most)
}

/// Digits alone: neither `inf` nor `1e5` is a length that anyone wrote down.
fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    let digits = text.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    text.parse().ok().filter(|n: &f64| digits && n.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_levels_as_people_write_them() {
        for (text, metres) in [
            ("12", 12.0),
            ("12.5 m", 12.5),
            (" 7m ", 7.0),
            ("10 ft", 3.048),
            ("10'", 3.048),
            ("5'6\"", 1.6764),
        ] {
            assert!((length_m(text).unwrap() - metres).abs() < 1e-12, "{text}");
        }
        for bad in ["", "high", "-3", "0", "1e3", "inf", "NaN", "2000", "12,5", "4;5", "'", "m"] {
            assert_eq!(length_m(bad), None, "{bad}");
        }
        assert_eq!((levels("5"), levels("1.5"), levels("4; 6")), (Some(5.0), Some(1.5), Some(6.0)));
        for bad in ["", "0", "-1", "many", "4;", "1000", "NaN"] {
            assert_eq!(levels(bad), None, "{bad}");
        }
    }
}
