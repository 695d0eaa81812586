//! Mutations: whole files broken in the ways in which files break, and in a few that only an enemy thinks of.
//!
//! In: seeds and a number. Out: bytes; the same for the same seeds and number, on every machine.

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Numbers at the edges of what readers expect.
const NUMBERS: &[&str] = &[
    "0",
    "-0",
    "-1",
    "1",
    "2",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "inf",
    "-inf",
    "1e150",
    "4294967296",
    "99999999999999999999",
    "0.0000001",
    "1.0.0",
    "0x10",
    "",
];

/// Texts that mean something to one reader or another.
const WORDS: &[&str] = &[
    "\0",
    "\u{feff}",
    "\r",
    "\n",
    "\t",
    " ",
    "<",
    ">",
    "\"",
    "'",
    "&",
    "{",
    "}",
    "(",
    ")",
    "[",
    "]",
    ",",
    ":",
    "<!--",
    "-->",
    "..",
    "JOINT",
    "ROOT",
    "End Site",
    "CHANNELS",
    "MOTION",
    "Frames:",
    "\u{10ffff}",
    "é",
    "/dev/zero",
    "name",
    "#",
    "//",
    "/*",
];

/// Breaks files.
pub struct Mutator {
    seeds: Vec<Vec<u8>>,
    random: Pcg64,
}

impl Mutator {
    /// Of whole files.
    ///
    /// # Panics
    /// Without any.
    pub fn new(seeds: Vec<Vec<u8>>, seed: u64) -> Self {
        assert!(!seeds.is_empty(), "no seeds to mutate");
        Self { seeds, random: Pcg64::seed_from_u64(seed) }
    }

    /// The next broken file: a seed after one to six changes.
    pub fn next_file(&mut self) -> Vec<u8> {
        let mut file = self.pick();
        for _ in 0..self.random.random_range(1..=6) {
            self.change(&mut file);
        }
        file
    }

    fn pick(&mut self) -> Vec<u8> {
        self.seeds.choose(&mut self.random).cloned().unwrap_or_default()
    }

    fn change(&mut self, file: &mut Vec<u8>) {
        let at = self.random.random_range(0..=file.len());
        let end = (at + self.length()).min(file.len());
        match self.random.random_range(0..9) {
            0 if at < file.len() => file[at] ^= 1 << self.random.random_range(0..8),
            1 => drop(file.drain(at..end)),
            2 => {
                let part = file[at..end].to_vec();
                for _ in 0..self.random.random_range(1..8) {
                    file.splice(at..at, part.iter().copied());
                }
            }
            3 => file.truncate(at),
            4 => self.number(file, at),
            5 | 6 => {
                let word = WORDS.choose(&mut self.random).copied().unwrap_or_default();
                file.splice(at..at, word.bytes());
            }
            7 => {
                let other = self.pick();
                let from = self.random.random_range(0..=other.len());
                let to = (from + self.length()).min(other.len());
                file.splice(at..end, other[from..to].iter().copied());
            }
            _ => self.swap_lines(file),
        }
    }

    /// Short more often than long.
    fn length(&mut self) -> usize {
        1 << self.random.random_range(0..11)
    }

    /// Another number in the place of the one after `at`.
    fn number(&mut self, file: &mut Vec<u8>, at: usize) {
        let part_of = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+' | b'e');
        let Some(from) = file[at..].iter().position(u8::is_ascii_digit).map(|k| at + k) else { return };
        let to = file[from..].iter().position(|b| !part_of(b)).map_or(file.len(), |k| from + k);
        let number = NUMBERS.choose(&mut self.random).copied().unwrap_or_default();
        file.splice(from..to, number.bytes());
    }

    fn swap_lines(&mut self, file: &mut Vec<u8>) {
        let mut lines: Vec<&[u8]> = file.split_inclusive(|b| *b == b'\n').collect();
        if lines.is_empty() {
            return;
        }
        let (a, b) = (self.random.random_range(0..lines.len()), self.random.random_range(0..lines.len()));
        lines.swap(a, b);
        *file = lines.concat();
    }
}
