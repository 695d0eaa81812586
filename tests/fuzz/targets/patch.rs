#![no_main]

libfuzzer_sys::fuzz_target!(|file: &[u8]| {
    (readers::reader("patch").read)(file);
});
