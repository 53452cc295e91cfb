//! Several threads.

use super::{
    support::{Asked, CITIES, OURS, THESIS, VIEW, asked, prepared},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
    night::Night,
};
use dapple_many_lights::region::{FacadeCluster, Many, RegionTechnique, make};
use rayon::prelude::*;
use std::{hint::black_box, sync::Arc, time::Instant};

/// Threads that are held against one, and how many times faster they have to be.
const THREADS: usize = 2;
const FASTER: f64 = 1.8;

/// What a machine gives to arithmetic that shares nothing, if both threads have a core of their own.
const QUIET: f64 = 1.9;

/// Rounds; the least time of each counts.
const ROUNDS: usize = 9;

pub fn claims() -> Vec<Claim> {
    vec![Claim {
        id: "conte-H6.1",
        statement: "Several threads double the pace of visibility: at least 1.8 times on two",
        place: "Conte 2018, section 6.1; threshold: goal of this project",
        method: "city, close-ended street, all faces of one frame on one thread and on two, nine times \
                 in turn, least times; as the source says it and by our settings. Between them \
                 arithmetic that shares nothing shows what the machine gives: below 1.9 it is busy or \
                 has one core, and less than 1.8 decides nothing. Met from 1.8 on in both settings with \
                 the same lists; other lists, or less than 1.5 on a quiet machine, contradict",
        judge: Box::new(pace),
    }]
}

/// Nanoseconds of all faces in the current pool, and their lists.
fn faces(
    night: &Night,
    settings: FacadeCluster,
    asked: &[Asked<'_>],
) -> Result<(f64, Vec<Vec<u32>>), SuiteError> {
    let (town, technique) = (&night.town, RegionTechnique::FacadeCluster(settings));
    let made = || make(&technique, false, town.world(true), &town.lights, &town.occluders);
    let mut many = Many::new(made)?;
    let mut precuts = Vec::new();
    // Once so that lists have grown.
    many.all(asked, &mut precuts);
    let start = Instant::now();
    many.all(asked, &mut precuts);
    Ok((start.elapsed().as_nanos() as f64, precuts))
}

/// Nanoseconds of arithmetic in the current pool: 64 equal parts.
fn arithmetic() -> f64 {
    let start = Instant::now();
    let step = |x: u64, i: u64| (x ^ i).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let part = |seed: u32| (0..400_000).fold(u64::from(seed), step);
    black_box((0..64_u32).into_par_iter().with_max_len(1).map(part).reduce(|| 0, |a, b| a ^ b));
    start.elapsed().as_nanos() as f64
}

/// Speedups by setting, what arithmetic reaches, and whether lists are the same.
fn doubles(speedups: &[f64], machine: f64, same: bool) -> Verdict {
    if !same {
        Verdict::Refuted
    } else if speedups.iter().all(|s| *s >= FASTER) && !speedups.is_empty() {
        Verdict::Reproduced
    } else if machine >= QUIET && speedups.iter().any(|s| *s < 1.5) {
        Verdict::Refuted
    } else if machine >= QUIET {
        Verdict::Open
    } else {
        Verdict::NeedsHardware
    }
}

fn pace(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let case = prepared(CITIES[0], VIEW, 1)?;
    let (night, asked) = (case.night(), asked(&case));
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| SuiteError::Internal(format!("{threads} threads: {error}")))
    };
    let pools = [Arc::new(pool(1)?), Arc::new(pool(THREADS)?)];
    let all = [("as the source says it", THESIS), ("our settings", OURS)];
    let mut machine = [f64::INFINITY; 2];
    let mut least = [[f64::INFINITY; 2]; 2];
    let mut same = true;
    for _ in 0..ROUNDS {
        for (which, (_, settings)) in all.into_iter().enumerate() {
            let mut lists = Vec::new();
            for (place, pool) in pools.iter().enumerate() {
                let (ns, found) = pool.install(|| faces(night, settings, &asked))?;
                least[which][place] = least[which][place].min(ns);
                lists.push(found);
            }
            same &= lists[0] == lists[1];
        }
        for (least, pool) in machine.iter_mut().zip(&pools) {
            *least = least.min(pool.install(arithmetic));
        }
    }
    let ratio = |[one, two]: [f64; 2]| one / two;
    let speedups = least.map(ratio);
    let mut figures = vec![
        figure("arithmetic, one thread over two", ratio(machine), ""),
        figure("lists alike", f64::from(u8::from(same)), ""),
    ];
    for ((name, _), (speedup, [one, two])) in all.into_iter().zip(speedups.into_iter().zip(least)) {
        figures.extend([
            figure(format!("{name}: one thread over two"), speedup, ""),
            figure(format!("{name}: a frame's faces, one thread"), one / 1e6, "ms"),
            figure(format!("{name}: a frame's faces, two threads"), two / 1e6, "ms"),
        ]);
    }
    let because = format!(
        "{:.2} and {:.2} times as fast on two threads, where arithmetic is {:.2} times",
        speedups[0],
        speedups[1],
        ratio(machine)
    );
    Ok(judged(doubles(&speedups, ratio(machine), same), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{NeedsHardware, Open, Refuted, Reproduced};

    #[test]
    fn two_threads_are_fast_or_the_machine_is_busy() {
        assert_eq!(doubles(&[1.9, 1.85], 1.95, true), Reproduced);
        assert_eq!(doubles(&[1.9, 1.7], 1.95, true), Open);
        assert_eq!(doubles(&[1.9, 1.2], 1.95, true), Refuted);
        assert_eq!(doubles(&[1.9, 1.2], 1.3, true), NeedsHardware);
        assert_eq!(doubles(&[1.9, 1.9], 1.95, false), Refuted);
        assert_eq!(doubles(&[], f64::NAN, true), NeedsHardware);
    }
}
