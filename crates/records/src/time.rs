//! UTC times as text, without a calendar crate.
//!
//! Based on: Howard Hinnant, "chrono-Compatible Low-Level Date Algorithms", 2013,
//! section `civil_from_days`.
//! Deviations: unsigned, as the clock here starts in 1970.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The present, as [`rfc3339`].
pub fn now() -> String {
    // A clock set before 1970 reads as 1970.
    rfc3339(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default())
}

/// `2026-11-22T04:37:22.125Z` from the time since 1970-01-01T00:00Z. Fixed width up to the year
/// 9999, so that text order is time order.
pub fn rfc3339(since_1970: Duration) -> String {
    let seconds = since_1970.as_secs();
    let (year, month, day) = civil_from_days(seconds / 86_400);
    let second = seconds % 86_400;
    format!(
        "{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}.{:03}Z",
        second / 3600,
        second / 60 % 60,
        second % 60,
        since_1970.subsec_millis()
    )
}

/// Milliseconds since 1970 of a UTC time as [`rfc3339`] writes it (digits behind the third of the
/// fraction are dropped; the fraction may be absent). `None` for any other text.
pub fn millis(time: &str) -> Option<i64> {
    let (date, clock) = time.strip_suffix('Z')?.split_once('T')?;
    let (clock, fraction) = clock.split_once('.').unwrap_or((clock, "0"));
    let [year, month, day] = numbers(date, '-')?;
    let [hour, minute, second] = numbers(clock, ':')?;
    if !(1970..=9999).contains(&year) || hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let digits: String = fraction.chars().chain("00".chars()).take(3).collect();
    if !fraction.bytes().all(|b| b.is_ascii_digit()) || digits.len() < 3 {
        return None;
    }
    let days =
        days_from_civil(year, month, day).filter(|&d| civil_from_days(d) == (year, month, day))?;
    let seconds = days * 86_400 + hour * 3_600 + minute * 60 + second;
    Some(seconds as i64 * 1000 + digits.parse::<i64>().ok()?)
}

/// Three whole numbers between separators.
fn numbers(text: &str, separator: char) -> Option<[u64; 3]> {
    let mut parts = text.split(separator).map(|part| {
        let digits = !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        part.parse::<u64>().ok().filter(|_| digits && part.len() <= 4)
    });
    let three = [parts.next()??, parts.next()??, parts.next()??];
    parts.next().is_none().then_some(three)
}

/// Days since 1970-01-01 of a date from 1970 on; dates that there are not give some other day.
fn days_from_civil(year: u64, month: u64, day: u64) -> Option<u64> {
    if !(1..=12).contains(&month) || day == 0 {
        return None;
    }
    let year = year - u64::from(month <= 2);
    let (era, year_of_era) = (year / 400, year % 400);
    let month_from_march = if month > 2 { month - 3 } else { month + 9 };
    let day_of_year = (153 * month_from_march + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    (era * 146_097 + day_of_era).checked_sub(719_468)
}

/// Year, month 1..=12 and day 1..=31 of the proleptic Gregorian calendar.
fn civil_from_days(days_since_1970: u64) -> (u64, u64, u64) {
    // Years begin on 1 March, so that the leap day comes last; an era is 400 years.
    let days = days_since_1970 + 719_468;
    let era = days / 146_097;
    let day_of_era = days % 146_097;
    let year_of_era =
        (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (era * 400 + year_of_era + u64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_instants() {
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00.000Z"),
            (951_782_400, "2000-02-29T00:00:00.000Z"),
            (1_000_000_000, "2001-09-09T01:46:40.000Z"),
            (1_709_251_199, "2024-02-29T23:59:59.000Z"),
            (4_107_542_400, "2100-03-01T00:00:00.000Z"),
            (253_402_300_799, "9999-12-31T23:59:59.000Z"),
        ] {
            assert_eq!(rfc3339(Duration::from_secs(seconds)), text);
        }
        assert_eq!(rfc3339(Duration::from_millis(1)), "1970-01-01T00:00:00.001Z");
    }

    #[test]
    fn what_is_written_is_read_again_and_nothing_else_is() {
        for days in (0..2_932_896).step_by(97) {
            let since = Duration::from_millis(days * 86_400_000 + days % 86_400_000);
            assert_eq!(millis(&rfc3339(since)), Some(since.as_millis() as i64));
        }
        assert_eq!(millis("1970-01-01T00:00:01Z"), Some(1000));
        assert_eq!(millis("1970-01-01T00:00:01.5Z"), Some(1500));
        assert_eq!(millis("1970-01-01T00:00:01.123456Z"), Some(1123));
        for bad in [
            "",
            "yesterday",
            "2026-01-02",
            "2026-01-02T03:04:05",
            "2026-01-02T03:04:05+01:00",
            "2026-13-02T03:04:05Z",
            "2026-02-30T03:04:05Z",
            "2026-00-00T03:04:05Z",
            "2026-01-02T24:04:05Z",
            "2026-01-02T03:04:05.xZ",
            "2026-01-02T03:04:05.Z",
            "2026-01-02-05T03:04:05Z",
            "99999-01-02T03:04:05Z",
            "1969-12-31T23:59:59Z",
            "+026-01-02T03:04:05Z",
            "2026-01-02T03:04:05.1\u{663}Z",
        ] {
            assert_eq!(millis(bad), None, "{bad}");
        }
    }

    #[test]
    fn every_day_of_eight_centuries_follows_the_calendar() {
        let (mut year, mut month, mut day) = (1970, 1, 1);
        for days in 0..800 * 365 {
            assert_eq!(civil_from_days(days), (year, month, day));
            let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
            let length = match month {
                2 => 28 + u64::from(leap),
                4 | 6 | 9 | 11 => 30,
                _ => 31,
            };
            day += 1;
            if day > length {
                (month, day) = (month + 1, 1);
            }
            if month > 12 {
                (year, month) = (year + 1, 1);
            }
        }
    }
}
