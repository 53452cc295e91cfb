//! What rows share, each once and by number; and the rows' entries.

use std::borrow::Borrow;
use std::collections::{BTreeMap, HashMap};
use std::hash::Hash;

use super::brief::Brief;
use super::{Ended, Entry, packed};

/// Values of a row that the index holds; of a row with more the rest are read from the file.
pub(crate) const MOST_VALUES: usize = 64;

/// Things by number, and numbers by thing.
#[derive(Clone, Debug)]
pub(crate) struct Interned<T> {
    pub(crate) items: Vec<T>,
    numbers: HashMap<T, u32>,
}

impl<T> Default for Interned<T> {
    fn default() -> Self {
        Self { items: Vec::new(), numbers: HashMap::new() }
    }
}

impl<T: Clone + Eq + Hash> Interned<T> {
    fn number<Q>(&mut self, item: &Q) -> u32
    where
        Q: Eq + Hash + ToOwned<Owned = T> + ?Sized,
        T: Borrow<Q>,
    {
        if let Some(number) = self.numbers.get(item) {
            return *number;
        }
        // Lines that could overflow this would not fit any disk's file.
        let number = self.items.len() as u32;
        self.items.push(item.to_owned());
        self.numbers.insert(item.to_owned(), number);
        number
    }
}

/// Names of a row's values, as numbers of texts: first the errors, then the counters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Shape {
    pub clock: u32,
    pub errors: u32,
    pub names: Vec<u32>,
    /// The row has more values than these.
    pub cut: bool,
}

/// Entries, and what they refer to by number.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    pub texts: Interned<String>,
    /// As in [`Brief::key`].
    pub keys: Interned<[u32; 9]>,
    /// Technique, variant, form.
    pub settings: Interned<[u32; 3]>,
    pub shapes: Interned<Shape>,
    pub values: Vec<u8>,
    /// Times that are not written as [`crate::time::rfc3339`] writes them, by file and offset.
    pub times: BTreeMap<(u32, u64), u32>,
}

impl Table {
    pub(crate) fn text(&self, number: u32) -> &str {
        self.texts.items.get(number as usize).map_or("", String::as_str)
    }

    /// The entry of a row at a place; its values are appended.
    pub(crate) fn entry(&mut self, row: &Brief<'_>, file: u32, offset: u64, length: u32) -> Entry {
        let key = row.key.each_ref().map(|text| self.texts.number(&**text));
        let setting = [&row.technique, &row.variant, &row.form].map(|t| self.texts.number(&**t));
        let names = row.errors.iter().map(|e| &e.0).chain(row.counters.iter().map(|c| &c.0));
        let shape = Shape {
            clock: self.texts.number(&*row.clock),
            errors: row.errors.len().min(MOST_VALUES) as u32,
            names: names.take(MOST_VALUES).map(|name| self.texts.number(&**name)).collect(),
            cut: row.errors.len() + row.counters.len() > MOST_VALUES,
        };
        let values = self.values.len() as u32;
        let counters = row.counters.iter().map(|counter| counter.1 as f64);
        let numbers = row.errors.iter().map(|error| error.1).chain(counters);
        numbers.take(MOST_VALUES).for_each(|number| packed::push(&mut self.values, number));
        let time_ms = crate::time::millis(&row.time);
        let plain_time = time_ms.is_some() && is_plain(&row.time);
        if !plain_time {
            let text = self.texts.number(&*row.time);
            self.times.insert((file, offset), text);
        }
        Entry {
            key: self.keys.number(&key),
            setting: self.settings.number(&setting),
            run: u32::MAX,
            ended: row.status,
            gpu_clock: row.clock == "gpu",
            time_ms: time_ms.unwrap_or_default(),
            median_ns: row.median_ns.unwrap_or(f64::NAN),
            mad_ns: row.mad_ns.unwrap_or(f64::NAN),
            p99_ns: row.p99_ns.map_or(f32::NAN, |ns| ns as f32),
            memory_bytes: row.memory_bytes,
            identity: identity(&row.row),
            plain_time,
            file,
            offset,
            length,
            of_run: self.texts.number(&*row.run),
            group: group(&row.group),
            shape: self.shapes.number(&shape),
            values,
        }
    }

