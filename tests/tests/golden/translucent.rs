//! Translucent shadows in grass and on hair at 160 x 90: lit images of the layered maps by number of
//! layers, the layer that each pixel reads, and what the maps of hair hold.

use dapple_metrics::rmse;
use dapple_opacity_maps::{
    Code, Fragments, Receiver, Settings, code, cpu::Maps, exact::Exact, layered::LayeredCode, taps,
};
use dapple_suite::{
    case::Case,
    knob::{self, Knobs},
    problem::{Form, Prepared, Setting},
    problems,
    problems::translucent_shadow::{SPEC, TranslucentCase, settings},
};
use dapple_tests::golden::{LSB, Picture, Tolerance, assert_golden};

const SIZE: [u32; 2] = [160, 90];

/// Texels a side: a picture of a map is small, and a texel about the size of what truth averages.
const SIDE: u32 = 128;

const TECHNIQUES: [&str; 3] = ["osm", "dom", "bom"];

/// Layers of the lit images, and the error against the uncompressed map that they may have. A layer
/// mixes up what lies in it; the finer, the less there is to mix up.
const LAYERS: [(i64, f64); 2] = [(4, 0.06), (16, 0.03)];

/// Share of the error of no shadow at all that a lit image may have: at this resolution the map alone
/// has a third in grass, and leaves that count as opaque, which make no picture of foliage, 0.44.
const MOST: f64 = 0.4;

/// Layers of the views of layers.
const VIEWED: i64 = 16;

/// What is not there, or in front of everything, in a view of layers. Layer 0 is light grey, the last
/// one black, as is what lies behind all of them.
const BACKGROUND: f32 = 1.0;

const SCENES: [&str; 2] = ["grass", "hair"];

/// Which maps of a bounding opacity map of hair are shown: its bounds, then sums.
const MAPS: [&str; 5] = ["first", "last", "sum-0", "sum-7", "sum-15"];

/// Names and tolerances of this file's goldens.
pub fn goldens() -> Vec<(String, Tolerance)> {
    let mut names = Vec::new();
    for scene in SCENES {
        names.push(format!("{scene}-light"));
        for technique in TECHNIQUES {
            names.extend(LAYERS.iter().map(|(k, _)| format!("{scene}-{technique}-{k}")));
            names.push(format!("{scene}-{technique}-layers"));
        }
    }
    names.extend(MAPS.iter().map(|map| format!("hair-bom-{map}")));
    names.into_iter().map(|name| (name, LSB)).collect()
}

fn prepared(scene: &str) -> TranslucentCase<'static> {
    let given = Knobs::from([("width".into(), SIZE[0].into())]);
    let parameters = knob::complete("parameter", SPEC.parameters, &given).unwrap();
    let case = Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: String::new(),
        seed: 1,
        parameters,
    };
    TranslucentCase::prepare(&case, None).unwrap()
}

fn setting(technique: &str, layers: i64) -> Setting {
    let spec = problems::find(SPEC.id).unwrap().spec().technique(technique).unwrap();
    let given = Knobs::from([
        ("resolution".into(), i64::from(SIDE).into()),
        ("layers".into(), layers.into()),
    ]);
    Setting {
        technique: technique.into(),
        variant: spec.variants[0].id.into(),
        form: Form::Cpu,
        knobs: knob::complete("knob", spec.knobs, &given).unwrap(),
    }
}

/// The lit image, after its gates and its error against the truth.
fn lit(case: &TranslucentCase<'_>, setting: &Setting, [most, own]: [f64; 2]) -> Picture {
    let mut subject = case.subject(setting).unwrap();
    let checked = subject.check().unwrap();
    assert_eq!(checked.violations, Vec::<String>::new(), "{setting}");
    let error = checked.errors["rmse"];
    println!("{setting}: rmse {error:.5} of at most {most:.5}");
    assert!(error <= most, "{setting}: rmse {error} against the truth exceeds {most}");
    let layering = checked.errors["layering_rmse"];
    assert!(layering <= own, "{setting}: {layering} against the same texels exceeds {own}");
    let picture = subject.picture().unwrap().unwrap();
    Picture::from_values(SIZE[0], SIZE[1], &picture.result)
}

/// A technique's maps with what they were made of.
struct Made {
    settings: Settings,
    maps: Maps,
    code: LayeredCode,
    exact: std::rc::Rc<Exact>,
    fragments: std::rc::Rc<Fragments>,
}

