//! Masked culling never hides what a depth for each pixel would show.

mod cases;
mod choice;
mod culling;
mod layers;
mod truth;

use super::buffer::Tile;
use super::*;
use cases::{KINDS, SIZES, case, perspective, pixels};
use glam::{Mat4, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use truth::{Case, depths};

fn drawn(form: Form, case: &Case, edges: Edges) -> Buffer {
    let mut buffer = Buffer::new(form, case.size[0], case.size[1]).unwrap();
    add(&mut buffer, case, edges);
    buffer
}

fn add(buffer: &mut Buffer, case: &Case, edges: Edges) {
    let (positions, triangles) = (&case.positions[..], &case.triangles[..]);
    let occluder = Occluder { positions, triangles, facing: Facing::Both, edges };
    buffer.rasterise(&occluder, &case.clip).unwrap();
}

/// Pixels that the buffer hides from something at the depth that is drawn there.
fn wrongly_hidden(buffer: &Buffer, depths: &[f64]) -> usize {
    let [width, height] = buffer.size();
    assert_eq!(depths.len(), (width * height) as usize);
    let hidden = |&i: &u32| {
        let (x, y) = (i % width, i / width);
        // The next number above, where f32 rounds down.
        let depth = depths[i as usize] as f32;
        !buffer.shows([x, x + 1], [y, y + 1], depth.next_up())
    };
    (0..width * height).filter(hidden).count()
}

/// Corners moved by another renderer's snapping.
fn moved(seed: u64) -> impl Fn(usize) -> [f64; 2] {
    move |i| {
        let mut random = Pcg64Mcg::seed_from_u64(seed ^ (i as u64) << 20);
        std::array::from_fn(|_| random.random_range(-0.5..=0.5) / 256.0)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn nothing_is_hidden_that_another_renderer_shows(kind in 0..KINDS, seed: u64) {
        let case = case(kind, seed);
        let connectivity = Connectivity::new(&case.positions, &case.triangles);
        for edges in [Edges::Inset(MOVED), Edges::Silhouette(MOVED, &connectivity)] {
            let buffer = drawn(Form::Fast, &case, edges);
            prop_assert_eq!(wrongly_hidden(&buffer, &depths(&case, |_| [0.0; 2])), 0);
            prop_assert_eq!(wrongly_hidden(&buffer, &depths(&case, moved(seed))), 0);
        }
    }

    #[test]
    fn both_forms_give_the_same_bits(kind in 0..KINDS, seed: u64, edges in 0..3) {
        let case = case(kind, seed);
        let connectivity = Connectivity::new(&case.positions, &case.triangles);
        let edges = match edges {
            0 => Edges::Exact,
            1 => Edges::Inset(131),
            _ => Edges::Silhouette(131, &connectivity),
        };
        let [fast, reference] = [Form::Fast, Form::Reference].map(|form| drawn(form, &case, edges));
        prop_assert_eq!(bits(&fast), bits(&reference));
    }

    #[test]
    fn a_rectangle_shows_where_a_pixel_of_it_does(kind in 0..KINDS, seed: u64) {
        let case = case(kind, seed);
        let buffer = drawn(Form::Fast, &case, Edges::Exact);
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let [width, height] = case.size;
        for _ in 0..8 {
            let mut range = |size: u32| {
                let a = random.random_range(0..=size);
                [a, random.random_range(a..=size + 3)]
            };
            let (x, y) = (range(width), range(height));
            let depth = random.random_range(0.0..1.0);
            let pixel = |x: u32, y: u32| buffer.shows([x, x + 1], [y, y + 1], depth);
            let any = (y[0]..y[1]).any(|y| (x[0]..x[1]).any(|x| pixel(x, y)));
            prop_assert_eq!(buffer.shows(x, y, depth), any);
        }
    }

    #[test]
    fn no_order_of_occluders_hides_too_much(kind in 0..KINDS, seed: u64) {
        let mut case = case(kind, seed);
        let truth = depths(&case, |_| [0.0; 2]);
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        for _ in 0..4 {
            for i in (1..case.triangles.len()).rev() {
                case.triangles.swap(i, random.random_range(0..=i));
            }
            let buffer = drawn(Form::Fast, &case, Edges::Inset(MOVED));
            prop_assert_eq!(wrongly_hidden(&buffer, &truth), 0);
        }
    }
}

fn bits(buffer: &Buffer) -> Vec<[u32; 24]> {
    let tile = |t: &Tile| {
        std::array::from_fn(|i| match i / 8 {
            0 => t.reference[i].to_bits(),
            1 => t.working[i - 8].to_bits(),
            _ => t.mask[i - 16],
        })
    };
    buffer.tiles.iter().map(tile).collect()
}

/// The control: depths of a nearer occluder are taken for the occluder's own.
#[test]
fn a_buffer_that_hides_too_much_is_caught() {
    let mut caught = 0;
    for seed in 0..40 {
        let case = case(0, seed);
        let mut nearer = case.clone();
        nearer.clip.z_axis.z = -0.05;
        let buffer = drawn(Form::Fast, &nearer, Edges::Inset(MOVED));
        caught += usize::from(wrongly_hidden(&buffer, &depths(&case, |_| [0.0; 2])) > 0);
    }
    assert!(caught > 20, "{caught} of 40");
}

/// The control: without insets, another renderer's snapping uncovers pixels.
#[test]
fn edges_that_are_not_moved_are_caught() {
    let caught = (0..200).filter(|&seed| {
        let case = case(1 + seed % 3, seed);
        let buffer = drawn(Form::Fast, &case, Edges::Exact);
        wrongly_hidden(&buffer, &depths(&case, moved(seed))) > 0
    });
    assert!(caught.count() > 2);
}

fn square(size: [u32; 2], split: bool, depth: f32) -> Case {
    let [w, h] = size.map(|s| s as f32);
    let corner = |x: f32, y: f32| Vec3::new(x, y, depth);
    let positions = vec![corner(0.0, 0.0), corner(w, 0.0), corner(w, h), corner(0.0, h)];
    let triangles = if split { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[1, 2, 3], [0, 1, 3]] };
    Case { size, clip: pixels(size), positions, triangles }
}

/// A sheet whose border, and what touches it, lies beyond the image hides all of it.
#[test]
fn silhouettes_leave_no_cracks() {
    let side = 9u32;
    let at = |i: u32, size: f32| (2.0 * i as f32 / (side - 1) as f32 - 0.5) * size;
    let places = (0..side * side).map(|i| Vec3::new(at(i % side, 96.0), at(i / side, 40.0), 0.5));
    let cells = (0..side * (side - 1)).filter(|i| i % side != side - 1);
    let triangles =
        cells.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]).collect();
    let size = [96, 40];
    let case = Case { size, clip: pixels(size), positions: places.collect(), triangles };
    let connectivity = Connectivity::new(&case.positions, &case.triangles);
    let whole = |edges| !drawn(Form::Fast, &case, edges).shows([0, 96], [0, 40], 0.4);
    assert!(whole(Edges::Silhouette(40, &connectivity)));
    // The control: the same sheet with all edges moved.
    assert!(!whole(Edges::Inset(40)));
}

