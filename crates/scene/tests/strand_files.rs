//! Hair files written byte by byte, right and wrong, through the public loaders.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

use dapple_scene::import::{self, Loaded};
use dapple_scene::{SceneError, Strands};
use glam::{DVec3, Vec3};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a file into a fresh folder and calls `f` with its path.
fn with_file<T>(name: &str, bytes: &[u8], f: impl Fn(&Path) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    f(&path)
}

fn strands(name: &str, bytes: &[u8]) -> Result<(Strands, Vec<String>), SceneError> {
    with_file(name, bytes, import::strands)
}

fn load(name: &str, bytes: &[u8]) -> Result<Loaded, SceneError> {
    with_file(name, bytes, import::load)
}

/// The message of a file that both loaders refuse alike.
fn refused(name: &str, bytes: &[u8]) -> String {
    let message = strands(name, bytes).unwrap_err().to_string();
    assert!(message.contains(name), "names no file: {message}");
    let tail = |s: &str| s.split(name).nth(1).unwrap().to_owned();
    let loaded = load(name, bytes).map(|l| l.scene.name).unwrap_err().to_string();
    assert_eq!(tail(&loaded), tail(&message));
    message
}

/// Two strands of three points.
fn points() -> Vec<Vec3> {
    [
        [0.0, 0.0, 0.0],
        [0.1, 1.0, 0.0],
        [0.0, 2.0, 0.1],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.2],
        [1.1, 2.0, 0.0],
    ]
    .map(Vec3::from_array)
    .to_vec()
}

fn words(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

fn floats(floats: &[f32]) -> Vec<u8> {
    floats.iter().flat_map(|w| w.to_le_bytes()).collect()
}

/// A TressFX file of two strands, its positions from byte 192 on.
fn tfx() -> Vec<u8> {
    let mut bytes = floats(&[4.0]);
    bytes.extend(words(&[2, 3, 192, 288, 0, 0, 0]));
    bytes.resize(192, 0xEE);
    for (i, p) in points().iter().enumerate() {
        bytes.extend(floats(&[p.x, p.y, p.z, if i % 3 == 0 { 0.0 } else { 1.0 }]));
    }
    // One pair of texture coordinates a strand.
    bytes.extend(floats(&[0.5; 4]));
    bytes
}

/// What a HAIR file may hold.
#[derive(Default)]
struct Hair {
    segments: Option<Vec<u16>>,
    thickness: Option<Vec<f32>>,
    rest: bool,
    default_thickness: f32,
}

fn hair(parts: &Hair) -> Vec<u8> {
    let flag = |on: bool, bit: u32| u32::from(on) << bit;
    let flags = flag(parts.segments.is_some(), 0)
        | flag(true, 1)
        | flag(parts.thickness.is_some(), 2)
        | flag(parts.rest, 3)
        | flag(parts.rest, 4);
    let mut bytes = b"HAIR".to_vec();
    bytes.extend(words(&[2, 6, flags, 2]));
    bytes.extend(floats(&[parts.default_thickness, 0.0, 0.5, 0.4, 0.3]));
    bytes.resize(128, b' ');
    for s in parts.segments.iter().flatten() {
        bytes.extend(s.to_le_bytes());
    }
    for p in points() {
        bytes.extend(floats(&p.to_array()));
    }
    bytes.extend(floats(parts.thickness.as_deref().unwrap_or_default()));
    if parts.rest {
        bytes.extend(floats(&[0.25; 6 + 18]));
    }
    bytes
}

fn patched(mut bytes: Vec<u8>, at: usize, with: &[u8]) -> Vec<u8> {
    bytes[at..at + with.len()].copy_from_slice(with);
    bytes
}

#[test]
fn tfx_gives_back_what_was_written() {
    let (s, warnings) = strands("tuft.TFX", &tfx()).unwrap();
    assert_eq!((s.name.as_str(), s.starts.as_slice(), s.points), ("tuft", &[0, 3][..], points()));
    // Half of a 2000th of the 2 m it is high.
    assert_eq!(s.radius, [5e-4]);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("tuft.TFX") && warnings[0].contains("5.000e-4 m"));
    let with_thickness = patched(tfx(), 28, &words(&[192]));
    let warnings = strands("tuft.tfx", &with_thickness).unwrap().1;
    assert!(warnings[0].contains("thicknesses at byte 192 are not read"), "{warnings:?}");
}

