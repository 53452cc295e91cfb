//! One measurement, or one failure.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::error::RecordError;
use crate::fields::{Fields, Object};
use crate::line::Line;

/// How a measurement ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Status {
    /// Checked, and timed unless the clock is `none`.
    #[default]
    Ok,
    /// A check failed, or the technique crashed, hung or lost the device. Never has times.
    Failed {
        /// Where: e.g. `prepare`, `port`, `constraint`, `time limit`.
        stage: String,
        /// Why, for people.
        reason: String,
    },
    /// Left out, e.g. `no adapter`. Never has times.
    NotRun {
        /// Why, for people.
        reason: String,
    },
}

/// One measurement (or failure). Written as one flat JSON line: see [`Row::to_line`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// The run's id.
    pub run: String,
    /// What was measured: [`Row::identity`].
    pub row: String,
    /// The interleaved group that this row was measured in.
    pub group: String,
    /// Problem id, e.g. `shadow-filtering`.
    pub problem: String,
    /// Technique id, e.g. `vsm`.
    pub technique: String,
    /// Named change of the technique; empty if it has none.
    pub variant: String,
    /// `reference`, `cpu` or `gpu`.
    pub form: String,
    /// Settings; scalars only. Keys `knob.NAME`.
    pub knobs: BTreeMap<String, Value>,
    /// Case id.
    pub case: String,
    /// Scene name or file name.
    pub scene: String,
    /// Hash of the scene's content.
    pub scene_hash: String,
    /// View or camera path.
    pub view: String,
    /// Size of the output, e.g. `640x480`.
    pub size: String,
    /// Graphics adapter's name; `cpu` for forms that use none.
    pub adapter: String,
    /// Driver and its version.
    pub driver: String,
    /// `hardware`, `software` or `cpu`.
    pub device: String,
    /// Processor's name.
    pub cpu: String,
    /// Threads that the measured code may use.
    pub threads: u32,
    /// Source revision of the program.
    pub revision: String,
    /// Whether the source had uncommitted changes.
    pub dirty: bool,
    /// Hash of all shaders; may be empty for forms that use none.
    pub shader_hash: String,
    /// Which machine: equal for two rows only if their times may be compared.
    pub machine: String,
    /// When the row was finished, RFC 3339 UTC (see [`crate::time`]).
    pub time: String,
    /// Outcome.
    pub status: Status,
    /// `gpu` (timestamps), `wall`, or `none` for a row that is not timed (reference forms,
    /// counters only).
    pub clock: String,
    /// Raw frame times, `[repeat][frame]`. Key `samples_ns`.
    pub samples_ns: Vec<Vec<u64>>,
    /// Median of each pass. Keys `pass.NAME_ns`.
    pub passes_ns: BTreeMap<String, u64>,
    /// Technique id of the group's baseline.
    pub baseline: String,
    /// Median, over paired samples, of this time over the baseline's.
    pub ratio: Option<f64>,
    /// Method errors against the ground truth, finite. Keys `error.NAME`.
    pub errors: BTreeMap<String, f64>,
    /// Port errors against the reference form, finite. Keys `port.NAME`.
    pub port_errors: BTreeMap<String, f64>,
    /// Hardware-independent work. Keys `counter.NAME`.
    pub counters: BTreeMap<String, u64>,
    /// Peak memory of the technique's own data. Key `memory_bytes`.
    pub memory_bytes: u64,
    /// The truth's parameters, for people.
    pub truth: String,
}

