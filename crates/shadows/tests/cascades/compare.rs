//! The reference against closed forms: edges, acne, cascades, and its deliberate faults.

use dapple_shadows::cascades::faults::{self, Fault};
use dapple_shadows::cascades::lookup::{Region, select};
use dapple_shadows::cascades::reference::visibility;
use dapple_shadows::cascades::{Cascade, CascadeError, CascadeReceiver, Settings, Taps};
use dapple_shadows::filtering::{DepthMap, FilterError};

use crate::scene::{self, all_settings, cascades, floor, maps, nearest, receivers};

/// A receiver's nearest texel centre is less than this many texels away.
const NEAREST: f64 = 0.75;

/// Receivers whose visibility differs from the truth, and how many have one: those further than
/// [`NEAREST`] texels from a rim.
fn wrong(
    found: &[f64],
    all: &[CascadeReceiver],
    cascades: &[Cascade],
    side: u32,
) -> (usize, usize) {
    let judged: Vec<_> = all
        .iter()
        .zip(found)
        .filter_map(|(r, v)| Some((scene::truth(r, cascades, side, NEAREST)?, *v)))
        .collect();
    (judged.iter().filter(|(truth, v)| truth != v).count(), judged.len())
}

#[test]
fn leaves_shade_the_floor_in_every_cascade_and_faults_show() {
    let side = 256;
    let all = receivers(4000, 1);
    let settings = Settings::new(Taps::One);
    for count in 1..=4 {
        let cascades = cascades(count, 0.5, side, 0);
        let maps = maps(&cascades, side, nearest);
        let found = visibility(&maps, &cascades, &all, &settings).unwrap();
        let (off, judged) = wrong(&found, &all, &cascades, side);
        assert_eq!(off, 0, "{count} cascades");
        assert!(judged > 3000, "{judged}");
        let dark = found.iter().filter(|v| **v == 0.0).count();
        assert!((500..3500).contains(&dark), "{dark}");
        for fault in Fault::ALL {
            let faulty = faults::visibility(&maps, &cascades, &all, &settings, fault).unwrap();
            let (off, _) = wrong(&faulty, &all, &cascades, side);
            if fault == Fault::NextCascade && count == 1 {
                assert_eq!(off, 0);
            } else {
                assert!(off > 10, "{fault:?}, {count} cascades: {off}");
            }
        }
    }
}

#[test]
fn more_cascades_resolve_more() {
    let side = 64;
    let all = receivers(8000, 2);
    let errors: Vec<usize> = (1..=4)
        .map(|count| {
            let cascades = cascades(count, 0.5, side, 0);
            let maps = maps(&cascades, side, nearest);
            let settings = Settings::new(Taps::One);
            let found = visibility(&maps, &cascades, &all, &settings).unwrap();
            let truth = |r: &CascadeReceiver| scene::truth(r, &cascades, side, 0.0).unwrap();
            all.iter().zip(&found).filter(|(r, v)| truth(r) != **v).count()
        })
        .collect();
    assert!(errors.windows(2).all(|pair| pair[1] < pair[0]), "{errors:?}");
}

#[test]
fn each_view_depth_is_in_one_cascade_and_boundaries_belong_to_the_nearer() {
    let cascades = cascades(4, 0.5, 64, 0);
    let regions: Vec<_> = cascades.iter().map(|c| Region::new(c, 64)).collect();
    for (i, cascade) in cascades.iter().enumerate() {
        let far = cascade.far as f32;
        assert_eq!(select(&regions, far), i);
        assert_eq!(select(&regions, far.next_down()), i);
        assert_eq!(select(&regions, far.next_up()), (i + 1).min(3));
        assert_eq!(select(&regions, (0.5 * (cascade.near + cascade.far)) as f32), i);
    }
    assert_eq!(select(&regions, -1.0), 0);
    assert_eq!(select(&regions, f32::MAX), 3);
    assert_eq!(select(&[], 1.0), 0);
    // Exactly one interval (near, far] holds each depth between the ends.
    for step in 1..=1000u16 {
        let depth = f64::from((scene::NEAR + 0.099 * f64::from(step)) as f32);
        let holding: Vec<usize> = (0..4)
            .filter(|&i| {
                let ends = |x: f64| f64::from(x as f32);
                ends(cascades[i].near) < depth && depth <= ends(cascades[i].far)
            })
            .collect();
        assert_eq!(holding, [select(&regions, depth as f32)]);
    }
}

/// An 8 x 8 map with an occluder at 0.25 where `covered`.
fn occluder(covered: impl Fn(u32, u32) -> bool) -> [DepthMap; 1] {
    let texels = (0..64).map(|i| if covered(i % 8, i / 8) { 0.25 } else { 1.0 });
    [DepthMap { width: 8, height: 8, depths: texels.collect() }]
}

