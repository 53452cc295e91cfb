//! Counters, and what each option changes.

use super::properties::plain;
use super::world::{Played, World};
use crate::camera::{Results, Settings, Technique, TightBounds, Work};

const SEEDS: std::ops::Range<u64> = 0..6;
const LATENCY: u32 = 20;

/// Work along a coherent path through several towns.
fn work(settings: Settings) -> Work {
    let mut sum = Work::default();
    each(settings, |played| played.iter().for_each(|p| sum += p.frame.work));
    sum
}

fn each(settings: Settings, mut look: impl FnMut(&[Played])) {
    for seed in SEEDS {
        let world = World::town(seed, 80);
        look(&world.play(&settings, LATENCY, &world.walk(30)));
    }
}

fn full() -> Settings {
    Settings::new(Technique::ChcPlusPlus)
}

#[test]
fn who_stops_and_waits_stalls_once_a_query() {
    let work = work(Settings::new(Technique::StopAndWait));
    assert!(work.queries > 1000);
    assert_eq!(work.stalls, work.queries);
    assert_eq!(work.batches, work.queries);
    assert_eq!(work.boxes, work.queries);
}

#[test]
fn each_technique_draws_no_more_than_the_one_before() {
    let work: Vec<Work> = Technique::ALL.iter().map(|&t| work(Settings::new(t))).collect();
    let [none, frustum, stop, chc, plus] = &work[..] else { panic!("five techniques") };
    assert!(frustum.triangles < none.triangles, "{frustum:?} {none:?}");
    assert!(stop.triangles < frustum.triangles, "{stop:?} {frustum:?}");
    assert_eq!((none.nodes, none.queries, frustum.queries), (0, 0, 0));
    // Coherence lets some be drawn that waiting would have culled, far fewer than there are.
    for coherent in [chc, plus] {
        assert!(coherent.triangles < frustum.triangles, "{coherent:?} {frustum:?}");
        assert!(coherent.stalls < stop.stalls / 2, "{coherent:?} {stop:?}");
        assert!(coherent.queries < stop.queries, "{coherent:?} {stop:?}");
    }
    assert_eq!(chc.batches, chc.queries);
    assert!(plus.batches * 3 < chc.batches, "{plus:?} {chc:?}");
    assert!(plus.stalls * 2 < chc.stalls, "{plus:?} {chc:?}");
    assert!(plus.wasted * 2 < chc.wasted, "{plus:?} {chc:?}");
}

#[test]
fn an_instant_answer_stalls_nobody_but_who_waits_for_each() {
    let world = World::town(1, 80);
    for technique in [Technique::Chc, Technique::ChcPlusPlus] {
        let played = world.play(&Settings::new(technique), 0, &world.walk(10));
        assert!(played.iter().all(|p| p.frame.work.stalls == 0), "{technique:?}");
    }
}

#[test]
fn larger_batches_change_state_less_often() {
    let batches: Vec<u64> =
        [1, 2, 5, 20].map(|batch| work(Settings { batch, ..full() }).batches).to_vec();
    assert!(batches.is_sorted_by(|a, b| a > b), "{batches:?}");
}

#[test]
fn queries_of_leaves_in_sight_fall_with_the_frames_of_assumed_visibility() {
    let of = |assumed_visible| work(Settings { assumed_visible, ..full() });
    let wasted: Vec<u64> = [0, 2, 5, 10, 30].map(|n| of(n).wasted).to_vec();
    assert!(wasted.is_sorted_by(|a, b| a > b), "{wasted:?}");
}

#[test]
fn jitter_spreads_the_queries_of_leaves_in_sight() {
    let still = |jitter| {
        let mut most = 0;
        for seed in SEEDS {
            let world = World::town(seed, 80);
            let settings = Settings { jitter, ..full() };
            let views = vec![world.walk(20)[19].clone(); 26];
            let played = world.play(&settings, LATENCY, &views);
            // The first frames ask about everything, with jitter or without.
            most += played[2..].iter().map(|p| p.frame.work.queries).max().unwrap();
        }
        most
    };
    assert!(still(true) * 3 < still(false) * 2, "{} {}", still(true), still(false));
}

#[test]
fn without_assumed_visibility_there_is_nothing_to_spread() {
    let none = Settings { assumed_visible: 0, ..full() };
    same(none, Settings { jitter: false, ..none });
    same(none, Settings { seed: 17, ..none });
    let steady = Settings { jitter: false, ..full() };
    same(steady, Settings { seed: 17, ..steady });
    assert_ne!(work(full()), work(Settings { seed: 17, ..full() }));
}

