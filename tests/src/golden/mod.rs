//! Golden images: a regression check, made only after a result has passed against the truth.
//!
//! References are small PNG files that insta keeps in `fixtures/goldens/` as binary snapshots,
//! compared by [`Tolerance`] and not byte by byte. `INSTA_UPDATE=always` replaces them; look at
//! every picture before committing it. On failure expected, difference and actual are written to
//! `target/golden-failures/`.

mod comparator;
mod compare;
mod folder;
mod picture;

pub use comparator::Tolerant;
pub use compare::{Deviation, EXACT, LSB, RASTER, Tolerance, compare};
pub use folder::{audit, failures_folder, goldens_folder, reference};
pub use picture::Picture;

use insta::{Settings, assert_binary_snapshot};
use std::path::Path;

/// Holds `actual` against the reference `name` in `fixtures/goldens/`.
///
/// # Panics
/// Where the reference is missing, or `actual` is beyond the tolerance.
#[track_caller]
pub fn assert_golden(name: &str, actual: &Picture, tolerance: Tolerance) {
    assert_golden_in(&goldens_folder(), &failures_folder(), name, actual, tolerance);
}

/// [`assert_golden`] with other folders.
///
/// # Panics
/// As [`assert_golden`], and where the environment tells insta to let failures pass.
#[track_caller]
pub fn assert_golden_in(
    goldens: &Path,
    failures: &Path,
    name: &str,
    actual: &Picture,
    tolerance: Tolerance,
) {
    let forced = std::env::var_os("INSTA_FORCE_PASS").is_some_and(|v| !v.is_empty() && v != "0");
    assert!(!forced, "INSTA_FORCE_PASS is set: a golden that cannot fail checks nothing");
    let mut settings = Settings::clone_current();
    settings.set_snapshot_path(goldens);
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_comparator(Box::new(Tolerant {
        name: name.into(),
        tolerance,
        failures: failures.into(),
    }));
    settings.bind(|| assert_binary_snapshot!(&format!("{name}.png"), actual.to_png()));
}

/// Holds the result of another form against the same reference, which is never replaced by it.
///
/// # Panics
/// Where the reference is missing, or `actual` is beyond the tolerance.
#[track_caller]
pub fn assert_like_golden(name: &str, form: &str, actual: &Picture, tolerance: Tolerance) {
    let failures = failures_folder();
    let comparator = Tolerant { name: format!("{name}-{form}"), tolerance, failures };
    let within = comparator.judge(reference(&goldens_folder(), name), actual);
    assert!(within, "the {form} form differs from the golden {name}");
}
