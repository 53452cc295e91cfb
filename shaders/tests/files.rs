//! Every file is embedded, resolves and validates; each check has a control that fails.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use std::path::Path;

use dapple_shaders::{FILES, ShaderError, hash, paths, source, struct_layout, validate};

/// Fewer files than this mean that the list, not the shaders, got lost.
const FLOOR: usize = 6;

#[test]
fn every_entry_file_resolves_and_validates() {
    let mut checked = 0;
    for path in paths() {
        let text = source(path).unwrap_or_else(|e| panic!("{e}"));
        assert!(!text.contains("#import"), "{path}: an import is left");
        validate(path, &text).unwrap_or_else(|e| panic!("{e}"));
        checked += 1;
    }
    assert!(checked >= FLOOR, "only {checked} files");
}

#[test]
fn every_common_file_is_part_of_an_entry_file() {
    // Common files may call what their importers define, so they validate only there.
    let resolved: Vec<_> = paths().map(|path| source(path).unwrap()).collect();
    let mut checked = 0;
    for (path, _) in FILES.iter().filter(|(path, _)| path.starts_with("common/")) {
        let text = source(path).unwrap();
        let last = text.lines().rev().find(|line| line.contains("fn ")).unwrap_or(&text);
        assert!(resolved.iter().any(|entry| entry.contains(last)), "{path} is imported nowhere");
        checked += 1;
    }
    assert!(checked >= 1);
}

#[test]
fn entry_files_have_entry_points_and_common_ones_have_none() {
    let is_entry =
        |text: &str| ["@compute", "@vertex", "@fragment"].iter().any(|s| text.contains(s));
    for (path, text) in FILES {
        assert_eq!(is_entry(text), !path.starts_with("common/"), "{path}");
    }
    assert!(paths().count() >= FLOOR);
}

/// Files below `root` that end in .wgsl and are not in `known`, as paths relative to it.
fn orphans(root: &Path, known: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    let mut folders = vec![root.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "wgsl") {
                let relative = path.strip_prefix(root).unwrap();
                let parts: Vec<_> = relative.iter().map(|p| p.to_string_lossy()).collect();
                found.push(parts.join("/"));
            }
        }
    }
    found.retain(|path| !known.contains(&path.as_str()));
    found.sort();
    found
}

#[test]
fn no_file_in_the_folder_is_left_out_of_the_list() {
    let known: Vec<_> = FILES.iter().map(|(path, _)| *path).collect();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_eq!(orphans(root, &known), [""; 0]);
    // Control: with one entry taken out of the list, its file is the orphan.
    assert_eq!(orphans(root, &known[1..]), [known[0]]);
    let mut twice = known.clone();
    twice.sort_unstable();
    twice.dedup();
    assert_eq!(twice.len(), known.len(), "a file is listed twice");
}

#[test]
fn an_orphan_in_a_folder_is_reported() {
    let root = std::env::temp_dir().join(format!("dapple-orphan-{}", std::process::id()));
    std::fs::create_dir_all(root.join("deep")).unwrap();
    for name in ["listed.wgsl", "deep/orphan.wgsl", "deep/notes.txt"] {
        std::fs::write(root.join(name), "").unwrap();
    }
    let found = orphans(&root, &["listed.wgsl"]);
    std::fs::remove_dir_all(&root).unwrap();
    assert_eq!(found, ["deep/orphan.wgsl"]);
}

#[test]
fn broken_shaders_fail_to_parse_or_validate() {
    let text = source("gpu/copy.wgsl").unwrap();
    let unparsable = text.replacen("fn copy(", "fn copy((", 1);
    assert!(matches!(validate("copy", &unparsable), Err(ShaderError::Parse { .. })));
    // A workgroup of no invocations parses, but is not valid.
    let invalid = text.replacen("@workgroup_size(256)", "@workgroup_size(0)", 1);
    let error = validate("copy", &invalid).unwrap_err();
    assert!(matches!(&error, ShaderError::Invalid { path, .. } if path == "copy"), "{error}");
    // A capability that devices are not asked for.
    let f64 = "@group(0) @binding(0) var<storage, read_write> x: f64;
        @compute @workgroup_size(1) fn main() { x = x * x; }";
    assert!(validate("f64", f64).is_err());
}

#[test]
fn layouts_follow_the_rules_of_wgsl() {
    // vec3 aligns to 16 and takes 12; the size is rounded up to the alignment.
    let text = "
        struct Mixed { a: f32, b: vec3<f32>, c: f32, d: vec2<f32>, e: array<u32, 3>, f: mat3x3<f32> }
        struct Flat { u: f32, v: f32 }
        @group(0) @binding(0) var<storage, read_write> x: array<Mixed>;";
    let mixed = struct_layout(text, "Mixed").unwrap();
    let fields: Vec<_> = mixed.fields.iter().map(|(n, o)| (n.as_str(), *o)).collect();
    assert_eq!(fields, [("a", 0), ("b", 16), ("c", 28), ("d", 32), ("e", 40), ("f", 64)]);
    assert_eq!(mixed.size, 112);
    let flat = struct_layout(text, "Flat").unwrap();
    assert_eq!(flat.size, 8);
    // Control: a field that moves changes the layout.
    let moved = text.replace("a: f32, b: vec3<f32>", "b: vec3<f32>, a: f32");
    assert_ne!(struct_layout(&moved, "Mixed").unwrap(), mixed);
    let error = struct_layout(text, "Gone").unwrap_err();
    assert_eq!(error.to_string(), "no struct `Gone`; there are: Mixed, Flat");
}

#[test]
fn the_hash_is_sixteen_hex_digits_and_stable() {
    assert_eq!(hash().len(), 16);
    assert!(hash().chars().all(|c| c.is_ascii_hexdigit()));
    assert_eq!(hash(), hash());
}

#[test]
fn an_unknown_path_is_an_error() {
    assert!(matches!(source("gpu/none.wgsl"), Err(ShaderError::Unknown { .. })));
}
