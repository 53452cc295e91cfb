//! The reader of records never panics, and finds a good row behind and before any bytes.
#![no_main]

#[path = "../../src/inputs.rs"]
mod inputs;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| inputs::records(bytes));
