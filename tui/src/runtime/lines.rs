//! Lines of a stream, of bounded length.

use std::io::{BufRead, Read};

/// The longest line that is taken: a picture is a few megabytes.
const MOST_BYTES: u64 = 64 << 20;

/// Calls `take` with each line (without its end, bytes that are no text replaced) until it returns
/// false or the stream ends. Of a longer line only a note is handed on.
pub fn each(source: impl BufRead, take: impl FnMut(String) -> bool) {
    bounded(source, MOST_BYTES, take);
}

fn bounded(mut source: impl BufRead, most: u64, mut take: impl FnMut(String) -> bool) {
    let mut line = Vec::new();
    loop {
        line.clear();
        match source.by_ref().take(most).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let text = if line.len() as u64 == most && !line.ends_with(b"\n") {
            match source.skip_until(b'\n') {
                Ok(more) => format!("a line of {} bytes was left out", line.len() + more),
                Err(_) => return,
            }
        } else {
            String::from_utf8_lossy(&line).trim_end().to_string()
        };
        if !text.is_empty() && !take(text) {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(bytes: &[u8]) -> Vec<String> {
        let mut lines = Vec::new();
        bounded(bytes, 8, |line| {
            lines.push(line);
            lines.len() < 4
        });
        lines
    }

    #[test]
    fn lines_are_bounded_and_bytes_that_are_no_text_do_no_harm() {
        assert_eq!(of(b"one\ntwo\r\n\nthree"), ["one", "two", "three"]);
        assert_eq!(of(b"\xff\xfe\n"), ["\u{fffd}\u{fffd}"]);
        assert_eq!(of(b"0123456789abc\nnext\n"), ["a line of 14 bytes was left out", "next"]);
        assert_eq!(of(b"1234567\n8"), ["1234567", "8"]);
        assert_eq!(of(b"1\n2\n3\n4\n5\n").len(), 4);
    }
}