#[test]
fn batches_of_one_hold_no_groups() {
    let one = Settings { batch: 1, ..full() };
    same(one, Settings { multiqueries: false, ..one });
}

#[test]
fn without_options_each_query_is_one_box() {
    let single = Settings { multiqueries: false, tight_bounds: TightBounds::OFF, ..full() };
    let (bare, grouped) = (work(single), work(Settings { multiqueries: true, ..single }));
    assert_eq!(bare.boxes, bare.queries);
    assert!(grouped.queries < bare.queries, "{grouped:?} {bare:?}");
    assert!(grouped.boxes > grouped.queries, "{grouped:?}");
    let tight = work(Settings { tight_bounds: TightBounds::default(), ..single });
    assert!(tight.boxes > tight.queries, "{tight:?}");
    // Closer boxes show less often.
    assert!(tight.wasted < bare.wasted, "{tight:?} {bare:?}");
}

#[test]
fn nothing_waits_for_the_queue_of_leaves_in_sight() {
    let of = |visible_queue| work(Settings { visible_queue, ..full() });
    let (with, without) = (of(true), of(false));
    assert!(with.stalls < without.stalls, "{with:?} {without:?}");
}

#[test]
fn knobs_of_the_revision_change_nothing_elsewhere() {
    for technique in [Technique::None, Technique::Frustum, Technique::StopAndWait, Technique::Chc] {
        let settings = Settings::new(technique);
        same(settings, Settings { seed: 5, ..plain(settings) });
    }
}

#[test]
fn answers_of_the_next_frame_do_not_stall() {
    for technique in [Technique::Chc, Technique::ChcPlusPlus] {
        let late = Settings { results: Results::NextFrame, ..Settings::new(technique) };
        let world = World::town(2, 80);
        let played = world.play(&late, LATENCY, &world.walk(20));
        let stalls: u64 = played.iter().map(|p| p.frame.work.stalls).sum();
        let exact = Settings::new(technique);
        let waited: u64 =
            world.play(&exact, LATENCY, &world.walk(20)).iter().map(|p| p.frame.work.stalls).sum();
        assert!(stalls < waited, "{technique:?}: {stalls} {waited}");
    }
}

#[test]
fn answers_of_the_next_frame_miss_nothing_in_the_first() {
    for technique in [Technique::Chc, Technique::ChcPlusPlus] {
        let late = Settings { results: Results::NextFrame, ..Settings::new(technique) };
        for seed in SEEDS {
            let world = World::town(seed, 60);
            for view in world.jumps(seed, 6) {
                let views = [view];
                let faults = world.faults(&late, &views, &world.play(&late, LATENCY, &views));
                assert_eq!(faults, Vec::<String>::new(), "{technique:?}, town {seed}");
            }
        }
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let refused = |settings: Settings| settings.check().unwrap_err().to_string();
    full().check().unwrap();
    assert_eq!(refused(Settings { batch: 0, ..full() }), "batch: 0 is not in 1..=200");
    assert_eq!(
        refused(Settings { assumed_visible: 61, ..full() }),
        "assumed_visible: 61 is not in 0..=60"
    );
    assert_eq!(
        refused(Settings { threshold_px: 1001, ..full() }),
        "threshold_px: 1001 is not in 0..=1000"
    );
    let tight = |depth, area| Settings { tight_bounds: TightBounds { depth, area }, ..full() };
    assert_eq!(refused(tight(5, 1.4)), "tight_bounds.depth: 5 is not in 0..=4");
    assert_eq!(refused(tight(3, f32::NAN)), "tight_bounds.area: NaN is not in 1..=10");
    assert_eq!(
        refused(Settings { results: Results::NextFrame, ..Settings::new(Technique::StopAndWait) }),
        "results: answers of the next frame, where each is waited for"
    );
    for technique in Technique::ALL {
        assert_eq!(Technique::by_name(technique.name()), Some(technique));
    }
    assert_eq!(Technique::by_name("chc++"), None);
}

fn same(a: Settings, b: Settings) {
    for seed in SEEDS {
        let world = World::town(seed, 80);
        let of = |s: &Settings| world.play(s, LATENCY, &world.walk(12));
        assert!(of(&a) == of(&b), "{a:?} {b:?}");
    }
}
