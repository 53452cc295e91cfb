//! Searches over bounding opacity maps, and the error of what they leave.

use dapple_opacity_maps::{
    Bins, Blend, Code, Criterion, EndMap, Format, Fragments, Layered, Layout, Lookup, Packing,
    Settings, Split, SplitKind, Storage,
    cpu::Maps,
    exact::Exact,
    search::{Plan, Search, oracle, with_lambda},
};

pub fn bounding(layers: u32) -> Settings {
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

pub fn finish(search: &mut Search, fragments: &Fragments) -> u32 {
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

pub fn rmse(maps: &Maps, fragments: &Fragments) -> f64 {
    oracle::rmse(maps, fragments, &Exact::of(fragments)).unwrap()
}

pub fn rmse_at(lambda: f32, layers: u32, fragments: &Fragments) -> f64 {
    let settings = with_lambda(&bounding(layers), lambda).unwrap();
    let mut maps = Maps::new(fragments.width, fragments.height, &settings).unwrap();
    maps.build(fragments).unwrap();
    rmse(&maps, fragments)
}

pub fn searched(criterion: Criterion, layers: u32, tile: u32, fragments: &Fragments) -> Search {
    let plan = Plan { tile, ..Plan::plain(bounding(layers), criterion) };
    let mut search = Search::new(fragments.width, fragments.height, plan).unwrap();
    assert_eq!(finish(&mut search, fragments), 11);
    search
}
