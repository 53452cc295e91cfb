//! An expanded sweep: which settings are measured on which cases, in which groups.

use crate::{SuiteError, case::Case, problem::Setting};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Settings of one form measured side by side on one case, in one process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// Position in the whole sweep, which a part of it keeps.
    pub index: usize,
    /// The case.
    pub case: Case,
    /// The settings; the first is the one that ratios refer to.
    pub settings: Vec<Setting>,
    /// Whether the first setting is there for its ratio only and recorded by an earlier group.
    pub repeated_baseline: bool,
    /// Settings of the whole sweep's group between the first here and the second here: another
    /// part measures them.
    pub skipped: usize,
}

/// Everything a run measures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The sweep's name.
    pub name: String,
    /// Timed repeats of every setting.
    pub repeats: u32,
    /// Seconds a group may take.
    pub limit_s: u64,
    /// The groups, in order.
    pub groups: Vec<Group>,
    /// What was left out, and why.
    pub notes: Vec<String>,
    /// Which part of the sweep this is, as `i/n`; empty if it is the whole.
    pub shard: String,
}

/// Most parts that a sweep may be split into.
const MOST_SHARDS: usize = 100_000;

/// Reads `I/N`: part I of N parts, counted from 0.
///
/// # Errors
/// [`SuiteError::Value`] unless both are whole numbers with I below N, and N is at most 100000.
pub fn parse_shard(text: &str) -> Result<(usize, usize), SuiteError> {
    let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    text.split_once('/')
        // `+1` is a number to Rust, and a slip of the hand here.
        .filter(|(i, n)| digits(i) && digits(n))
        .and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)))
        .filter(|&(index, count)| index < count && count <= MOST_SHARDS)
        .ok_or_else(|| not_a_shard(text))
}

fn not_a_shard(text: &str) -> SuiteError {
    SuiteError::Value {
        what: "flag",
        name: "--shard".into(),
        value: text.into(),
        limit: format!("must be I/N with I below N, e.g. 0/4, and N at most {MOST_SHARDS}"),
    }
}

impl Plan {
    /// Rows the run will hold when finished.
    pub fn rows(&self) -> usize {
        self.groups.iter().map(Group::rows).sum()
    }

    /// Part `index` of `count`: the parts are disjoint and together the plan, and their rows
    /// differ by at most one in number. A part is a run of neighbours, so that few parts prepare
    /// the same case; where it begins in the middle of a group, the group's baseline is measured
    /// again for its ratios and recorded by its own part alone. Keys of rows are those of the
    /// whole plan. With more parts than rows some are empty.
    ///
    /// # Errors
    /// [`SuiteError::Value`] unless `index` is below `count` and `count` at most 100000.
    pub fn shard(&self, index: usize, count: usize) -> Result<Self, SuiteError> {
        let shard = format!("{index}/{count}");
        parse_shard(&shard)?;
        let total = self.rows();
        // Neither product overflows: a plan of 2^40 rows would not fit in memory.
        let (begin, end) = (total * index / count, total * (index + 1) / count);
        let mut groups = Vec::new();
        let mut before = 0;
        for group in &self.groups {
            let part = begin.max(before)..end.min(before + group.rows());
            if !part.is_empty() {
                groups.push(group.part(part.start - before..part.end - before));
            }
            before += group.rows();
        }
        Ok(Self { groups, shard, ..self.clone() })
    }

    /// Hash of all that decides which rows there are.
    pub fn hash(&self) -> String {
        // Serialising plain data to memory cannot fail; an empty text would only lose resumption.
        let text = serde_json::to_string(self).unwrap_or_default();
        blake3::hash(text.as_bytes()).to_hex()[..16].to_string()
    }
}

impl Group {
    /// Rows this group leaves.
    pub fn rows(&self) -> usize {
        self.settings.len() - usize::from(self.repeated_baseline)
    }

    /// The key of a setting's row within its run: that of the whole sweep, whatever part this is.
    pub fn key(&self, setting: usize) -> String {
        let skipped = if setting == 0 { 0 } else { self.skipped };
        format!("{:04}.{:03}", self.index, setting + skipped)
    }

    /// The rows of that range, with the baseline they need. The range is not empty.
    fn part(&self, rows: Range<usize>) -> Self {
        let first = usize::from(self.repeated_baseline);
        // Positions of the settings that follow the baseline.
        let from = (rows.start + first).max(1);
        let settings = self.settings[..1].iter().chain(&self.settings[from..rows.end + first]);
        Self {
            index: self.index,
            case: self.case.clone(),
            settings: settings.cloned().collect(),
            repeated_baseline: rows.start + first > 0,
            skipped: self.skipped + from - 1,
        }
    }

