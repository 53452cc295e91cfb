//! Cities' own hierarchies.

use crate::{shapes::depth, support::numbers};
use dapple_many_lights::{
    Emission, LightTree,
    tree::{
        Build, Representative,
        city::{LAMPS, Levels, keys, limited},
    },
};
use dapple_scene::{
    city::{City, StreetLamp},
    generate,
};
use glam::{DVec3, Vec3};

fn city() -> City {
    generate::city_of("city_small", 1).unwrap()
}

fn tree(city: &City, levels: Levels) -> LightTree {
    let (lights, keys) = keys(city, DVec3::ZERO, levels);
    let tree = LightTree::by_keys(&lights, &keys).unwrap();
    tree.check(&lights).unwrap();
    tree
}

fn children(tree: &LightTree, index: usize) -> Vec<usize> {
    let end = index + tree.nodes[index].size as usize;
    let first = (index + 1 < end).then_some(index + 1);
    let next = |&child: &usize| {
        let next = child + tree.nodes[child].size as usize;
        (next < end).then_some(next)
    };
    std::iter::successors(first, next).collect()
}

fn widest(tree: &LightTree) -> usize {
    (0..tree.nodes.len()).map(|index| children(tree, index).len()).max().unwrap()
}

#[test]
fn a_city_is_five_levels_deep_and_has_few_clusters() {
    let city = city();
    let tree = tree(&city, Levels::default());
    let windows = city.lights.len();
    assert!(windows > 1000, "{windows}");
    let of_windows = tree.roots.iter().position(|&r| tree.nodes[r as usize].kind == 2).unwrap();
    let root = tree.nodes[tree.roots[of_windows] as usize];
    assert_eq!(depth(&tree), 5);
    assert!(f64::from(root.size) <= 1.6 * windows as f64, "{} {windows}", root.size);
    // A third of a cluster for each storey of three windows, and some above.
    assert!(f64::from(root.size) >= 1.33 * windows as f64);
}

#[test]
fn clusters_are_what_lies_together_in_the_city() {
    let city = city();
    let (lights, _) = keys(&city, DVec3::new(3.0, 4.0, 5.0), Levels::default());
    for (light, window) in lights.iter().zip(&city.lights) {
        assert_eq!(light.position, window.position - DVec3::new(3.0, 4.0, 5.0));
        assert_eq!((light.axis, light.intensity), (window.direction, window.intensity.as_dvec3()));
        let half_angle_rad = window.half_angle_rad;
        assert_eq!(light.emission, Emission::Spot { half_angle_rad });
    }
    let tree = tree(&city, Levels::default());
    let mut storeys = 0;
    for (index, node) in tree.nodes.iter().enumerate().filter(|(_, n)| n.kind == 2) {
        let below = children(&tree, index);
        if below.is_empty() || !below.iter().all(|&child| tree.nodes[child].is_leaf()) {
            continue;
        }
        // The lowest clusters are storeys of a facade.
        let of = |&child: &usize| {
            let window = &city.lights[tree.nodes[child].light as usize];
            (window.building, window.facade, window.storey)
        };
        assert!(below.iter().all(|child| of(child) == of(&below[0])), "node {index}");
        assert!(node.cone_rad < 1e-6, "a facade has one direction");
        storeys += 1;
    }
    assert!(storeys > 300, "{storeys}");
}

#[test]
fn levels_left_out_make_trees_shallower_and_wider() {
    let city = city();
    let all = Levels::default();
    let whole = tree(&city, all);
    let without = [
        Levels { block: false, ..all },
        Levels { building: false, ..all },
        Levels { facade: false, ..all },
        Levels { storey: false, ..all },
    ];
    for levels in without {
        let tree = tree(&city, levels);
        assert_eq!(depth(&tree), 4, "{levels:?}");
        assert!(tree.nodes.len() < whole.nodes.len(), "{levels:?}");
        assert!(widest(&tree) >= widest(&whole), "{levels:?}");
    }
    let none = Levels { block: false, building: false, facade: false, storey: false };
    let (lights, _) = keys(&city, DVec3::ZERO, none);
    assert!(tree(&City { lamps: vec![], ..city }, none).nodes.len() <= lights.len() + 1);
}

#[test]
fn street_lamps_lie_in_tiles_and_halves() {
    let mut next = numbers(11);
    let lamps: Vec<StreetLamp> = (0..700)
        .map(|_| {
            let position = DVec3::new(next() * 900.0 - 450.0, 6.0, next() * 900.0 - 450.0);
            StreetLamp { position, intensity: Vec3::ONE }
        })
        .collect();
    let city = City { lamps, ..City::default() };
    let tree = tree(&city, Levels::default());
    assert!(tree.nodes.iter().all(|node| node.kind == 0));
    // 81 to 100 tiles of 100 m.
    let tiles = children(&tree, 0).len();
    assert!((81..=100).contains(&tiles), "{tiles}");
    for index in 0..tree.nodes.len() {
        let below = children(&tree, index);
        assert!(index == 0 || below.len() <= LAMPS, "node {index}: {}", below.len());
    }
    for tile in children(&tree, 0) {
        let extent = tree.nodes[tile].max - tree.nodes[tile].min;
        assert!(extent.max_element() <= 100.0);
    }
}

#[test]
fn clusters_of_too_many_children_are_divided() {
    let city = city();
    let (lights, keys) = keys(&city, DVec3::ZERO, Levels::default());
    let free = LightTree::by_keys(&lights, &keys).unwrap();
    assert!(widest(&free) > 4);
    for most in [2, 3, 4, 7] {
        let keys = limited(&lights, &keys, most).unwrap();
        let tree = LightTree::by_keys(&lights, &keys).unwrap();
        tree.check(&lights).unwrap();
        assert!(widest(&tree) <= most as usize, "{most}: {}", widest(&tree));
        assert!(tree.nodes.len() > free.nodes.len());
    }
    // As many as there are changes nothing.
    let same = limited(&lights, &keys, 100_000).unwrap();
    assert_eq!(LightTree::by_keys(&lights, &same).unwrap().nodes, free.nodes);
    let error = limited(&lights, &keys, 1).unwrap_err().to_string();
    assert!(error.contains("1 is not at least 2"), "{error}");
    // Ten thousand lights right below the root, in one place and in many.
    let flat = vec![vec![]; 10_000];
    for scale in [0.0, 1.0] {
        let mut next = numbers(3);
        let lights: Vec<_> = (0..10_000)
            .map(|_| crate::support::omni(DVec3::new(next(), next(), next()) * scale, 1.0))
            .collect();
        let keys = limited(&lights, &flat, 10).unwrap();
        let tree = LightTree::build(&lights, Build::Keys(&keys), Representative::Nearest).unwrap();
        tree.check(&lights).unwrap();
        assert_eq!((widest(&tree), depth(&tree)), (10, 4), "10 to the 4 lights");
    }
}

#[test]
fn a_city_without_lights_is_no_tree() {
    let empty = City::default();
    assert!(tree(&empty, Levels::default()).nodes.is_empty());
    let mut one = city();
    (one.lights, one.lamps) = (vec![one.lights[0]], vec![]);
    assert_eq!(tree(&one, Levels::default()).nodes.len(), 1);
}