fn made(case: &TranslucentCase<'_>, setting: &Setting) -> Made {
    let model = dapple_opacity_maps::Model::ExpTau;
    let fragments = case.fragments(true, SIDE, model).unwrap();
    let exact = case.exact(true, SIDE, model).unwrap();
    let settings = settings(setting, || Ok(exact.deepest_span())).unwrap();
    let mut maps = Maps::new(SIDE, SIDE, &settings).unwrap();
    maps.build(&fragments).unwrap();
    let Code::Layered(layered) = &settings.code else { panic!("{setting} has no layers") };
    let mut code = LayeredCode::new(layered, settings.opaque);
    code::TexelCode::prepare(&mut code, &fragments);
    Made { settings, maps, code, exact, fragments }
}

/// First receiver of every pixel that has one and may be shadowed.
fn nearest(case: &TranslucentCase<'_>) -> Vec<Option<Receiver>> {
    let receivers = case.receivers(true);
    let pixels = case.pixels().windows(2);
    pixels
        .map(|range| {
            let first = range[0] as usize;
            let there = range[0] < range[1] && receivers[first].in_map();
            there.then(|| receivers[first])
        })
        .collect()
}

/// The layer that a receiver reads in its own texel, by the definition: a share of the way between
/// the first and the last fragment, or from the first on.
fn layer_by_hand(made: &Made, technique: &str, receiver: &Receiver) -> Option<f64> {
    let depth = f64::from(receiver.depth - made.settings.bias);
    let texel = taps::own(receiver, SIDE, SIDE);
    let every = (0..made.fragments.texels()).filter_map(|t| made.exact.ends(t));
    let own = made.exact.ends(texel);
    let (first, last) = match technique {
        "osm" => every.fold((1.0, 0.0), |a: (f32, f32), b| (a.0.min(b.0), a.1.max(b.1))),
        "dom" => own.map(|(first, _)| (first, first + made.exact.deepest_span()))?,
        _ => own?,
    };
    let (first, last) = (f64::from(first), f64::from(last));
    let share = (depth - first) / (last - first);
    // Bounds this close are one layer; what lies behind all of them counts as in the last.
    let thin = last - first < 1e-5;
    (share >= 0.0 && !thin).then_some((share * VIEWED as f64).min(VIEWED as f64 - 0.5))
}

/// The layer that a receiver reads of a texel, the last one behind everything.
fn layer_read(made: &Made, texel: usize, receiver: &Receiver) -> Option<usize> {
    let (words, depth) = (made.maps.texel(texel), receiver.depth - made.settings.bias);
    let bounds = made.code.placement.read(words);
    let behind = bounds.first <= bounds.last && depth >= bounds.last;
    made.code.layer_at(words, depth).or(behind.then_some(VIEWED as usize - 1))
}

/// The view of layers, held against [`layer_by_hand`], with how many pixels read each layer.
fn layers(case: &TranslucentCase<'_>, technique: &str) -> (Picture, Vec<usize>) {
    let made = made(case, &setting(technique, VIEWED));
    let mut used = vec![0; VIEWED as usize];
    let (mut held, mut apart) = (0, 0);
    let mut shade = |receiver: Option<Receiver>| {
        let Some(receiver) = receiver else { return BACKGROUND };
        let layer = layer_read(&made, taps::own(&receiver, SIDE, SIDE), &receiver);
        if let Some(expected) = layer_by_hand(&made, technique, &receiver) {
            // Rounding may put a receiver on the other side of a boundary.
            let inside = (expected - expected.round()).abs() > 1e-3;
            held += usize::from(inside);
            apart += usize::from(inside && layer != Some(expected as usize));
        }
        let Some(layer) = layer else { return BACKGROUND };
        used[layer] += 1;
        0.85 * (1.0 - layer as f32 / (VIEWED - 1) as f32)
    };
    let values: Vec<f32> = nearest(case).into_iter().map(&mut shade).collect();
    assert!(held > 500, "{technique}: only {held} pixels were held against the definition");
    assert_eq!(apart, 0, "{technique}: {apart} of {held} pixels read another layer");
    (Picture::from_values(SIZE[0], SIZE[1], &values), used)
}

