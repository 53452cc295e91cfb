//! The device, for one test at a time.

use std::sync::{Mutex, MutexGuard, PoisonError};

use dapple_gpu::Gpu;
use dapple_gpu::testing::test_gpu;

/// The device all tests of this process share. One at a time: a poll on another thread may run
/// the callback that a read-back on this one waits for.
pub fn device() -> Option<(&'static Gpu, MutexGuard<'static, ()>)> {
    static TURN: Mutex<()> = Mutex::new(());
    let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    Some((test_gpu()?, turn))
}
