//! Sums and cuts on a device against f64: the same but for rounding, except where a threshold lies
//! within rounding of a bound.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod gpu_support;

use dapple_gpu::{Gpu, testing::test_gpu};
use dapple_many_lights::{
    Absolute, BoundForm, Emission, Form, LightTree, Lightcuts, Lighting, PackedNode, PackedTree,
    Per, Relative, Selection, Shaded, Technique, World,
    cut::{self, Given, Starts},
    gpu,
    gpu::Scene,
    make,
    worlds::{Facade, WINDOW, emissions, facade},
};
use glam::DVec3;
use gpu_support::{BLACK, TOLERANCE, agree, lit, shade, there, undecided, with_tree};
use std::sync::Arc;

/// Sizes that fill tiles, and that do not.
const SIZES: [[u32; 2]; 4] = [[1, 1], [8, 8], [13, 7], [40, 30]];

fn absolute(threshold: f64, bound: BoundForm, per: Per) -> Technique {
    Technique::Absolute(Absolute { threshold, bound, per })
}

#[test]
fn brute_force_is_the_sum_over_all_lights() {
    let Some(gpu) = test_gpu() else { return };
    let mut checked = 0;
    for emissions in emissions() {
        for (lights, size) in [(0, [8, 8]), (1, [13, 7]), (2, [1, 1]), (300, [40, 30])] {
            let given = lit(lights, &emissions, size);
            let found = shade(gpu, Form::Gpu, &Technique::BruteForce, &given);
            let world = &given.0;
            for (pixel, point) in world.frames[0].points.iter().enumerate() {
                let expected =
                    if point.is_there() { world.truth(point) } else { DVec3::ZERO }.as_vec3();
                assert!(agree(found.radiance[pixel], expected), "{pixel}: {expected}");
                checked += usize::from(expected.max_element() > 0.0);
            }
            let pixels = there(world).count() as u64;
            assert_eq!(
                (found.work.pixels, found.work.lights),
                (pixels, pixels * u64::from(lights))
            );
            assert_eq!((found.work.visits, found.work.clusters, found.work.cut), (0, 0, 0));
        }
    }
    assert!(checked > 2000, "{checked}");
}

#[test]
fn sums_of_very_many_lights_keep_what_is_added_late() {
    let Some(gpu) = test_gpu() else { return };
    // Half of the light is in the first light: one running sum would round each of the others.
    let (world, _) = lit(200_000, &[Emission::Omni], [4, 3]);
    let mut world = (*world).clone();
    let total: DVec3 = world.lights.iter().map(|light| light.intensity).sum();
    world.lights[0].intensity = total;
    let (world, tree) = with_tree(world);
    let mut running = 0;
    for technique in [Technique::BruteForce, absolute(0.0, BoundForm::Cheap, Per::Pixel)] {
        let found = shade(gpu, Form::Gpu, &technique, &(Arc::clone(&world), Arc::clone(&tree)));
        let lit = world.frames[0].points.iter().zip(found.radiance);
        for (point, found) in lit.filter(|(point, _)| point.is_there()) {
            let expected = world.truth(point).as_vec3();
            let error = (found - expected).abs().max_element() / expected.max_element();
            assert!(error < 1e-5, "{error}");
            // Negative control: the running sum is beyond that.
            let plain = |sum: glam::Vec3, light| {
                sum + dapple_many_lights::radiance(point, light, world.clamp_m).as_vec3()
            };
            let plain = world.lights.iter().fold(glam::Vec3::ZERO, plain);
            let error = (plain - expected).abs().max_element() / expected.max_element();
            running += usize::from(error > 1e-5);
        }
    }
    assert!(running > 0, "the scene does not tell sums apart");
}

