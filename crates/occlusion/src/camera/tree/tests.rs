use super::bottom_up::{exact, locally_ordered};
use super::*;
use crate::camera::Object;
use glam::{Mat3, Vec3};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

fn of_boxes(boxes: &[Bounds]) -> Objects {
    let object =
        |&bounds| Object { template: 0, linear: Mat3::IDENTITY, translation: Vec3::ZERO, bounds };
    Objects { objects: boxes.iter().map(object).collect(), ..Objects::default() }
}

fn random_boxes(count: usize, seed: u64, size: f32) -> Vec<Bounds> {
    let mut rng = Pcg32::seed_from_u64(seed);
    let mut point = |scale: f32| {
        Vec3::new(rng.random::<f32>(), rng.random::<f32>(), rng.random::<f32>()) * scale
    };
    let mut one = || {
        let min = point(1.0);
        Bounds { min, max: min + point(size) }
    };
    (0..count).map(|_| one()).collect()
}

/// Storeys of a street grid: masses of equal distances.
fn regular(side: u32) -> Vec<Bounds> {
    let cell = |i: u32| {
        let min = Vec3::new((i % side) as f32, (i / side % side) as f32, (i / side / side) as f32);
        Bounds { min, max: min + Vec3::new(1.0, 1.0, 0.0) }
    };
    (0..side * side * side).map(cell).collect()
}

