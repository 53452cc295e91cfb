//! How many cases the property tests run.

use proptest::test_runner::Config;

/// 32 cases unless PROPTEST_CASES says otherwise.
pub(crate) fn config() -> Config {
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => Config::default(),
        None => Config::with_cases(32),
    }
}