    /// A name for progress and logs.
    pub fn title(&self) -> String {
        let form = self.settings.first().map(|s| s.form.to_string()).unwrap_or_default();
        format!("{} {} {form}", self.case.problem, self.case.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Form;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// Groups of these sizes, the second and later of a case with a repeated baseline.
    fn plan(sizes: &[(usize, bool)]) -> Plan {
        let setting = |technique: String| Setting {
            technique,
            variant: String::new(),
            form: Form::Cpu,
            knobs: Default::default(),
        };
        let group = |index: usize, size: usize, repeated: bool| Group {
            index,
            case: Case {
                problem: "p".into(),
                scene: format!("scene-{index}"),
                view: String::new(),
                seed: 0,
                parameters: Default::default(),
            },
            settings: std::iter::once(setting("baseline".into()))
                .chain((1..size).map(|i| setting(format!("{index}-{i}"))))
                .collect(),
            repeated_baseline: repeated && size > 1,
            skipped: 0,
        };
        Plan {
            name: "p".into(),
            repeats: 1,
            limit_s: 1,
            groups: sizes.iter().enumerate().map(|(i, s)| group(i, s.0, s.1)).collect(),
            notes: Vec::new(),
            shard: String::new(),
        }
    }

    /// Key, case and setting of every row.
    fn rows(plan: &Plan) -> Vec<(String, String, String)> {
        let of = |group: &Group| {
            let first = usize::from(group.repeated_baseline);
            let all = first..group.settings.len();
            let row = |i: usize| {
                let technique = group.settings[i].technique.clone();
                (group.key(i), group.case.scene.clone(), technique)
            };
            all.map(row).collect::<Vec<_>>()
        };
        plan.groups.iter().flat_map(of).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn parts_are_disjoint_balanced_and_together_the_whole(
            sizes in prop::collection::vec((1_usize..9, any::<bool>()), 1..9),
            count in 1_usize..90,
        ) {
            let whole = plan(&sizes);
            let parts: Vec<Plan> = (0..count).map(|i| whole.shard(i, count).unwrap()).collect();
            let together: Vec<_> = parts.iter().flat_map(rows).collect();
            prop_assert_eq!(&together, &rows(&whole));
            let keys: BTreeSet<_> = together.iter().map(|row| &row.0).collect();
            prop_assert_eq!(keys.len(), together.len());
            let sizes: Vec<usize> = parts.iter().map(Plan::rows).collect();
            prop_assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
            let hashes: BTreeSet<_> = parts.iter().map(Plan::hash).collect();
            prop_assert_eq!(hashes.len(), count, "two parts would resume each other's run");
            // Every ratio refers to the same baseline as in the whole.
            for group in parts.iter().flat_map(|p| &p.groups) {
                prop_assert_eq!(&group.settings[0].technique, "baseline");
                prop_assert!(group.rows() > 0);
            }
        }

        #[test]
        fn a_part_of_a_part_still_has_the_keys_of_the_whole(
            sizes in prop::collection::vec((1_usize..9, any::<bool>()), 1..5),
            count in 1_usize..6,
        ) {
            let whole = plan(&sizes);
            let mut together = Vec::new();
            for i in 0..count {
                let part = whole.shard(i, count).unwrap();
                together.extend((0..3).flat_map(|j| rows(&part.shard(j, 3).unwrap())));
            }
            prop_assert_eq!(together, rows(&whole));
        }
    }

    /// Control: a split that forgets that a group's keys go on would give two rows one key.
    #[test]
    fn keys_without_what_was_skipped_would_clash() {
        let whole = plan(&[(4, false)]);
        let mut parts: Vec<Plan> = (0..2).map(|i| whole.shard(i, 2).unwrap()).collect();
        parts.iter_mut().flat_map(|p| &mut p.groups).for_each(|g| g.skipped = 0);
        let keys: BTreeSet<String> = parts.iter().flat_map(rows).map(|row| row.0).collect();
        assert!(keys.len() < 4, "{keys:?}");
    }

    #[test]
    fn parts_that_are_none_are_refused_with_the_limit() {
        assert_eq!(parse_shard("0/1").unwrap(), (0, 1));
        assert_eq!(parse_shard("99999/100000").unwrap(), (99_999, 100_000));
        for text in [
            "4/4",
            "a/b",
            "0/0",
            "",
            "/",
            "1",
            "-1/4",
            "+1/4",
            "0/100001",
            "0/4/4",
            "0/99999999999999999999",
        ] {
            let error = parse_shard(text).unwrap_err();
            assert!(error.to_string().contains("must be I/N with I below N"), "{text}: {error}");
            assert_eq!(error.exit_code(), 2);
        }
        assert!(plan(&[(1, false)]).shard(2, 2).is_err());
    }
}