impl Row {
    /// What was measured, as 16 hexadecimal digits: a hash of problem, technique, variant, form,
    /// knobs, case, scene hash, view, size, adapter, threads and truth.
    ///
    /// Not in it: run, group, time, revision, shaders and driver version, so that two runs can be
    /// compared across them; nor machine and CPU, which a comparison matches on its own. Knobs `1`
    /// and `1.0` are the same setting.
    pub fn identity(&self) -> String {
        let mut hash = blake3::Hasher::new();
        let mut put = |text: &str| {
            // Lengths first: ("ab", "c") and ("a", "bc") differ.
            hash.update(&(text.len() as u64).to_le_bytes());
            hash.update(text.as_bytes());
        };
        for text in [&self.problem, &self.technique, &self.variant, &self.form] {
            put(text);
        }
        put(&self.knobs.len().to_string());
        for (name, value) in &self.knobs {
            put(name);
            put(&canonical(value));
        }
        for text in [&self.case, &self.scene_hash, &self.view, &self.size, &self.adapter] {
            put(text);
        }
        put(&self.threads.to_string());
        put(&self.truth);
        hash.finalize().to_hex().as_str().chars().take(16).collect()
    }

    /// Sets `row` to [`Row::identity`].
    #[must_use]
    pub fn identified(mut self) -> Self {
        self.row = self.identity();
        self
    }

    /// Median over repeats of each repeat's median frame. None without samples.
    pub fn median_ns(&self) -> Option<f64> {
        median_ns(&self.samples_ns)
    }

    /// Median absolute deviation of the repeats' medians from [`Row::median_ns`], unscaled.
    pub fn mad_ns(&self) -> Option<f64> {
        mad_ns(&self.samples_ns)
    }

    /// 99th percentile of all frames of all repeats, by nearest rank: the smallest sample that at
    /// least 99 % of the samples do not exceed.
    pub fn p99_ns(&self) -> Option<f64> {
        p99_ns(&self.samples_ns)
    }

    /// One JSON line, without its line feed.
    ///
    /// `median_ns`, `mad_ns` and `p99_ns` are added for readers that query the file directly; this
    /// crate ignores them and derives them again from `samples_ns`. A non-finite number is `null`.
    pub fn to_line(&self) -> String {
        self.object().to_line()
    }

    /// Keys and values of [`Row::to_line`], in its order.
    pub(crate) fn object(&self) -> Object {
        let mut out = Object::new("row");
        for (key, text) in [
            ("run", &self.run),
            ("row", &self.row),
            ("group", &self.group),
            ("problem", &self.problem),
            ("technique", &self.technique),
            ("variant", &self.variant),
            ("form", &self.form),
        ] {
            out.put(key, text.as_str());
        }
        for (name, value) in &self.knobs {
            out.put(format!("knob.{name}"), value.clone());
        }
        for (key, text) in [
            ("case", &self.case),
            ("scene", &self.scene),
            ("scene_hash", &self.scene_hash),
            ("view", &self.view),
            ("size", &self.size),
            ("truth", &self.truth),
            ("adapter", &self.adapter),
            ("driver", &self.driver),
            ("device", &self.device),
            ("cpu", &self.cpu),
        ] {
            out.put(key, text.as_str());
        }
        out.put("threads", self.threads);
        out.put("revision", self.revision.as_str());
        out.put("dirty", self.dirty);
        out.put("shader_hash", self.shader_hash.as_str());
        out.put("machine", self.machine.as_str());
        out.put("time", self.time.as_str());
        match &self.status {
            Status::Ok => out.put("status", "ok"),
            Status::Failed { stage, reason } => {
                out.put("status", "failed");
                out.put("stage", stage.as_str());
                out.put("reason", reason.as_str());
            }
            Status::NotRun { reason } => {
                out.put("status", "not_run");
                out.put("reason", reason.as_str());
            }
        }
        for (name, value) in &self.errors {
            out.put(format!("error.{name}"), *value);
        }
        for (name, value) in &self.port_errors {
            out.put(format!("port.{name}"), *value);
        }
        for (name, value) in &self.counters {
            out.put(format!("counter.{name}"), *value);
        }
        out.put("memory_bytes", self.memory_bytes);
        out.put("clock", self.clock.as_str());
        for (key, value) in
            [("median_ns", self.median_ns()), ("mad_ns", self.mad_ns()), ("p99_ns", self.p99_ns())]
        {
            if let Some(ns) = value {
                out.put(key, ns);
            }
        }
        out.put("baseline", self.baseline.as_str());
        if let Some(ratio) = self.ratio {
            out.put("ratio", ratio);
        }
        for (name, value) in &self.passes_ns {
            out.put(format!("pass.{name}_ns"), *value);
        }
        out.put("samples_ns", self.samples_ns.clone());
        out
    }

