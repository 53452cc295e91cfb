//! Small files written by hand, right and wrong, through the public loader.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a failed step fails its test")]

use dapple_scene::import::{Loaded, load};
use dapple_scene::{Scene, SceneError};
use glam::{Vec2, Vec3};
use std::io::Write;
use std::path::PathBuf;

/// Writes files into a fresh folder and loads the first.
fn load_files(files: &[(&str, &[u8])]) -> Result<Loaded, SceneError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    load(&folder.path().join(files[0].0))
}

fn refused(files: &[(&str, &[u8])]) -> String {
    let message = load_files(files).map(|l| l.scene.name).unwrap_err().to_string();
    assert!(message.contains(files[0].0) || message.contains(".mtl"), "names no file: {message}");
    message
}

fn png(texels: &[[u8; 4]], width: u32) -> Vec<u8> {
    let mut out = std::io::Cursor::new(vec![]);
    let height = texels.len() as u32 / width;
    image::RgbaImage::from_raw(width, height, texels.concat())
        .unwrap()
        .write_to(&mut out, image::ImageFormat::Png)
        .unwrap();
    out.into_inner()
}

const OBJ: &str = "mtllib a.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0.5 1.5 0
vt 0 0
vt 1 0.25
o first
usemtl red
f 1/1 2/2 3/1
usemtl leaf
f 1/1 3/2 4/1
usemtl red
f -5/1 -4/1 -3/1 -2/2
o second
usemtl red
f 1 2 3 5 4
";
const MTL: &str = "newmtl red
Kd 1 0 0
Ns broken
newmtl leaf
Kd 0 1 0
d 0.5
map_Kd -clamp off leaf.png
map_Bump absent_normals.png
";

#[test]
fn obj_has_one_mesh_per_object_and_material() {
    let leaf = png(&[[255; 4], [9, 9, 9, 0]], 2);
    let files: [(&str, &[u8]); 3] =
        [("a.obj", OBJ.as_bytes()), ("a.mtl", MTL.as_bytes()), ("leaf.png", &leaf)];
    let Loaded { scene, warnings } = load_files(&files).unwrap();
    let meshes: Vec<_> = scene
        .meshes
        .iter()
        .map(|m| {
            (m.name.as_str(), scene.materials[m.material as usize].name.as_str(), m.triangles.len())
        })
        .collect();
    // A quad is 2 triangles and a pentagon 3; red in "first" is met twice and joined.
    assert_eq!(meshes, [("first", "red", 3), ("first", "leaf", 1), ("second", "red", 3)]);
    assert_eq!(scene.triangle_count(), 7);
    let (red, leaf) = (&scene.materials[0], &scene.materials[1]);
    assert_eq!((red.albedo, red.opacity, red.alpha_test), (Vec3::X, 1.0, None));
    assert_eq!((leaf.albedo, leaf.opacity), (Vec3::Y, 0.5));
    assert_eq!(leaf.alpha_test.unwrap().texture, 0);
    assert_eq!(scene.textures[0].texels, [[255; 4], [9, 9, 9, 0]]);
    // v is counted from the top: 1 - 0.25.
    assert!(scene.meshes[0].uvs.contains(&Vec2::new(1.0, 0.75)));
    assert!(scene.meshes[2].uvs.is_empty());
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("absent_normals.png") && warnings[0].contains("a.obj"));
    assert!(scene.lights.is_empty() && scene.cameras.is_empty());
}

#[test]
fn obj_says_what_is_absent_and_goes_on() {
    let text = "mtllib no.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl x\nf 1 2 3\n";
    let loaded = load_files(&[("b.obj", text.as_bytes())]).unwrap();
    assert_eq!(loaded.warnings.len(), 2, "{:?}", loaded.warnings);
    assert!(loaded.warnings[0].contains("no.mtl") && loaded.warnings[1].contains("\"x\""));
    assert_eq!(loaded.scene.materials.len(), 1);
    let mtl = "newmtl x\nmap_Kd gone.png\n";
    let text = text.replace("no.mtl", "c.mtl");
    let loaded = load_files(&[("c.obj", text.as_bytes()), ("c.mtl", mtl.as_bytes())]).unwrap();
    assert_eq!(loaded.warnings.len(), 1);
    assert!(loaded.warnings[0].contains("gone.png"));
}

