//! From raw readings to a verdict: pure, so that faults of drivers can be tested without them.

use super::{
    Abilities, F16_ROUNDING, F16_SUBNORMAL, Fault, LOOP_ITERATIONS, LoopReading, OCCLUSION_COUNTS,
    Readings, TimestampReading,
};

/// A compute pass that makes up all but a few microseconds of a submission must have at least
/// this share of its wall time. Other load on the machine only lowers the share; the wrong
/// stamps of stock lavapipe give 0.004.
const LEAST_SHARE: f64 = 0.25;

/// Device and host clocks drift apart by parts per million; 5 % more than the wall is a fault.
const LARGEST_SHARE: f64 = 1.05;

/// The abilities of an adapter with these readings.
///
/// # Errors
/// The fault for which the adapter must be refused: wrong loops.
pub fn judge(readings: &Readings) -> Result<Abilities, Fault> {
    judge_loops(&readings.loops)?;
    let mut notes = readings.notes.clone();
    let timestamps = match readings.timestamps.as_deref().map(judge_timestamps) {
        Some(Ok(())) => true,
        Some(Err(why)) => {
            notes.push(format!("timestamps: {why}"));
            false
        }
        None => false,
    };
    let rounded = |bits: &[u16], table: &[(f32, u16)]| {
        bits.len() == table.len() && bits.iter().zip(table).all(|(bits, (_, rne))| bits == rne)
    };
    let arithmetic = readings.arithmetic.as_ref();
    let packed = arithmetic.map_or(&[][..], |a| &a.packed);
    let (normal, subnormal) = packed.split_at(packed.len().min(F16_ROUNDING.len()));
    let stored = readings.stored.as_deref().unwrap_or_default();
    let occlusion = readings.occlusion;
    let features = readings.features;
    Ok(Abilities {
        timestamps,
        loops_sound: true,
        f16_pack_rne: rounded(normal, &F16_ROUNDING),
        f16_store_rne: rounded(stored, &F16_ROUNDING),
        f16_subnormals: rounded(subnormal, &F16_SUBNORMAL),
        occlusion_exact_counts: occlusion == Some(OCCLUSION_COUNTS),
        occlusion_boolean: occlusion
            .is_some_and(|counts| counts.map(|n| n > 0) == OCCLUSION_COUNTS.map(|n| n > 0)),
        f32_subnormals: arithmetic.is_some_and(|a| a.halved == 0x0040_0000),
        f32_division_rne: arithmetic.is_some_and(|a| a.third == (1.0f32 / 3.0).to_bits()),
        mul_add_contracted: arithmetic.is_some_and(|a| a.square_difference != 0),
        subgroup: features.contains(wgpu::Features::SUBGROUP),
        max_workgroup: readings.max_workgroup,
        shader_f16: features.contains(wgpu::Features::SHADER_F16),
        f32_filterable: features.contains(wgpu::Features::FLOAT32_FILTERABLE),
        f32_blendable: features.contains(wgpu::Features::FLOAT32_BLENDABLE),
        indirect_first_instance: features.contains(wgpu::Features::INDIRECT_FIRST_INSTANCE),
        multi_draw_indirect_count: features.contains(wgpu::Features::MULTI_DRAW_INDIRECT_COUNT),
        notes,
    })
}

fn judge_loops(found: &[LoopReading; 2]) -> Result<(), Fault> {
    let expected = LOOP_ITERATIONS.map(loop_after);
    if *found == expected {
        return Ok(());
    }
    let line = |loops: &[LoopReading; 2]| {
        let [a, b] = loops.map(|l| format!("{} iterations (state {:08x})", l.counted, l.state));
        format!("{a}, then {b}")
    };
    Err(Fault { probe: "loop length".into(), expected: line(&expected), found: line(found) })
}

/// What a loop of `iterations` must leave behind.
fn loop_after(iterations: u32) -> LoopReading {
    let step = |x: u32, _| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    LoopReading { counted: iterations, state: (0..iterations).fold(1, step) }
}

