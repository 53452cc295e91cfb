//! Bringing what was read into order: the last of what is there twice counts.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use hashbrown::HashTable;

use super::{Entry, Index, Place, SettingName};
use crate::front::Key;
use crate::line::Line;

/// One hash of two numbers, spread over all bits.
pub(crate) fn mix(a: u32, b: u64) -> u64 {
    let spread = (b ^ u64::from(a).rotate_left(40)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    spread ^ (spread >> 32)
}

impl Index {
    /// Files by the order of their names, as positions.
    fn ranks(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.files.len()).collect();
        order.sort_by(|&a, &b| self.files[a].path.cmp(&self.files[b].path));
        let mut ranks = vec![0; order.len()];
        for (rank, file) in order.into_iter().enumerate() {
            ranks[file] = rank;
        }
        ranks
    }

    pub(crate) fn settle(&mut self, lines: Vec<(Place, Line)>) {
        let ranks = self.ranks();
        let rank = |place: Place| (ranks.get(place.file as usize).copied(), place.offset);
        let by_place = |entry: &Entry| rank(Place { file: entry.file, offset: entry.offset });
        if !self.entries.is_sorted_by_key(by_place) {
            self.entries.sort_unstable_by_key(by_place);
        }
        drop_earlier(&mut self.entries);
        self.settle_lines(lines, rank);
        self.name();
        self.skipped.sort_by(|a, b| (&a.path, a.line).cmp(&(&b.path, b.line)));
    }

    fn settle_lines(&mut self, lines: Vec<(Place, Line)>, rank: impl Fn(Place) -> Rank + Copy) {
        let (mut headers, mut gates) = (Vec::new(), Vec::new());
        let (mut claims, mut stress) = (Vec::new(), Vec::new());
        for (place, line) in lines {
            match line {
                Line::Header(line) => headers.push((place, *line)),
                Line::Gate(line) => gates.push((place, *line)),
                Line::Claim(line) => claims.push((place, *line)),
                Line::Stress(line) => stress.push((place, *line)),
                Line::End(end) => drop(self.ended_runs.insert(end.run)),
                // Rows became entries.
                Line::Row(_) => {}
            }
        }
        let places = &mut self.places;
        let run = |h: &crate::RunHeader| h.run.clone();
        // Of a run's headers the last counts, whatever its time.
        newest(&mut self.headers, &mut places[0], headers, rank, run, |_| "");
        newest(
            &mut self.gates,
            &mut places[1],
            gates,
            rank,
            |g| [&g.problem, &g.technique, &g.gate, &g.machine, &g.adapter].map(Clone::clone),
            |g| &g.time,
        );
        newest(
            &mut self.claims,
            &mut places[2],
            claims,
            rank,
            |c| [&c.problem, &c.id, &c.machine, &c.adapter].map(Clone::clone),
            |c| &c.time,
        );
        newest(
            &mut self.stress,
            &mut places[3],
            stress,
            rank,
            |s| {
                let names = [&s.problem, &s.case, &s.technique, &s.variant, &s.form, &s.axis];
                let places = [&s.machine, &s.adapter];
                (names.map(Clone::clone), places.map(Clone::clone), s.value.to_bits())
            },
            |s| &s.time,
        );
        self.ended = self.headers.iter().map(|h| self.ended_runs.contains(&h.run)).collect();
    }

    /// Gives the numbers that are new their names, and every entry its run.
    fn name(&mut self) {
        let text = |number: u32| self.table.text(number).to_owned();
        for key in self.table.keys.items.iter().skip(self.keys.len()) {
            let [problem, case, scene_hash, view, size, truth, machine, adapter, device] =
                key.map(text);
            self.keys.push(Key {
                problem,
                case,
                scene_hash,
                view,
                size,
                truth,
                machine,
                adapter,
                device,
            });
        }
        for setting in self.table.settings.items.iter().skip(self.settings.len()) {
            let [technique, variant, form] = setting.map(text);
            self.settings.push(SettingName { technique, variant, form });
        }
        for shape in self.table.shapes.items.iter().skip(self.names.len()) {
            self.names.push(shape.names.iter().map(|&name| text(name)).collect());
        }
        let runs: HashMap<&str, u32> =
            self.headers.iter().enumerate().map(|(i, h)| (h.run.as_str(), i as u32)).collect();
        let run = |text: &String| runs.get(text.as_str()).copied();
        let of_text: Vec<u32> =
            self.table.texts.items.iter().map(|t| run(t).unwrap_or(u32::MAX)).collect();
        for entry in &mut self.entries {
            entry.run = of_text.get(entry.of_run as usize).copied().unwrap_or(u32::MAX);
        }
    }
}

/// A place among all files: by the rank of its file, then within it.
pub(crate) type Rank = (Option<usize>, u64);

/// Of entries of one run, group and identity the last is kept.
fn drop_earlier(entries: &mut Vec<Entry>) {
    let hash = |entry: &Entry| mix(entry.of_run, entry.identity ^ entry.group);
    let mut last: HashTable<u32> = HashTable::with_capacity(entries.len());
    let mut lost = BTreeSet::new();
    for (position, entry) in entries.iter().enumerate() {
        let same = |&other: &u32| {
            let other = &entries[other as usize];
            let one = |e: &Entry| (e.of_run, e.group, e.identity);
            one(other) == one(entry)
        };
        let again = |&other: &u32| hash(&entries[other as usize]);
        match last.entry(hash(entry), same, again) {
            hashbrown::hash_table::Entry::Occupied(mut found) => {
                lost.insert(*found.get());
                *found.get_mut() = position as u32;
            }
            hashbrown::hash_table::Entry::Vacant(free) => {
                free.insert(position as u32);
            }
        }
    }
    if !lost.is_empty() {
        let mut position = 0;
        entries.retain(|_| {
            position += 1;
            !lost.contains(&(position - 1))
        });
    }
}

/// Adds lines to those at hand; of several with one key the last by time is kept, of several at
/// that time the last in the files' order. Both lists stay in the files' order.
fn newest<T, K: Ord>(
    items: &mut Vec<T>,
    places: &mut Vec<Place>,
    fresh: Vec<(Place, T)>,
    rank: impl Fn(Place) -> Rank,
    key: impl Fn(&T) -> K,
    time: impl Fn(&T) -> &str,
) {
    if fresh.is_empty() {
        return;
    }
    let mut all: Vec<(Place, T)> = places.drain(..).zip(items.drain(..)).collect();
    all.extend(fresh);
    all.sort_by_key(|(place, _)| rank(*place));
    let mut best: BTreeMap<K, usize> = BTreeMap::new();
    for (i, (_, item)) in all.iter().enumerate() {
        let kept = best.entry(key(item)).or_insert(i);
        if time(&all[*kept].1) <= time(item) {
            *kept = i;
        }
    }
    let keep: BTreeSet<usize> = best.into_values().collect();
    for (i, (place, item)) in all.into_iter().enumerate() {
        if keep.contains(&i) {
            places.push(place);
            items.push(item);
        }
    }
}
