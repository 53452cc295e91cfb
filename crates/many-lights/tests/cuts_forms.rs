//! Cuts on the processor against cuts in f64: frames, counters, starts, shadows.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Absolute, BoundForm, Emission, Form, LightTree, Lightcuts, Lighting, Per, Relative, Selection,
    Shaded, Technique, World,
    cut::{Cpu, Given, Receiver, Reference, Rule, Starts, band, tile},
    make,
    worlds::{self, Cloud, WINDOW},
};
use std::sync::Arc;

const BOUNDS: [BoundForm; 2] = [BoundForm::Cheap, BoundForm::Walter];

fn absolute(threshold: f64, per: Per, bound: BoundForm) -> Technique {
    Technique::Absolute(Absolute { threshold, per, bound })
}

fn worst(selection: Selection, epsilon: f64, most: u32) -> Technique {
    Technique::Lightcuts(Lightcuts { epsilon, most, selection, bound: BoundForm::Walter })
}

fn techniques() -> Vec<Technique> {
    let mut all = vec![
        worst(Selection::Heap, 0.02, 1000),
        worst(Selection::Scan, 0.05, 30),
        worst(Selection::Heap, 0.0, 1),
    ];
    for bound in BOUNDS {
        all.push(Technique::Relative(Relative { epsilon: 0.1, bound }));
        for per in [Per::Pixel, Per::Tile] {
            let thresholds = [0.0, 1.0 / 25500.0, 1.0 / 255.0, f64::INFINITY];
            all.extend(thresholds.map(|threshold| absolute(threshold, per, bound)));
        }
    }
    all
}

fn cloud(lights: u32, size: [u32; 2]) -> World {
    let emissions = vec![Emission::Omni, Emission::Oriented, WINDOW, WINDOW, Emission::Directional];
    worlds::cloud(&Cloud { lights, size, emissions, seed: 5, ..Cloud::default() }).world
}

fn with_tree(world: World) -> (Arc<World>, Arc<LightTree>) {
    let tree = LightTree::median(&world.lights).unwrap();
    (Arc::new(world), Arc::new(tree))
}

fn shaded(lighting: &mut dyn Lighting, count: bool) -> Shaded {
    let mut shaded = Shaded::default();
    lighting.shade(0, count).unwrap();
    lighting.read(&mut shaded).unwrap();
    shaded
}

fn of_form(
    form: Form,
    technique: &Technique,
    (world, tree): &(Arc<World>, Arc<LightTree>),
) -> Shaded {
    shaded(&mut *make(form, technique, world, tree, None).unwrap(), true)
}

/// Pixels whose radiance differs by more than `share` of it, where display can show it at all.
fn apart(a: &Shaded, b: &Shaded, share: f32) -> Vec<usize> {
    assert_eq!(a.radiance.len(), b.radiance.len());
    let differs = |&pixel: &usize| {
        let (a, b) = (a.radiance[pixel], b.radiance[pixel]);
        let is_near = (a - b).abs().max_element() <= share * a.max(b).max_element() + 1e-7;
        // What is not a number is not near.
        !is_near
    };
    (0..a.radiance.len()).filter(differs).collect()
}

#[test]
fn f32_shows_what_f64_shows_except_where_it_may_cut_otherwise() {
    let (mut same, mut other) = (0, 0);
    for (lights, size) in [(0, [9, 7]), (1, [16, 8]), (2, [13, 9]), (300, [21, 18])] {
        let given = with_tree(cloud(lights, size));
        for technique in techniques() {
            let reference = of_form(Form::Reference, &technique, &given);
            let cpu = of_form(Form::Cpu, &technique, &given);
            let apart = apart(&reference, &cpu, 1e-4);
            let alike = |pixel: &usize| reference.visits[*pixel] == cpu.visits[*pixel];
            let alone: Vec<_> = apart.iter().filter(|pixel| alike(pixel)).collect();
            assert!(alone.is_empty(), "{technique:?}: cut alike, but differ: {alone:?}");
            let differ = (0..cpu.visits.len()).filter(|pixel| !alike(pixel)).count();
            if differ == 0 {
                assert_eq!(reference.work, cpu.work, "{technique:?}");
            }
            other += differ;
            same += cpu.visits.len() - differ;
        }
    }
    // T = 0 splits what gives nothing in one and the smallest number in the other.
    assert!(same > 10_000 && other * 50 < same, "{other} cut otherwise, {same} alike");
}

