//! Times and counts for people.

pub use dapple_records::text::{bytes, duration, significant};

/// How long ago, in the largest unit that leaves a whole number: `now`, `12 s`, `5 min`, `3 h`,
/// `9 d`. A clock that was set back reads as `now`.
pub fn age(now_ms: i64, then_ms: i64) -> String {
    let seconds = now_ms.saturating_sub(then_ms) / 1000;
    match seconds {
        ..=0 => "now".into(),
        1..=59 => format!("{seconds} s"),
        60..=3_599 => format!("{} min", seconds / 60),
        3_600..=86_399 => format!("{} h", seconds / 3_600),
        _ => format!("{} d", seconds / 86_400),
    }
}

/// [`age`] of an RFC 3339 time; `?` where that cannot be read.
pub fn age_of(now_ms: i64, time: &str) -> String {
    dapple_records::time::millis(time).map_or("?".into(), |then| age(now_ms, then))
}

/// A span of time as a clock shows it: `0:07`, `12:34`, `3:04:05`.
pub fn clock(ms: i64) -> String {
    let seconds = (ms / 1000).max(0);
    let (hours, minutes, seconds) = (seconds / 3_600, seconds / 60 % 60, seconds % 60);
    match hours {
        0 => format!("{minutes}:{seconds:02}"),
        _ => format!("{hours}:{minutes:02}:{seconds:02}"),
    }
}

/// A count with its thousands apart: `12,345`.
pub fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 run`, `2 runs`.
pub fn plural(n: usize, one: &str) -> String {
    format!("{} {one}{}", count(n), if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ages_take_the_largest_whole_unit() {
        let s = 1000;
        for (ms, text) in [
            (-5 * s, "now"),
            (0, "now"),
            (59 * s, "59 s"),
            (60 * s, "1 min"),
            (3_599 * s, "59 min"),
            (3_600 * s, "1 h"),
            (86_400 * s, "1 d"),
            (i64::MAX, "106751991167 d"),
        ] {
            assert_eq!(age(ms, 0), text);
        }
        assert_eq!(age(i64::MIN, i64::MAX), "now");
        assert_eq!(age_of(60_000, "1970-01-01T00:00:00.000Z"), "1 min");
        assert_eq!(age_of(60_000, "yesterday"), "?");
    }

    #[test]
    fn clocks_and_counts() {
        assert_eq!(clock(7_999), "0:07");
        assert_eq!(clock(3_600_000 + 245_000), "1:04:05");
        assert_eq!(clock(-1), "0:00");
        assert_eq!(
            (count(0), count(999), count(1_000)),
            ("0".into(), "999".into(), "1,000".into())
        );
        assert_eq!(count(1_234_567), "1,234,567");
        assert_eq!((plural(1, "run"), plural(2, "run")), ("1 run".into(), "2 runs".into()));
    }
}
