//! What nodes say of their lights, against sums over the lights themselves.

use crate::support::{WEIGHTED, builds, cloud, numbers, omni, spot, windows};
use dapple_many_lights::{
    Emission, Light, LightTree, LightsError,
    tree::{Build, Representative},
};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Lights below a node.
fn lights_of(tree: &LightTree, index: usize) -> Vec<u32> {
    let below = &tree.nodes[index..index + tree.nodes[index].size as usize];
    below.iter().filter(|node| node.is_leaf()).map(|node| node.light).collect()
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

#[test]
fn nodes_are_what_their_lights_are_together() {
    let lights = cloud(300, 5);
    let keys: Vec<Vec<u32>> = (0..300).map(|i| vec![i % 3, i % 5, i % 7]).collect();
    for build in builds(&keys) {
        let tree = LightTree::build(&lights, build, WEIGHTED).unwrap();
        tree.check(&lights).unwrap();
        for (index, node) in tree.nodes.iter().enumerate().filter(|(_, n)| !n.is_leaf()) {
            let own: Vec<&Light> =
                lights_of(&tree, index).into_iter().map(|l| &lights[l as usize]).collect();
            let weight: f64 = own.iter().map(|l| l.luminance()).sum();
            let intensity: DVec3 = own.iter().map(|l| l.intensity).sum();
            let position: DVec3 =
                own.iter().map(|l| l.position * l.luminance()).sum::<DVec3>() / weight;
            let axis = own.iter().map(|l| l.axis * l.luminance()).sum::<DVec3>().normalize();
            assert!((node.intensity - intensity).abs().max_element() < 1e-9 * weight);
            assert!(node.position.distance(position) < 1e-9 * 100.0);
            assert!(angle(node.axis, axis) < 1e-9);
            // The cone is the narrowest around that axis.
            let widest = own.iter().map(|l| angle(axis, l.axis)).fold(0.0, f64::max);
            assert!((node.cone_rad - widest).abs() < 1e-7, "{} {widest}", node.cone_rad);
            let nearest = own.iter().map(|l| l.position.distance(node.position));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            let stands = lights[node.light as usize].position.distance(node.position);
            assert_eq!(stands, nearest);
        }
    }
}

#[test]
fn dark_lights_weigh_alike() {
    let dark = [0.0, 3.0, 9.0].map(|x| omni(DVec3::X * x, 0.0));
    let root = LightTree::median(&dark).unwrap().nodes[0];
    assert!((root.position - DVec3::X * 4.0).length() < 1e-12);
    // Beside a bright one they do not count.
    let mixed = [dark[0], dark[1], omni(DVec3::X * 9.0, 1e-9)];
    assert_eq!(LightTree::median(&mixed).unwrap().nodes[0].position, DVec3::X * 9.0);
}

#[test]
fn opposite_axes_cancel_and_a_third_does_not() {
    let opposite = [spot(DVec3::ZERO, DVec3::X), spot(DVec3::Y, -DVec3::X)];
    let root = LightTree::median(&opposite).unwrap().nodes[0];
    assert_eq!(root.cone_rad, PI);
    let three = [opposite[0], opposite[1], spot(DVec3::Y * 2.0, DVec3::Z)];
    let tree = LightTree::median(&three).unwrap();
    assert!((tree.nodes[0].cone_rad - FRAC_PI_2).abs() < 1e-9);
    assert_eq!(tree.nodes[0].axis, DVec3::Z);
    // A real light that stands for others never cancels.
    let random = LightTree::build(&opposite, Build::Median, Representative::Random { seed: 1 });
    let root = random.unwrap().nodes[0];
    assert!(root.cone_rad < PI && root.cone_rad > 0.99 * PI);
    assert!(root.pack().cone_rad < std::f32::consts::PI);
}

#[test]
fn packed_nodes_hold_what_nodes_held() {
    let mut lights = cloud(500, 8);
    lights.extend(windows(10, 10).into_iter().map(|l| Light { position: l.position * 1e4, ..l }));
    let tree = LightTree::median(&lights).unwrap();
    let packed = tree.pack();
    for (node, packed) in tree.nodes.iter().zip(&packed.nodes) {
        assert!(packed.min.as_dvec3().cmple(node.min).all());
        assert!(packed.max.as_dvec3().cmpge(node.max).all());
        if !node.is_leaf() {
            for axis in [node.axis, DVec3::X, DVec3::Z] {
                let reach = angle(node.axis, axis).min(node.cone_rad);
                // Whatever lies in the cone lies in the packed one.
                let to = node.axis.any_orthonormal_vector();
                let edge = node.axis * reach.cos() + to * reach.sin();
                // The f32 below π is what is nearest to it and no cancelling.
                let slack = if reach > PI - 1e-6 { 2e-7 } else { 1e-12 };
                let turned = angle(packed.axis.as_dvec3(), edge);
                assert!(turned <= f64::from(packed.cone_rad) + slack);
            }
        }
    }
}

#[test]
fn a_random_representative_is_right_in_the_mean() {
    // Alike but for place, brightness and axis: the mean over seeds is the sum over lights.
    let mut next = numbers(4);
    let lights: Vec<Light> = (0..7)
        .map(|i| {
            let axis = DVec3::new(next() - 0.5, next() - 0.5, 2.0);
            let light = spot(DVec3::new(next(), next(), f64::from(i) * 0.1), axis);
            Light { intensity: DVec3::splat(0.1 + f64::from(i)), ..light }
        })
        .collect();
    let point = DVec3::new(0.3, 0.6, 6.0);
    let falls = |position: DVec3, axis: DVec3| {
        let away = point - position;
        let falloff = Emission::Spot { half_angle_rad: 0.8 }.falloff(angle(axis, away));
        falloff / away.length_squared()
    };
    let exact: f64 = lights.iter().map(|l| l.intensity.x * falls(l.position, l.axis)).sum();
    let seeds = 10_000;
    for build in [Build::Median, Build::Greedy { spread: 1.0 }, Build::SurfaceArea] {
        let (mut sum, mut squares) = (0.0, 0.0);
        for seed in 0..seeds {
            let tree = LightTree::build(&lights, build, Representative::Random { seed }).unwrap();
            let root = tree.nodes[0];
            let real = &lights[root.light as usize];
            assert_eq!((root.position, root.axis), (real.position, real.axis));
            let estimate = root.intensity.x * falls(root.position, root.axis);
            (sum, squares) = (sum + estimate, squares + estimate * estimate);
        }
        let mean = sum / seeds as f64;
        let error = ((squares / seeds as f64 - mean * mean) / seeds as f64).sqrt();
        assert!((mean - exact).abs() < 4.0 * error, "{mean} {exact} {error}");
        assert!(error < 0.02 * exact, "too few seeds to tell");
        // The weighted mean is another number.
        let weighted = LightTree::build(&lights, build, WEIGHTED).unwrap().nodes[0];
        let estimate = weighted.intensity.x * falls(weighted.position, weighted.axis);
        assert!((estimate - exact).abs() > 4.0 * error);
    }
}

#[test]
fn the_nearest_light_stands_for_the_mean() {
    let lights = cloud(100, 2);
    let weighted = LightTree::median(&lights).unwrap();
    let nearest = LightTree::build(&lights, Build::Median, Representative::Nearest).unwrap();
    for (mean, real) in weighted.nodes.iter().zip(&nearest.nodes) {
        assert_eq!(mean.light, real.light);
        assert_eq!(real.position, lights[real.light as usize].position);
    }
}

/// What breaks a tree, and what the check then says.
#[test]
fn a_broken_tree_is_noticed() {
    type Break = fn(&mut LightTree);
    let lights = cloud(40, 6);
    let keys: Vec<Vec<u32>> = (0..40).map(|i| vec![i / 10, i / 5]).collect();
    let sound = LightTree::by_keys(&lights, &keys).unwrap();
    let broken: [(&str, Break); 13] = [
        ("ends outside", |t| t.nodes[1].size += 1),
        ("is not at node", |t| t.leaves.swap(0, 1)),
        ("roots hold", |t| t.nodes[0].size -= 1),
        ("a root at node", |t| t.roots[0] = 1),
        ("leaves for 40 lights", |t| t.leaves.truncate(39)),
        ("box does not hold", |t| {
            t.nodes[1].max.x -= 1e-9 + (t.nodes[1].max.x - t.nodes[1].position.x) * 0.5
        }),
        ("outside of its box", |t| t.nodes[1].position.x = 1e3),
        ("not the sum", |t| t.nodes[1].intensity.y *= 1.001),
        ("cone does not hold", |t| t.nodes[1].cone_rad *= 0.99),
        ("half angle", |t| t.nodes[1].half_angle_rad *= 0.5),
        ("not its own", |t| t.nodes[1].light = t.nodes[t.nodes.len() - 1].light),
        ("differs from its light", |t| t.nodes[3].half_angle_rad *= 0.9),
        ("no angle", |t| t.nodes[1].cone_rad = f64::NAN),
    ];
    sound.check(&lights).unwrap();
    for (message, damage) in broken {
        let mut tree = sound.clone();
        damage(&mut tree);
        let error = tree.check(&lights).map_err(|error: LightsError| error.to_string());
        assert!(error.as_ref().is_err_and(|e| e.contains(message)), "{message}: {error:?}");
    }
}

#[test]
fn a_cone_that_forgets_its_children_s_axes_is_noticed() {
    let lights = windows(4, 4);
    let mut tree = LightTree::median(&lights).unwrap();
    for node in &mut tree.nodes {
        node.cone_rad = 0.0;
    }
    assert!(tree.check(&lights).unwrap_err().to_string().contains("cone does not hold"));
}

#[test]
fn arranged_children_are_the_same_clusters() {
    let lights = cloud(60, 9);
    let keys: Vec<Vec<u32>> = (0..60).map(|i| vec![i % 4, i % 6]).collect();
    for build in builds(&keys) {
        let tree = LightTree::build(&lights, build, WEIGHTED).unwrap();
        let turned = tree.with_children_arranged(<[u32]>::reverse);
        turned.check(&lights).unwrap();
        assert_ne!(tree.nodes, turned.nodes);
        assert_eq!(turned.with_children_arranged(<[u32]>::reverse).nodes, tree.nodes);
        assert_eq!(tree.with_children_arranged(|_| ()).leaves, tree.leaves);
    }
}
