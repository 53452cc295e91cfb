//! Requests on their way from standard input: the newest waits, an older one that nobody has begun
//! with is forgotten.

use dapple_records::Show;
use serde_json::Value;
use std::{
    io::{self, BufRead},
    sync::{Condvar, Mutex, MutexGuard, PoisonError},
    time::{Duration, Instant},
};

/// Longest line that is read; a request takes a few hundred bytes.
const LONGEST: usize = 1 << 20;

/// What a wait came to.
#[derive(Debug)]
pub enum Next<T> {
    /// A request.
    Asked(Box<T>),
    /// None for as long as was to be waited.
    Nothing,
    /// None, and none will come.
    Closed,
}

/// The newest request.
#[derive(Default)]
pub struct Inbox {
    state: Mutex<State>,
    news: Condvar,
}

#[derive(Default)]
struct State {
    next: Option<Show>,
    closed: bool,
}

impl Inbox {
    /// Waits for a request, for ever where `most` is not given. One that came before the input
    /// ended is still handed out.
    pub fn take(&self, most: Option<Duration>) -> Next<Show> {
        let until = most.and_then(|most| Instant::now().checked_add(most));
        let mut state = self.state();
        loop {
            if let Some(show) = state.next.take() {
                return Next::Asked(Box::new(show));
            }
            if state.closed {
                return Next::Closed;
            }
            let Some(until) = until else {
                state = self.news.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Next::Nothing;
            }
            let waited = self.news.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Reads lines until the input ends. `refuse` is told the number (0 if there is none to be
    /// read) and the reason for each line that is no request; where it fails, reading ends.
    pub fn fill(
        &self,
        input: &mut impl BufRead,
        refuse: &mut dyn FnMut(u64, &str) -> io::Result<()>,
    ) {
        let mut line = Vec::new();
        while let Ok(Some(whole)) = read_line(input, &mut line) {
            let told = match request(&line, whole) {
                Ok(Some(show)) => {
                    self.state().next = Some(show);
                    self.news.notify_one();
                    Ok(())
                }
                Ok(None) => Ok(()),
                Err((number, reason)) => refuse(number, &reason),
            };
            if told.is_err() {
                break;
            }
        }
        self.state().closed = true;
        self.news.notify_one();
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads a line without its end, no more than [`LONGEST`] bytes of it; the rest is passed over.
/// Returns whether it is whole, or none at the input's end.
fn read_line(input: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<Option<bool>> {
    line.clear();
    let (mut read, mut whole) = (false, true);
    loop {
        let available = match input.fill_buf() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            available => available?,
        };
        if available.is_empty() {
            return Ok(read.then_some(whole));
        }
        read = true;
        let end = available.iter().position(|b| *b == b'\n');
        let part = &available[..end.unwrap_or(available.len())];
        let room = LONGEST - line.len();
        whole &= part.len() <= room;
        line.extend_from_slice(&part[..part.len().min(room)]);
        let used = part.len() + usize::from(end.is_some());
        input.consume(used);
        if end.is_some() {
            return Ok(Some(whole));
        }
    }
}

/// A line as a request; none for an empty line.
fn request(line: &[u8], whole: bool) -> Result<Option<Show>, (u64, String)> {
    if !whole {
        return Err((0, format!("a request longer than {LONGEST} bytes")));
    }
    if line.trim_ascii().is_empty() {
        return Ok(None);
    }
    serde_json::from_slice(line).map(Some).map_err(|error| {
        let number = serde_json::from_slice::<Value>(line).ok();
        let number = number.and_then(|value| value.get("request")?.as_u64());
        (number.unwrap_or_default(), format!("not a request: {error}"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn show(request: u64) -> String {
        // Plain data: serialising it cannot fail.
        serde_json::to_string(&Show { request, ..Show::default() }).unwrap()
    }

    /// The request that is left, and what was refused.
    fn filled(input: &[u8]) -> (Option<u64>, Vec<(u64, String)>) {
        let inbox = Inbox::default();
        let mut refused = Vec::new();
        inbox.fill(&mut Cursor::new(input), &mut |number, reason| {
            refused.push((number, reason.to_string()));
            Ok(())
        });
        let left = match inbox.take(None) {
            Next::Asked(show) => Some(show.request),
            _ => None,
        };
        assert!(matches!(inbox.take(None), Next::Closed));
        (left, refused)
    }

    #[test]
    fn only_the_newest_is_left_and_bad_lines_do_not_replace_it() {
        let lines = format!("{}\n\n{}\nrubbish\n{{\"request\":9}}\n", show(1), show(2));
        let (left, refused) = filled(lines.as_bytes());
        assert_eq!(left, Some(2));
        assert_eq!(refused.iter().map(|r| r.0).collect::<Vec<_>>(), [0, 9]);
        assert!(refused.iter().all(|r| r.1.starts_with("not a request: ")), "{refused:?}");
    }

    #[test]
    fn a_last_line_without_its_end_counts_and_no_line_is_too_odd() {
        assert_eq!(filled(show(3).as_bytes()), (Some(3), Vec::new()));
        assert_eq!(filled(b""), (None, Vec::new()));
        for odd in [&b"\xff\xfe\n"[..], b"[1]\n", b"\0\n", b"nul", &[b'['; 100_000]] {
            let (left, refused) = filled(odd);
            assert_eq!((left, refused.len()), (None, 1), "{odd:?}");
        }
    }

    #[test]
    fn a_line_that_is_too_long_is_refused_and_the_next_is_read() {
        let mut input = vec![b'x'; LONGEST + 1];
        input.extend_from_slice(format!("\n{}\n", show(4)).as_bytes());
        let (left, refused) = filled(&input);
        assert_eq!((left, refused.len()), (Some(4), 1));
        assert!(refused[0].1.contains("1048576 bytes"), "{refused:?}");
        // One that just fits is read, and found to be no request.
        let (_, refused) = filled(&vec![b'x'; LONGEST]);
        assert!(refused[0].1.starts_with("not a request"), "{refused:?}");
    }

    #[test]
    fn a_wait_ends() {
        let inbox = Inbox::default();
        assert!(matches!(inbox.take(Some(Duration::ZERO)), Next::Nothing));
        assert!(matches!(inbox.take(Some(Duration::from_millis(5))), Next::Nothing));
    }
}
