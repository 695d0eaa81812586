//! Writes the seeds of every reader into a folder, `FOLDER/READER/NUMBER`: the first corpus of a fuzzer.
//!
//! `cargo run --release -p readers --example seeds -- FOLDER`

use std::path::PathBuf;

fn main() {
    let folder = PathBuf::from(std::env::args_os().nth(1).expect("a folder"));
    for reader in readers::READERS {
        let folder = folder.join(reader.name);
        std::fs::create_dir_all(&folder).expect("a folder that can be made");
        for (k, seed) in (reader.seeds)().iter().enumerate() {
            std::fs::write(folder.join(k.to_string()), seed).expect("a folder that can be written");
        }
    }
}
