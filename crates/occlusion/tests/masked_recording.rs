//! Masked culling of a recorded frame, held against a depth for each of its pixels. Needs
//! `DAPPLE_DATA`.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod recording;

use dapple_occlusion::camera::masked::{Buffer, Edges, Facing, Form, Occluder};
use glam::{Mat4, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use recording::{Mesh, Recording};
use std::io::Write;

/// The recording, or none and a word about it.
fn load() -> Option<Recording> {
    let Some(root) = std::env::var_os("DAPPLE_DATA") else {
        // Past the harness, which keeps what a passing test prints to itself.
        let _ = writeln!(std::io::stderr(), "skipped: recording: DAPPLE_DATA is not set");
        return None;
    };
    let path = std::path::Path::new(&root).join("occlusion/OcclusionCulling_0.mocrec");
    Some(recording::read(&std::fs::read(path).unwrap()).unwrap())
}

fn facing(mesh: &Mesh) -> Facing {
    match mesh.back {
        0 => Facing::Both,
        1 => Facing::CounterClockwise,
        _ => Facing::Clockwise,
    }
}

fn buffer(recording: &Recording, form: Form) -> Buffer {
    let mut buffer = Buffer::new(form, recording.width, recording.height).unwrap();
    for mesh in &recording.meshes {
        let (positions, triangles) = (&mesh.positions[..], &mesh.triangles[..]);
        let occluder = Occluder { positions, triangles, facing: facing(mesh), edges: Edges::Exact };
        buffer.rasterise(&occluder, &mesh.clip).unwrap();
    }
    buffer
}

/// A depth for each pixel, by the same corners on the grid of 1/256 pixel but nothing else in
/// common: edges in integers, depth by interpolation in `f64`. Triangles that reach behind the near
/// plane are left out: were there any in sight, what they hide would count against the buffer.
fn depths(recording: &Recording) -> Vec<f64> {
    let (width, height) = (recording.width as i64, recording.height as i64);
    let mut out = vec![0.0f64; (width * height) as usize];
    for mesh in &recording.meshes {
        let snap = |p: Vec3| {
            let c = mesh.clip * p.extend(1.0);
            let half = [128.0 * width as f32, 128.0 * height as f32];
            let x = (c.x / c.w * half[0] + half[0]).round_ties_even();
            let y = (half[1] - c.y / c.w * half[1]).round_ties_even();
            (x as i64, y as i64, f64::from(c.z / c.w), c.w >= recording.near)
        };
        for t in &mesh.triangles {
            let [a, mut b, mut c] = t.map(|i| snap(mesh.positions[i as usize]));
            if !(a.3 && b.3 && c.3) {
                continue;
            }
            let mut area = (b.0 - a.0) * (c.1 - a.1) - (c.0 - a.0) * (b.1 - a.1);
            let back = if mesh.back == 1 { area > 0 } else { mesh.back == 2 && area < 0 };
            if area == 0 || back {
                continue;
            }
            if area < 0 {
                (b, c, area) = (c, b, -area);
            }
            let least = |u: i64, v: i64, w: i64| ((u.min(v).min(w) - 128) / 256).max(0);
            let most = |u: i64, v: i64, w: i64, n: i64| (u.max(v).max(w) / 256 + 1).min(n);
            for y in least(a.1, b.1, c.1)..most(a.1, b.1, c.1, height) {
                for x in least(a.0, b.0, c.0)..most(a.0, b.0, c.0, width) {
                    let (px, py) = (256 * x + 128, 256 * y + 128);
                    let edge = |p: (i64, i64, f64, bool), q: (i64, i64, f64, bool)| {
                        (q.0 - p.0) * (py - p.1) - (px - p.0) * (q.1 - p.1)
                    };
                    let weights = [edge(b, c), edge(c, a), edge(a, b)];
                    if weights.iter().all(|&w| w >= 0) {
                        let z = (weights[0] as f64 * a.2
                            + weights[1] as f64 * b.2
                            + weights[2] as f64 * c.2)
                            / area as f64;
                        let depth = &mut out[(y * width + x) as usize];
                        *depth = depth.max(z);
                    }
                }
            }
        }
    }
    out
}

/// Rectangles at depths: boxes around places on the recording's own meshes, of all sizes, in front
/// of them and behind.
fn questions(recording: &Recording, count: usize) -> Vec<([u32; 2], [u32; 2], f32)> {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let (width, height) = (recording.width as f32, recording.height as f32);
    let mut questions = Vec::new();
    while questions.len() < count {
        let mesh = &recording.meshes[random.random_range(0..recording.meshes.len())];
        let t = mesh.triangles[random.random_range(0..mesh.triangles.len())];
        let p = mesh.positions[t[random.random_range(0..3usize)] as usize];
        let Some([x, y, w]) = project(&mesh.clip, p, width, height) else { continue };
        let scale = 2f32.powf(random.random_range(-2.0..3.0));
        let side = 2f32.powf(random.random_range(0.0..9.0));
        let range = |middle: f32, size: f32| {
            let low = (middle - 0.5 * side).clamp(0.0, size) as u32;
            [low, ((middle + 0.5 * side).clamp(0.0, size) as u32).max(low)]
        };
        let (x, y) = (range(x, width), range(y, height));
        if x[0] < x[1] && y[0] < y[1] {
            questions.push((x, y, recording.near / (w * scale)));
        }
    }
    questions
}

fn project(clip: &Mat4, p: Vec3, width: f32, height: f32) -> Option<[f32; 3]> {
    let c = clip * p.extend(1.0);
    let [x, y] = [0.5 * (c.x / c.w + 1.0) * width, 0.5 * (1.0 - c.y / c.w) * height];
    let inside = c.w > 1.0 && (0.0..width).contains(&x) && (0.0..height).contains(&y);
    inside.then_some([x, y, c.w])
}

/// (hidden by each pixel's depth, of those hidden by the buffer, hidden by the buffer alone).
fn tally(recording: &Recording, buffer: &Buffer, depths: &[f64]) -> [usize; 3] {
    let mut tally = [0; 3];
    for (x, y, depth) in questions(recording, 4000) {
        let shows = (y[0]..y[1]).any(|row| {
            let line = &depths[(row * recording.width) as usize..];
            line[x[0] as usize..x[1] as usize].iter().any(|&d| f64::from(depth) >= d)
        });
        let hidden = !buffer.shows(x, y, depth);
        tally[0] += usize::from(!shows);
        tally[1] += usize::from(!shows && hidden);
        tally[2] += usize::from(shows && hidden);
    }
    tally
}

#[test]
fn nothing_visible_is_culled_and_almost_all_that_is_hidden() {
    let Some(recording) = load() else { return };
    assert_eq!((recording.meshes.len(), recording.triangles()), (9, 14_894));
    let depths = depths(&recording);
    let buffer = buffer(&recording, Form::Fast);
    let [hidden, found, wrong] = tally(&recording, &buffer, &depths);
    assert_eq!(wrong, 0);
    assert!(hidden > 500, "only {hidden} questions are hidden");
    let share = found as f64 / hidden as f64;
    println!("{found} of {hidden} hidden rectangles found: {share:.4}");
    assert!(share >= 0.98, "{found} of {hidden}");

    // The control: a frame whose occluders come nearer is caught.
    let mut nearer = recording;
    nearer.meshes.iter_mut().for_each(|m| {
        let z = m.clip.row(2) * 1.5;
        for (column, z) in z.to_array().into_iter().enumerate() {
            m.clip.col_mut(column).z = z;
        }
    });
    let buffer = self::buffer(&nearer, Form::Fast);
    assert!(tally(&nearer, &buffer, &depths)[2] > 0);
}

#[test]
fn both_forms_agree_on_a_recorded_frame() {
    let Some(recording) = load() else { return };
    let [a, b] = [Form::Fast, Form::Reference].map(|form| buffer(&recording, form));
    for (x, y, depth) in questions(&recording, 4000) {
        assert_eq!(a.shows(x, y, depth), b.shows(x, y, depth), "{x:?} {y:?} {depth}");
    }
}

#[test]
fn damaged_recordings_are_refused() {
    let refusal = |bytes: &[u8]| recording::read(bytes).map(drop).unwrap_err();
    assert!(refusal(&[0; 20]).contains("signature"));
    let mut bytes = 0xa701_b600u32.to_le_bytes().to_vec();
    assert!(refusal(&bytes).contains("byte 4"));
    bytes.extend([0; 12]);
    bytes.push(9);
    assert!(refusal(&bytes).contains("unknown record 0x9"));
    *bytes.last_mut().unwrap() = 0x7f;
    assert!(recording::read(&bytes).unwrap().meshes.is_empty());
}