fn scene(name: &str) {
    let case = prepared(name);
    assert_eq!(case.size(), SIZE);
    let truth = Picture::from_values(SIZE[0], SIZE[1], &case.image(case.truth()));
    let unshadowed = vec![1.0_f32; case.truth().len()];
    let none = rmse(&unshadowed, case.truth(), Some(case.mask())).unwrap();
    assert!(none > 0.2, "{name}: light everywhere has an error of {none} alone");
    let mut pictures = vec![(format!("{name}-light"), truth)];
    let mut idle = Vec::new();
    for technique in TECHNIQUES {
        for (layers, own) in LAYERS {
            let picture = lit(&case, &setting(technique, layers), [MOST * none, own]);
            pictures.push((format!("{name}-{technique}-{layers}"), picture));
        }
        let (picture, used) = layers(&case, technique);
        println!("{name}, {technique}: pixels by layer {used:?}");
        idle.push(used.iter().filter(|count| **count == 0).count());
        pictures.push((format!("{name}-{technique}-layers"), picture));
    }
    // What sets the method apart: a receiver may lie in any layer.
    assert_eq!(idle[2], 0, "{name}: {} layers of the bounding map are read by no pixel", idle[2]);
    for (name, picture) in &pictures {
        assert_golden(name, picture, LSB);
    }
}

#[test]
fn grass() {
    scene("grass");
}

#[test]
fn hair() {
    scene("hair");
}

/// Control: a binary map breaks both bounds of a lit image.
#[test]
fn leaves_that_count_as_opaque_break_the_bounds() {
    for name in SCENES {
        let case = prepared(name);
        let unshadowed = vec![1.0_f32; case.truth().len()];
        let none = rmse(&unshadowed, case.truth(), Some(case.mask())).unwrap();
        let spec = SPEC.technique("shadow-map").unwrap();
        let given = Knobs::from([("resolution".into(), i64::from(SIDE).into())]);
        let knobs = knob::complete("knob", spec.knobs, &given).unwrap();
        let binary = Setting { technique: spec.id.into(), knobs, ..setting("bom", 4) };
        let binary = Setting { variant: spec.variants[0].id.into(), ..binary };
        let errors = case.subject(&binary).unwrap().check().unwrap().errors;
        assert!(errors["rmse"] > MOST * none, "{name}: {} of {none}", errors["rmse"]);
        assert!(errors["layering_rmse"] > LAYERS[0].1, "{name}: {}", errors["layering_rmse"]);
    }
}

/// Bounds and sums of a bounding opacity map, held against the sorted fragments.
#[test]
fn maps_of_hair() {
    let case = prepared("hair");
    let made = made(&case, &setting("bom", VIEWED));
    let words = |texel: usize| made.maps.texel(texel);
    let mut covered = 0;
    for texel in 0..made.maps.texels() {
        let Some((first, last)) = made.exact.ends(texel) else {
            assert_eq!(words(texel), [&[1.0, 0.0][..], &[0.0; VIEWED as usize]].concat());
            continue;
        };
        covered += 1;
        assert_eq!(words(texel)[..2], [first, last], "texel {texel}");
        let sums = &words(texel)[2..];
        assert!(sums.is_sorted(), "texel {texel}: {sums:?}");
        let total = made.exact.omega(texel, 2.0);
        let off = (f64::from(sums[VIEWED as usize - 1]) - total).abs();
        assert!(off <= 1e-5 * total.max(1.0), "texel {texel}: {off} of {total}");
    }
    assert!(covered > 2000, "only {covered} texels hold anything");
    let shown = |texel: usize, map: &str| match map {
        "first" => words(texel)[0],
        "last" => words(texel)[1],
        // Light that is left, as sums have no upper end.
        sum => (-words(texel)[2 + sum[4..].parse::<usize>().unwrap()]).exp(),
    };
    for map in MAPS {
        let values: Vec<f32> = (0..made.maps.texels()).map(|texel| shown(texel, map)).collect();
        assert_golden(&format!("hair-bom-{map}"), &Picture::from_values(SIDE, SIDE, &values), LSB);
    }
}

/// Control: the definition sees layers that lie between another texel's bounds.
#[test]
fn layers_of_other_bounds_are_told_apart() {
    let case = prepared("hair");
    let made = made(&case, &setting("bom", VIEWED));
    let receivers: Vec<Receiver> = nearest(&case).into_iter().flatten().collect();
    let wrong = receivers.iter().filter(|receiver| {
        let texel = taps::own(receiver, SIDE, SIDE);
        let read = layer_read(&made, (texel + 1) % made.maps.texels(), receiver);
        let expected = layer_by_hand(&made, "bom", receiver).map(|c| c as usize);
        expected.is_some() && read != expected
    });
    let wrong = wrong.count();
    assert!(wrong > 200, "only {wrong} of {} receivers show it", receivers.len());
}
