//! Which row after belongs to which row before.

use std::collections::{BTreeMap, BTreeSet};

use crate::front;
use crate::row::{Row, Status};

/// Positions that belong together.
#[derive(Default)]
pub(super) struct Joined {
    /// Of each two at least one is there.
    pub pairs: Vec<(Option<usize>, Option<usize>)>,
    /// See [`super::Comparison::refused`].
    pub refused: Vec<String>,
    /// See [`super::Comparison::superseded_old`].
    pub superseded_old: usize,
    /// See [`super::Comparison::superseded_new`].
    pub superseded_new: usize,
}

pub(super) fn join(old: &[Row], new: &[Row], any_machine: bool) -> Joined {
    let (before, mut after) = (counting(old, any_machine), counting(new, any_machine));
    let mut joined = Joined {
        superseded_old: old.len() - before.len(),
        superseded_new: new.len() - after.len(),
        ..Joined::default()
    };
    let mut left_old = Vec::new();
    for (key, a) in before {
        match after.remove(&key) {
            Some(b) => joined.pairs.push((Some(a), Some(b))),
            None => left_old.push(a),
        }
    }
    let mut left_new: Vec<usize> = after.into_values().collect();

    let by_setting = |rows: &[Row], i: usize| setting(&rows[i], any_machine);
    let of_setting = matched((old, &left_old), (new, &left_new), &by_setting, &|a, b| {
        is_unplaced(a) || is_unplaced(b)
    });
    take(&mut left_old, of_setting.iter().map(|pair| pair.0));
    take(&mut left_new, of_setting.iter().map(|pair| pair.1));
    joined.pairs.extend(of_setting.into_iter().map(|(a, b)| (Some(a), Some(b))));
    if !any_machine {
        joined.refused = refuse(old, new, &mut left_old, &mut left_new);
    }
    joined.pairs.extend(left_old.into_iter().map(|a| (Some(a), None)));
    joined.pairs.extend(left_new.into_iter().map(|b| (None, Some(b))));
    joined
}

/// What a row is called, for order and for people: problem, case, technique, variant, form, knobs.
pub(super) fn label(row: &Row) -> String {
    let knobs = serde_json::to_string(&row.knobs).unwrap_or_default();
    let names =
        [&row.problem, &row.case, &row.view, &row.technique, &row.variant, &row.form, &knobs];
    let place = [&row.truth, &row.size, &row.adapter, &row.machine];
    names.iter().chain(&place).map(|text| text.as_str()).collect::<Vec<_>>().join("\n")
}

type Key = (String, String);

fn place(row: &Row, any_machine: bool) -> String {
    if any_machine { String::new() } else { format!("{}\n{}", row.machine, row.cpu) }
}

/// What was measured and where.
fn key(row: &Row, any_machine: bool) -> Key {
    let what = if any_machine { portable(row) } else { row.identity() };
    (place(row, any_machine), what)
}

/// The identity less what a machine decides: adapter and threads.
fn portable(row: &Row) -> String {
    let work = Row {
        problem: row.problem.clone(),
        technique: row.technique.clone(),
        variant: row.variant.clone(),
        form: row.form.clone(),
        knobs: row.knobs.clone(),
        case: row.case.clone(),
        scene_hash: row.scene_hash.clone(),
        view: row.view.clone(),
        size: row.size.clone(),
        truth: row.truth.clone(),
        ..Row::default()
    };
    work.identity()
}

/// What is known of a row even where its case was never prepared: setting and case.
fn setting(row: &Row, any_machine: bool) -> Key {
    let known = Row {
        problem: row.problem.clone(),
        technique: row.technique.clone(),
        variant: row.variant.clone(),
        form: row.form.clone(),
        knobs: row.knobs.clone(),
        case: row.case.clone(),
        ..Row::default()
    };
    (place(row, any_machine), known.identity())
}

/// A failure or omission before the case was prepared: it knows no device, hence no adapter,
/// scene or truth.
fn is_unplaced(row: &Row) -> bool {
    row.status != Status::Ok && !["hardware", "software", "cpu"].contains(&row.device.as_str())
}

