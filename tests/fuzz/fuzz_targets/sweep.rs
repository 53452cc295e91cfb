//! A sweep is planned or refused.
#![no_main]

#[path = "../../src/inputs.rs"]
mod inputs;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| inputs::sweep(bytes));