/// Holds a technique on the device against f64; how many pixels were undecided, and how many not.
fn held_to_f64(
    gpu: &Gpu,
    technique: &Technique,
    given: &(Arc<World>, Arc<LightTree>),
) -> (usize, usize) {
    let (world, tree) = given;
    let expected = shade(gpu, Form::Reference, technique, given);
    let found = shade(gpu, Form::Gpu, technique, given);
    let undecided = undecided(technique, world, tree);
    for (pixel, near) in undecided.iter().enumerate() {
        let (lit, wanted) = (found.radiance[pixel], expected.radiance[pixel]);
        if let Some(cost) = near {
            let error = f64::from((lit - wanted).abs().max_element());
            let rounding = f64::from(TOLERANCE * wanted.max_element() + BLACK);
            assert!(error <= cost + rounding, "{technique:?}: pixel {pixel}: {error} of {cost}");
        } else {
            assert_eq!(found.visits[pixel], expected.visits[pixel], "{technique:?}: {pixel}");
            assert!(agree(lit, wanted), "{technique:?}: pixel {pixel}: {lit}, not {wanted}");
        }
    }
    let open = undecided.iter().flatten().count();
    if open == 0 {
        assert_eq!(found.work, expected.work, "{technique:?}");
    }
    (open, undecided.len() - open)
}

#[test]
fn cuts_are_those_of_f64_where_no_threshold_is_within_rounding() {
    let Some(gpu) = test_gpu() else { return };
    let mut techniques = Vec::new();
    for bound in [BoundForm::Walter, BoundForm::Cheap] {
        techniques.push(Technique::Relative(Relative { epsilon: 0.5, bound }));
        for per in [Per::Pixel, Per::Tile] {
            techniques.extend([1.0 / 255.0, 1.0 / 25_500.0].map(|t| absolute(t, bound, per)));
            techniques.extend([0.0, f64::INFINITY].map(|t| absolute(t, bound, per)));
        }
    }
    let (mut open, mut decided) = (0, 0);
    for technique in &techniques {
        for emissions in emissions() {
            for (lights, size) in [0, 1, 2, 200].into_iter().zip(SIZES) {
                let (near, clear) = held_to_f64(gpu, technique, &lit(lights, &emissions, size));
                // At T = 0 every node that may give nothing at all is in the band.
                if !matches!(technique, Technique::Absolute(a) if a.threshold == 0.0) {
                    open += near;
                    decided += clear;
                }
            }
        }
    }
    // The band is narrow: half a percent of pixels at most are in it for some node of theirs.
    assert!(decided > 50_000 && open * 200 < decided, "{open} undecided, {decided} decided");
}

#[test]
fn walks_start_where_an_object_says() {
    let Some(gpu) = test_gpu() else { return };
    let (world, tree) = lit(300, &[Emission::Omni, WINDOW], [43, 30]);
    let scene = Arc::new(Scene::new(gpu, &world).unwrap());
    let children = |node| cut::children(node, |n| tree.nodes[n as usize].size);
    let deep: Vec<u32> = tree.roots.iter().flat_map(|&root| children(root)).collect();
    // The ground starts below the roots, the first wall at one root, the second nowhere, the third
    // has no list.
    let lists = [Some(deep), Some(tree.roots[1..].to_vec()), Some(vec![])];
    let starts = Starts::new(&tree.roots, &lists, tree.nodes.len()).unwrap();
    let mut several = 0;
    for technique in [
        absolute(1.0 / 1020.0, BoundForm::Cheap, Per::Pixel),
        absolute(1.0 / 1020.0, BoundForm::Cheap, Per::Tile),
        lightcuts(0.02, 1000, BoundForm::Cheap),
    ] {
        let mut given = Given::new(&technique, &world, &tree).unwrap();
        given.starts = starts.clone();
        let (mut expected, mut found) = (Shaded::default(), Shaded::default());
        let mut reference = cut::Reference::new(given.clone());
        reference.shade(0, true).unwrap();
        reference.read(&mut expected).unwrap();
        let mut device = gpu::cut(&scene, &given).unwrap();
        device.shade(0, true).unwrap();
        device.read(&mut found).unwrap();
        assert!(found.visits == expected.visits, "{technique:?}: visits");
        assert_eq!(found.work, expected.work, "{technique:?}");
        for (pixel, point) in world.frames[0].points.iter().enumerate() {
            let (lit, wanted) = (found.radiance[pixel], expected.radiance[pixel]);
            assert!(agree(lit, wanted), "{technique:?}: pixel {pixel}: {lit}, not {wanted}");
            if point.object == 2 {
                assert_eq!((lit, found.visits[pixel]), (glam::Vec3::ZERO, 0));
                several += 1;
            }
        }
    }
    assert!(several > 30);
}

