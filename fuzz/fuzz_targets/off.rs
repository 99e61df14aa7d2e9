#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tetcvt_fuzz::surface("a.off", b"OFF\n", bytes));