fn both(objects: &Objects) -> [Statistics; 2] {
    let boxes: Vec<Bounds> = objects.objects.iter().map(|o| o.bounds).collect();
    [exact(&boxes), locally_ordered(&boxes)].map(|merges| {
        let mut tree = Tree::from_merges(boxes.len(), &merges);
        tree.fit(objects);
        tree.validate(objects).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn every_object_has_a_leaf_and_boxes_hold_what_is_below(
        count in 1_usize..150, seed: u64, size in 0.0_f32..0.5,
    ) {
        let objects = of_boxes(&random_boxes(count, seed, size));
        for shape in both(&objects) {
            prop_assert_eq!(shape.nodes, 2 * count as u64 - 1);
            prop_assert_eq!(shape.leaves, count as u64);
            prop_assert!(shape.children_most <= 2);
        }
        Tree::bottom_up(&objects).unwrap().validate(&objects).unwrap();
    }

    #[test]
    fn exact_always_joins_the_least_pair(count in 2_usize..60, seed: u64, lattice: bool) {
        let mut boxes = random_boxes(count, seed, 0.2);
        if lattice {
            // Many ties.
            for b in &mut boxes {
                b.min = (b.min * 4.0).floor();
                b.max = b.min + 1.0;
            }
        }
        let merges = exact(&boxes);
        prop_assert_eq!(merges.len(), count - 1);
        let mut live: Vec<u32> = (0..count as u32).collect();
        for [a, b] in merges {
            let area = |i: u32, j: u32| boxes[i as usize].union(boxes[j as usize]).surface_area();
            let least = live
                .iter()
                .flat_map(|&i| live.iter().filter(move |&&j| j < i).map(move |&j| (i, j)))
                .map(|(i, j)| area(i, j))
                .min_by(f32::total_cmp)
                .unwrap();
            prop_assert_eq!(area(a, b), least);
            live.retain(|&i| i != a && i != b);
            live.push(boxes.len() as u32);
            boxes.push(boxes[a as usize].union(boxes[b as usize]));
        }
    }

    #[test]
    fn by_keys_follows_the_given_paths(
        keys in prop::collection::vec(prop::collection::vec(0_u32..3, 0..5), 1..80), seed: u64,
    ) {
        let objects = of_boxes(&random_boxes(keys.len(), seed, 0.1));
        let tree = Tree::by_keys(&objects, &keys).unwrap();
        let shape = tree.validate(&objects).unwrap();
        prop_assert_eq!(shape.leaves, keys.len() as u64);
        prop_assert!(shape.nodes < 2 * shape.leaves);
        for index in 0..tree.nodes.len() as u32 {
            let below = tree.objects_of(index);
            prop_assert_eq!(tree.is_leaf(index), below.len() == 1);
            // A node is all objects of one leading path.
            let first = &keys[below[0] as usize];
            let common = below
                .iter()
                .map(|&o| keys[o as usize].iter().zip(first).take_while(|(a, b)| a == b).count())
                .min()
                .unwrap();
            let sharing = keys.iter().filter(|k| k.starts_with(&first[..common])).count();
            prop_assert!(below.len() == 1 || below.len() == sharing);
        }
    }

    #[test]
    fn scaled_and_moved_objects_give_the_same_tree(seed: u64, power in -19_i32..20) {
        // Powers of two change no bit of any comparison.
        let boxes = random_boxes(100, seed, 0.1);
        let scale = 2.0_f32.powi(power);
        let scaled: Vec<Bounds> = boxes
            .iter()
            .map(|b| Bounds { min: b.min * scale, max: b.max * scale })
            .collect();
        prop_assert_eq!(exact(&boxes), exact(&scaled));
        prop_assert_eq!(locally_ordered(&boxes), locally_ordered(&scaled));
    }
}

#[test]
fn rows_of_equal_boxes_make_shallow_trees() {
    let point = Bounds { min: Vec3::ONE, max: Vec3::ONE };
    for count in [1, 2, 3, 5, 64, 1000] {
        for shape in both(&of_boxes(&vec![point; count])) {
            let least = (count as f64).log2().ceil() as u32;
            assert!(shape.depth_most <= least + 1, "{count}: {shape:?}");
        }
    }
    for shape in both(&of_boxes(&regular(12))) {
        assert!(shape.depth_most <= 20, "{shape:?}");
    }
}

#[test]
fn locally_ordered_stays_shallow_where_each_is_nearer_to_the_one_before() {
    // Gaps that grow along a line, and boxes within boxes: few agree with their neighbours.
    let growing = |i: u32| {
        let x = (i as f32).powi(3);
        Bounds { min: Vec3::new(x, 0.0, 0.0), max: Vec3::new(x, 1.0, 1.0) }
    };
    let nested = |i: u32| Bounds { min: Vec3::splat(-(i as f32)), max: Vec3::splat(i as f32) };
    for make in [&growing as &dyn Fn(u32) -> Bounds, &nested] {
        let boxes: Vec<Bounds> = (0..20_000).map(make).collect();
        let objects = of_boxes(&boxes);
        let shape = Tree::bottom_up(&objects).unwrap().validate(&objects).unwrap();
        assert!(shape.depth_most < 600, "{shape:?}");
    }
}

#[test]
fn locally_ordered_is_nearly_as_good_as_exact() {
    for seed in 0..5 {
        let [exact, local] = both(&of_boxes(&random_boxes(1500, seed, 0.05)));
        assert!(local.area_ratio < 1.15 * exact.area_ratio, "{exact:?} {local:?}");
    }
}

#[test]
fn threads_do_not_change_the_tree() {
    let boxes = random_boxes(20_000, 3, 0.01);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let many = rayon::ThreadPoolBuilder::new().num_threads(5).build().unwrap();
    let merges = alone.install(|| locally_ordered(&boxes));
    assert_eq!(merges, many.install(|| locally_ordered(&boxes)));
}

#[test]
fn hundreds_of_thousands_take_seconds() {
    let boxes = random_boxes(420_000, 1, 0.002);
    let objects = of_boxes(&boxes);
    let start = std::time::Instant::now();
    let tree = Tree::bottom_up(&objects).unwrap();
    let took = start.elapsed();
    let shape = tree.validate(&objects).unwrap();
    assert!(took.as_secs() < 60, "{took:?}");
    assert!(shape.depth_most < 64, "{shape:?}");
}

#[test]
fn nothing_one_and_bad_boxes() {
    let none = of_boxes(&[]);
    let tree = Tree::bottom_up(&none).unwrap();
    assert!(tree.nodes.is_empty());
    assert_eq!(tree.validate(&none).unwrap(), Statistics::default());
    assert!(Tree::by_keys(&none, &[]).unwrap().nodes.is_empty());

    let one = of_boxes(&random_boxes(1, 1, 0.0));
    for tree in [Tree::bottom_up(&one).unwrap(), Tree::by_keys(&one, &[vec![7, 7]]).unwrap()] {
        assert_eq!(tree.nodes.len(), 1);
        assert!(tree.is_leaf(0));
        assert_eq!(tree.objects_of(0), [0]);
    }
    let message = Tree::by_keys(&one, &[]).unwrap_err().to_string();
    assert!(message.contains("0 for 1 objects"), "{message}");

    let mut boxes = random_boxes(3, 1, 0.1);
    for bad in [f32::NAN, f32::INFINITY] {
        boxes[2].max.y = bad;
        let message = Tree::bottom_up(&of_boxes(&boxes)).unwrap_err().to_string();
        assert!(message.contains("object 2"), "{message}");
    }
    boxes[2] = Bounds::EMPTY;
    assert!(Tree::bottom_up(&of_boxes(&boxes)).is_err());
}

#[test]
fn single_children_are_left_out_and_equal_paths_lie_together() {
    let keys = [vec![1, 4, 2], vec![1, 4, 0], vec![1, 4, 0], vec![3], vec![1, 4]];
    let objects = of_boxes(&random_boxes(5, 9, 0.1));
    let tree = Tree::by_keys(&objects, &keys).unwrap();
    tree.validate(&objects).unwrap();
    // Root: [1, 4, ..] and [3]. Below the first: the one that ends there, [0] twice, [2].
    assert_eq!(tree.nodes[0].children.len(), 2);
    let inner = tree.nodes[0].children.start;
    assert_eq!(tree.objects_of(inner), [4, 1, 2, 0]);
    assert_eq!(tree.nodes[inner as usize].children.len(), 3);
    assert_eq!(tree.nodes.len(), 8);
}

#[test]
fn validate_finds_what_is_broken() {
    let objects = of_boxes(&random_boxes(20, 5, 0.1));
    let good = Tree::bottom_up(&objects).unwrap();
    let breaks: [&dyn Fn(&mut Tree); 7] = [
        &|t| t.objects[3] = t.objects[4],
        &|t| t.nodes[2].bounds.max.x -= 0.5,
        &|t| t.nodes[0].bounds = Bounds::EMPTY,
        &|t| t.nodes[5].parent = 4,
        &|t| t.nodes[0].children = 0..2,
        &|t| t.nodes[1].objects.end -= 1,
        &|t| t.nodes.push(t.nodes[1].clone()),
    ];
    for (i, spoil) in breaks.iter().enumerate() {
        let mut tree = good.clone();
        spoil(&mut tree);
        assert!(tree.validate(&objects).is_err(), "{i}");
    }
}