#[test]
fn lanes_wait_less_in_shallow_trees_and_not_at_all_for_one_cut_a_tile() {
    let Some(gpu) = test_gpu() else { return };
    let wide = Facade { storeys: 24, windows: 96, size: [64, 32], ..Facade::default() };
    let (made, keys) = facade(&wide);
    let shallow = Arc::new(LightTree::by_keys(&made.world.lights, &keys).unwrap());
    let (world, deep) = with_tree(made.world);
    let divergence = |per: Per, tree: &Arc<LightTree>| {
        let technique = absolute(1.0 / 1020.0, BoundForm::Cheap, per);
        shade(gpu, Form::Gpu, &technique, &(Arc::clone(&world), Arc::clone(tree))).work.divergence()
    };
    let [of_deep, of_shallow] = [&deep, &shallow].map(|tree| divergence(Per::Pixel, tree));
    assert!(1.0 < of_shallow && of_shallow < of_deep, "{of_shallow} and {of_deep}");
    // The wall fills every tile.
    assert_eq!(divergence(Per::Tile, &deep), 1.0);
}

#[test]
fn a_band_that_is_not_looked_at_would_be_missed() {
    // Negative control of the test above: cuts of another threshold are told apart.
    let Some(gpu) = test_gpu() else { return };
    let given = lit(200, &[WINDOW], [40, 30]);
    let of = |threshold| absolute(threshold, BoundForm::Cheap, Per::Pixel);
    let found = shade(gpu, Form::Gpu, &of(1.0 / 1020.0), &given);
    let other = shade(gpu, Form::Reference, &of(1.01 / 1020.0), &given);
    let near = undecided(&of(1.0 / 1020.0), &given.0, &given.1);
    let differ =
        |pixel: &usize| near[*pixel].is_none() && found.visits[*pixel] != other.visits[*pixel];
    assert!((0..near.len()).filter(differ).count() > 10);
}

fn lightcuts(epsilon: f64, most: u32, bound: BoundForm) -> Technique {
    Technique::Lightcuts(Lightcuts { epsilon, most, selection: Selection::Scan, bound })
}

#[test]
fn lightcuts_are_those_of_f64() {
    let Some(gpu) = test_gpu() else { return };
    let (mut same, mut other) = (0, 0);
    for bound in [BoundForm::Walter, BoundForm::Cheap] {
        for (epsilon, most) in [(0.02, 1000), (0.1, 1000), (0.02, 24), (0.0, 1000), (0.02, 1)] {
            for emissions in emissions() {
                for (lights, size) in [0, 1, 2, 200].into_iter().zip(SIZES) {
                    let technique = lightcuts(epsilon, most, bound);
                    let given = lit(lights, &emissions, size);
                    let expected = shade(gpu, Form::Reference, &technique, &given);
                    let found = shade(gpu, Form::Gpu, &technique, &given);
                    assert_eq!(found.work.pixels, expected.work.pixels);
                    assert!(found.work.most_cut <= u64::from(most).max(4));
                    let differ = |pixel: &usize| {
                        let (f, e) = (found.radiance[*pixel], expected.radiance[*pixel]);
                        found.visits[*pixel] != expected.visits[*pixel] || !agree(f, e)
                    };
                    let differing = (0..found.visits.len()).filter(differ).count();
                    if differing == 0 {
                        assert_eq!(found.work, expected.work, "{technique:?}");
                    }
                    other += differing;
                    same += found.visits.len() - differing;
                }
            }
        }
    }
    // Two clusters whose bounds agree to rounding may be split in either order, or the limit lie
    // between: 1 % of pixels at most.
    assert!(same > 20_000 && other * 100 < same, "{other} differ, {same} do not");
}

