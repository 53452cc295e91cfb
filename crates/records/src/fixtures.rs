//! Valid rows for tests.

use std::collections::BTreeMap;

use proptest::test_runner::Config;

use crate::{Row, RunHeader};

/// 32 cases unless PROPTEST_CASES says otherwise.
pub(crate) fn config() -> Config {
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => Config::default(),
        None => Config::with_cases(32),
    }
}

/// A valid, timed row; `n` makes it a different one.
pub(crate) fn row(n: u64) -> Row {
    Row {
        run: "0123456789abcdef".into(),
        group: "g".into(),
        problem: "shadow-filtering".into(),
        technique: "vsm".into(),
        variant: "plain".into(),
        form: "gpu".into(),
        knobs: BTreeMap::from([("resolution".into(), n.into()), ("bias".into(), 0.002.into())]),
        case: "spheres".into(),
        scene: "spheres".into(),
        scene_hash: "feed".into(),
        view: "front".into(),
        size: "640x480".into(),
        adapter: "adapter".into(),
        driver: "driver 1".into(),
        device: "software".into(),
        cpu: "cpu".into(),
        threads: 2,
        revision: "abc".into(),
        dirty: true,
        shader_hash: "beef".into(),
        machine: "machine".into(),
        time: "2026-01-02T03:04:05.678Z".into(),
        clock: "gpu".into(),
        samples_ns: vec![vec![100 + n, 200], vec![300]],
        passes_ns: BTreeMap::from([("filter-x".into(), 60)]),
        baseline: "pcf".into(),
        ratio: Some(0.5),
        errors: BTreeMap::from([("rmse".into(), 0.1)]),
        port_errors: BTreeMap::from([("max_abs".into(), 1e-7)]),
        counters: BTreeMap::from([("texels".into(), u64::MAX)]),
        memory_bytes: 1 << 40,
        truth: "64 rays".into(),
        ..Row::default()
    }
    .identified()
}

pub(crate) fn header(run: &str) -> RunHeader {
    RunHeader {
        run: run.into(),
        sweep: "quick".into(),
        sweep_hash: "5eed".into(),
        command: "dapple measure".into(),
        time: "2026-01-02T03:04:05.678Z".into(),
        machine: "machine".into(),
        threads: 2,
        ..RunHeader::default()
    }
}