fn ninths(map: &[DepthMap], taps: Taps, places: &[(f32, f32)]) -> Vec<f64> {
    let all: Vec<_> =
        places.iter().map(|&(x, y)| CascadeReceiver::at(x / 8.0, y / 8.0, 0.5, 2.0)).collect();
    let found = visibility(map, &[Cascade::whole(1.0, 3.0)], &all, &Settings::new(taps)).unwrap();
    let n = f64::from(taps.side().pow(2));
    found.iter().map(|v| v * n).collect()
}

#[test]
fn a_plane_gives_0_and_1_and_edges_give_steps_by_hand() {
    // Texels of x < 4 are covered.
    let half = occluder(|x, _| x < 4);
    let row: Vec<_> = (0..8).map(|x| (x as f32 + 0.5, 4.5)).collect();
    assert_eq!(ninths(&half, Taps::One, &row), [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    assert_eq!(ninths(&half, Taps::Box3, &row), [0.0, 0.0, 0.0, 3.0, 6.0, 9.0, 9.0, 9.0]);
    // Texels of x + y < 7: receivers along the diagonal's normal see 1 + 2 + 3 of nine ...
    let corner = occluder(|x, y| x + y < 7);
    let diagonal: Vec<_> = (1..7).map(|i| (i as f32 + 0.5, i as f32 + 0.5)).collect();
    assert_eq!(ninths(&corner, Taps::Box3, &diagonal), [0.0, 0.0, 3.0, 8.0, 9.0, 9.0]);
    let beside: Vec<_> = (1..7).map(|i| (i as f32 + 0.5, 3.5)).collect();
    assert_eq!(ninths(&corner, Taps::Box3, &beside), [0.0, 1.0, 3.0, 6.0, 8.0, 9.0]);
    // Four texels from floor(x - 3/2): 2.2 reads 0..=3, 2.7 and 3.2 read 1..=4.
    let places: Vec<_> = [2.2, 2.7, 3.2, 3.7, 4.2, 4.7, 5.2, 5.7].map(|x| (x, 4.0)).into();
    assert_eq!(ninths(&half, Taps::Box4, &places), [0.0, 4.0, 4.0, 8.0, 8.0, 12.0, 12.0, 16.0]);
    let mut seen = Vec::new();
    for i in 0..64u8 {
        let at = (1.6 + 0.4 * f32::from(i % 8), 2.0 + 0.5 * f32::from(i / 8));
        seen.extend(ninths(&corner, Taps::Box4, &[at]));
    }
    seen.sort_by(f64::total_cmp);
    seen.dedup();
    assert!(seen.iter().all(|n| n.fract() == 0.0 && (0.0..=16.0).contains(n)), "{seen:?}");
    assert!(seen.len() > 6, "{seen:?}");
}

#[test]
fn the_border_repeats_under_wide_taps() {
    let half = occluder(|x, _| x < 4);
    let edges = [(0.0, 0.0), (8.0, 8.0), (0.0, 8.0), (8.0, 0.0)];
    for taps in Taps::ALL {
        let n = f64::from(taps.side().pow(2));
        assert_eq!(ninths(&half, taps, &edges), [0.0, n, 0.0, n], "{taps:?}");
    }
}

#[test]
fn a_slanted_floor_does_not_shadow_itself_with_any_sufficient_bias() {
    let side = 64;
    let all = receivers(3000, 3);
    for count in [1, 3] {
        let cascades = cascades(count, 0.5, side, 0);
        let maps = maps(&cascades, side, floor);
        let dark = |settings: Settings| {
            let found = visibility(&maps, &cascades, &all, &settings).unwrap();
            found.iter().filter(|v| **v < 1.0).count()
        };
        // Half a texel of slope for one tap, and one more for each texel further away.
        for (taps, enough) in [(Taps::One, 0.5), (Taps::Box3, 1.5), (Taps::Box4, 2.0)] {
            let plain = Settings { taps, bias: 1e-6, slope_bias: 0.0, plane_bias: false };
            assert_eq!(dark(Settings { slope_bias: enough, ..plain }), 0, "{taps:?}");
            assert_eq!(dark(Settings { plane_bias: true, ..plain }), 0, "{taps:?}");
            // Controls: a little less slope, and none.
            assert!(dark(Settings { slope_bias: enough - 0.1, ..plain }) > 0, "{taps:?}");
            let none = dark(plain);
            assert!(none > all.len() / 4, "{taps:?}: {none}");
        }
        let unbiased =
            faults::visibility(&maps, &cascades, &all, &Settings::new(Taps::One), Fault::Unbiased);
        let acne = unbiased.unwrap().iter().filter(|v| **v == 0.0).count();
        assert!((all.len() / 4..all.len() * 3 / 4).contains(&acne), "{acne}");
    }
}

#[test]
fn what_is_outside_is_lit() {
    let dark = maps(&cascades(2, 0.5, 16, 0), 16, |_, _| 0.0);
    let mut two = cascades(2, 0.5, 16, 0);
    let [u, v] = two[1].base([0.5, 0.5]).map(|x| x as f32);
    let inside = CascadeReceiver::at(u, v, 0.9, scene::view_depth(f64::from(v)) as f32);
    let shade = |cascades: &[Cascade], all: &[CascadeReceiver]| {
        all_settings()
            .iter()
            .flat_map(|s| visibility(&dark, cascades, all, s).unwrap())
            .collect::<Vec<f64>>()
    };
    assert!(shade(&two, &[inside]).iter().all(|v| *v == 0.0));
    let mut strangers = vec![CascadeReceiver { flags: 0, ..inside }];
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        strangers.push(CascadeReceiver { u: bad, ..inside });
        strangers.push(CascadeReceiver { v: bad, ..inside });
        strangers.push(CascadeReceiver { depth: bad, ..inside });
        strangers.push(CascadeReceiver { view_depth: bad, ..inside });
    }
    strangers.push(CascadeReceiver { u: -4.0, ..inside });
    strangers.push(CascadeReceiver { v: 4.0, ..inside });
    // In the first cascade's depths but outside its region.
    strangers.push(CascadeReceiver { view_depth: 0.0, v: 0.99, ..inside });
    assert!(shade(&two, &strangers).iter().all(|v| *v == 1.0));
    assert_eq!(shade(&two, &[]), []);
    // Beyond the far plane the last cascade's map still holds.
    let beyond = CascadeReceiver { view_depth: 1e6, ..inside };
    assert!(shade(&two, &[beyond]).iter().all(|v| *v == 0.0));
    // Slopes that are no numbers count as none.
    let odd = inside.with_slope(f32::NAN, f32::INFINITY);
    assert!(shade(&two, &[odd]).iter().all(|v| *v == 0.0));
    // An empty cascade lights its receivers whatever its map holds.
    two[1].scale = 0.0;
    assert!(shade(&two, &[inside]).iter().all(|v| *v == 1.0));
}

#[test]
fn bad_input_is_refused_by_name() {
    let good = cascades(2, 0.5, 8, 0);
    let maps = maps(&good, 8, floor);
    let settings = Settings::new(Taps::One);
    let run =
        |maps: &[DepthMap], cascades: &[Cascade], s: &Settings| visibility(maps, cascades, &[], s);
    assert_eq!(run(&maps, &good, &settings), Ok(Vec::new()));
    let refused = run(&maps[..1], &good, &settings);
    assert_eq!(refused, Err(CascadeError::Length { what: "maps", expected: 2, actual: 1 }));
    assert!(run(&[], &[], &settings).is_err());
    let mut broken = maps.clone();
    broken[1].depths[7] = f32::NAN;
    let refused = run(&broken, &good, &settings);
    let found = matches!(
        refused,
        Err(CascadeError::Map { cascade: 1, error: FilterError::Depth { texel: 7, .. } })
    );
    assert!(found);
    broken[1] = DepthMap { width: 4, height: 16, depths: vec![1.0; 64] };
    assert!(matches!(run(&broken, &good, &settings), Err(CascadeError::Map { cascade: 1, .. })));
    let changes: [fn(&mut Cascade); 8] = [
        |c| c.near = 1.5,
        |c| c.far = f64::NAN,
        |c| c.offset[1] = f64::INFINITY,
        |c| c.offset[0] = f64::NAN,
        |c| c.offset[0] = -1e7,
        |c| c.scale = f64::NAN,
        |c| c.scale = -1.0,
        |c| c.scale = 1e-9,
    ];
    for change in changes {
        let mut cascades = good.clone();
        change(&mut cascades[1]);
        let refused = run(&maps, &cascades, &settings);
        assert!(matches!(refused, Err(CascadeError::Cascade { cascade: 1, .. })), "{refused:?}");
    }
    for bad in [-1e-3, f32::NAN, f32::INFINITY] {
        let refused = run(&maps, &good, &Settings { bias: bad, ..settings });
        assert!(matches!(refused, Err(CascadeError::Knob { name: "bias", .. })));
        let refused = run(&maps, &good, &Settings { slope_bias: bad, ..settings });
        assert!(matches!(refused, Err(CascadeError::Knob { name: "slope_bias", .. })));
    }
}
