//! A line of a child's output is an event, a record, noise or an error.
#![no_main]

#[path = "../../src/inputs.rs"]
mod inputs;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| inputs::feed(bytes));