fn judge_timestamps(runs: &[TimestampReading]) -> Result<(), String> {
    let mut best = 0.0f64;
    for run in runs {
        for (pass, [begin, end]) in [("raster", run.raster), ("compute", run.compute)] {
            if begin == 0 || end <= begin {
                return Err(format!("a {pass} pass begins at {begin} ns and ends at {end} ns"));
            }
        }
        if run.compute[0] < run.raster[0] {
            return Err("a compute pass begins before the raster pass recorded first".into());
        }
        let taken = run.compute[1] - run.compute[0];
        let share = taken as f64 / run.wall_ns.max(1) as f64;
        if share > LARGEST_SHARE {
            return Err(format!("a pass takes {taken} ns of {} ns wall time", run.wall_ns));
        }
        best = best.max(share);
    }
    if best < LEAST_SHARE {
        return Err(format!("a compute pass shows {:.1} % of the time it took", 100.0 * best));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::probe::ArithmeticReading;

    /// Readings of a device without fault.
    fn sound() -> Readings {
        let bits = |table: &[(f32, u16)]| table.iter().map(|(_, b)| *b).collect::<Vec<_>>();
        Readings {
            loops: LOOP_ITERATIONS.map(loop_after),
            timestamps: Some(vec![stamps(10_000_000, 11_000_000)]),
            arithmetic: Some(ArithmeticReading {
                packed: [bits(&F16_ROUNDING), bits(&F16_SUBNORMAL)].concat(),
                halved: 0x0040_0000,
                square_difference: 0,
                third: 0x3EAA_AAAB,
            }),
            stored: Some(bits(&F16_ROUNDING)),
            occlusion: Some(OCCLUSION_COUNTS),
            features: wgpu::Features::empty(),
            max_workgroup: 256,
            notes: Vec::new(),
        }
    }

    fn stamps(compute_ns: u64, wall_ns: u64) -> TimestampReading {
        let begin = 5_000;
        TimestampReading { raster: [1_000, 4_000], compute: [begin, begin + compute_ns], wall_ns }
    }

    #[test]
    fn a_sound_device_has_every_ability_that_is_probed() {
        let a = judge(&sound()).unwrap();
        assert!(a.timestamps && a.loops_sound && a.f16_pack_rne && a.f16_store_rne);
        assert!(a.occlusion_exact_counts && a.occlusion_boolean && a.f32_subnormals);
        assert!(a.f32_division_rne && !a.mul_add_contracted && a.f16_subnormals);
        assert_eq!(a.notes, [""; 0]);
    }

    #[test]
    fn the_loop_cap_of_stock_lavapipe_is_refused() {
        // Mesa 22.3.6: 65,535 iterations an invocation over all loops, so none is left for the
        // second; the result carries no error.
        let mut readings = sound();
        readings.loops = [loop_after(65_535), loop_after(0)];
        let fault = judge(&readings).unwrap_err();
        assert_eq!(fault.probe, "loop length");
        assert!(fault.expected.contains("70000 iterations"), "{}", fault.expected);
        assert!(fault.found.contains("65535 iterations"), "{}", fault.found);
    }

    #[test]
    fn a_right_count_with_a_wrong_state_is_refused() {
        // A compiler may fold the counter and still cut the loop short.
        let mut readings = sound();
        readings.loops[0].state = loop_after(65_535).state;
        assert!(judge(&readings).is_err());
        let mut readings = sound();
        readings.loops[1] = loop_after(0);
        assert!(judge(&readings).is_err());
    }

    #[test]
    fn timestamps_of_stock_lavapipe_after_a_raster_pass_are_not_believed() {
        // 0.07 of 16.7 ms, seen on Mesa 22.3.6.
        let mut readings = sound();
        readings.timestamps = Some(vec![stamps(70_000, 16_700_000); 3]);
        let abilities = judge(&readings).unwrap();
        assert!(!abilities.timestamps);
        assert_eq!(abilities.notes, ["timestamps: a compute pass shows 0.4 % of the time it took"]);
    }

    #[test]
    fn negative_zero_unordered_and_too_long_times_are_not_believed() {
        let good = stamps(10_000_000, 11_000_000);
        let bad = [
            TimestampReading { compute: [9_000, 8_000], ..good },
            TimestampReading { compute: [9_000, 9_000], ..good },
            TimestampReading { raster: [4_000, 1_000], ..good },
            TimestampReading { raster: [9_000, 9_500], ..good },
            TimestampReading { raster: [0, 1_000], ..good },
            stamps(20_000_000, 11_000_000),
        ];
        for reading in bad {
            let mut readings = sound();
            readings.timestamps = Some(vec![good, reading]);
            assert!(!judge(&readings).unwrap().timestamps, "{reading:?}");
        }
    }

    #[test]
    fn one_undisturbed_run_of_the_timestamp_probe_is_enough() {
        let mut readings = sound();
        readings.timestamps =
            Some(vec![stamps(10_000_000, 90_000_000), stamps(10_000_000, 11_000_000)]);
        assert!(judge(&readings).unwrap().timestamps);
    }

    #[test]
    fn a_truncating_store_takes_one_ability_away() {
        let mut readings = sound();
        if let Some(stored) = &mut readings.stored {
            stored[4] = 0x3999; // 0.7 towards zero
        }
        let abilities = judge(&readings).unwrap();
        assert!(!abilities.f16_store_rne && abilities.f16_pack_rne);
    }

    #[test]
    fn boolean_occlusion_is_not_taken_for_counts() {
        let mut readings = sound();
        readings.occlusion = Some([1, 1, 0, 0]);
        let abilities = judge(&readings).unwrap();
        assert!(abilities.occlusion_boolean && !abilities.occlusion_exact_counts);
        readings.occlusion = Some([5000, 1000, 1, 0]);
        assert!(!judge(&readings).unwrap().occlusion_boolean);
    }

    #[test]
    fn a_probe_that_did_not_run_gives_no_ability() {
        let mut readings = sound();
        readings.timestamps = None;
        readings.arithmetic = None;
        readings.stored = None;
        readings.occlusion = None;
        let a = judge(&readings).unwrap();
        assert!(!a.timestamps && !a.f16_pack_rne && !a.f16_store_rne && !a.occlusion_boolean);
        readings.timestamps = Some(Vec::new());
        assert!(!judge(&readings).unwrap().timestamps);
    }

    #[test]
    fn the_rounding_table_is_nearest_even() {
        for (value, bits) in F16_ROUNDING.into_iter().chain(F16_SUBNORMAL) {
            assert_eq!(half::f16::from_f32(value).to_bits(), bits, "{value}");
        }
        // The table must tell nearest even from truncation and from ties away from zero.
        let truncated = |v: f32| half::f16::from_f32(f32::from_bits(v.to_bits() & !0x1FFF));
        assert!(F16_ROUNDING.iter().filter(|(v, b)| truncated(*v).to_bits() != *b).count() >= 4);
        assert_eq!(F16_ROUNDING[0].0, 1.0 + 2f32.powi(-11));
        assert_eq!(F16_ROUNDING[1].0, 1.0 + 3.0 * 2f32.powi(-11));
        assert_eq!(F16_SUBNORMAL.map(|(v, _)| v), [2f32.powi(-24), 3.0 * 2f32.powi(-25)]);
    }
}