    /// Reads one `row` line. Required keys: run, row, problem, technique, form, case, status.
    ///
    /// # Errors
    /// What is wrong with the line, naming the key.
    pub fn from_line(line: &str) -> Result<Self, RecordError> {
        match Line::parse(line.as_bytes())? {
            Line::Row(row) => Ok(*row),
            Line::Header(_) => Err(RecordError::Kind("run".to_owned())),
            Line::End(_) => Err(RecordError::Kind("end".to_owned())),
            Line::Gate(_) => Err(RecordError::Kind("gate".to_owned())),
            Line::Claim(_) => Err(RecordError::Kind("claim".to_owned())),
            Line::Stress(_) => Err(RecordError::Kind("stress".to_owned())),
        }
    }

    pub(crate) fn from_fields(f: &mut Fields) -> Result<Self, RecordError> {
        let status = match f.required("status")?.as_str() {
            "ok" => Status::Ok,
            "failed" => Status::Failed { stage: f.text("stage")?, reason: f.text("reason")? },
            "not_run" => Status::NotRun { reason: f.text("reason")? },
            _ => return Err(crate::fields::type_error("status", "ok, failed or not_run")),
        };
        Ok(Self {
            run: f.required("run")?,
            row: f.required("row")?,
            group: f.text("group")?,
            problem: f.required("problem")?,
            technique: f.required("technique")?,
            variant: f.text("variant")?,
            form: f.required("form")?,
            knobs: f.values("knob."),
            case: f.required("case")?,
            scene: f.text("scene")?,
            scene_hash: f.text("scene_hash")?,
            view: f.text("view")?,
            size: f.text("size")?,
            adapter: f.text("adapter")?,
            driver: f.text("driver")?,
            device: f.text("device")?,
            cpu: f.text("cpu")?,
            threads: f.count32("threads")?,
            revision: f.text("revision")?,
            dirty: f.flag("dirty")?,
            shader_hash: f.text("shader_hash")?,
            machine: f.text("machine")?,
            time: f.text("time")?,
            status,
            clock: f.text("clock")?,
            samples_ns: f.samples("samples_ns")?,
            passes_ns: f.counts("pass.", "_ns")?,
            baseline: f.text("baseline")?,
            ratio: f.number("ratio")?,
            errors: f.numbers("error.")?,
            port_errors: f.numbers("port.")?,
            counters: f.counts("counter.", "")?,
            memory_bytes: f.count("memory_bytes")?,
            truth: f.text("truth")?,
        })
    }
}

/// Whole floats below 2^53 are written as integers, so that `1` and `1.0` agree.
fn canonical(value: &Value) -> String {
    match value.as_f64() {
        Some(v) if v.fract() == 0.0 && v.abs() < 9_007_199_254_740_992.0 => (v as i64).to_string(),
        _ => value.to_string(),
    }
}

pub(crate) fn median_ns(samples_ns: &[Vec<u64>]) -> Option<f64> {
    median(&mut repeat_medians(samples_ns))
}

pub(crate) fn mad_ns(samples_ns: &[Vec<u64>]) -> Option<f64> {
    median_and_mad_ns(samples_ns).map(|both| both.1)
}

pub(crate) fn median_and_mad_ns(samples_ns: &[Vec<u64>]) -> Option<(f64, f64)> {
    let mut repeats = repeat_medians(samples_ns);
    let centre = median(&mut repeats)?;
    let mut deviations: Vec<f64> = repeats.iter().map(|v| (v - centre).abs()).collect();
    Some((centre, median(&mut deviations)?))
}

pub(crate) fn p99_ns(samples_ns: &[Vec<u64>]) -> Option<f64> {
    let mut all: Vec<u64> = samples_ns.iter().flatten().copied().collect();
    let rank = (all.len() * 99).div_ceil(100).checked_sub(1)?;
    Some(*all.select_nth_unstable(rank).1 as f64)
}