#[test]
fn pixels_cut_otherwise_only_within_the_band() {
    let (world, tree) = with_tree(cloud(2000, [40, 30]));
    let packed = tree.pack();
    let tree = band::unpacked(&packed);
    let (mut visited, mut parted) = (0, 0);
    for bound in BOUNDS {
        for rule in [1.0 / 25500.0, 1.0 / 1020.0, 1.0 / 255.0].map(Rule::Absolute) {
            for point in world.frames[0].points.iter().filter(|point| point.is_there()) {
                let receiver = Receiver { point, form: bound, clamp_m: world.clamp_m };
                let takes = |node: u32| rule.takes(&packed.nodes[node as usize], &receiver);
                let differences = band::differences(&tree, &tree.roots, rule, &receiver, takes);
                let unexplained = differences.iter().find(|one| !one.is_explained());
                assert!(unexplained.is_none(), "{rule:?}: {unexplained:?}");
                let undecided = band::undecided(&tree, &tree.roots, rule, &receiver);
                assert!(undecided > 0 || differences.is_empty());
                parted += differences.len();
                visited += 1;
            }
        }
    }
    assert!(visited > 4000);
    assert!(parted * 100 < visited, "{parted} of {visited} cuts part");
}

#[test]
fn a_rule_that_is_off_by_one_per_cent_leaves_the_band() {
    let (world, tree) = with_tree(cloud(2000, [40, 30]));
    let (rule, off) = (Rule::Absolute(1.0 / 1020.0), Rule::Absolute(1.01 / 1020.0));
    let packed = tree.pack();
    let unexplained =
        world.frames[0].points.iter().filter(|point| point.is_there()).filter(|point| {
            let receiver = Receiver { point, form: BoundForm::Cheap, clamp_m: world.clamp_m };
            let takes = |node: u32| off.takes(&packed.nodes[node as usize], &receiver);
            let found = band::differences(&tree, &tree.roots, rule, &receiver, takes);
            found.iter().any(|one| !one.is_explained())
        });
    assert!(unexplained.count() > 100);
}