#[test]
fn bad_obj_files_are_refused_by_name() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let face = |f: &str| refused(&[("x.obj", format!("{vertices}f 1 2 3\nf {f}\n").as_bytes())]);
    let message = face("1 2 4");
    assert!(message.contains("line 5, face 1") && message.contains("index 4"), "{message}");
    for bad in
        ["0 1 2", "-4 1 2", "1/1 2/1 3/1", "1//1 2//1 3//1", "1 2 x", "1/2/3/4 2 3", "/1 2 3"]
    {
        assert!(face(bad).contains("face 1"), "{bad}");
    }
    let far = format!("-{} 1 2", i64::MAX);
    assert!(face(&far).contains("face 1"));
    assert!(face("99999999999999999999 1 2").contains("face 1"));
    let nan = format!("{vertices}v nan 0 0\nf 1 2 4\n");
    assert!(refused(&[("x.obj", nan.as_bytes())]).contains("vertex"));
    assert!(refused(&[("x.obj", b"v 1 2\nf 1 1 1\n")]).contains("position"));
    assert!(refused(&[("x.obj", b"# nothing\n")]).contains("no triangle"));
    assert!(refused(&[("x.obj", b"")]).contains("no triangle"));
    let text = format!("mtllib x.mtl\n{vertices}f 1 2 3\n");
    for mtl in ["newmtl a\nKd 1 2\n", "newmtl a\nd\n", "newmtl a\nKd a b c\n", "newmtl a\nTr ?\n"] {
        let message = refused(&[("x.obj", text.as_bytes()), ("x.mtl", mtl.as_bytes())]);
        assert!(message.contains("x.mtl: line 2"), "{message}");
    }
    let mtl = b"newmtl a\nmap_Kd bad.png\n";
    let message =
        refused(&[("x.obj", text.as_bytes()), ("x.mtl", mtl), ("bad.png", b"not a picture")]);
    assert!(message.contains("bad.png"), "{message}");
}

const PLY: &str = "ply
format ascii 1.0
comment a square and a triangle
element vertex 5
property float x
property float y
property float z
property uchar red
element face 2
property list uchar int vertex_indices
end_header
0 0 0 1
1 0 0 1
1 1 0 1
0 1 0 1
0.5 1.5 0 1
4 0 1 2 3
3 3 2 4
";

fn binary_ply(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let header = PLY.split("end_header\n").next().unwrap();
    let mut out = header.replace("ascii", &format!("binary_{order}_endian")).into_bytes();
    out.extend(b"end_header\n");
    let float = |x: f32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
    let int = |x: i32| if big { x.to_be_bytes() } else { x.to_le_bytes() };
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 1.5]] {
        out.extend([float(x), float(y), float(0.0)].concat());
        out.push(1);
    }
    for face in [&[0, 1, 2, 3][..], &[3, 2, 4]] {
        out.push(face.len() as u8);
        face.iter().for_each(|&i| out.extend(int(i)));
    }
    out
}

#[test]
fn ply_reads_alike_in_every_encoding() {
    let expected = [[0, 1, 2], [0, 2, 3], [3, 2, 4]];
    let read = |bytes: &[u8]| load_files(&[("a.ply", bytes)]).unwrap().scene;
    let ascii = read(PLY.as_bytes());
    assert_eq!(ascii.meshes[0].triangles, expected);
    assert_eq!(ascii.meshes[0].positions[4], Vec3::new(0.5, 1.5, 0.0));
    for big in [false, true] {
        assert_eq!(read(&binary_ply(big)).hash(), ascii.hash());
    }
    assert_eq!(read(PLY.replace('\n', "\r\n").as_bytes()).hash(), ascii.hash());
}

#[test]
fn bad_ply_files_are_refused_by_name() {
    let ply = |from: &str, to: &str| {
        assert!(PLY.contains(from));
        refused(&[("x.ply", PLY.replace(from, to).as_bytes())])
    };
    assert!(ply("3 3 2 4", "3 3 2 5").contains("face 1: vertex index 5"));
    assert!(ply("3 3 2 4", "3 3 2 -1").contains("index -1"));
    assert!(ply("3 3 2 4", "3 3 2").contains("truncated"));
    assert!(ply("4 0 1 2 3", "99999999999999 0 1 2 3").contains("face 0"));
    assert!(ply("element vertex 5", "element vertex 18446744073709551615").contains("bytes"));
    assert!(ply("0.5 1.5 0 1", "0.5 what 0 1").contains("\"what\""));
    assert!(ply("0.5 1.5 0 1", "0.5 nan 0 1").contains("vertex 4"));
    assert!(ply("property float y\n", "").contains("x, y, z"));
    assert!(ply("ply\n", "plx\n").contains("header"));
    let bytes = binary_ply(true);
    // Any truncation of the payload misses a byte of the last face.
    for end in [bytes.len() - 1, bytes.len() - 20, bytes.len() - 60] {
        assert!(refused(&[("x.ply", &bytes[..end])]).contains("x.ply"));
    }
    // A negative list length: the last face is a count and three indices.
    let header = bytes.windows(10).position(|w| w == b"list uchar").unwrap();
    let mut signed = bytes.clone();
    signed.splice(header..header + 10, *b"list char");
    let at = signed.len() - 13;
    assert_eq!(signed[at], 3);
    signed[at] = 0xFF;
    assert!(refused(&[("x.ply", &signed)]).contains("face 1: -1 is not a list length"));
}

