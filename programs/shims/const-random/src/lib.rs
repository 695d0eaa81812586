//! Fixed numbers in place of random ones, for the hash seeds that ahash draws at compile time.
//!
//! The package of this name draws other numbers in every build, and is made with code under a licence that this project
//! does not take. Hashes of the language rhai are of the names in a program, which the person who runs it wrote: there
//! is nobody to defend against. `[patch.crates-io]` of the workspace puts this package in its place.

/// A number of the type asked for; another one at every place of a file.
#[macro_export]
macro_rules! const_random {
    ($t:ty) => {
        // an odd multiplier spreads neighbouring places over all bits
        ((line!() as u64 * 65_537 + column!() as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)) as $t
    };
}
