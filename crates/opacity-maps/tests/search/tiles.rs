//! The split texture: λ by texel and by tile.

use crate::rays::{fragments, poisson, volume};
use crate::searches::{bounding, finish, rmse, searched};
use dapple_opacity_maps::{
    Blur, Criterion, Fragments, Receiver, Taps,
    cpu::Maps,
    exact::Exact,
    search::{Plan, Search, SplitTexture, Steps, oracle, with_lambda},
};

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
