//! The criterion that knows the answer: error of transmittance against sorted fragments.

use super::layers::Region;
use crate::{Fragments, OpacityError, cpu::Maps, exact::Exact};

/// Σ (T - T_exact)² over the translucent fragments of a region's texels, each a receiver at its own
/// depth, and their number.
///
/// A receiver behind everything is told the total by every λ, so it is left out.
pub fn squared_error(
    maps: &Maps,
    fragments: &Fragments,
    exact: &Exact,
    region: Region,
) -> (f64, u64) {
    let code = maps.code();
    let (mut sum, mut n) = (0.0, 0);
    for texel in region.texels(fragments.width as usize) {
        let words = maps.texel(texel);
        for fragment in fragments.texel(texel) {
            let read = code.decode(texel, words, fragment.depth - maps.settings().bias);
            let error = f64::from(read) - exact.transmittance(texel, fragment.depth);
            sum += error * error;
            n += 1;
        }
    }
    (sum, n)
}

/// Root of the mean square over all texels, 0 without fragments. `exact` must be of the same
/// `fragments`, which the maps were built from.
///
/// # Errors
/// Fragments of another size than the maps.
pub fn rmse(maps: &Maps, fragments: &Fragments, exact: &Exact) -> Result<f64, OpacityError> {
    let (expected, actual) = (maps.texels(), fragments.texels());
    if expected != actual {
        return Err(OpacityError::Length { what: "texels of the fragments", expected, actual });
    }
    let (width, height) = (fragments.width as usize, fragments.height as usize);
    let all = Region { columns: (0, width), rows: (0, height), step: 1 };
    let (sum, n) = squared_error(maps, fragments, exact, all);
    Ok((sum / n.max(1) as f64).sqrt())
}