#[test]
fn a_square_in_two_triangles_hides_every_pixel() {
    for size in SIZES {
        for split in [false, true] {
            for form in [Form::Fast, Form::Reference] {
                let buffer = drawn(form, &square(size, split, 0.5), Edges::Exact);
                let all = |v: u32| [0, v];
                assert!(
                    !buffer.shows(all(size[0]), all(size[1]), 0.499),
                    "{size:?} {split} {form:?}"
                );
                // A tie shows.
                assert!(buffer.shows(all(size[0]), all(size[1]), 0.5));
            }
        }
    }
}

/// Triangles around random points: the fill rule gives each pixel to one of them.
#[test]
fn a_fan_has_neither_cracks_nor_overlaps() {
    let size = [64, 24];
    for seed in 0..60u64 {
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let mut random = |most: u32| {
            // Half of the points lie on centres.
            if seed % 2 == 0 {
                random.random_range(0..2 * most) as f32 * 0.5
            } else {
                random.random_range(0.0..most as f32)
            }
        };
        let middle = Vec3::new(random(64), random(24), 0.5);
        let mut case = square(size, true, 0.5);
        case.positions.push(middle);
        case.triangles = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        let covered = |triangles: &[[u32; 3]]| {
            let part = Case { triangles: triangles.to_vec(), ..case.clone() };
            let buffer = drawn(Form::Fast, &part, Edges::Exact);
            let pixels = (0..64 * 24u32).map(|i| (i % 64, i / 64));
            pixels.filter(|&(x, y)| !buffer.shows([x, x + 1], [y, y + 1], 0.1)).count()
        };
        let each: usize = case.triangles.iter().map(|&t| covered(&[t])).sum();
        assert_eq!((covered(&case.triangles), each), (64 * 24, 64 * 24), "seed {seed}");
    }
}

#[test]
fn an_empty_buffer_shows_all_and_clearing_empties() {
    let case = square([40, 20], true, 0.5);
    let mut buffer = drawn(Form::Fast, &case, Edges::Exact);
    assert!(!buffer.shows([0, 40], [0, 20], 0.1));
    buffer.clear();
    let fresh = Buffer::new(Form::Fast, 40, 20).unwrap();
    assert_eq!(bits(&buffer), bits(&fresh));
    assert!(
        buffer.shows([39, 40], [19, 20], 0.1) && buffer.shows([0, 1], [0, 1], f32::MIN_POSITIVE)
    );
    // Nothing shows beyond the image or in no pixel.
    assert!(!buffer.shows([40, 50], [0, 20], 1.0) && !buffer.shows([3, 3], [0, 20], 1.0));
}