/// The rows that count, by key: the latest of each; and of an unplaced row and the placed rows of
/// its setting whichever is later, if it failed (an omission never stands in for a result).
fn counting(rows: &[Row], any_machine: bool) -> BTreeMap<Key, usize> {
    let borrowed: Vec<&Row> = rows.iter().collect();
    let mut counting: BTreeMap<Key, usize> = BTreeMap::new();
    for index in front::latest(&borrowed) {
        let kept = counting.entry(key(&rows[index], any_machine)).or_insert(index);
        if rows[*kept].time <= rows[index].time {
            *kept = index;
        }
    }
    let all: Vec<usize> = counting.values().copied().collect();
    let by_setting = |rows: &[Row], i: usize| setting(&rows[i], any_machine);
    let rivals = matched((rows, &all), (rows, &all), &by_setting, &|placed, unplaced| {
        !is_unplaced(placed) && is_unplaced(unplaced)
    });
    let beaten = |(placed, unplaced): (usize, usize)| {
        let failed = matches!(rows[unplaced].status, Status::Failed { .. });
        let stands = failed && rows[unplaced].time > rows[placed].time;
        if stands { placed } else { unplaced }
    };
    let beaten: BTreeSet<usize> = rivals.into_iter().map(beaten).collect();
    counting.retain(|_, i| !beaten.contains(i));
    counting
}

/// Takes positions out of a list.
fn take(list: &mut Vec<usize>, out: impl Iterator<Item = usize>) {
    let out: BTreeSet<usize> = out.collect();
    list.retain(|i| !out.contains(i));
}

type Rows<'a> = (&'a [Row], &'a [usize]);

/// Pairs of positions, one of each list, that share a key and may be paired. Where several share
/// one (cases that differ only in what an unplaced row does not know), those of the same place in
/// the plan; where there is still a choice, none.
fn matched(
    (old, left): Rows<'_>,
    (new, right): Rows<'_>,
    key: &dyn Fn(&[Row], usize) -> Key,
    may: &dyn Fn(&Row, &Row) -> bool,
) -> Vec<(usize, usize)> {
    let mut by_key: BTreeMap<Key, (Vec<usize>, Vec<usize>)> = BTreeMap::new();
    left.iter().for_each(|&a| by_key.entry(key(old, a)).or_default().0.push(a));
    right.iter().for_each(|&b| by_key.entry(key(new, b)).or_default().1.push(b));
    let mut pairs = Vec::new();
    for (left, right) in by_key.into_values() {
        let choices: Vec<(usize, usize)> = left
            .iter()
            .flat_map(|&a| right.iter().map(move |&b| (a, b)))
            .filter(|&(a, b)| may(&old[a], &new[b]))
            .collect();
        let only = |choices: &[(usize, usize)], (a, b): (usize, usize)| {
            choices.iter().filter(|c| c.0 == a || c.1 == b).count() == 1
        };
        let same_place: Vec<(usize, usize)> =
            choices.iter().copied().filter(|&(a, b)| old[a].group == new[b].group).collect();
        for &choice in &choices {
            if only(&choices, choice) || same_place.contains(&choice) && only(&same_place, choice) {
                pairs.push(choice);
            }
        }
    }
    pairs
}

/// Takes out the rows that were measured on both sides, on machines, processors, adapters or
/// threads that differ; and says so once for each two places.
fn refuse(
    old: &[Row],
    new: &[Row],
    left_old: &mut Vec<usize>,
    left_new: &mut Vec<usize>,
) -> Vec<String> {
    let mut elsewhere: BTreeMap<String, (Vec<usize>, Vec<usize>)> = BTreeMap::new();
    left_old.iter().for_each(|&a| elsewhere.entry(portable(&old[a])).or_default().0.push(a));
    left_new.iter().for_each(|&b| elsewhere.entry(portable(&new[b])).or_default().1.push(b));
    elsewhere.retain(|_, (a, b)| !a.is_empty() && !b.is_empty());

    let mut counts: BTreeMap<(String, String), usize> = BTreeMap::new();
    for (before, after) in elsewhere.values() {
        let places = |rows: &[Row], of: &[usize]| {
            let mut names: Vec<String> = of.iter().map(|&i| place_name(&rows[i])).collect();
            names.sort();
            names.dedup();
            names.join(" and ")
        };
        *counts.entry((places(old, before), places(new, after))).or_insert(0) += 1;
    }
    take(left_old, elsewhere.values().flat_map(|(before, _)| before.iter().copied()));
    take(left_new, elsewhere.values().flat_map(|(_, after)| after.iter().copied()));
    let sentence = |((old, new), count): ((String, String), usize)| {
        format!("{count} rows were measured on {old} before, on {new} after")
    };
    counts.into_iter().map(sentence).collect()
}

fn place_name(row: &Row) -> String {
    let device =
        if row.device == "cpu" { row.cpu.clone() } else { format!("adapter {}", row.adapter) };
    format!("{device} of machine {} with {} threads", row.machine, row.threads)
}
