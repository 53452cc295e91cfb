//! One device a process for the GPU tests of every crate.

use std::{io::Write, sync::OnceLock};

use crate::{AdapterChoice, Gpu, GpuError};

/// The adapter for tests: `DAPPLE_ADAPTER` names one, else the first there is.
///
/// Returns `None` after printing `not run: ...` where no adapter can be opened; with
/// `DAPPLE_REQUIRE_GPU=1` that is a failure.
///
/// # Panics
/// With `DAPPLE_REQUIRE_GPU=1` and no usable adapter.
#[expect(clippy::panic, reason = "the build server demands a GPU")]
pub fn test_gpu() -> Option<&'static Gpu> {
    static GPU: OnceLock<Result<Gpu, GpuError>> = OnceLock::new();
    match GPU.get_or_init(|| Gpu::open(&choice())) {
        Ok(gpu) => Some(gpu),
        Err(error) if std::env::var("DAPPLE_REQUIRE_GPU").is_ok_and(|v| v == "1") => {
            panic!("DAPPLE_REQUIRE_GPU=1, but {error}")
        }
        Err(error) => {
            say_not_run(&format!("no adapter ({error})"));
            None
        }
    }
}

/// Says on standard error that the current test is not run, and why. Past the harness, which
/// keeps what a passing test prints to itself: a test that is not run must not look like a pass.
pub fn say_not_run(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // Nobody to tell is no reason to fail.
    let _ = writeln!(std::io::stderr(), "not run: {test}: {why}");
}

/// The adapter that tests open.
pub fn choice() -> AdapterChoice {
    std::env::var("DAPPLE_ADAPTER").map_or(AdapterChoice::Auto, AdapterChoice::Named)
}

/// Objects that are alive in this process, over all devices: buffers, textures, query sets, bind
/// groups, compute and raster pipelines. For tests of growth.
pub fn live_objects() -> Option<[usize; 6]> {
    let report = crate::adapter::instance().generate_report()?;
    let hub = report.hub_report();
    Some([
        hub.buffers.num_allocated,
        hub.textures.num_allocated,
        hub.query_sets.num_allocated,
        hub.bind_groups.num_allocated,
        hub.compute_pipelines.num_allocated,
        hub.render_pipelines.num_allocated,
    ])
}
