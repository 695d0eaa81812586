//! Readers take whole files, and nothing that is broken brings one down.

use std::panic::{AssertUnwindSafe, catch_unwind};

use readers::{Mutator, READERS};

/// Broken files for each reader; ten readers make 10,000.
const FILES: usize = 1000;

/// Seed of all of them.
const SEED: u64 = 12;

/// Every reader takes at least one of its seeds: what is mutated begins as what is read.
#[test]
fn every_reader_takes_a_seed_slow() {
    for reader in READERS {
        let seeds = (reader.seeds)();
        let taken = seeds.iter().filter(|seed| (reader.read)(seed)).count();
        println!("{}: {taken} of {} seeds are read", reader.name, seeds.len());
        assert!(taken > 0, "`{}` takes none of its {} seeds", reader.name, seeds.len());
    }
}

/// A broken file is read or refused; it never panics, and what is read is finite (the readers' own assertions).
#[test]
fn broken_files_are_refused_or_read_slow() {
    let mut faults = Vec::new();
    for reader in READERS {
        let mut mutator = Mutator::new((reader.seeds)(), SEED);
        let mut taken = 0;
        for k in 0..FILES {
            let file = mutator.next_file();
            match catch_unwind(AssertUnwindSafe(|| (reader.read)(&file))) {
                Ok(read) => taken += usize::from(read),
                Err(_) => {
                    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR"))
                        .join(format!("{}-{k}", reader.name));
                    std::fs::write(&path, &file).unwrap();
                    faults.push(path.display().to_string());
                }
            }
        }
        println!("{}: {FILES} broken files, {taken} of them read, seed {SEED}", reader.name);
        assert!(taken < FILES, "`{}` takes everything", reader.name);
    }
    assert!(faults.is_empty(), "files that bring a reader down:\n{}", faults.join("\n"));
}