#[test]
fn a_slit_of_one_pixel_shows() {
    let size = [96, 40];
    let mut case = square(size, true, 0.5);
    for slit in [0.0, 31.0, 32.0, 50.0, 95.0] {
        let (p, q) = (slit, slit + 1.0);
        let x = [0.0, p, q, 96.0];
        case.positions =
            x.iter().flat_map(|&x| [0.0, 40.0].map(|y| Vec3::new(x, y, 0.5))).collect();
        case.triangles = vec![[0, 1, 2], [1, 3, 2], [4, 5, 6], [5, 7, 6]];
        let buffer = drawn(Form::Fast, &case, Edges::Exact);
        assert!(buffer.shows([0, 96], [0, 40], 0.1), "slit at {slit}");
        let column = slit as u32;
        assert!(
            !buffer.shows([0, column], [0, 40], 0.1)
                && !buffer.shows([column + 1, 96], [0, 40], 0.1)
        );
        // Narrower than a pixel and beside all centres: no image shows it.
        case.positions[2].x = slit + 0.6;
        case.positions[3].x = slit + 0.6;
        let buffer = drawn(Form::Fast, &case, Edges::Exact);
        assert!(!buffer.shows([0, 96], [0, 40], 0.1), "closed slit at {slit}");
    }
}

#[test]
fn facing_leaves_out_the_other_side() {
    let size = [33, 9];
    let case = square(size, true, 0.5);
    let shows = |facing, form| {
        let (positions, triangles) = (&case.positions[..], &case.triangles[..]);
        let mut buffer = Buffer::new(form, 33, 9).unwrap();
        let occluder = Occluder { positions, triangles, facing, edges: Edges::Exact };
        buffer.rasterise(&occluder, &case.clip).unwrap();
        buffer.shows([0, 33], [0, 9], 0.1)
    };
    for form in [Form::Fast, Form::Reference] {
        // Clockwise on the image: right, then down.
        assert!(!shows(Facing::Clockwise, form) && !shows(Facing::Both, form));
        assert!(shows(Facing::CounterClockwise, form));
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let refusal =
        |size: [u32; 2]| Buffer::new(Form::Fast, size[0], size[1]).unwrap_err().to_string();
    assert!(refusal([0, 5]).contains("0 x 5") && refusal([5, 16_385]).contains("1..=16384"));
    let good = square([33, 9], true, 0.5);
    let error = |positions: Vec<Vec3>, triangles: Vec<[u32; 3]>, clip: Mat4, form| {
        let mut buffer = Buffer::new(form, 33, 9).unwrap();
        let (positions, triangles) = (&positions[..], &triangles[..]);
        let occluder = Occluder { positions, triangles, facing: Facing::Both, edges: Edges::Exact };
        buffer.rasterise(&occluder, &clip).unwrap_err().to_string()
    };
    for form in [Form::Fast, Form::Reference] {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for index in [0, 3, 11] {
                let mut positions =
                    [&good.positions[..], &good.positions, &good.positions].concat();
                positions[index].y = bad;
                let message = error(positions, good.triangles.clone(), good.clip, form);
                assert!(message.contains(&format!("vertex {index} ")), "{message}");
            }
            let clip = Mat4::from_cols_array(&[bad; 16]);
            let message = error(good.positions.clone(), good.triangles.clone(), clip, form);
            assert!(message.contains("matrix"), "{message}");
        }
        let message = error(good.positions.clone(), vec![[0, 1, 2], [0, 1, 4]], good.clip, form);
        assert!(message.contains("triangle 1") && message.contains("4 corners"), "{message}");
    }
}

#[test]
fn nothing_and_degenerate_triangles_cover_nothing() {
    let size = [64, 16];
    for triangles in [vec![], vec![[0, 0, 1], [2, 2, 2], [0, 1, 0]]] {
        let case = Case { triangles, ..square(size, true, 0.5) };
        for form in [Form::Fast, Form::Reference] {
            let fresh = Buffer::new(form, 64, 16).unwrap();
            assert_eq!(bits(&drawn(form, &case, Edges::Exact)), bits(&fresh));
        }
    }
    let behind = Case {
        positions: vec![Vec3::Z, Vec3::new(1.0, 0.0, 2.0), Vec3::new(0.0, 1.0, 2.0)],
        triangles: vec![[0, 1, 2]],
        size,
        clip: perspective(size),
    };
    let fresh = Buffer::new(Form::Fast, 64, 16).unwrap();
    assert_eq!(bits(&drawn(Form::Fast, &behind, Edges::Exact)), bits(&fresh));
}

#[test]
fn the_largest_image_holds_the_largest_triangle() {
    let size = [16_384, 8];
    let mut case = square(size, true, 0.25);
    case.positions =
        vec![Vec3::new(-1e9, -1e9, 0.25), Vec3::new(1e9, -1e9, 0.25), Vec3::new(0.0, 1e9, 0.25)];
    case.triangles = vec![[0, 1, 2]];
    let buffer = drawn(Form::Fast, &case, Edges::Inset(MOVED));
    let shown = |&x: &u32| buffer.shows([x, x + 1], [0, 8], 0.2);
    assert_eq!((0..16_384).filter(shown).count(), 0, "{:?}", buffer.tiles[3]);
    assert_eq!(buffer.bytes(), 512 * 96);
}
