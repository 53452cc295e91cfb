//! A crown sorted into cells, its path of factors, and the truth of every frame.

use super::{
    spec::{CROWN, SPEC},
    subject,
};
use crate::{
    SuiteError,
    case::{self, Case, Source},
    knob::Get,
    problem::{Facts, Prepared, Setting, Subject},
};
use dapple_foliage::partition::{Cells, FactorPath, Ranges, quantise_into, reference};
use dapple_gpu::Gpu;
use dapple_scene::{Scene, import};
use glam::DVec3;
use rand::{SeedableRng, seq::SliceRandom};
use rand_pcg::Pcg64Mcg;

/// A prepared case.
pub struct Crown<'g> {
    pub gpu: Option<&'g Gpu>,
    pub cells: Cells,
    /// Quantised factors by frame.
    pub factors: Vec<Vec<u32>>,
    /// The reference's ranges by frame.
    pub truth: Vec<Ranges>,
    facts: Facts,
}

impl<'g> Crown<'g> {
    pub fn prepare(case: &Case, gpu: Option<&'g Gpu>) -> Result<Self, SuiteError> {
        let n_cells = case.parameters.int("cells")? as usize;
        let frames = case.parameters.int("frames")? as u32;
        let mut notes = Vec::new();
        let (cells, scene_hash) = match case::source(&case.scene)? {
            Source::Generated(name) if name == CROWN => {
                let leaves = case.parameters.int("leaves")? as usize;
                let cells = Cells::generate(case.seed, leaves, n_cells)?;
                let hash = hash(&cells);
                (cells, hash)
            }
            Source::Generated(name) => return Err(SuiteError::unknown("scene", &name, [CROWN])),
            Source::File(path) => {
                let loaded = import::load(&path)?;
                notes.extend(loaded.warnings);
                notes.push("each triangle of the file counts as one leaf".into());
                let cells = cells_of(&loaded.scene, n_cells, case.seed)?;
                (cells, loaded.scene.hash())
            }
            Source::MissingData(path) => return Err(case::missing_data(&path)),
        };
        let path = FactorPath { seed: case.seed, frames };
        let facts = Facts { scene: case.scene.clone(), scene_hash, notes, ..Facts::default() };
        Self::of(
            cells,
            frames,
            |cells, frame, out| path.factors_into(cells, frame, out),
            facts,
            gpu,
        )
    }

    /// The same for cells and factors at hand: `factors_of` gives those of a frame, one a cell.
    pub fn of(
        cells: Cells,
        frames: u32,
        factors_of: impl Fn(&Cells, u32, &mut Vec<f32>),
        facts: Facts,
        gpu: Option<&'g Gpu>,
    ) -> Result<Self, SuiteError> {
        cells.validate()?;
        let mut factors = Vec::new();
        let mut truth = Vec::new();
        let mut raw = Vec::new();
        for frame in 0..frames {
            let mut quantised = Vec::new();
            factors_of(&cells, frame, &mut raw);
            quantise_into(&raw, &mut quantised)?;
            truth.push(reference::extract(&cells, &quantised)?);
            factors.push(quantised);
        }
        let facts = Facts {
            view: format!("path of {frames}"),
            size: format!("{} leaves in {} cells", cells.leaf_ids.len(), cells.len()),
            truth: SPEC.truth.into(),
            ..facts
        };
        Ok(Self { gpu, cells, factors, truth, facts })
    }
}

impl Prepared for Crown<'_> {
    fn facts(&self) -> Facts {
        self.facts.clone()
    }

    fn subject<'a>(&'a self, setting: &Setting) -> Result<Box<dyn Subject + 'a>, SuiteError> {
        subject::make(self, setting)
    }
}

fn hash(cells: &Cells) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(bytemuck::cast_slice(&cells.starts));
    hasher.update(bytemuck::cast_slice(&cells.leaf_ids));
    hasher.finalize().to_hex()[..16].to_string()
}

/// Sorts a scene's triangles into cells by median splits of the widest axis, each cell in random
/// order. The number of cells is met exactly: a part gets cells in proportion to its share.
fn cells_of(scene: &Scene, n_cells: usize, seed: u64) -> Result<Cells, SuiteError> {
    let centres: Vec<DVec3> =
        scene.world_triangles().map(|(_, [a, b, c])| (a + b + c) / 3.0).collect();
    let mut ids: Vec<u32> = (0..centres.len() as u32).collect();
    let mut starts = vec![0];
    split(&centres, &mut ids, n_cells, &mut starts);
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    for cell in starts.windows(2) {
        ids[cell[0] as usize..cell[1] as usize].shuffle(&mut random);
    }
    let cells = Cells { starts, leaf_ids: ids };
    cells.validate()?;
    Ok(cells)
}

fn split(centres: &[DVec3], ids: &mut [u32], n_cells: usize, starts: &mut Vec<u32>) {
    if n_cells <= 1 {
        let before = starts.last().copied().unwrap_or(0);
        starts.push(before + ids.len() as u32);
        return;
    }
    let left_cells = n_cells / 2;
    let middle = ids.len() * left_cells / n_cells;
    if middle > 0 && middle < ids.len() {
        let (low, high) = ids.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), i| {
            (l.min(centres[*i as usize]), h.max(centres[*i as usize]))
        });
        let axis = (high - low).max_position();
        // A total order: equal coordinates are split by index, the same on every machine.
        ids.select_nth_unstable_by(middle, |a, b| {
            let (x, y) = (centres[*a as usize][axis], centres[*b as usize][axis]);
            x.total_cmp(&y).then(a.cmp(b))
        });
    }
    let (left, right) = ids.split_at_mut(middle);
    split(centres, left, left_cells, starts);
    split(centres, right, n_cells - left_cells, starts);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_are_sorted_into_the_asked_number_of_cells() {
        let scene = dapple_scene::generate::by_name("chairs", 0).unwrap();
        for n_cells in [1, 2, 7, 512, 100_000] {
            let cells = cells_of(&scene, n_cells, 3).unwrap();
            assert_eq!(cells.len(), n_cells);
            assert_eq!(cells.leaf_ids.len(), scene.triangle_count());
            let sizes: Vec<u32> = cells.sizes().collect();
            let spread = sizes.iter().max().unwrap() - sizes.iter().min().unwrap();
            assert!(spread <= 1 + n_cells.ilog2(), "{n_cells}: {spread}");
        }
        // The order inside a cell is the seed's.
        let order = |seed| cells_of(&scene, 4, seed).unwrap().leaf_ids;
        assert_eq!(order(1), order(1));
        assert_ne!(order(1), order(2));
    }
}
