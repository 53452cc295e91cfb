//! Whole searches over maps, and the split texture that they leave.

use crate::rays::{fragments, poisson, split, sums, volume};
use dapple_opacity_maps::{
    Bins, Blend, Blur, Code, Criterion, EndMap, Format, Fragments, Layered, Layout, Lookup,
    Packing, Receiver, Settings, Split, SplitKind, Storage, Taps,
    cpu::Maps,
    exact::Exact,
    search::{
        Layers, Plan, Scorer, Scoring, Search, Shown, SplitCode, SplitTexture, Steps,
        criteria::is_better, oracle, with_lambda,
    },
};
use std::sync::Arc;

fn bounding(layers: u32) -> Settings {
    Settings {
        bias: 0.0,
        ..Settings::plain(Code::Layered(Layered {
            layout: Layout::Bounded {
                split: Split { lambda: 0.0, kind: SplitKind::Normalised, width: 512 },
                bins: Bins::Full,
            },
            layers,
            lookup: Lookup::Lerp,
            blend: Blend::Add,
            format: Format::F32,
            packing: Packing::Targets(8),
            storage: Storage::Blend,
            end_map: EndMap::MaxBlend,
            write_bias: 0.0,
            soft_start: false,
        }))
    }
}

/// A narrow stand, dense and strong, beside a wide one, sparse and faint: about as many fragments
/// in either.
fn mixed(side: u32, seed: u64) -> Fragments {
    fragments(side, side, seed, |random, x, _, out| {
        if x < side * 3 / 16 {
            poisson(random, (0.1, 0.9), 60.0, 0.4, out);
        } else if x > side * 3 / 16 + 2 {
            poisson(random, (0.2, 0.8), 12.0, 0.05, out);
        }
    })
}

fn finish(search: &mut Search, fragments: &Fragments) -> u32 {
    let mut scored = 0;
    for _ in 0..100 {
        let report = search.frame(fragments).unwrap();
        scored += u32::from(report.trial.is_some());
        if report.adopted {
            break;
        }
    }
    scored
}

fn rmse(maps: &Maps, fragments: &Fragments) -> f64 {
    oracle::rmse(maps, fragments, &Exact::of(fragments)).unwrap()
}

fn rmse_at(lambda: f32, layers: u32, fragments: &Fragments) -> f64 {
    let settings = with_lambda(&bounding(layers), lambda).unwrap();
    let mut maps = Maps::new(fragments.width, fragments.height, &settings).unwrap();
    maps.build(fragments).unwrap();
    rmse(&maps, fragments)
}

fn searched(criterion: Criterion, layers: u32, tile: u32, fragments: &Fragments) -> Search {
    let plan = Plan { tile, ..Plan::plain(bounding(layers), criterion) };
    let mut search = Search::new(fragments.width, fragments.height, plan).unwrap();
    assert_eq!(finish(&mut search, fragments), 11);
    search
}

#[test]
fn a_search_finds_what_maps_by_definition_say() {
    let fragments = volume(48, 11, 25.0, 0.15);
    for criterion in [
        Criterion::Sad,
        Criterion::Correlation,
        Criterion::MutualInformation,
        Criterion::EqualOpacity,
    ] {
        for layers in [4, 9] {
            let mut scorer = Scorer::new(Scoring::plain(criterion));
            let scores: Vec<f64> = (0..=10)
                .map(|step| {
                    let sums = sums(&fragments, f64::from(step) / 10.0, layers);
                    let maps = Layers::new((48, 48), layers, layers, 0, &sums).unwrap();
                    scorer.score(&maps).unwrap()
                })
                .collect();
            let best = (0..11)
                .reduce(|a, b| if is_better(criterion, scores[b], scores[a]) { b } else { a });
            let mut search =
                Search::new(48, 48, Plan::plain(bounding(layers as u32), criterion)).unwrap();
            for (step, expected) in scores.iter().enumerate() {
                assert!(search.is_searching());
                let report = search.frame(&fragments).unwrap();
                let (lambda, score) = report.trial.unwrap();
                assert_eq!((lambda, report.map_sets), (step as f32 / 10.0, 2));
                // A fragment at a boundary may fall to either side in 32 bits.
                let off = (score - expected).abs() / expected.abs();
                assert!(off < 2e-3, "{criterion:?} K {layers} λ {lambda}: {score} {expected}");
                assert_eq!(report.adopted, step == 10);
            }
            assert_eq!(search.lambda(), best.unwrap() as f32 / 10.0, "{criterion:?} K {layers}");
            // Nothing more is tried, and what is drawn is drawn with the adopted λ.
            let report = search.frame(&fragments).unwrap();
            assert_eq!((report.trial, report.map_sets), (None, 1));
            let there = rmse_at(search.lambda(), layers as u32, &fragments);
            assert_eq!(rmse(search.maps(), &fragments), there);
            // P12: found again.
            let first = search.lambda();
            search.needs_recompute();
            assert_eq!(finish(&mut search, &fragments), 11);
            assert_eq!(search.lambda(), first);
        }
    }
}