fn repeat_medians(samples_ns: &[Vec<u64>]) -> Vec<f64> {
    let frames = |repeat: &Vec<u64>| -> Option<f64> {
        median(&mut repeat.iter().map(|&ns| ns as f64).collect::<Vec<_>>())
    };
    samples_ns.iter().filter_map(frames).collect()
}

/// Mean of the middle two for an even count. Sorts its argument.
fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    if values.len() % 2 == 1 {
        return Some(upper);
    }
    let lower = *values.get((values.len() / 2).checked_sub(1)?)?;
    Some(lower + (upper - lower) / 2.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::fixtures::{config, row};

    #[test]
    fn keys_carry_their_units_and_maps_are_flat() {
        let value: Value = serde_json::from_str(&row(7).to_line()).unwrap();
        assert_eq!(value["kind"], "row");
        assert_eq!(value["schema"], 1);
        assert_eq!(value["knob.resolution"], 7);
        assert_eq!(value["error.rmse"], 0.1);
        assert_eq!(value["port.max_abs"], 1e-7);
        assert_eq!(value["counter.texels"], u64::MAX);
        assert_eq!(value["pass.filter-x_ns"], 60);
        assert_eq!(value["memory_bytes"], 1_u64 << 40);
        assert_eq!(value["samples_ns"], serde_json::json!([[107, 200], [300]]));
        let flat = value.as_object().unwrap().values().all(|v| !v.is_object());
        assert!(flat);
    }

    #[test]
    fn summaries_are_hand_computed() {
        let timed = |samples_ns| Row { samples_ns, ..Row::default() };
        // Repeats' medians 2, 5, 20; deviations from 5: 3, 0, 15.
        let path = timed(vec![vec![3, 1, 2], vec![4, 6], vec![20]]);
        assert_eq!((path.median_ns(), path.mad_ns()), (Some(5.0), Some(3.0)));
        assert_eq!(path.p99_ns(), Some(20.0), "fewer than 100 samples: the greatest");
        assert_eq!(timed(vec![(1..=200).rev().collect()]).p99_ns(), Some(198.0));
        assert_eq!(timed(vec![(1..=100).collect()]).p99_ns(), Some(99.0));
        for none in [vec![], vec![vec![]]] {
            let row = timed(none);
            assert_eq!((row.median_ns(), row.mad_ns(), row.p99_ns()), (None, None, None));
        }
        assert_eq!(timed(vec![vec![u64::MAX; 2]]).median_ns(), Some(u64::MAX as f64));
    }

    #[test]
    fn identity_covers_what_was_measured_and_nothing_else() {
        type Change = fn(&mut Row);
        let inside: [Change; 13] = [
            |r| r.problem.push('x'),
            |r| r.technique.push('x'),
            |r| r.variant.push('x'),
            |r| r.form.push('x'),
            |r| drop(r.knobs.insert("bias".into(), 0.003.into())),
            |r| drop(r.knobs.remove("bias")),
            |r| r.case.push('x'),
            |r| r.scene_hash.push('x'),
            |r| r.view.push('x'),
            |r| r.size.push('x'),
            |r| r.adapter.push('x'),
            |r| r.threads += 1,
            |r| r.truth.push('x'),
        ];
        let outside: [Change; 8] = [
            |r| r.run.push('x'),
            |r| r.group.push('x'),
            |r| r.time.push('x'),
            |r| r.revision.push('x'),
            |r| r.driver.push('x'),
            |r| r.machine.push('x'),
            |r| r.status = Status::NotRun { reason: "x".into() },
            |r| r.samples_ns.clear(),
        ];
        let base = row(0).identity();
        assert_eq!(base.len(), 16);
        let changed = |change: &Change| {
            let mut row = row(0);
            change(&mut row);
            row.identity()
        };
        let mut seen: Vec<String> = inside.iter().map(changed).collect();
        seen.push(base.clone());
        seen.sort();
        seen.dedup();
        assert_eq!(seen.len(), inside.len() + 1);
        assert!(outside.iter().all(|change| changed(change) == base));
    }

    #[test]
    fn identity_keeps_fields_apart_and_numbers_together() {
        let of = |problem: &str, technique: &str, knob: Value| {
            let knobs = BTreeMap::from([("k".to_owned(), knob)]);
            Row { problem: problem.into(), technique: technique.into(), knobs, ..Row::default() }
                .identity()
        };
        assert_ne!(of("ab", "c", 1.into()), of("a", "bc", 1.into()));
        assert_eq!(of("a", "b", 1.into()), of("a", "b", 1.0.into()));
        assert_eq!(of("a", "b", 0.into()), of("a", "b", (-0.0).into()));
        assert_ne!(of("a", "b", 1.into()), of("a", "b", "1".into()), "text is no number");
        assert_ne!(of("a", "b", 1.into()), of("a", "b", 1.5.into()));
        assert_ne!(of("a", "b", u64::MAX.into()), of("a", "b", (u64::MAX - 1).into()));
    }

    #[test]
    fn what_is_not_finite_becomes_null_and_reads_as_nan() {
        let mut row = row(0);
        row.errors.insert("psnr".into(), f64::INFINITY);
        let line = row.to_line();
        assert!(line.contains(r#""error.psnr":null"#));
        assert!(Row::from_line(&line).unwrap().errors["psnr"].is_nan());
    }

    #[test]
    fn other_tools_may_write_counts_as_floats_but_not_fractions() {
        let line = row(0).to_line();
        let float = line.replace(r#""pass.filter-x_ns":60"#, r#""pass.filter-x_ns":60.0"#);
        assert_ne!(line, float);
        assert_eq!(Row::from_line(&float).unwrap(), row(0));
        for bad in ["60.5", "-60", "1e300", "\"60\"", "null"] {
            let line = line.replace(r#"_ns":60"#, &format!(r#"_ns":{bad}"#));
            assert!(Row::from_line(&line).is_err(), "{bad}");
        }
    }

    fn text() -> impl Strategy<Value = String> {
        prop::collection::vec(any::<char>(), 1..8).prop_map(|c| c.into_iter().collect())
    }

    fn number() -> impl Strategy<Value = f64> {
        use prop::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
        NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE
    }

    fn knob() -> impl Strategy<Value = Value> {
        prop_oneof![
            any::<i64>().prop_map(Value::from),
            number().prop_map(Value::from),
            any::<bool>().prop_map(Value::from),
            text().prop_map(Value::from),
        ]
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn lines_read_back_bit_for_bit(
            texts in prop::collection::vec(text(), 6),
            knobs in prop::collection::btree_map(text(), knob(), 0..5),
            errors in prop::collection::btree_map(text(), number(), 0..5),
            counters in prop::collection::btree_map(text(), any::<u64>(), 0..5),
            samples_ns in prop::collection::vec(prop::collection::vec(any::<u64>(), 0..5), 0..4),
            status in 0..3,
        ) {
            let [problem, technique, case, view, stage, reason] = &texts[..] else {
                return Err(TestCaseError::fail("six texts"));
            };
            let row = Row {
                problem: problem.clone(),
                technique: technique.clone(),
                case: case.clone(),
                view: view.clone(),
                status: match status {
                    0 => Status::Ok,
                    1 => Status::Failed { stage: stage.clone(), reason: reason.clone() },
                    _ => Status::NotRun { reason: reason.clone() },
                },
                knobs,
                ratio: errors.values().next().copied(),
                port_errors: errors.clone(),
                errors,
                passes_ns: counters.clone(),
                counters,
                samples_ns,
                ..row(1)
            }
            .identified();
            let line = row.to_line();
            prop_assert!(!line.contains('\n'));
            let read = Row::from_line(&line)?;
            prop_assert_eq!(read.identity(), row.identity());
            prop_assert_eq!(read, row);
        }
    }
}