#[test]
fn hair_gives_back_what_was_written() {
    let read = |parts: &Hair| strands("a.hair", &hair(parts)).unwrap();
    // Everything by default: two segments a strand, a thickness of 2 cm.
    let plain = Hair { default_thickness: 0.02, ..Hair::default() };
    let (s, warnings) = read(&plain);
    assert_eq!((s.starts, s.points, s.radius), (vec![0, 3], points(), vec![0.01]));
    assert!(warnings.is_empty(), "{warnings:?}");
    // No thickness at all.
    let (s, warnings) = read(&Hair::default());
    assert_eq!(s.radius, [5e-4]);
    assert!(warnings[0].contains("2000th of the largest extent"), "{warnings:?}");
    // Arrays: strands of two and four points, a thickness each that ends in nothing.
    let arrays = Hair {
        segments: Some(vec![1, 3]),
        thickness: Some(vec![0.02, 0.0, 2.0, 0.03, 0.02, 0.0]),
        rest: true,
        ..plain
    };
    let (s, warnings) = read(&arrays);
    assert_eq!((s.starts, s.points), (vec![0, 2], points()));
    assert_eq!(s.radius, [0.01, 0.001, 1.0, 0.015, 0.01, 0.001]);
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("2 radii below"), "{warnings:?}");
    // Fewer points used than there are.
    let (s, warnings) = read(&Hair { segments: Some(vec![1, 1]), ..arrays });
    assert_eq!((s.starts, s.points.len(), s.radius.len()), (vec![0, 2], 4, 4));
    assert!(warnings[0].contains("2 points belong to no strand"), "{warnings:?}");
}

#[test]
fn a_scene_of_hair_is_ribbons_that_face_its_default_view() {
    let hair = hair(&Hair { default_thickness: 0.02, ..Hair::default() });
    for (name, bytes, chosen) in [("a.hair", hair, 1), ("b.tfx", tfx(), 2)] {
        let Loaded { mut scene, warnings } = load(name, &bytes).unwrap();
        assert_eq!((scene.triangle_count(), warnings.len()), (8, chosen), "{warnings:?}");
        assert!(
            warnings[chosen - 1].contains("2 strands drawn as ribbons that face the three-quarter")
        );
        // By its name the mesh is found again, to be turned to another viewer.
        assert_eq!(scene.meshes[0].name, strands(name, &bytes).unwrap().0.name);
        let material = &scene.materials[0];
        assert_eq!((material.opacity, scene.degenerate_triangles()), (70.0 / 255.0, 0));
        assert!(scene.lights.is_empty() && scene.cameras.is_empty());
        scene.add_defaults();
        scene.validate().unwrap();
        let eye = scene.cameras[0].position;
        for (_, [a, b, c]) in scene.world_triangles() {
            assert!((b - a).cross(c - a).dot(eye - a) > 0.0, "turned away: {a} {b} {c}");
        }
        assert!(scene.meshes[0].normals.iter().all(|n| n.as_dvec3().dot(eye) > 0.0));
    }
    let twice = patched(tfx(), 192 + 16, &floats(&[0.0; 3]));
    let warnings = load("c.tfx", &twice).unwrap().warnings;
    assert!(warnings.last().unwrap().contains("1 segments have no length"), "{warnings:?}");
}

#[test]
fn bad_tfx_files_are_refused_by_name() {
    let bad = |at: usize, with: &[u8]| refused("x.tfx", &patched(tfx(), at, with));
    assert!(bad(0, &floats(&[3.0])).contains("TFX header: version 3"));
    assert!(bad(0, &floats(&[f32::NAN])).contains("version NaN"));
    assert!(bad(4, &words(&[0])).contains("0 strands of 3 vertices"));
    assert!(bad(8, &words(&[1])).contains("2 strands of 1 vertices"));
    assert!(bad(12, &words(&[159])).contains("positions begin at byte 159"));
    assert!(bad(12, &words(&[u32::MAX])).contains("the file has 304 bytes"));
    // No memory is taken for what the file cannot hold.
    let message = bad(4, &words(&[u32::MAX, u32::MAX]));
    assert!(message.contains("TFX positions: 18446744065119617025 of 16 bytes"), "{message}");
    assert!(bad(4, &words(&[4, 3])).contains("TFX positions: 12 of 16 bytes from byte 192"));
    let message = bad(192 + 16 * 4 + 8, &floats(&[f32::NAN]));
    assert!(message.contains("strand 1, point 1: position") && message.contains("at most 1e9"));
    assert!(bad(192 + 16 * 2, &floats(&[2e9])).contains("strand 0, point 2: position"));
    // All points in one place: no triangle to place, but strands.
    let one_place = patched(tfx(), 192, &floats(&[0.5; 24]));
    assert_eq!(strands("x.tfx", &one_place).unwrap().0.radius, [1.0]);
    assert!(load("x.tfx", &one_place).unwrap_err().to_string().contains("no triangle"));
}