#[test]
fn no_criterion_errs_less_than_the_oracle() {
    for (seed, density, omega) in [(1, 8.0, 0.1), (2, 40.0, 0.1), (3, 40.0, 0.6)] {
        let fragments = volume(40, seed, density, omega);
        for layers in [4, 16] {
            let error = |criterion| {
                rmse_at(searched(criterion, layers, 0, &fragments).lambda(), layers, &fragments)
            };
            let oracle = error(Criterion::Oracle);
            for step in 0..=10 {
                assert!(oracle <= rmse_at(step as f32 / 10.0, layers, &fragments));
            }
            for criterion in [Criterion::Sad, Criterion::Correlation, Criterion::EqualOpacity] {
                assert!(oracle <= error(criterion), "{criterion:?}");
            }
        }
    }
}

/// Tables A.11 with all that the thesis had: its table of bytes, K - 1 bins, maps clipped to 8 bits.
/// There a single tree (sparse) has λ* 0.7, 0.2, 0.2 at K = 4, 16, 32 by correlation; grass from
/// the side (dense) 1.0, 0.8, 0.7; absolute differences 1.0 nearly everywhere.
#[test]
fn the_best_split_falls_with_layers_and_rises_with_density_as_the_thesis_found() {
    let best = |criterion, layers, fragments: &Fragments| {
        let mut settings = bounding(layers);
        if let Code::Layered(layered) = &mut settings.code {
            let split = Split { lambda: 0.0, kind: SplitKind::Listing, width: 512 };
            layered.layout = Layout::Bounded { split, bins: Bins::Thesis };
        }
        let scoring = Scoring::thesis(criterion);
        let plan = Plan { scoring, ..Plan::plain(settings, criterion) };
        let mut search = Search::new(fragments.width, fragments.height, plan).unwrap();
        assert_eq!(finish(&mut search, fragments), 11);
        search.lambda()
    };
    for seed in [7, 8] {
        let (sparse, dense) = (volume(96, seed, 4.0, 0.69), volume(96, seed, 10.0, 0.69));
        let all = |criterion, fragments: &Fragments| {
            [4, 16, 32].map(|layers| best(criterion, layers, fragments))
        };
        let (tree, grass) =
            (all(Criterion::Correlation, &sparse), all(Criterion::Correlation, &dense));
        assert!(tree[0] > tree[1] && tree[1] > tree[2], "{tree:?}");
        assert!(grass[0] > grass[1] && grass[1] >= grass[2], "{grass:?}");
        assert!(tree.iter().zip(&grass).all(|(t, g)| t < g), "{tree:?} {grass:?}");
        let differences = all(Criterion::Sad, &dense);
        assert!(differences.iter().all(|&lambda| lambda > 0.85), "{differences:?}");
    }
}

#[test]
fn tiles_beat_one_split_for_all_where_dense_and_sparse_stand_side_by_side() {
    let fragments = mixed(64, 1);
    for layers in [4, 8, 16, 32] {
        let error = |criterion, tile| {
            rmse(searched(criterion, layers, tile, &fragments).maps(), &fragments)
        };
        let best_single = error(Criterion::Oracle, 0);
        let known = [16, 8, 1].map(|tile| error(Criterion::Oracle, tile));
        assert!(known[0] < best_single && known[1] < known[0] && known[2] < known[1]);
        // A criterion that sees maps alone errs less in tiles than the best single λ there is.
        let light = |tile| error(Criterion::EqualTransmittance, tile);
        let (one, coarse, fine) = (light(0), light(16), light(8));
        assert!(best_single <= one);
        assert!(coarse < best_single, "K {layers}: {coarse} {best_single}");
        assert!(fine < best_single, "K {layers}: {fine} {best_single}");
        // By texel it gains too, but a ray's few fragments mislead where layers are thin.
        let texel = light(1);
        assert!(texel < one, "K {layers}: {texel} {one}");
        assert!(layers == 4 || fine < texel, "K {layers}: {fine} {texel}");
    }
}

