//! What more occluders do to what is hidden.

use super::*;

/// Questions about whole subtiles within the image: columns, rows, depth.
fn questions(size: [u32; 2], seed: u64) -> Vec<([u32; 2], [u32; 2], f32)> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut range = |size: u32, side: u32| {
        let most = size / side;
        let first = random.random_range(0..=most);
        [first * side, random.random_range(first..=most) * side]
    };
    let mut ranges: Vec<_> = (0..40).map(|_| (range(size[0], 8), range(size[1], 4))).collect();
    // Small ones are hidden more often.
    let cells = |size: u32, side: u32| (0..size / side).map(move |i| [i * side, (i + 1) * side]);
    ranges.extend(cells(size[0], 8).flat_map(|x| cells(size[1], 4).map(move |y| (x, y))));
    ranges.into_iter().map(|(x, y)| (x, y, random.random_range(0.0..0.5))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn whole_subtiles_stay_hidden(kind in 0..KINDS, seed: u64) {
        let first = case(kind, seed);
        let questions = questions(first.size, seed);
        let mut buffer = drawn(Form::Fast, &first, Edges::Exact);
        for step in 1..4 {
            let hidden: Vec<bool> = questions.iter().map(|&(x, y, z)| !buffer.shows(x, y, z)).collect();
            let more = Case { size: first.size, ..case(kind, seed.wrapping_add(step)) };
            add(&mut buffer, &more, Edges::Exact);
            for (&(x, y, z), hidden) in questions.iter().zip(hidden) {
                prop_assert!(!(hidden && buffer.shows(x, y, z)), "{x:?} {y:?} {z}");
            }
        }
    }
}

/// The control, and the limit of the promise: two depths cannot keep three, so a part of a subtile
/// may show again.
#[test]
fn parts_of_subtiles_may_show_again() {
    let strip = |from: f32, to: f32, depth: f32| {
        let corner = |x: f32, y: f32| Vec3::new(x, y, depth);
        let positions =
            vec![corner(from, 0.0), corner(to, 0.0), corner(to, 4.0), corner(from, 4.0)];
        Case {
            size: [8, 4],
            clip: pixels([8, 4]),
            positions,
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    };
    let mut buffer = drawn(Form::Fast, &strip(0.0, 1.0, 0.5), Edges::Exact);
    assert!(!buffer.shows([0, 1], [0, 4], 0.4));
    add(&mut buffer, &strip(1.0, 7.0, 0.25), Edges::Exact);
    assert!(buffer.shows([0, 1], [0, 4], 0.4) && !buffer.shows([0, 7], [0, 4], 0.2));
}

/// Half a subtile near and all of it far away fit into two depths, in either order.
#[test]
fn a_wall_behind_does_not_spoil_what_stands_half_before_it() {
    let size = [8, 4];
    let near = square([4, 4], true, 0.5);
    let near = Case { size, clip: pixels(size), ..near };
    // One triangle: the first of two would come to a third depth.
    let far = Case { size, clip: pixels(size), ..square([16, 8], true, 0.25) };
    let far = Case { triangles: vec![[0, 1, 3]], ..far };
    for form in [Form::Fast, Form::Reference] {
        for order in [[&near, &far], [&far, &near]] {
            let mut buffer = drawn(form, order[0], Edges::Exact);
            add(&mut buffer, order[1], Edges::Exact);
            assert!(!buffer.shows([0, 4], [0, 4], 0.4), "{form:?}");
            assert!(!buffer.shows([0, 8], [0, 4], 0.2), "{form:?}");
            assert!(buffer.shows([0, 5], [0, 4], 0.3), "{form:?}");
        }
    }
}