#[test]
fn bad_hair_files_are_refused_by_name() {
    let full = || {
        hair(&Hair {
            segments: Some(vec![2, 2]),
            thickness: Some(vec![0.02; 6]),
            ..Hair::default()
        })
    };
    let bad = |at: usize, with: &[u8]| refused("x.hair", &patched(full(), at, with));
    assert!(bad(0, b"HAIL").contains("HAIR header"));
    assert!(bad(4, &words(&[0])).contains("0 strands"));
    assert!(bad(12, &words(&[1])).contains("flags 0x1 say it has no points"));
    assert!(bad(4, &words(&[u32::MAX])).contains("HAIR segments: 4294967295 of 2 bytes"));
    assert!(bad(8, &words(&[u32::MAX])).contains("HAIR points: 4294967295 of 12 bytes"));
    assert!(bad(8, &words(&[7])).contains("HAIR thicknesses: 7 of 4 bytes"));
    assert!(bad(128, &[3, 0]).contains("strand 1: ends at point 7, but there are 6"));
    assert!(bad(128, &[0xFF, 0xFF]).contains("strand 0: ends at point 65536"));
    let points_at = 128 + 4;
    assert!(bad(points_at + 12 * 5, &floats(&[f32::INFINITY])).contains("strand 1, point 2"));
    let thickness_at = points_at + 72;
    assert!(bad(thickness_at + 4, &floats(&[-1.0])).contains("strand 0, point 1: radius -0.5 m"));
    assert!(bad(thickness_at, &floats(&[f32::NAN])).contains("strand 0, point 0: radius NaN"));
    // By defaults alone a file may claim any number of strands and segments.
    let plain = || hair(&Hair { default_thickness: 0.02, ..Hair::default() });
    let bad = |at: usize, with: &[u8]| refused("y.hair", &patched(plain(), at, with));
    assert!(bad(4, &words(&[u32::MAX])).contains("4294967295 strands, but only 6 points"));
    assert!(bad(16, &words(&[u32::MAX])).contains("strand 0: ends at point 4294967296"));
    assert!(bad(20, &floats(&[-0.02])).contains("radius -0.01 m"));
    assert!(bad(20, &floats(&[f32::NAN])).contains("radius NaN"));
}

#[test]
fn truncated_and_damaged_files_never_panic() {
    let full =
        Hair { segments: Some(vec![2, 2]), thickness: Some(vec![0.02; 6]), ..Hair::default() };
    let (mut loaded, mut failed) = (0, 0);
    // One folder for thousands of files; each is new, as a disk is slow to write over an old one.
    let folder = tempfile::tempdir().unwrap();
    let mut written = 0;
    let mut load = |name: &str, bytes: &[u8]| {
        written += 1;
        let path = folder.path().join(format!("{written}{name}"));
        std::fs::write(&path, bytes).unwrap();
        import::load(&path)
    };
    for (name, bytes, needed) in [("x.tfx", tfx(), 288), ("x.hair", hair(&full), 228)] {
        for end in 0..bytes.len() {
            // What follows the positions of a TressFX file is not read.
            assert_eq!(load(name, &bytes[..end]).is_err(), end < needed, "{name} {end}");
        }
        for at in 0..bytes.len() {
            for bit in 0..8 {
                match load(name, &patched(bytes.clone(), at, &[bytes[at] ^ 1 << bit])) {
                    Ok(_) => loaded += 1,
                    Err(_) => failed += 1,
                }
            }
        }
    }
    assert!(loaded > 500 && failed > 100, "{loaded} loaded, {failed} refused");
}

#[test]
fn the_real_hair_loads_if_it_is_there() {
    let Some(root) = std::env::var_os("DAPPLE_DATA").map(PathBuf::from) else {
        // Past the harness, which keeps what a passing test prints to itself.
        let _ = writeln!(std::io::stderr(), "skipped: real hair: DAPPLE_DATA is not set");
        return;
    };
    let path = root.join("hair/Ratboy_mohawk.tfx");
    let (s, warnings) = import::strands(&path).unwrap();
    assert_eq!((s.starts.len(), s.segment_count(), s.points.len()), (2_228, 2_228 * 31, 71_296));
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    let size = s.bounds().max - s.bounds().min;
    assert!(size.distance(DVec3::new(0.2125, 0.8956, 0.6067)) < 1e-3, "{size}");
    let loaded = import::load(&path).unwrap();
    assert_eq!(loaded.scene.name, "Ratboy_mohawk");
    // Five segments are no longer than the rounding of their ends, about 1e-7 m.
    assert_eq!(loaded.scene.triangle_count(), 2_228 * 62 - 10);
    assert!(loaded.warnings[2].contains("5 segments"), "{:?}", loaded.warnings);
}
