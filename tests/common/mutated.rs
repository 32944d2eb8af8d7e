//! Mutated copies of small valid files, for tests that a reader gives an error and never panics.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;

use super::random::Random;

/// Number of mutated files for each reader if `STREAKCAST_MUTATIONS` is not set.
const DEFAULT_RUNS: u64 = 300;
/// Largest length of an error, characters. Errors are for people; they must not repeat a file.
const LONGEST_ERROR: usize = 2000;
/// Largest size of a mutated file, bytes. Repeated ranges would double it with each mutation.
const LARGEST_FILE: usize = 1 << 18;

/// Texts that are special in one format or another.
const TOKENS: [&str; 40] = [
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "99999999999999999999",
    "-1",
    "0",
    "2147483648",
    "\0",
    "\u{feff}",
    "\u{e9}",
    "\u{1f6f0}",
    "\r\n",
    "\n\n",
    "\"",
    "'",
    "<",
    ">",
    "&",
    "]]>",
    "{",
    "}",
    "[",
    "]",
    ",",
    ";",
    ":",
    "=",
    "#",
    "!",
    "%",
    "\t",
    "null",
    "true",
    "\\u0000",
    "&#0;",
    "END",
    "1 ",
];

/// Function that reads a file and returns its error.
pub type Read<'a> = dyn Fn(&[u8]) -> Result<(), String> + Sync + 'a;

/// Reader under test: its name, valid files, and a function that returns the error of a file.
pub struct Reader<'a> {
    pub name: &'static str,
    pub seeds: Vec<Vec<u8>>,
    pub read: Box<Read<'a>>,
}

impl Reader<'_> {
    /// Returns the mutated file with a number; the same file for the same number.
    fn mutant(&self, number: u64) -> Vec<u8> {
        let mut random = Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d));
        let mut bytes = self.seeds[below(&mut random, self.seeds.len())].clone();
        for _ in 0..=below(&mut random, 8) {
            mutate(&mut bytes, &mut random);
        }
        bytes
    }

    /// Reads mutated files: `STREAKCAST_MUTATIONS` of them, or else a few hundred.
    ///
    /// # Panics
    /// A valid file is rejected, a reader panics, or an error is empty or very long.
    pub fn check(&self) {
        for (index, seed) in self.seeds.iter().enumerate() {
            (self.read)(seed).unwrap_or_else(|error| panic!("{}: valid file {index} is rejected: {error}", self.name));
        }
        let runs = match std::env::var("STREAKCAST_MUTATIONS") {
            Ok(text) => text.parse().expect("STREAKCAST_MUTATIONS is a number"),
            Err(_) => DEFAULT_RUNS,
        };
        let outcome = |number: u64| -> Result<bool, String> {
            let bytes = self.mutant(number);
            match catch_unwind(AssertUnwindSafe(|| (self.read)(&bytes))) {
                Ok(Ok(())) => Ok(true),
                Ok(Err(error)) if !error.is_empty() && error.chars().count() <= LONGEST_ERROR => Ok(false),
                Ok(Err(error)) => Err(format!("file {number} has an error of {} characters: {error}", error.len())),
                Err(_) => Err(format!("file {number} makes the reader panic")),
            }
        };
        let outcomes: Vec<Result<bool, String>> = (0..runs).into_par_iter().map(outcome).collect();
        let accepted = outcomes.iter().filter(|one| **one == Ok(true)).count();
        let findings: Vec<&String> = outcomes.iter().filter_map(|one| one.as_ref().err()).take(5).collect();
        println!("{}: {runs} mutated files, {accepted} of them accepted", self.name);
        assert!(findings.is_empty(), "{}: {findings:#?}", self.name);
    }
}

/// Returns a number from 0 to `end` - 1; 0 if `end` is 0.
fn below(random: &mut Random, end: usize) -> usize {
    (random.uniform() * end as f64) as usize
}

fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    let at = below(random, bytes.len());
    // Most ranges are short.
    let scale = 1 << below(random, 9);
    let length = below(random, scale).min(bytes.len() - at);
    let range = at..at + length;
    match below(random, 8) {
        0 if !bytes.is_empty() => bytes[at] ^= 1 << below(random, 8),
        1 if !bytes.is_empty() => bytes[at] = below(random, 256) as u8,
        2 => drop(bytes.drain(range)),
        3 => bytes.truncate(at),
        4 | 5 => {
            let token = TOKENS[below(random, TOKENS.len())].bytes();
            drop(bytes.splice(at..at + below(random, 2).min(length), token));
        }
        6 if bytes.len() < LARGEST_FILE => {
            let copy = bytes[range].to_vec();
            let to = below(random, bytes.len() + 1);
            drop(bytes.splice(to..to, copy));
        }
        _ => {
            // A number is replaced, because most limits are limits of numbers.
            let is_digit = |byte: &u8| byte.is_ascii_digit();
            let Some(from) = bytes[at..].iter().position(is_digit).map(|from| at + from) else { return };
            let until = bytes[from..].iter().position(|byte| !is_digit(byte)).map_or(bytes.len(), |end| from + end);
            drop(bytes.splice(from..until, TOKENS[below(random, 10)].bytes()));
        }
    }
}