#[test]
fn counters_are_what_the_visits_say_and_counting_changes_nothing() {
    let given = with_tree(cloud(300, [21, 18]));
    for form in [Form::Reference, Form::Cpu] {
        for technique in techniques() {
            let mut lighting = make(form, &technique, &given.0, &given.1, None).unwrap();
            let counted = shaded(&mut *lighting, true);
            let plain = shaded(&mut *lighting, false);
            assert_eq!(counted.radiance, plain.radiance);
            assert_eq!(plain.work, dapple_many_lights::Work::default());
            assert!(plain.visits.is_empty());
            let work = counted.work;
            assert_eq!(work.visits, counted.visits.iter().map(|&v| u64::from(v)).sum::<u64>());
            assert_eq!(work.lane_visits, tile::lane_visits(21, 18, &counted.visits));
            let there = given.0.frames[0].points.iter().filter(|point| point.is_there());
            assert_eq!(work.pixels, there.count() as u64);
            assert!(work.cut >= work.pixels * given.1.roots.len() as u64);
            assert!(work.most_cut * work.pixels >= work.cut);
            assert_eq!(work.rays, 0);
            if let Technique::Absolute(settings) = technique {
                assert_eq!(work.cut, work.lights + work.clusters, "{technique:?}");
                if settings.per == Per::Pixel {
                    assert_eq!(work.visits, work.bounds + work.lights);
                    let work = tile::spread(&given.0.frames[0], &counted.visits);
                    assert_eq!(work.divergence, counted.work.divergence());
                }
            }
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let given = with_tree(cloud(300, [37, 50]));
    for technique in techniques() {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let shaded = pool.install(|| of_form(Form::Cpu, &technique, &given));
            (shaded.radiance, shaded.visits, shaded.work)
        };
        assert_eq!(with(1), with(5), "{technique:?}");
    }
}

#[test]
fn lists_of_starts_replace_the_roots() {
    let given = with_tree(cloud(300, [21, 18]));
    let (world, tree) = &given;
    let objects = 4;
    let roots = vec![Some(tree.roots.clone()); objects];
    let nothing = vec![Some(vec![]); objects];
    for technique in techniques() {
        let lit = |starts: Option<Vec<Option<Vec<u32>>>>| {
            let mut given = Given::new(&technique, world, tree).unwrap();
            if let Some(lists) = starts {
                given.starts = Starts::new(&tree.roots, &lists, tree.nodes.len()).unwrap();
            }
            let mut forms: [Box<dyn Lighting>; 2] =
                [Box::new(Reference::new(given.clone())), Box::new(Cpu::new(given))];
            forms.each_mut().map(|form| shaded(&mut **form, true))
        };
        let (by_default, by_list) = (lit(None), lit(Some(roots.clone())));
        for (by_default, by_list) in by_default.iter().zip(&by_list) {
            // Objects no longer share lists, so tiles are cut object by object.
            let per_tile =
                matches!(technique, Technique::Absolute(Absolute { per: Per::Tile, .. }));
            if !per_tile {
                assert_eq!(by_default.radiance, by_list.radiance, "{technique:?}");
                assert_eq!(by_default.work, by_list.work, "{technique:?}");
            }
        }
        for dark in lit(Some(nothing.clone())) {
            assert!(dark.radiance.iter().all(|radiance| *radiance == glam::Vec3::ZERO));
            assert_eq!((dark.work.visits, dark.work.cut), (0, 0));
        }
    }
}

#[test]
fn shadow_rays_take_away_what_is_not_seen() {
    let made = worlds::cloud(&Cloud { lights: 60, size: [20, 15], ..Cloud::default() });
    let open = with_tree(made.world.clone());
    let shadowed = with_tree(made.with_shadows().unwrap());
    let frame = &shadowed.0.frames[0];
    let all = absolute(0.0, Per::Pixel, BoundForm::Cheap);
    let mut darker = 0;
    for technique in
        [all, absolute(0.0, Per::Tile, BoundForm::Cheap), worst(Selection::Heap, 0.0, 1000)]
    {
        for form in [Form::Reference, Form::Cpu] {
            let (lit, free) =
                (of_form(form, &technique, &shadowed), of_form(form, &technique, &open));
            assert!(lit.work.rays > 0 && free.work.rays == 0);
            for (pixel, point) in frame.points.iter().enumerate() {
                let truth = if point.is_there() {
                    shadowed.0.truth(point).as_vec3()
                } else {
                    glam::Vec3::ZERO
                };
                let off = (lit.radiance[pixel] - truth).abs().max_element();
                assert!(
                    off <= 1e-4 * truth.max_element() + 1e-7,
                    "{technique:?} {form:?} {pixel}: {off}"
                );
                darker +=
                    usize::from(truth.max_element() < 0.9 * free.radiance[pixel].max_element());
            }
        }
    }
    assert!(darker > 100, "{darker}");
}

#[test]
fn a_million_lights_are_summed_without_losing_any() {
    let world = worlds::cloud(&Cloud { lights: 1_000_000, size: [8, 8], ..Cloud::default() }).world;
    let given = with_tree(world);
    let found = of_form(Form::Cpu, &absolute(0.0, Per::Pixel, BoundForm::Cheap), &given);
    let frame = &given.0.frames[0];
    let (pixel, point) = frame.points.iter().enumerate().find(|(_, p)| p.is_there()).unwrap();
    let truth = given.0.truth(point);
    let error = (found.radiance[pixel].as_dvec3() - truth).abs().max_element();
    assert!(error <= 2e-5 * truth.max_element(), "{error} of {truth}");
}

#[test]
fn frames_and_trees_that_do_not_fit_are_refused_by_name() {
    let (world, tree) = with_tree(cloud(3, [4, 4]));
    let technique = absolute(0.1, Per::Pixel, BoundForm::Cheap);
    let mut lighting = make(Form::Cpu, &technique, &world, &tree, None).unwrap();
    assert_eq!(lighting.shade(1, false).unwrap_err().to_string(), "frame 1: there are 1");
    let other = Arc::new(LightTree::default());
    let error = make(Form::Cpu, &technique, &world, &other, None).err().unwrap();
    assert_eq!(error.to_string(), "light tree: has 0 leaves for 3 lights");
    let error = Given::new(&Technique::BruteForce, &world, &tree).err().unwrap();
    assert_eq!(error.to_string(), "BruteForce: makes no cuts");
}
