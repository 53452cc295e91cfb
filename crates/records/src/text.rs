//! Figures for people, in one way everywhere: tables, pages, the dashboard.

/// Four significant digits, without an exponent where that stays readable.
pub fn significant(x: f64) -> String {
    let magnitude = x.abs();
    if x == 0.0 {
        "0".into()
    } else if !(1e-4..1e6).contains(&magnitude) {
        format!("{x:.2e}")
    } else {
        // In range, the exponent lies in -4..=5.
        let digits = (3 - magnitude.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    }
}

/// A duration with a unit that leaves one to three digits before the point.
pub fn duration(ns: f64) -> String {
    match ns {
        ns if ns < 1e3 => format!("{ns:.0} ns"),
        ns if ns < 1e6 => format!("{:.1} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.2} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}

/// A size in binary units.
pub fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1024.0 => format!("{b} B"),
        b if b < 1024.0 * 1024.0 => format!("{:.1} KiB", b / 1024.0),
        b => format!("{:.1} MiB", b / (1024.0 * 1024.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_fit_the_size() {
        assert_eq!(duration(12.0), "12 ns");
        assert_eq!(duration(1_500.0), "1.5 µs");
        assert_eq!(duration(2_500_000.0), "2.50 ms");
        assert_eq!(duration(3e9), "3.00 s");
        assert_eq!((bytes(17), bytes(1536)), ("17 B".into(), "1.5 KiB".into()));
        assert_eq!(bytes(3 << 20), "3.0 MiB");
    }

    #[test]
    fn four_digits_are_kept() {
        for (x, text) in [
            (0.0, "0"),
            (0.015434, "0.01543"),
            (2.264e-8, "2.26e-8"),
            (123456.0, "123456"),
            (-2.34567, "-2.346"),
            (2.5e7, "2.50e7"),
            (f64::INFINITY, "inf"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(significant(x), text);
        }
    }
}
