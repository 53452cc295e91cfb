//! What must hold of every packing, and the faults that each gate must catch.

use super::{
    case::Crown,
    spec::SPEC,
    subject::{self, Packer},
};
use crate::{
    SuiteError,
    problem::{Form, Technique},
    verify::{Gate, GateContext, Tally},
};
use dapple_foliage::partition::{
    Cells, FULL, FactorPath,
    faults::{self, Fault},
    kept, quantise_all, reference, validate,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Leaves at which sizes of blocks, cells and rounding change.
const SIZES: [usize; 6] = [0, 1, 511, 512, 513, 20_000];
/// Cells at which the scan's blocks change.
const CELLS: [usize; 5] = [1, 2, 511, 513, 4097];

/// One exactness gate a technique, each with another fault, and what all share.
pub fn gates() -> Vec<Gate> {
    let exactness =
        SPEC.techniques.iter().zip(Fault::ALL.iter().cycle()).map(|(t, (fault, what))| {
            let (technique, fault) = (*t, *fault);
            Gate {
                technique: t.id.into(),
                name: "P3.6-P3.8 exact path".into(),
                statement: "over a path with a reset, ranges tile exactly, guards are intact, and \
                        every frame is bit-equal to the reference",
                needs_gpu: !t.forms.contains(&Form::Cpu),
                run: Box::new(move |context| exact(&technique, context)),
                fault: what,
                control: Box::new(move |_| faulty(fault)),
            }
        });
    exactness.chain([nesting()]).collect()
}

fn exact(technique: &Technique, context: &GateContext<'_>) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let mut random = Pcg64Mcg::seed_from_u64(context.seed);
    let fixed = SIZES.iter().flat_map(|n| CELLS.map(|c| (*n, c)));
    let extra: Vec<_> = (0..context.cases / 8)
        .map(|_| (random.random_range(0..5000), random.random_range(1..700)))
        .collect();
    for (n_leaves, n_cells) in fixed.chain(extra) {
        let cells = Cells::generate(context.seed, n_leaves, n_cells)?;
        let path = FactorPath { seed: context.seed, frames: 6 };
        let mut packer = subject::packer(technique.id, context.gpu, &cells)?;
        for frame in [0, 1, 2, 3, 4, 5, 1, 4] {
            let q = quantise_all(&path.factors(&cells, frame))?;
            if frame == 3 {
                packer.reset(context.gpu)?;
            }
            let found = packer.ranges(context.gpu, &cells, &q)?;
            let valid = validate(&found, &cells, &q);
            let truth = reference::extract(&cells, &q)?;
            let same = found.offsets == truth.offsets && found.indices == truth.indices;
            tally.check(valid.is_ok() && same, || {
                let why =
                    valid.err().map_or("differs from the reference".into(), |e| e.to_string());
                format!("{n_leaves} leaves, {n_cells} cells, frame {frame}: {why}")
            });
        }
    }
    Ok(tally)
}

/// The gate's own judgement of a deliberately wrong packing.
fn faulty(fault: Fault) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    let (cells, q) = faults::case()?;
    let found = faults::extract(fault, &cells, &q)?;
    let valid = validate(&found, &cells, &q);
    tally.check(valid.is_ok(), || format!("{:?}", valid.err().map(|e| e.to_string())));
    Ok(tally)
}

/// P3.5 on the kept counts: monotone in the factor, 0 at 0, all at 1.
fn nesting() -> Gate {
    fn judge(context: &GateContext<'_>, kept: fn(u32, u32) -> u32) -> Result<Tally, SuiteError> {
        let mut tally = Tally::default();
        let mut random = Pcg64Mcg::seed_from_u64(context.seed);
        let sizes = [0, 1, 2, 511, 512, 513, 65_534, 65_535, 65_536, 1_000_000];
        for case in 0..context.cases.max(16) as usize {
            let n = sizes.get(case).copied().unwrap_or_else(|| random.random_range(0..1_000_000));
            let mut factors: Vec<u32> = (0..50).map(|_| random.random_range(0..=FULL)).collect();
            factors.extend([0, 1, FULL - 1, FULL]);
            factors.sort_unstable();
            let counts: Vec<u32> = factors.iter().map(|q| kept(n, *q)).collect();
            tally.check(counts.is_sorted(), || format!("{n} leaves: the count falls"));
            tally.check(counts[0] == 0, || format!("{n} leaves: {} kept at 0", counts[0]));
            let all = counts.last().copied().unwrap_or(0);
            tally.check(all == n, || format!("{n} leaves: {all} kept at 1"));
        }
        Ok(tally)
    }
    Gate {
        technique: "-".into(),
        name: "P3.5 kept counts".into(),
        statement: "the kept count grows with the factor, is 0 at 0 and all at 1",
        needs_gpu: false,
        run: Box::new(|context| judge(context, kept)),
        fault: "rounding up past n",
        control: Box::new(|context| judge(context, |n, q| kept(n, q) + 1)),
    }
}

impl Crown<'_> {
    /// Compares a packing of one frame with the truth: valid, and bit-equal.
    pub(super) fn judge(
        &self,
        packer: &mut Packer,
        frame: usize,
    ) -> Result<Option<String>, SuiteError> {
        let q = &self.factors[frame];
        let found = packer.ranges(self.gpu, &self.cells, q)?;
        if let Err(error) = validate(&found, &self.cells, q) {
            return Ok(Some(format!("frame {frame}: {error}")));
        }
        let truth = &self.truth[frame];
        let same = found.offsets == truth.offsets && found.indices == truth.indices;
        Ok((!same).then(|| format!("frame {frame} differs from the reference")))
    }
}