#[test]
fn damaged_ply_and_obj_files_never_panic() {
    let (mut loaded, mut refused) = (0, 0);
    for (name, bytes) in [
        ("x.ply", PLY.as_bytes().to_vec()),
        ("x.ply", binary_ply(true)),
        ("x.ply", binary_ply(false)),
        ("x.obj", OBJ.as_bytes().to_vec()),
    ] {
        for at in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 7);
            let mut nine = bytes.clone();
            nine[at] = b'9';
            for damaged in [&flipped[..], &nine, &bytes[..at]] {
                match load_files(&[(name, damaged)]) {
                    Ok(_) => loaded += 1,
                    Err(_) => refused += 1,
                }
            }
        }
    }
    assert!(loaded > 100 && refused > 100, "{loaded} loaded, {refused} refused");
}

fn gltf(json: &str) -> Result<Scene, String> {
    load_files(&[("x.gltf", json.as_bytes())]).map(|l| l.scene).map_err(|e| e.to_string())
}

/// A triangle whose 36 bytes of positions are all `AAAA...` = 0, but for x of the second and y of
/// the third vertex, which are 1.0.
fn triangle_json(edit: impl Fn(String) -> String) -> String {
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    edit(format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,{data}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}]}}"#
    ))
}

#[test]
fn gltf_with_inline_data_loads() {
    let scene = gltf(&triangle_json(|s| s)).unwrap();
    assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(scene.meshes[0].triangles, [[0, 1, 2]]);
    assert_eq!(scene.materials.len(), 1);
}

