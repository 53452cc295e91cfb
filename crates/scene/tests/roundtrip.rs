//! What is written is what is read, and damaged files never panic.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

use dapple_scene::import::load;
use dapple_scene::{AlphaTest, Light, Projection, Scene, Texture, generate, write_glb};
use glam::{DVec3, Vec2};

fn written(scene: &Scene) -> (Vec<u8>, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    let warnings = write_glb(scene, &path).unwrap();
    (std::fs::read(path).unwrap(), warnings)
}

fn read(bytes: &[u8]) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, bytes).unwrap();
    let loaded = load(&path).map_err(|e| e.to_string())?;
    Ok(loaded.scene)
}

/// A textured scene with every kind of light and projection; transforms exact in `f32`.
fn full() -> Scene {
    let mut s = generate::by_name("cube", 1).unwrap();
    s.meshes[1].uvs = vec![Vec2::new(0.25, 1.5); s.meshes[1].positions.len()];
    let texels = (0..12).map(|i| [i, 2 * i, 3 * i, 20 * i]).collect();
    s.textures.push(Texture { name: "t".into(), width: 4, height: 3, texels });
    s.materials[1].alpha_test = Some(AlphaTest { texture: 0, cutoff: 0.25 });
    s.materials[1].albedo_texture = Some(0);
    s.instances[1].transform.translation = DVec3::new(0.5, 2.25, -1024.0);
    s.instances[1].transform.matrix3 *= 0.125;
    let (position, direction) = (DVec3::new(1.0, 5.0, 2.0), DVec3::new(0.1, -1.0, 0.3));
    s.lights.push(Light::Spot { position, direction, half_angle_rad: 0.4 });
    let (half_u, half_v) = (DVec3::X * 0.5, DVec3::Z * 0.25);
    s.lights.push(Light::Area { centre: DVec3::Y * 7.0, half_u, half_v });
    let mut flat = s.cameras[0].clone();
    flat.projection = Projection::Orthographic { height_m: 3.0 };
    s.cameras.push(flat);
    s
}

#[test]
fn geometry_survives_writing_bit_by_bit() {
    let (bytes, warnings) = written(&full());
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(read(&bytes).unwrap().geometry_hash(), full().geometry_hash());
    // Control: a change in one vertex shows.
    let mut moved = full();
    moved.meshes[0].positions[0].x += 0.5;
    assert_ne!(read(&written(&moved).0).unwrap().geometry_hash(), full().geometry_hash());
}

#[test]
fn generated_scenes_survive_within_the_rounding_of_f32_transforms() {
    for (name, _) in generate::NAMES {
        let scene = generate::by_name(name, 5).unwrap();
        let back = read(&written(&scene).0).unwrap();
        assert_eq!(back.triangle_count(), scene.triangle_count(), "{name}");
        for ((_, a), (_, b)) in scene.world_triangles().zip(back.world_triangles()) {
            for (p, q) in a.into_iter().zip(b) {
                // Twelve factors rounded by 2^-24, on coordinates below 16 m.
                assert!(p.distance(q) < 12.0 * 16.0 * 2.0_f64.powi(-24), "{name}: {p} {q}");
            }
        }
        let exact = !matches!(*name, "spheres" | "chairs" | "car");
        assert_eq!(back.geometry_hash() == scene.geometry_hash(), exact, "{name}");
    }
}