    /// Takes over another table's entries, with their numbers made this table's.
    pub(crate) fn absorb(&mut self, other: Table, entries: Vec<Entry>, into: &mut Vec<Entry>) {
        let texts: Vec<u32> = other.texts.items.iter().map(|t| self.texts.number(t)).collect();
        let text = |number: u32| texts.get(number as usize).copied().unwrap_or(u32::MAX);
        let renumbered = |list: &[[u32; 9]], into: &mut Interned<[u32; 9]>| -> Vec<u32> {
            list.iter().map(|item| into.number(&item.map(text))).collect()
        };
        let keys = renumbered(&other.keys.items, &mut self.keys);
        let settings: Vec<u32> =
            other.settings.items.iter().map(|s| self.settings.number(&s.map(text))).collect();
        let shapes: Vec<u32> = other
            .shapes
            .items
            .into_iter()
            .map(|shape| {
                let names = shape.names.iter().map(|&name| text(name)).collect();
                self.shapes.number(&Shape { clock: text(shape.clock), names, ..shape })
            })
            .collect();
        let of = |list: &[u32], number: u32| list.get(number as usize).copied().unwrap_or(u32::MAX);
        let first = self.values.len();
        // Beyond 4 GiB of values their places do not fit; such rows are read from the file.
        let fits = u32::try_from(first + other.values.len()).is_ok();
        if fits {
            grow(&mut self.values, other.values.len());
            self.values.extend(other.values);
        }
        grow(into, entries.len());
        into.extend(entries.into_iter().map(|entry| Entry {
            key: of(&keys, entry.key),
            setting: of(&settings, entry.setting),
            of_run: text(entry.of_run),
            shape: of(&shapes, entry.shape),
            values: if fits { first as u32 + entry.values } else { u32::MAX },
            ..entry
        }));
        self.times.extend(other.times.into_iter().map(|(place, time)| (place, text(time))));
    }

    /// A value by its position in the row's shape.
    pub(crate) fn value(&self, entry: &Entry, at: usize) -> Option<f64> {
        packed::nth(self.values.get(entry.values as usize..)?, at)
    }

    pub(crate) fn shape(&self, entry: &Entry) -> Option<&Shape> {
        self.shapes.items.get(entry.shape as usize)
    }

    /// Orders two entries by the text of their time.
    pub(crate) fn by_time(&self, a: &Entry, b: &Entry) -> std::cmp::Ordering {
        if a.plain_time && b.plain_time {
            return a.time_ms.cmp(&b.time_ms);
        }
        self.time(a).cmp(&self.time(b))
    }

    /// The text of an entry's time.
    pub(crate) fn time(&self, entry: &Entry) -> String {
        if entry.plain_time {
            let since = std::time::Duration::from_millis(entry.time_ms.unsigned_abs());
            return crate::time::rfc3339(since);
        }
        let text = self.times.get(&(entry.file, entry.offset));
        text.map(|text| self.text(*text).to_owned()).unwrap_or_default()
    }

    /// Bytes on the heap, about.
    pub(crate) fn heap_bytes(&self) -> usize {
        // A text is held twice, with its header and the allocator's; a number has its slot.
        let texts: usize = self.texts.items.iter().map(|text| 2 * (text.len() + 40) + 8).sum();
        let shapes: usize = self.shapes.items.iter().map(|s| 2 * (40 + 4 * s.names.len())).sum();
        let plain =
            self.keys.items.len() * 80 + self.settings.items.len() * 32 + self.times.len() * 32;
        texts + shapes + plain + self.values.capacity()
    }
}

/// Whether a time that was read is written as [`crate::time::rfc3339`] writes it, so that its
/// number says all.
fn is_plain(time: &str) -> bool {
    let bytes = time.as_bytes();
    let marks = [(4, b'-'), (7, b'-'), (10, b'T'), (13, b':'), (16, b':'), (19, b'.'), (23, b'Z')];
    bytes.len() == 24
        && marks.iter().all(|&(at, mark)| bytes[at] == mark)
        // A leap second has the number of the next second's.
        && bytes[17] != b'6'
}

/// The first eight bytes, or all there are.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().take(8).fold(0, |sum, &byte| sum << 8 | u64::from(byte))
}

/// A group's name as a number: itself where it is short, as the runner's are, else a hash.
pub(crate) fn group(name: &str) -> u64 {
    match name.len() {
        0..=8 => number(name.as_bytes()),
        _ => number(blake3::hash(name.as_bytes()).as_bytes()),
    }
}

/// A row's identity as a number; of one that is not 16 hexadecimal digits a hash, so that no two
/// that differ are taken for one.
pub(crate) fn identity(row: &str) -> u64 {
    let digits = row.len() == 16 && row.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'));
    match u64::from_str_radix(row, 16) {
        Ok(number) if digits => number,
        _ => number(blake3::hash(row.as_bytes()).as_bytes()),
    }
}

/// Room for more, an eighth at a time: doubling would leave up to half of it unused.
fn grow<T>(list: &mut Vec<T>, more: usize) {
    if list.capacity() - list.len() < more {
        list.reserve_exact(more.max(list.len() / 8));
    }
}

impl Ended {
    /// Why a row takes no part in a front; none if it may.
    pub(crate) fn excluded(self) -> Option<&'static str> {
        match self {
            Self::Ok => None,
            Self::Failed => Some("failed"),
            Self::NotRun => Some("not run"),
        }
    }
}
