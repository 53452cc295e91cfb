//! Criterion over checked suite cases: a case is checked and leaves a record before its clock
//! starts, and a frame that took no time is an error.

use criterion::{BenchmarkGroup, Criterion, measurement::WallTime};
use dapple_gpu::Gpu;
use dapple_records::{RunHeader, Status, Writer, new_run_id, now};
use dapple_suite::{
    environment::environment,
    plan::{Group, Plan},
    problem::{Form, Subject},
    problems,
    run::{
        child,
        protocol::{Event, Job},
    },
    sweep::Sweep,
};
use std::{path::Path, time::Duration};

/// Benches every setting of a sweep (TOML). Settings of form `gpu` are named as not run where
/// there is no adapter.
///
/// # Panics
/// A case that fails its check, or records that cannot be written: a bench must not time what is
/// wrong.
#[expect(clippy::panic, clippy::expect_used, clippy::print_stderr, reason = "a bench harness")]
pub fn sweep(criterion: &mut Criterion, name: &str, toml: &str) {
    let sweep = Sweep::parse(Path::new(name), toml).expect("the bench's own sweep");
    let plan = sweep.plan(name).expect("the bench's own sweep");
    let gpu = match Gpu::open(&dapple_gpu::AdapterChoice::Auto) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            eprintln!("gpu forms are not run: {error}");
            None
        }
    };
    let mut writer = Writer::create(&records(), &header(&plan)).expect("a record file");
    for group in &plan.groups {
        let form = group.settings[0].form;
        if form == Form::Gpu && gpu.is_none() {
            continue;
        }
        record(&mut writer, group);
        let problem = problems::find(&group.case.problem).expect("a problem of the plan");
        let adapter = gpu.as_ref().filter(|_| form == Form::Gpu);
        let prepared = problem.prepare(&group.case, adapter).expect("a case that can be prepared");
        let mut benches = criterion.benchmark_group(group.title().replace(' ', "/"));
        for setting in &group.settings {
            let mut subject = prepared.subject(setting).expect("a setting that passed its check");
            let id = format!("{}/{}", setting.technique, setting.variant);
            frames(&mut benches, &id, subject.as_mut());
        }
        benches.finish();
    }
    writer.end().unwrap_or_else(|e| panic!("closing the records: {e}"));
}

/// Where the records of benches go: beside those of `dapple measure`.
fn records() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../records")
}

fn header(plan: &Plan) -> RunHeader {
    let facts = environment();
    RunHeader {
        run: new_run_id(),
        sweep: format!("bench-{}", plan.name),
        sweep_hash: plan.hash(),
        command: "cargo bench".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        machine: facts.machine.clone(),
        cpu: facts.cpu.clone(),
        threads: facts.threads,
        memory_bytes: facts.memory_bytes,
        revision: facts.revision.clone(),
        dirty: facts.dirty,
        time: now(),
        ..RunHeader::default()
    }
}

/// Runs the group as the runner would, which checks it, and keeps its rows.
#[expect(clippy::panic, reason = "a bench must not time what is wrong")]
fn record(writer: &mut Writer, group: &Group) {
    let job = Job {
        run: writer.run().into(),
        group: group.clone(),
        todo: (0..group.settings.len()).collect(),
        banned: Vec::new(),
        repeats: 3,
        adapter: None,
        fault: None,
    };
    child::run(&job, &mut |event| match event {
        Event::Row(row) => {
            if let Status::Failed { stage, reason } = &row.status {
                panic!("{} {}: {stage}: {reason}", row.case, row.technique);
            }
            writer.append(&row).unwrap_or_else(|e| panic!("writing records: {e}"));
        }
        Event::Failed { reason, .. } => panic!("{}: {reason}", group.title()),
        _ => {}
    });
}

/// Times whole paths by the subject's own clock: the device's where it is sound.
#[expect(clippy::panic, reason = "a bench must not time what is wrong")]
fn frames(benches: &mut BenchmarkGroup<'_, WallTime>, id: &str, subject: &mut dyn Subject) {
    benches.sample_size(10).bench_function(id, |bencher| {
        bencher.iter_custom(|iterations| {
            let mut total = 0;
            for _ in 0..iterations {
                subject.reset().unwrap_or_else(|e| panic!("{id}: {e}"));
                for frame in 0..subject.frames() {
                    let time = subject.frame(frame).unwrap_or_else(|e| panic!("{id}: {e}"));
                    let ns = time.gpu_ns.unwrap_or(time.wall_ns);
                    assert!(ns > 0, "{id}: a frame took no time: the clock is broken");
                    total += ns;
                }
            }
            Duration::from_nanos(total)
        });
    });
}