#[test]
fn gltf_hierarchy_multiplies_parents_first() {
    let nodes = r#""nodes":[{"scale":[2,2,2],"children":[1]},{"mesh":0,"translation":[1,0,0]}]"#;
    let scene = gltf(&triangle_json(|s| s.replace(r#""nodes":[{"mesh":0}]"#, nodes))).unwrap();
    let corner = scene.world_triangles().next().unwrap().1[1];
    assert_eq!(corner, glam::DVec3::new(4.0, 0.0, 0.0));
}

#[test]
fn bad_gltf_files_are_refused_by_name() {
    let edited = |from: &str, to: &str| {
        let json = triangle_json(|s| {
            assert!(s.contains(from), "{from}");
            s.replace(from, to)
        });
        let message = gltf(&json).map(|s| s.name).unwrap_err();
        assert!(message.contains("x.gltf"), "{message}");
        message
    };
    assert!(edited(r#""count":3"#, r#""count":4"#).contains("accessor 0"));
    assert!(edited(r#""count":3"#, r#""count":18446744073709551615"#).contains("accessor 0"));
    assert!(
        edited(r#""buffer":0,"byteLength":36"#, r#""buffer":0,"byteLength":37"#).contains("view 0")
    );
    assert!(edited(r#"[{"byteLength":36"#, r#"[{"byteLength":99"#).contains("buffer 0: truncated"));
    assert!(
        edited(r#""bufferView":0,"#, r#""bufferView":0,"byteOffset":12,"#).contains("accessor 0")
    );
    assert!(edited(r#""mesh":0"#, r#""mesh":7"#).contains("glTF document"));
    assert!(edited(r#"{"mesh":0}"#, r#"{"mesh":0,"children":[0]}"#).contains("node 0"));
    assert!(edited(r#""POSITION":0}"#, r#""POSITION":0},"material":3"#).contains("document"));
    assert!(edited(r#"AAAAAAAAAAAAAAAAAACAPw"#, r#"AADAfwAAAAAAAAAAAACAPw"#).contains("vertex 0"));
    assert!(edited(r#"data:application/octet-stream;base64,"#, "http://h/").contains("URI"));
    assert!(gltf("").is_err() && gltf("{").is_err() && gltf("glTF").is_err());
    let nothing = gltf(r#"{"asset":{"version":"2.0"}}"#).unwrap_err();
    assert!(nothing.contains("no triangle"), "{nothing}");
    let json =
        triangle_json(|s| s.replace(r#""uri":"data:"#, r#""uri":"no%20such.bin","name":"data:"#));
    assert!(gltf(&json).unwrap_err().contains("no such.bin"));
    let required = r#""asset":{"version":"2.0"},"extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"]"#;
    assert!(edited(r#""asset":{"version":"2.0"}"#, required).contains("document"));
}

#[test]
fn gltf_alpha_modes_become_cut_out_or_opacity() {
    let material = |mode: &str, factor: f32, alpha: u8| {
        let image = png(&[[255; 4], [255, 255, 255, alpha]], 2);
        let json = triangle_json(|s| {
            let extra = format!(
                r#""materials":[{{"alphaMode":"{mode}","pbrMetallicRoughness":{{"baseColorFactor":[1,1,1,{factor}],"baseColorTexture":{{"index":0}}}}}}],"textures":[{{"source":0}}],"images":[{{"uri":"t.png"}}],"buffers""#
            );
            s.replace("\"buffers\"", &extra)
                .replace(r#""POSITION":0}"#, r#""POSITION":0},"material":0"#)
        });
        let files: [(&str, &[u8]); 2] = [("x.gltf", json.as_bytes()), ("t.png", &image)];
        let scene = load_files(&files).unwrap().scene;
        let m = scene.materials[0].clone();
        assert_eq!(m.albedo_texture, Some(0));
        (m.alpha_test.map(|t| t.cutoff), m.opacity)
    };
    assert_eq!(material("OPAQUE", 0.5, 0), (None, 1.0));
    assert_eq!(material("MASK", 1.0, 0), (Some(0.5), 1.0));
    // alpha * 0.8 >= 0.5 where alpha >= 0.625.
    assert_eq!(material("MASK", 0.8, 0), (Some(0.625), 1.0));
    assert_eq!(material("MASK", 0.4, 0), (None, 0.0));
    assert_eq!(material("BLEND", 0.8, 0), (Some(0.5), 0.8));
    assert_eq!(material("BLEND", 0.8, 255), (None, 0.8));
}

#[test]
fn real_models_load_if_they_are_there() {
    let Some(root) = std::env::var_os("DAPPLE_DATA").map(PathBuf::from) else {
        // Past the harness, which keeps what a passing test prints to itself.
        let _ = writeln!(std::io::stderr(), "skipped: real models: DAPPLE_DATA is not set");
        return;
    };
    let Loaded { scene, warnings } = load(&root.join("classic/bunny.obj")).unwrap();
    assert_eq!((scene.triangle_count(), scene.meshes[0].positions.len()), (69_666, 34_835));
    assert_eq!((scene.meshes.len(), warnings.len()), (1, 0), "{warnings:?}");

    let Loaded { scene, warnings } = load(&root.join("trees/crystalspace_tree.obj")).unwrap();
    let names: Vec<&str> = scene.meshes.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["TreeTrunk", "TreeBranch", "TreeLeaf", "Plant", "PlaneFact"]);
    let count = |name: &str| {
        let mesh = scene.meshes.iter().find(|m| m.name == name).unwrap();
        mesh.triangles.len()
    };
    assert_eq!((count("TreeLeaf"), count("Plant"), scene.triangle_count()), (3_660, 9_884, 13_588));
    assert!(warnings.is_empty() && scene.has_ground());
    let needs = dapple_scene::inspect::inspect(&scene);
    assert_eq!((needs.needs("translucency"), needs.needs("alpha-test")), (Some(true), Some(false)));

    let Loaded { mut scene, warnings } = load(&root.join("trees/smallpine/scene.gltf")).unwrap();
    assert_eq!(warnings.len(), 1, "{warnings:?}");
    assert!(warnings[0].contains("M_TreeAtlas_normal.png") && warnings[0].contains("scene.gltf"));
    let triangles: Vec<usize> = scene.meshes.iter().map(|m| m.triangles.len()).collect();
    assert_eq!(triangles, [208, 1_442]);
    assert_eq!(scene.textures.len(), 2);
    let needs = dapple_scene::inspect::inspect(&scene);
    assert_eq!(needs.needs("alpha-test"), Some(true), "{needs:?}");
    assert_eq!(needs.needs("translucency"), Some(false));
    // The file's z reaches 75.014; its own node matrices turn that to y.
    let b = scene.bounds();
    assert!((b.max.y - 75.014).abs() < 0.01 && b.min.y.abs() < 0.1, "{b:?}");
    assert!(!scene.has_ground());
    dapple_scene::add_ground(&mut scene);
    assert_eq!(scene.add_defaults().len(), 3);
    scene.validate().unwrap();
}
