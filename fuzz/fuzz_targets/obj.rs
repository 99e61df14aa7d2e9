#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tetcvt_fuzz::surface("a.obj", b"v 0 0 0\n", bytes));
