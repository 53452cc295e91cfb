//! What the thesis prints of searches and times: tables A.11, 5.2.3.1, 6.1.1, 6.2.1 and 6.3.1.
//! Times are of a GT 335M under a Pentium at 1.3 GHz, a debug build: only their ratios are compared.

/// Layers of table A.11; its first column is headed 1, which is one target of four.
pub const LAYERS_A11: [u32; 3] = [4, 16, 32];

/// λ* by absolute differences and by correlation, the views in the order of
/// [`super::search_trials::VIEWS`], for [`LAYERS_A11`].
pub const TABLE_A11: [[[f64; 3]; 2]; 6] = [
    [[1.0, 0.4, 0.2], [0.7, 0.2, 0.2]],
    [[1.0, 0.6, 0.2], [0.7, 0.3, 0.1]],
    [[1.0, 0.9, 1.0], [0.7, 0.3, 0.2]],
    [[1.0, 1.0, 1.0], [1.0, 0.8, 0.7]],
    [[1.0, 1.0, 1.0], [0.8, 0.4, 0.3]],
    [[1.0, 1.0, 1.0], [1.0, 0.9, 0.8]],
];

/// Layers of the tables of times and of table 5.2.3.1.
pub const LAYERS: [u32; 4] = [4, 8, 16, 32];

/// Scenes of those tables, by our names.
pub const SCENES: [&str; 3] = ["trees", "grass", "grass_dense"];

/// Mean correlation of neighbouring maps of [`SCENES`], for [`LAYERS`] (table 5.2.3.1).
pub const CORRELATION: [[f64; 4]; 3] =
    [[0.66, 0.83, 0.92, 0.96], [0.72, 0.86, 0.93, 0.96], [0.72, 0.86, 0.93, 0.96]];

/// Frames a second of OSM, DOM and BOM, on [`SCENES`], for [`LAYERS`].
pub const FRAME_RATES: [[[f64; 4]; 3]; 3] = [
    [[147.58, 124.85, 86.68, 53.80], [137.53, 110.00, 73.87, 39.83], [107.76, 79.91, 59.53, 36.58]],
    [[112.10, 90.66, 63.96, 43.90], [77.38, 60.56, 47.93, 29.45], [70.53, 61.23, 41.85, 27.28]],
    [[73.41, 67.53, 58.91, 41.88], [61.18, 55.13, 46.96, 31.93], [49.80, 43.61, 34.66, 26.80]],
];