#[test]
fn receivers_must_read_with_the_split_that_maps_were_written_with() {
    let fragments = mixed(64, 13);
    let search = searched(Criterion::Oracle, 8, 8, &fragments);
    let right = rmse(search.maps(), &fragments);
    // The same words, read with the split of the whole map.
    let settings = with_lambda(&bounding(8), search.lambda()).unwrap();
    let reader = Maps::new(64, 64, &settings).unwrap();
    let exact = Exact::of(&fragments);
    let (mut sum, mut n) = (0.0, 0.0);
    for texel in 0..fragments.texels() {
        for f in fragments.texel(texel) {
            let read = reader.code().decode(texel, search.maps().texel(texel), f.depth);
            sum += (f64::from(read) - exact.transmittance(texel, f.depth)).powi(2);
            n += 1.0;
        }
    }
    assert!((sum / n).sqrt() > 1.5 * right, "{} {right}", (sum / n).sqrt());
}

#[test]
fn a_search_that_repeats_forgets_what_was_best_before() {
    let (first, second) = (volume(32, 14, 60.0, 0.5), volume(32, 15, 5.0, 0.05));
    for tile in [0, 8] {
        let plan = Plan { tile, repeat: true, ..Plan::plain(bounding(8), Criterion::EqualOpacity) };
        let mut search = Search::new(32, 32, plan.clone()).unwrap();
        assert_eq!(finish(&mut search, &first), 11);
        let before = search.texture().lambdas();
        for _ in 0..10 {
            search.frame(&second).unwrap();
            assert_eq!(search.texture().lambdas(), before, "published after the cycle alone");
        }
        assert_eq!(finish(&mut search, &second), 1);
        let mut fresh = Search::new(32, 32, plan).unwrap();
        finish(&mut fresh, &second);
        assert_eq!(search.texture().lambdas(), fresh.texture().lambdas(), "tile {tile}");
        assert_ne!(search.texture().lambdas(), before);
        assert!(search.is_searching(), "the next cycle has begun");
    }
    // A restart in the middle forgets the half that was tried.
    let mut search =
        Search::new(32, 32, Plan::plain(bounding(8), Criterion::EqualOpacity)).unwrap();
    (0..6).for_each(|_| {
        search.frame(&first).unwrap();
    });
    search.needs_recompute();
    assert_eq!(finish(&mut search, &second), 11);
    assert_eq!(search.lambda(), searched(Criterion::EqualOpacity, 8, 0, &second).lambda());
}

#[test]
fn maps_on_trial_are_drawn_or_a_second_set_is_built() {
    let fragments = volume(24, 16, 30.0, 0.2);
    let plan = |shown| Plan { shown, ..Plan::plain(bounding(6), Criterion::EqualOpacity) };
    let mut trial = Search::new(24, 24, plan(Shown::Trial)).unwrap();
    let mut adopted = Search::new(24, 24, plan(Shown::Adopted)).unwrap();
    for frame in 0..14 {
        let (a, b) = (trial.frame(&fragments).unwrap(), adopted.frame(&fragments).unwrap());
        assert_eq!(a.trial, b.trial);
        assert_eq!((a.map_sets, b.map_sets), (1, if frame < 11 { 2 } else { 1 }));
        let lambda = if frame < 11 { frame as f32 / 10.0 } else { trial.lambda() };
        assert_eq!(rmse(trial.maps(), &fragments), rmse_at(lambda, 6, &fragments));
        let lambda = if frame < 10 { 0.0 } else { adopted.lambda() };
        assert_eq!(rmse(adopted.maps(), &fragments), rmse_at(lambda, 6, &fragments));
    }
    assert_eq!(trial.maps().words(), adopted.maps().words());
    let receiver = Receiver::at(0.5, 0.5, 0.7);
    assert_eq!(trial.maps().transmittance(&receiver), adopted.maps().transmittance(&receiver));
}

#[test]
fn packing_does_not_change_what_is_found() {
    let fragments = volume(24, 17, 30.0, 0.2);
    let of = |packing| {
        let mut settings = bounding(9);
        if let Code::Layered(layered) = &mut settings.code {
            layered.packing = packing;
        }
        let mut search =
            Search::new(24, 24, Plan::plain(settings, Criterion::Correlation)).unwrap();
        finish(&mut search, &fragments);
        (search.lambda(), rmse(search.maps(), &fragments))
    };
    let expected = of(Packing::Targets(8));
    for packing in [Packing::Slabs, Packing::Targets(2), Packing::Single, Packing::Sorted] {
        let (lambda, error) = of(packing);
        assert_eq!(lambda, expected.0, "{packing:?}");
        assert!((error - expected.1).abs() < 1e-6, "{packing:?}");
    }
}

