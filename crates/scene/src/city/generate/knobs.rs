//! What may be asked of the generator, and within which limits.

use crate::city::CityError;

/// What a generated city is like. The default is the reference city: 6 x 6 blocks of 44 buildings,
/// brick offset, 1 to 7 storeys.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knobs {
    /// Blocks along x, 1..=24.
    pub blocks_x: u32,
    /// Rows of blocks, along z, 1..=24.
    pub blocks_z: u32,
    /// Where the lots of a block lie.
    pub shape: BlockShape,
    /// Storeys of the buildings.
    pub heights: Heights,
    /// Share of lots without a building, 0..=0.5.
    pub empty_lots: f64,
    /// Moves every other row of blocks by half a block, so that the streets across it are closed
    /// by facades at both ends.
    pub brick_offset: bool,
    /// Width of carriageways in metres, 6..=30, rounded to 1/64 m.
    pub street_m: f64,
    /// Lit windows a storey of a facade, 1..=8.
    pub lights_per_storey: u32,
    /// Trees on the sidewalks of a block, 0..=64.
    pub trees_per_block: u32,
}

/// Where the lots of a block lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockShape {
    /// Two rows of so many lots, 1..=64, back to back over an alley.
    DoubleRow(u32),
    /// A closed ring with so many lots a side, 3..=64, around a yard.
    Ring(u32),
}

/// Storeys of the buildings, each 1..=100.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heights {
    /// The same everywhere.
    Fixed(u32),
    /// Every number of the range equally often in every block, shuffled: the counts of a city grow
    /// with its blocks without the noise of chance. What does not divide evenly is spread evenly
    /// over the range.
    Stratified {
        /// Lowest.
        least: u32,
        /// Highest.
        most: u32,
    },
    /// Every number of the range with equal chance, each building for itself.
    Independent {
        /// Lowest.
        least: u32,
        /// Highest.
        most: u32,
    },
}

impl Default for Knobs {
    fn default() -> Self {
        Self {
            blocks_x: 6,
            blocks_z: 6,
            shape: BlockShape::DoubleRow(22),
            heights: Heights::Stratified { least: 1, most: 7 },
            empty_lots: 0.0,
            brick_offset: true,
            street_m: 12.0,
            lights_per_storey: 3,
            trees_per_block: 0,
        }
    }
}

impl Knobs {
    /// Checks every knob.
    ///
    /// # Errors
    /// [`CityError::Value`] with the first knob beyond its range.
    pub fn check(&self) -> Result<(), CityError> {
        within("blocks_x", f64::from(self.blocks_x), 1.0, 24.0)?;
        within("blocks_z", f64::from(self.blocks_z), 1.0, 24.0)?;
        match self.shape {
            BlockShape::DoubleRow(lots) => {
                within("lots of a double row", f64::from(lots), 1.0, 64.0)?;
            }
            BlockShape::Ring(lots) => within("lots of a ring's side", f64::from(lots), 3.0, 64.0)?,
        }
        match self.heights {
            Heights::Fixed(storeys) => within("storeys", f64::from(storeys), 1.0, 100.0)?,
            Heights::Stratified { least, most } | Heights::Independent { least, most } => {
                within("least storeys", f64::from(least), 1.0, 100.0)?;
                within("most storeys", f64::from(most), f64::from(least), 100.0)?;
            }
        }
        within("empty_lots", self.empty_lots, 0.0, 0.5)?;
        within("street_m", self.street_m, 6.0, 30.0)?;
        within("lights_per_storey", f64::from(self.lights_per_storey), 1.0, 8.0)?;
        within("trees_per_block", f64::from(self.trees_per_block), 0.0, 64.0)
    }
}

fn within(name: &'static str, value: f64, least: f64, most: f64) -> Result<(), CityError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(CityError::Value { name, value, limit: format!("{least}..={most}") })
}
