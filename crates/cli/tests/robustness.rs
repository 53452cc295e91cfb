//! What a hostile machine, or a hurried user, does to the program.

mod common;

use common::{dapple, run, said};
use dapple_records::{Row, Status};
use std::{
    fs,
    path::Path,
    process::{Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

const PATIENCE: Duration = Duration::from_secs(120);

/// A sweep of a few seconds: `cases` cases of every `cpu` technique.
fn sweep(folder: &Path, cases: usize, head: &str) {
    let seeds: Vec<_> = (1..=cases).map(|seed| seed.to_string()).collect();
    let text = format!(
        "about = 'robustness'\n{head}\n[[measure]]\nproblem = 'partition-offsets'\n\
         seeds = [{}]\nforms = ['cpu']\n\
         parameters = {{ leaves = [200000], cells = [512], frames = [24] }}\n",
        seeds.join(",")
    );
    fs::write(folder.join("sweep.toml"), text).unwrap();
}

fn measure(folder: &Path) -> Command {
    let mut command = dapple(folder);
    command.args(["measure", "--sweep", "sweep.toml"]).stdout(Stdio::null());
    command
}

/// Every row line on disk, doubled ones too.
fn rows(folder: &Path) -> Vec<Row> {
    let Ok(entries) = fs::read_dir(folder.join("records")) else { return Vec::new() };
    let texts = entries.map(|entry| fs::read_to_string(entry.unwrap().path()).unwrap());
    let text: String = texts.collect();
    text.lines().filter_map(|line| Row::from_line(line).ok()).collect()
}

#[track_caller]
fn wait_until(what: &str, mut reached: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !reached() {
        assert!(Instant::now() < deadline, "not within two minutes: {what}");
        thread::sleep(Duration::from_millis(5));
    }
}

#[track_caller]
fn expect(output: &Output, code: i32, parts: &[&str]) {
    let text = said(output);
    assert_eq!(output.status.code(), Some(code), "{text}");
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
    assert!(!text.contains("panicked"), "{text}");
}

#[test]
fn arguments_that_would_silently_change_nothing_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let hard = ["measure", "shadow-filtering", "--technique", "hard", "--form", "cpu"];
    for (more, part) in [
        (["--knob", "layers=4"], "no knob `layers`"),
        (["--repeats", "0"], "1..="),
        (["--knob", "resolution="], "must be an integer"),
    ] {
        expect(&run(at, &[&hard[..], &more].concat()), 2, &[part]);
    }
    expect(&run(at, &["verify", "--cases", "0"]), 2, &["1.."]);
    let two = ["--scene", "half_plane", "--scene", "spheres"];
    let render = ["render", "shadow-filtering", "vsm"];
    expect(&run(at, &[&render[..], &two].concat()), 2, &["this names 2"]);
    expect(&run(at, &["scene", "generate", "spheres", "-o", "x.obj"]), 2, &[".glb"]);
    assert!(!at.join("x.obj").exists());
    assert!(!at.join("records").exists());
}

#[test]
fn an_error_says_its_cause_once() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &["scene", "inspect", "absent.obj"]);
    expect(&output, 2, &["No such file"]);
    assert_eq!(said(&output).matches("No such file").count(), 1, "{}", said(&output));
}

#[cfg(unix)]
#[test]
fn an_argument_that_is_no_text_is_a_path_like_any_other() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    sweep(folder.path(), 1, "repeats = 1");
    let name = std::ffi::OsStr::from_bytes(b"r\xff");
    let output = measure(folder.path()).arg("--records").arg(name).output().unwrap();
    expect(&output, 0, &[]);
    assert!(folder.path().join(name).is_dir());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_or_error_is_no_panic() {
    let folder = tempfile::tempdir().unwrap();
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    sweep(folder.path(), 1, "repeats = 1");
    expect(&measure(folder.path()).output().unwrap(), 0, &[]);
    let verbs: [&[&str]; 7] = [
        &[],
        &["list"],
        &["list", "--format", "csv"],
        &["front"],
        &["front", "--format", "jsonl"],
        &["doctor"],
        &["scene", "inspect", "spheres"],
    ];
    for verb in verbs {
        let output = dapple(folder.path()).args(verb).stdout(full()).output().unwrap();
        expect(&output, 3, &["No space left"]);
    }
    let output = measure(folder.path()).stderr(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn a_sweep_whose_notes_nobody_reads_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    // The note that a missing scene gets would meet a closed pipe.
    sweep(folder.path(), 2, "repeats = 1");
    let mut text = fs::read_to_string(folder.path().join("sweep.toml")).unwrap();
    text += "[[measure]]\nproblem = 'shadow-filtering'\nforms = ['cpu']\nscenes = ['half_plane']\n\
             [[measure.technique]]\nid = 'hard'\n";
    fs::write(folder.path().join("sweep.toml"), text).unwrap();
    let mut child = measure(folder.path()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    child.wait().unwrap();
    assert!(rows(folder.path()).iter().any(|row| row.problem == "shadow-filtering"));
}

#[test]
fn two_sweeps_at_once_never_fill_one_file() {
    let folder = tempfile::tempdir().unwrap();
    sweep(folder.path(), 6, "repeats = 3");
    let mut first = measure(folder.path()).stderr(Stdio::null()).spawn().unwrap();
    wait_until("a first row", || !rows(folder.path()).is_empty());
    let second = measure(folder.path()).output().unwrap();
    assert!(first.try_wait().unwrap().is_none(), "the first sweep was too short to meet another");
    expect(&second, 3, &["being written by another process", "--fresh"]);
    let fresh = measure(folder.path()).arg("--fresh").output().unwrap();
    expect(&fresh, 0, &[]);
    assert!(first.wait().unwrap().success());
    let mut keys: Vec<_> = rows(folder.path()).into_iter().map(|r| (r.run, r.group)).collect();
    let count = keys.len();
    keys.sort();
    keys.dedup();
    assert_eq!(keys.len(), count, "a row is doubled");
    assert_eq!(fs::read_dir(folder.path().join("records")).unwrap().count(), 2);
}

#[test]
fn fronts_of_two_machines_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    sweep(at, 1, "repeats = 1");
    expect(&measure(at).output().unwrap(), 0, &[]);
    let front = |at: &Path| String::from_utf8(run(at, &["front"]).stdout).unwrap();
    assert!(!front(at).contains("machine: "), "{}", front(at));
    let file = fs::read_dir(at.join("records")).unwrap().next().unwrap().unwrap().path();
    let machine = rows(at)[0].machine.clone();
    let text = fs::read_to_string(&file).unwrap().replace(&machine, "elsewhere");
    fs::write(at.join("records/other.jsonl"), text.replace(&rows(at)[0].run, "b")).unwrap();
    let both = front(at);
    assert!(both.contains(&format!("machine: {machine}")), "{both}");
    assert!(both.contains("machine: elsewhere"), "{both}");
}

#[test]
fn damaged_and_foreign_records_are_passed_over_with_a_word() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    sweep(at, 1, "repeats = 1");
    expect(&measure(at).output().unwrap(), 0, &[]);
    let records = at.join("records");
    fs::write(records.join("a.jsonl"), [0, 159, 146, 150, b'\n', b'{']).unwrap();
    fs::write(records.join("b.jsonl"), "{\"kind\":\"row\",\"schema\":99}\n").unwrap();
    fs::create_dir(records.join("c.jsonl")).unwrap();
    expect(&run(at, &["front"]), 0, &["lines skipped"]);
    expect(&run(at, &["front", "--records", "records/b.jsonl"]), 2, &["no rows", "schema 99"]);
    expect(&run(at, &[]), 0, &[]);
    // They are in nobody's way when a sweep looks for work to resume.
    expect(&measure(at).output().unwrap(), 0, &[]);
}