#[test]
fn what_is_scored_is_thickness_however_it_is_stored() {
    // Three units of a scaled byte, so that these round nothing either.
    let fragments = volume(32, 22, 20.0, 3.0 * 8.0 * std::f32::consts::LN_2 / 255.0);
    let scores = |blend, format, criterion| -> Vec<f64> {
        let mut settings = bounding(8);
        if let Code::Layered(layered) = &mut settings.code {
            (layered.blend, layered.format) = (blend, format);
        }
        let mut search = Search::new(32, 32, Plan::plain(settings, criterion)).unwrap();
        (0..11).map(|_| search.frame(&fragments).unwrap().trial.unwrap().1).collect()
    };
    for criterion in
        [Criterion::EqualTransmittance, Criterion::EqualOpacity, Criterion::Correlation]
    {
        let plain = scores(Blend::Add, Format::F32, criterion);
        for (blend, format, bound) in [
            (Blend::Add, Format::Fixed, 1e-3),
            (Blend::Over, Format::F32, 1e-3),
            (Blend::Add, Format::Unorm8Scaled, 1e-3),
            (Blend::Add, Format::F16, 0.02),
        ] {
            for (a, b) in scores(blend, format, criterion).iter().zip(&plain) {
                assert!((a - b).abs() <= bound * b, "{criterion:?} {blend:?} {format:?}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_map_of_nothing_is_searched_too_and_keeps_the_even_split() {
    let empty = fragments(16, 16, 0, |_, _, _, _| {});
    for criterion in [
        Criterion::Sad,
        Criterion::Correlation,
        Criterion::MutualInformation,
        Criterion::EqualOpacity,
        Criterion::Oracle,
    ] {
        let search = searched(criterion, 5, 0, &empty);
        assert_eq!(search.lambda(), 0.0, "{criterion:?}");
        assert_eq!(search.maps().transmittance(&Receiver::at(0.5, 0.5, 0.9)), 1.0);
    }
    let tiled = searched(Criterion::Correlation, 5, 8, &empty);
    assert!(tiled.texture().lambdas().iter().all(|&l| l == 0.0));
}

#[test]
fn each_tile_has_the_split_that_is_best_there() {
    // Neither side is a whole number of tiles.
    let (width, height, layers) = (21, 13, 6);
    let fragments = fragments(width, height, 20, |random, x, y, out| {
        let thick = if (x / 8 + y / 8) % 2 == 0 { 0.6 } else { 0.02 };
        poisson(random, (0.1, 0.9), 40.0, thick, out);
    });
    let exact = Exact::of(&fragments);
    let trials: Vec<Maps> = (0..=10)
        .map(|step| {
            let settings = with_lambda(&bounding(layers), step as f32 / 10.0).unwrap();
            let mut maps = Maps::new(width, height, &settings).unwrap();
            maps.build(&fragments).unwrap();
            maps
        })
        .collect();
    let search = searched(Criterion::Oracle, layers, 8, &fragments);
    let texture = search.texture();
    assert_eq!(texture.len(), 6);
    let mut found = Vec::new();
    for tile in 0..texture.len() {
        let region = texture.region(tile);
        let errors: Vec<f64> = trials
            .iter()
            .map(|maps| oracle::squared_error(maps, &fragments, &exact, region).0)
            .collect();
        let best = (0..11).reduce(|a, b| if errors[b] < errors[a] { b } else { a }).unwrap();
        for texel in region.texels(width as usize) {
            assert_eq!(texture.lambda(texel), best as f32 / 10.0, "tile {tile}, texel {texel}");
            assert_eq!(search.maps().texel(texel), trials[best].texel(texel));
        }
        found.push(best);
    }
    assert!(found.windows(2).all(|w| w[0] != w[1]), "a chessboard: {found:?}");
}

#[test]
fn blurred_sums_are_read_with_the_split_of_the_receivers_own_texel() {
    let fragments = volume(24, 21, 30.0, 0.2);
    let blurred = |lambda: f32| {
        let mut settings = with_lambda(&bounding(6), lambda).unwrap();
        (settings.taps, settings.blur) = (Taps::Box3, Blur::Stored);
        settings
    };
    let plan = Plan::plain(blurred(0.0), Criterion::EqualTransmittance);
    let mut search = Search::new(24, 24, plan).unwrap();
    finish(&mut search, &fragments);
    assert!(search.lambda() > 0.0);
    let read = |maps: &Maps| -> Vec<f32> {
        let at = |i: usize| Receiver::at(i as f32 / 200.0, 0.4, 0.3 + i as f32 / 400.0);
        (0..200).map(|i| maps.transmittance(&at(i))).collect()
    };
    let mut same = Maps::new(24, 24, &blurred(search.lambda())).unwrap();
    same.build(&fragments).unwrap();
    assert_eq!(read(search.maps()), read(&same));
}

#[test]
fn every_texel_lies_in_one_tile() {
    for (width, height, tile, tiles) in
        [(16, 16, 8, 4), (17, 9, 8, 6), (5, 3, 1, 15), (5, 3, 0, 1), (5, 3, 64, 1)]
    {
        let texture = SplitTexture::new(width, height, tile, Steps::THESIS).unwrap();
        assert_eq!(texture.len(), tiles);
        let mut seen = vec![0; (width * height) as usize];
        for tile in 0..tiles {
            texture.region(tile).texels(width as usize).for_each(|texel| seen[texel] += 1);
        }
        assert!(seen.iter().all(|&n| n == 1), "{width} x {height}, {tile}");
    }
}

#[test]
fn plans_that_cannot_work_are_refused_by_name() {
    let good = Plan::plain(bounding(4), Criterion::Correlation);
    let refused = |change: &dyn Fn(&mut Plan), named: &str| {
        let mut plan = good.clone();
        change(&mut plan);
        let error = Search::new(8, 8, plan).err().unwrap().to_string();
        assert!(error.contains(named), "{error}");
    };
    refused(&|p| p.settings = Settings::plain(Code::Binary), "layered");
    refused(&|p| p.tile = 1, "tile");
    refused(
        &|p| {
            p.tile = 8;
            p.scoring.criterion = Criterion::MutualInformation;
        },
        "tile",
    );
    refused(
        &|p| {
            p.repeat = true;
            p.shown = Shown::Trial;
        },
        "shown",
    );
    refused(&|p| p.settings.bias = f32::NAN, "bias");
    let deep = |p: &mut Plan| {
        if let Code::Layered(layered) = &mut p.settings.code {
            layered.layout = Layout::Deep { span: 0.5, growth: 1.0, listing: false };
        }
    };
    refused(&deep, "split");
    assert!(Search::new(0, 8, good.clone()).is_err());
    // Fragments of another size end no search: it starts again.
    let mut search = Search::new(8, 8, good).unwrap();
    let (small, right) = (volume(4, 1, 9.0, 0.1), volume(8, 1, 9.0, 0.1));
    search.frame(&right).unwrap();
    assert!(search.frame(&small).is_err());
    assert_eq!(finish(&mut search, &right), 11);
    let texture = Arc::new(SplitTexture::new(8, 8, 1, Steps::THESIS).unwrap());
    assert!(SplitCode::new(&Settings::plain(Code::Unshadowed), texture).is_err());
}

#[test]
fn the_oracle_measures_what_layers_by_definition_lose() {
    let fragments = volume(16, 18, 20.0, 0.3);
    let (layers, lambda) = (6, 0.7);
    let all = sums(&fragments, lambda, layers);
    let (mut sum, mut n) = (0.0, 0.0);
    for texel in 0..fragments.texels() {
        let mut sorted = fragments.texel(texel).to_vec();
        sorted.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        let Some((first, last)) = sorted.first().zip(sorted.last()) else { continue };
        let (near, span) = (first.depth, f64::from(last.depth - first.depth));
        let mut before = 0.0;
        for f in &sorted {
            let c = split(lambda, f64::from(f.depth - near) / span.max(1e-6)) * layers as f64;
            let k = (c as usize).min(layers - 1);
            let at = |k: usize| f64::from(all[texel * layers + k]);
            let below = if k == 0 { 0.0 } else { at(k - 1) };
            let omega = below + (at(k) - below) * (c - k as f64);
            sum += ((-omega).exp() - f64::exp(-before)).powi(2);
            n += 1.0;
            before += f64::from(f.omega);
        }
    }
    let (expected, actual) = ((sum / n).sqrt(), rmse_at(0.7, 6, &fragments));
    assert!((actual - expected).abs() < 1e-4, "{actual} {expected}");
    assert!(expected > 0.01);
}