#[test]
fn what_a_large_estimate_hid_is_not_lost() {
    // A cluster whose representative touches the point, its lights away from it: the estimate is
    // 10^8 times what the lights give.
    let Some(gpu) = test_gpu() else { return };
    let (world, _) = lit(0, &[Emission::Omni], [24, 16]);
    let mut world = (*world).clone();
    let middle = there(&world).nth(100).unwrap().position.as_dvec3() + DVec3::Y * 0.01;
    let light = |offset: DVec3| dapple_many_lights::Light {
        position: middle + offset,
        axis: DVec3::Y,
        intensity: DVec3::ONE,
        emission: Emission::Omni,
    };
    world.clamp_m = 1e-5;
    for x in 0..8 {
        let far = DVec3::new(40.0 + f64::from(x), 30.0, 0.0);
        world
            .lights
            .extend([light(far), light(far * DVec3::new(-1.0, 1.0, 1.0) - 60.0 * DVec3::Y)]);
    }
    let given = with_tree(world);
    let technique = lightcuts(0.02, 1000, BoundForm::Cheap);
    let expected = shade(gpu, Form::Reference, &technique, &given);
    let found = shade(gpu, Form::Gpu, &technique, &given);
    for (found, expected) in found.radiance.iter().zip(&expected.radiance) {
        assert!(agree(*found, *expected), "{found}, not {expected}");
    }
}

#[test]
fn what_a_device_cannot_do_is_refused_by_name() {
    let Some(gpu) = test_gpu() else { return };
    let (world, tree) = lit(4, &[WINDOW], [8, 8]);
    let technique = absolute(0.01, BoundForm::Cheap, Per::Pixel);
    let none = make(Form::Gpu, &technique, &world, &tree, None).err().unwrap();
    assert_eq!(none.to_string(), "gpu form: needs a scene on a device");
    let (other, _) = lit(4, &[WINDOW], [8, 8]);
    let scene = Arc::new(Scene::new(gpu, &other).unwrap());
    let error = make(Form::Gpu, &technique, &world, &tree, Some(&scene)).err().unwrap();
    assert_eq!(error.to_string(), "gpu form: the scene on the device is of another world");
    // A tree of more bytes than the device binds.
    let most = gpu.limits().max_storage_buffer_binding_size;
    let nodes = vec![PackedNode::default(); (most / 80 + 1) as usize];
    let large = PackedTree { nodes, roots: vec![0] };
    let error = gpu::Tree::new(gpu, &large, &Starts::roots(&large.roots)).unwrap_err().to_string();
    assert!(error.starts_with("buffer `light tree`"), "{error}");
    assert!(error.contains("max_storage_buffer_binding_size"), "{error}");
}

#[test]
fn nothing_is_read_before_a_frame_is_lit() {
    let Some(gpu) = test_gpu() else { return };
    let (world, tree) = lit(4, &[WINDOW], [8, 8]);
    let scene = Arc::new(Scene::new(gpu, &world).unwrap());
    let mut lighting =
        make(Form::Gpu, &Technique::BruteForce, &world, &tree, Some(&scene)).unwrap();
    let mut shaded = Shaded::default();
    assert!(lighting.read(&mut shaded).is_err());
    lighting.shade(0, false).unwrap();
    assert!(lighting.read(&mut shaded).is_ok());
    lighting.reset(1).unwrap();
    assert!(lighting.read(&mut shaded).is_err());
}