#[cfg(unix)]
mod signals {
    use super::*;

    fn kill(signal: &str, pid: u32) {
        let pid = pid.to_string();
        assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
    }

    /// What /proc says of a process from its state on: state, parent, ...; empty if it is gone.
    #[cfg(target_os = "linux")]
    fn stat(pid: u32) -> Vec<String> {
        let text = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
        // The name before may hold anything.
        let rest = text.rsplit_once(')').map_or("", |(_, rest)| rest);
        rest.split_whitespace().map(Into::into).collect()
    }

    #[cfg(target_os = "linux")]
    fn is_alive(pid: u32) -> bool {
        // A zombie that nobody has waited for is dead.
        stat(pid).first().is_some_and(|state| state != "Z")
    }

    /// The process that measures for `runner`, once it hangs: it uses no more processor time.
    #[cfg(target_os = "linux")]
    fn hanging_worker(runner: u32) -> u32 {
        let worker = || {
            let pids = fs::read_dir("/proc").unwrap();
            let mut pids = pids.filter_map(|e| e.ok()?.file_name().to_str()?.parse::<u32>().ok());
            pids.find(|pid| {
                let command = fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
                stat(*pid).get(1) == Some(&runner.to_string())
                    && String::from_utf8_lossy(&command).contains("run-group")
            })
        };
        wait_until("a measuring process", || worker().is_some());
        let worker = worker().unwrap();
        let used = || stat(worker).get(11..13).map(<[String]>::to_vec);
        wait_until("a hang", || {
            let before = used();
            thread::sleep(Duration::from_millis(1500));
            before == used()
        });
        worker
    }

    #[test]
    fn a_request_to_terminate_is_an_interrupt() {
        for signal in ["-TERM", "-HUP"] {
            let folder = tempfile::tempdir().unwrap();
            sweep(folder.path(), 8, "repeats = 3");
            let child = measure(folder.path()).stderr(Stdio::piped()).spawn().unwrap();
            wait_until("a first row", || !rows(folder.path()).is_empty());
            kill(signal, child.id());
            let output = child.wait_with_output().unwrap();
            expect(&output, 3, &["interrupted", "the same command resumes"]);
            assert!(rows(folder.path()).iter().all(|row| row.status == Status::Ok));
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_killed_runner_leaves_no_orphan_to_disturb_the_next() {
        let folder = tempfile::tempdir().unwrap();
        sweep(folder.path(), 1, "repeats = 1");
        let mut runner = measure(folder.path())
            .args(["--fault", "hang:cpu-threads"])
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let worker = hanging_worker(runner.id());
        assert!(is_alive(worker));
        runner.kill().unwrap();
        runner.wait().unwrap();
        wait_until("the end of the orphan", || !is_alive(worker));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_killed_measuring_process_costs_one_setting() {
        let folder = tempfile::tempdir().unwrap();
        sweep(folder.path(), 1, "repeats = 1");
        let runner = measure(folder.path())
            .args(["--fault", "hang:cpu-threads"])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        kill("-KILL", hanging_worker(runner.id()));
        let output = runner.wait_with_output().unwrap();
        expect(&output, 1, &["SIGKILL", "cpu-threads"]);
        let rows = rows(folder.path());
        let failed: Vec<_> = rows.iter().filter(|row| row.status != Status::Ok).collect();
        assert_eq!(failed.len(), 1, "{failed:?}");
        assert!(rows.len() > 1);
    }
}
