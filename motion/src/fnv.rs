//! FNV-1a, 64 bits: one number for many bytes, the same on every machine. It tells inputs apart; it keeps no secrets.

/// A running hash (Fowler, Noll, Vo; variant 1a).
///
/// # Examples
/// ```
/// let mut hash = motion::Fnv::default();
/// hash.bytes(b"foo");
/// hash.bytes(b"bar");
/// assert_eq!(hash.value(), 0x8594_4171_f739_67e8);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// Adds bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.0 = (self.0 ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The hash of all bytes so far.
    pub fn value(&self) -> u64 {
        self.0
    }
}
