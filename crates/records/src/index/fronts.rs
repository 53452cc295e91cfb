//! Which entries count, and fronts from them, without the rows.

use std::collections::{BTreeMap, HashMap};

use hashbrown::HashTable;
use hashbrown::hash_table::Entry as Slot;

use super::settle::mix;
use super::{Entry, Index};
use crate::front::{Constraint, Excluded, Front, Fronts, Point, mark};

impl Index {
    /// Positions of the rows that count, in order: of those with the same identity and machine
    /// the last by time, as [`crate::front::latest`] has it.
    pub fn latest(&self) -> Vec<usize> {
        let mut numbers: HashMap<&str, u32> = HashMap::new();
        let machine: Vec<u32> = self
            .keys
            .iter()
            .map(|key| {
                let next = numbers.len() as u32;
                *numbers.entry(key.machine.as_str()).or_insert(next)
            })
            .collect();
        let what = |entry: &Entry| (machine[entry.key as usize], entry.identity);
        let hash = |entry: &Entry| mix(what(entry).0, what(entry).1);
        let mut kept: HashTable<u32> = HashTable::with_capacity(self.entries.len());
        for (position, entry) in self.entries.iter().enumerate() {
            let same = |&other: &u32| what(&self.entries[other as usize]) == what(entry);
            let again = |&other: &u32| hash(&self.entries[other as usize]);
            match kept.entry(hash(entry), same, again) {
                Slot::Occupied(mut found) => {
                    let other = &self.entries[*found.get() as usize];
                    if self.table.by_time(other, entry).is_le() {
                        *found.get_mut() = position as u32;
                    }
                }
                Slot::Vacant(free) => {
                    free.insert(position as u32);
                }
            }
        }
        let mut chosen: Vec<usize> = kept.iter().map(|&position| position as usize).collect();
        chosen.sort_unstable();
        chosen
    }

    /// Fronts of `metric` against the median time by `clock`, of the [`Index::latest`] rows that
    /// `filter` lets pass: the same points and fronts as [`crate::front::constrained`] of the
    /// whole rows. [`Point::index`] is a position in `entries`. Why a row failed or was not run
    /// stands in the row alone.
    pub fn fronts(
        &self,
        metric: &str,
        clock: &str,
        constraints: &[Constraint],
        filter: impl Fn(&Entry) -> bool,
    ) -> Fronts {
        let latest = self.latest();
        let superseded = self.entries.len() - latest.len();
        let mut fronts: BTreeMap<u32, Front> = BTreeMap::new();
        for index in latest {
            let entry = &self.entries[index];
            if !filter(entry) {
                continue;
            }
            let front = fronts.entry(entry.key).or_insert_with(|| Front {
                key: self.key(entry).clone(),
                points: Vec::new(),
                excluded: Vec::new(),
            });
            match self.point(entry, index, metric, clock, constraints) {
                Ok(point) => front.points.push(point),
                Err(reason) => front.excluded.push(Excluded { index, reason }),
            }
        }
        let mut fronts: Vec<Front> = fronts.into_values().collect();
        fronts.sort_by(|a, b| a.key.cmp(&b.key));
        fronts.iter_mut().for_each(|front| mark(&mut front.points));
        Fronts { fronts, superseded }
    }

    fn point(
        &self,
        entry: &Entry,
        index: usize,
        metric: &str,
        clock: &str,
        constraints: &[Constraint],
    ) -> Result<Point, String> {
        if let Some(why) = entry.ended.excluded() {
            return Err(why.to_owned());
        }
        let own = self.clock(entry);
        if own != clock {
            return Err(format!("timed by the clock {own:?}, not {clock:?}"));
        }
        for Constraint { name, at_most } in constraints {
            match self.value(entry, name) {
                None => return Err(format!("constraint {name} was not measured")),
                Some(value) if value <= *at_most => {}
                Some(value) => {
                    return Err(format!("constraint {name} is {value}, above {at_most}"));
                }
            }
        }
        if entry.median_ns.is_nan() {
            return Err("no samples".to_owned());
        }
        match self.value(entry, metric) {
            None => Err(format!("{metric} was not measured")),
            Some(error) if !error.is_finite() => Err(format!("{metric} is {error}")),
            Some(error) => Ok(Point {
                index,
                time_ns: entry.median_ns,
                mad_ns: entry.mad_ns,
                error,
                on_front: false,
                dominated_by: None,
            }),
        }
    }
}
