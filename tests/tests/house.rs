//! Holds `cargo metadata` against the picture in `ARCHITECTURE.md`: imports point down only.

use cargo_metadata::{DependencyKind, MetadataCommand};
use std::{collections::BTreeMap, fs, path::Path};

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// A crate's place in the picture: indentation, and line.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    depth: usize,
    line: usize,
}

/// The crates of the first code block, by name.
fn picture(text: &str) -> BTreeMap<String, Place> {
    let block = text.split("```").nth(1).expect("a code block");
    block
        .lines()
        .enumerate()
        .filter_map(|(line, text)| {
            let name = text.split_whitespace().nth(1).filter(|n| n.starts_with("dapple"))?;
            let depth = (text.len() - text.trim_start().len()) / 2;
            Some((name.to_string(), Place { depth, line }))
        })
        .collect()
}

/// Edges that the picture forbids. Crates that serve tests and benches stand outside it and may
/// import anything.
fn violations(picture: &BTreeMap<String, Place>, edges: &[(String, String)]) -> Vec<String> {
    let ground = picture.values().map(|p| p.depth).max().unwrap_or(0);
    edges
        .iter()
        .filter_map(|(from, to)| {
            if to == "wgpu" && from != "dapple-gpu" {
                return Some(format!("{from} names wgpu: only dapple-gpu may"));
            }
            if !to.starts_with("dapple") {
                return None;
            }
            let (Some(a), Some(b)) = (picture.get(from), picture.get(to)) else {
                return Some(format!("{from} -> {to} is not in the picture"));
            };
            // Neighbours on the ground may build on one another; techniques may not.
            let down = a.depth < b.depth || (a.depth == ground && b.depth == ground);
            (!down || a.line >= b.line).then(|| format!("{from} -> {to} points up or sideways"))
        })
        .collect()
}

fn edges() -> Vec<(String, String)> {
    let metadata = MetadataCommand::new()
        .manifest_path(Path::new(ROOT).join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata");
    let outside = ["dapple-benches", "dapple-tests"];
    metadata
        .packages
        .iter()
        .filter(|package| !outside.contains(&package.name.as_str()))
        .flat_map(|package| {
            let normal = package.dependencies.iter().filter(|d| d.kind == DependencyKind::Normal);
            normal.map(|d| (package.name.to_string(), d.name.clone()))
        })
        .collect()
}

fn drawn() -> BTreeMap<String, Place> {
    picture(&fs::read_to_string(Path::new(ROOT).join("ARCHITECTURE.md")).expect("ARCHITECTURE.md"))
}

#[test]
fn imports_point_down() {
    let (picture, edges) = (drawn(), edges());
    assert!(picture.len() >= 10, "the picture names {} crates", picture.len());
    let checked = edges.iter().filter(|(_, to)| to.starts_with("dapple")).count();
    assert!(checked >= 15, "only {checked} imports between our crates were seen");
    assert_eq!(violations(&picture, &edges), Vec::<String>::new());
}

#[test]
fn every_crate_is_in_the_picture_and_every_name_in_it_exists() {
    let metadata = MetadataCommand::new()
        .manifest_path(Path::new(ROOT).join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata");
    let mut names: Vec<String> = metadata.packages.iter().map(|p| p.name.to_string()).collect();
    names.retain(|name| name != "dapple-benches" && name != "dapple-tests");
    names.sort();
    assert_eq!(names, drawn().into_keys().collect::<Vec<_>>());
}

#[test]
fn there_is_one_glam_and_one_wgpu() {
    let metadata = MetadataCommand::new()
        .manifest_path(Path::new(ROOT).join("Cargo.toml"))
        .exec()
        .expect("cargo metadata");
    let resolve = metadata.resolve.as_ref().expect("a resolved graph");
    for name in ["glam", "wgpu", "naga"] {
        let built: Vec<_> = resolve
            .nodes
            .iter()
            .filter(|node| metadata[&node.id].name.as_str() == name)
            .map(|node| metadata[&node.id].version.to_string())
            .collect();
        assert_eq!(built.len(), 1, "{name}: {built:?}");
    }
}

/// Controls: each forbidden kind of edge is reported.
#[test]
fn forbidden_edges_are_caught() {
    let picture = drawn();
    for (from, to) in [
        ("dapple-scene", "dapple-suite"),
        ("dapple-shadows", "dapple-foliage"),
        ("dapple-foliage", "dapple-shadows"),
        ("dapple-scene", "dapple-trace"),
        ("dapple-suite", "wgpu"),
        ("dapple-suite", "dapple-invented"),
    ] {
        let edge = [(from.to_string(), to.to_string())];
        assert_eq!(violations(&picture, &edge).len(), 1, "{from} -> {to}");
    }
    let allowed = [("dapple-suite".to_string(), "dapple-scene".to_string())];
    assert!(violations(&picture, &allowed).is_empty());
}
