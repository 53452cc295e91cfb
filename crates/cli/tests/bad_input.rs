//! Bad input gets a clear error with its exit code, and loses nothing.

mod common;

use common::{run, said};
use std::{fs, path::Path, process::Command};

/// Runs and expects a code and a text on standard error.
#[track_caller]
fn refuses(folder: &Path, arguments: &[&str], code: i32, expect: &[&str]) {
    let output = run(folder, arguments);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    for part in expect {
        assert!(text.contains(part), "{arguments:?}: `{part}` is not in: {text}");
    }
    assert!(!text.contains("panicked"), "{arguments:?}: {text}");
}

fn measure<'a>(scene: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let base =
        ["measure", "shadow-filtering", "--form", "cpu", "--technique", "hard", "--scene", scene];
    [&base[..], more].concat()
}

#[test]
fn unknown_names_say_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    refuses(at, &["measure", "nothing"], 2, &["no problem `nothing`", "shadow-filtering"]);
    refuses(at, &["measure", "--sweep", "nothing"], 2, &["no sweep `nothing`", "quick"]);
    refuses(at, &["measure", "--sweep", "absent.toml"], 3, &["absent.toml"]);
    refuses(at, &["verify", "--technique", "nothing"], 2, &["no technique `nothing`", "vsm"]);
    refuses(at, &["claims", "shadow-filtering", "--id", "x"], 2, &["no claim `x`"]);
    refuses(at, &["scene", "inspect", "nothing"], 2, &["no scene `nothing`", "spheres"]);
    refuses(at, &["front", "shadow-filtering"], 3, &["records"]);
    refuses(at, &["frobnicate"], 2, &["frobnicate"]);
    refuses(at, &["measure"], 2, &["--sweep"]);
    let vsm = ["measure", "shadow-filtering", "--technique", "vsm/none"];
    refuses(at, &vsm, 2, &["no variant `vsm/none`", "plain"]);
}

#[test]
fn knobs_out_of_range_are_named_with_their_limit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (flag, expect) in [
        ("resolution=0", "must be an integer in"),
        ("resolution=many", "must be an integer in"),
        ("resolution=999999999", "must be an integer in"),
        ("bias=NaN", "must be a number in"),
        ("nothing=1", "no knob `nothing`"),
        ("resolution", "expected NAME=VALUE"),
    ] {
        refuses(at, &measure("half_plane", &["--knob", flag]), 2, &[expect]);
    }
    let param = measure("half_plane", &["--param", "width=-3"]);
    refuses(at, &param, 2, &["parameter `width`"]);
}

#[test]
fn broken_scenes_are_named_with_file_and_element() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("index.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").unwrap();
    fs::write(at.join("nan.obj"), "v 0 0 NaN\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(at.join("empty.obj"), "").unwrap();
    fs::write(at.join("short.glb"), b"glTF\x02\x00\x00\x00\xff\xff\x00\x00JS").unwrap();
    fs::write(at.join("scene.xyz"), "what").unwrap();
    for (file, expect) in [
        ("absent.obj", "absent.obj"),
        ("index.obj", "index.obj"),
        ("nan.obj", "nan.obj"),
        ("empty.obj", "empty.obj"),
        ("short.glb", "short.glb"),
        ("scene.xyz", "scene.xyz"),
    ] {
        refuses(at, &["scene", "inspect", file], 2, &[expect]);
        // As a measurement: the reason is printed, and the row that says so is on disk.
        let records = format!("records-{file}");
        refuses(at, &measure(file, &["--records", &records]), 2, &[expect]);
        let read = dapple_records::read_dir(&at.join(records)).unwrap();
        assert_eq!(read.rows.len(), 1, "{file}");
        assert!(matches!(read.rows[0].status, dapple_records::Status::Failed { .. }));
    }
}

#[test]
fn a_light_without_area_is_named_with_its_limit() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let mut scene = dapple_scene::generate::by_name("cube", 0).unwrap();
    let [centre, half_u, half_v] = [[0.0, 9.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.7512]];
    scene.lights.push(dapple_scene::Light::Area {
        centre: centre.into(),
        half_u: half_u.into(),
        half_v: half_v.into(),
    });
    let path = at.join("lamp.glb");
    dapple_scene::write_glb(&scene, &path).unwrap();
    assert!(run(at, &["scene", "inspect", "lamp.glb"]).status.success());
    // No valid scene can be written with it, so its one distance is struck out in the file.
    let mut bytes = fs::read(&path).unwrap();
    let found = bytes.windows(6).position(|w| w == b"0.7512").expect("the light's half side");
    bytes[found..found + 6].copy_from_slice(b"0.0000");
    fs::write(&path, bytes).unwrap();
    refuses(at, &["scene", "inspect", "lamp.glb"], 2, &["lamp.glb", "area", "more than 0"]);
    refuses(at, &measure("lamp.glb", &[]), 2, &["lamp.glb", "area"]);
}

#[test]
fn test_data_that_are_not_at_hand_say_how_to_get_them() {
    let folder = tempfile::tempdir().unwrap();
    refuses(folder.path(), &measure("data:trees/oak.obj", &[]), 2, &["DAPPLE_DATA"]);
}

#[test]
fn records_that_cannot_be_written_stop_the_run_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("file"), "").unwrap();
    refuses(at, &measure("half_plane", &["--records", "file/records"]), 3, &["file/records"]);
}

/// A limit on file sizes makes writes fail as a full disk does: after some rows, in a row.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_rows_that_fitted() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec {} measure partition-offsets --form cpu \
         --param leaves=100,200,300,400 --param frames=3",
        env!("CARGO_BIN_EXE_dapple")
    );
    let output = Command::new("bash").args(["-c", &script]).current_dir(at).output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(said(&output).contains("records"), "{}", said(&output));
    let read = dapple_records::read_dir(&at.join("records")).unwrap();
    assert!(!read.rows.is_empty() && read.rows.len() < 8, "{} rows", read.rows.len());
}

#[test]
fn an_adapter_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let output = run(at, &["verify", "--adapter", "no-such-adapter"]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
}