#[test]
fn lights_cameras_and_paths_survive() {
    let (scene, back) = (full(), read(&written(&full()).0).unwrap());
    assert_eq!((back.lights.len(), back.cameras.len(), back.paths.len()), (3, 2, 1));
    for (a, b) in scene.cameras.iter().zip(&back.cameras) {
        assert_eq!(a.name, b.name);
        for (x, y) in [(0.0, 0.0), (0.5, 0.5), (1.0, 0.25)] {
            let ((o, d), (p, e)) = (a.ray(x, y, 1.5), b.ray(x, y, 1.5));
            assert!(o.distance(p) < 1e-5 && d.distance(e) < 1e-5, "{o} {p} {d} {e}");
        }
    }
    for (a, b) in scene.lights.iter().zip(&back.lights) {
        match (*a, *b) {
            (Light::Directional { direction: a }, Light::Directional { direction: b }) => {
                assert!(a.normalize().distance(b) < 1e-6);
            }
            (
                Light::Spot { position, direction, half_angle_rad },
                Light::Spot { position: p, direction: d, half_angle_rad: h },
            ) => {
                assert!(position.distance(p) < 1e-6 && direction.normalize().distance(d) < 1e-6);
                assert!((half_angle_rad - h).abs() < 1e-6);
            }
            (
                Light::Area { centre, half_u, half_v },
                Light::Area { centre: c, half_u: u, half_v: v },
            ) => assert_eq!((centre, half_u, half_v), (c, u, v)),
            other => panic!("light changed its kind: {other:?}"),
        }
    }
    assert_eq!(back.paths[0].frames, scene.paths[0].frames);
    assert_eq!(back.paths[0].keys.len(), scene.paths[0].keys.len());
    let (a, b) = (&scene.paths[0].keys[3], &back.paths[0].keys[3]);
    assert!(a.position.distance(b.position) < 1e-12);
}

#[test]
fn what_the_format_cannot_hold_is_said() {
    let mut s = full();
    s.materials[1].opacity = 0.5;
    assert!(written(&s).1[0].contains("cutoff 0.25"));
    let mut s = full();
    s.instances[0].transform.translation.x = 1e7 + 0.1;
    assert!(written(&s).1[0].contains("rounded to f32"));
    // Colour from one texture, cut-out from another.
    let mut s = full();
    let texels = vec![[7, 8, 9, 255]];
    s.textures.push(Texture { name: "colour".into(), width: 1, height: 1, texels });
    s.materials[1].albedo_texture = Some(1);
    let back = read(&written(&s).0).unwrap();
    let m = &back.materials[1];
    let merged = &back.textures[m.alpha_test.unwrap().texture as usize];
    assert_eq!((merged.width, merged.height, merged.texels[5]), (4, 3, [7, 8, 9, 100]));
}

#[test]
fn writing_where_nothing_can_be_written_is_an_error() {
    let error = write_glb(&full(), std::path::Path::new("no/such/folder/x.glb")).unwrap_err();
    assert!(error.to_string().contains("no/such/folder/x.glb"), "{error}");
    let mut broken = full();
    broken.meshes[0].positions[0].x = f32::NAN;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.glb");
    assert!(write_glb(&broken, &path).is_err());
    assert!(!path.exists());
}

#[test]
fn truncated_files_are_refused() {
    let (bytes, _) = written(&full());
    let mut checked = 0;
    for end in (0..bytes.len()).step_by(64).chain([bytes.len() - 1]) {
        let error = read(&bytes[..end]).unwrap_err();
        assert!(error.contains("scene.glb"), "{error}");
        checked += 1;
    }
    assert!(checked > 20, "{checked}");
    // Control: the whole file is read.
    read(&bytes).unwrap();
}

#[test]
fn flipped_bits_never_panic() {
    let (bytes, _) = written(&full());
    let (mut loaded, mut refused) = (0, 0);
    for at in 0..bytes.len().min(12_000) {
        let mut damaged = bytes.clone();
        // A different bit in each byte, so that letters, digits and punctuation all come up.
        damaged[at] ^= 1 << (at % 7);
        match read(&damaged) {
            Ok(_) => loaded += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(loaded > 100 && refused > 100, "{loaded} loaded, {refused} refused");
}

#[test]
fn changed_digits_never_panic() {
    // Numbers are where sizes and indices hide: every digit becomes 9, then 0.
    let (bytes, _) = written(&full());
    let text_end = bytes.windows(4).position(|w| w == b"BIN\0").unwrap();
    let mut refused = 0;
    for at in (20..text_end).filter(|&i| bytes[i].is_ascii_digit()) {
        for digit in [b'9', b'0', b'-'] {
            let mut damaged = bytes.clone();
            damaged[at] = digit;
            refused += usize::from(read(&damaged).is_err());
        }
    }
    assert!(refused > 50, "{refused}");
}
