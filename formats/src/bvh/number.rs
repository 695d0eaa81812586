//! Decimal numbers of a motion block: correctly rounded, and fast.
//!
//! In: bytes at a position. Out: the value and where it ends. Grammar: optional sign, digits with an
//! optional point (at least one digit), optional exponent. No `nan`, no `inf`, no hexadecimal.
//!
//! Digits gather in an integer mantissa m; the value is m·10^e. When m < 2⁵³ and |e| ≤ 22 both m and
//! 10^|e| are exact doubles, so one multiplication or division rounds once and is correct
//! [Clinger 1990]. Anything else goes to the standard library, which is correct and slower.
//!
//! [Clinger 1990] W. D. Clinger. How to read floating point numbers accurately. PLDI 1990.

const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// Digits a `u64` holds whatever they are.
const MAX_DIGITS: usize = 19;

/// The number that starts at `at`, and the position after it; `None` if there is none.
///
/// The caller checks what follows it. May return an infinity for an exponent out of range.
#[inline]
pub(super) fn scan(text: &[u8], at: usize) -> Option<(f64, usize)> {
    let mut i = at;
    let mut negative = false;
    if let Some(&c @ (b'-' | b'+')) = text.get(i) {
        negative = c == b'-';
        i += 1;
    }
    let mut mantissa = 0u64;
    let whole_at = i;
    while let Some(&c) = text.get(i) {
        let digit = c.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        i += 1;
    }
    let mut digits = i - whole_at;
    let mut exponent = 0i64;
    if text.get(i) == Some(&b'.') {
        i += 1;
        let fraction_at = i;
        while let Some(&c) = text.get(i) {
            let digit = c.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
            i += 1;
        }
        digits += i - fraction_at;
        exponent = -((i - fraction_at) as i64);
    }
    if digits == 0 {
        return None;
    }
    if let Some(b'e' | b'E') = text.get(i) {
        let (shown, end) = scan_exponent(text, i + 1)?;
        exponent += shown;
        i = end;
    }
    if digits <= MAX_DIGITS && mantissa < 1 << 53 && exponent.abs() <= 22 {
        let m = mantissa as f64;
        let p = POW10[exponent.unsigned_abs() as usize];
        let value = if exponent < 0 { m / p } else { m * p };
        return Some((if negative { -value } else { value }, i));
    }
    // The slice matches the grammar, which is a subset of what the standard library reads.
    let value = std::str::from_utf8(&text[at..i]).ok()?.parse().ok()?;
    Some((value, i))
}

/// Signed exponent digits; clamped far beyond any double so that the sum cannot overflow.
#[cold]
fn scan_exponent(text: &[u8], at: usize) -> Option<(i64, usize)> {
    let mut i = at;
    let negative = text.get(i) == Some(&b'-');
    if let Some(b'-' | b'+') = text.get(i) {
        i += 1;
    }
    let digits_at = i;
    let mut value = 0i64;
    while let Some(c) = text.get(i).filter(|c| c.is_ascii_digit()) {
        value = (value * 10 + i64::from(c - b'0')).min(1 << 40);
        i += 1;
    }
    (i > digits_at).then_some((if negative { -value } else { value }, i))
}

#[cfg(test)]
mod tests {
    use super::scan;
    use proptest::prelude::*;

    fn same_as_std(text: &str) {
        let (value, end) = scan(text.as_bytes(), 0).unwrap_or_else(|| panic!("{text}"));
        assert_eq!(end, text.len(), "{text}");
        assert_eq!(value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{text}");
    }

    #[test]
    fn chosen_numbers_have_the_bits_of_std() {
        for text in [
            "0",
            "-0",
            "+0.0",
            "1",
            ".35e1",
            "5.",
            "-5.",
            "+1.0E+00",
            "2e0",
            "0.1",
            "1e22",
            "1e23",
            "1e-22",
            "1e-23",
            "9007199254740991",
            "9007199254740992",
            "9007199254740993",
            "123456789012345678901234567890",
            "0.000000000000000000000000000001",
            "1.7976931348623157e308",
            "4.9e-324",
            "1e-400",
            "1e400",
            "2.2250738585072011e-308",
            "00000000000000000000000000001.5",
            "179.999999999999999999999",
            "1e99999999999999999999",
            "1e-99999999999999999999",
            "18446744073709551616.0",
        ] {
            same_as_std(text);
        }
    }

    #[test]
    fn what_is_no_number_is_none() {
        for text in ["", "-", "+", ".", "-.", "e5", "nan", "inf", "--1", "1e", "1e+", "x"] {
            assert_eq!(scan(text.as_bytes(), 0), None, "{text}");
        }
    }

    #[test]
    fn numbers_of_the_mocap_files_have_the_bits_of_std() {
        let mut seen = 0;
        for folder in ["mocap/bvh", "mocap/cgspeed", "bvh-zoo"] {
            for path in support::files(&support::shared(folder), "bvh") {
                let text = String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
                let at = text.find("Frame Time:").unwrap();
                for word in text[at..].split_whitespace().skip(2) {
                    same_as_std(word);
                    seen += 1;
                }
            }
        }
        assert!(seen > 1_000_000, "{seen}");
    }

    proptest! {
        #[test]
        fn any_decimal_has_the_bits_of_std(text in "[+-]?[0-9]{0,22}\\.[0-9]{1,22}([eE][+-]?[0-9]{1,3})?") {
            same_as_std(&text);
        }

        #[test]
        fn any_double_comes_back(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            same_as_std(&format!("{value:e}"));
        }
    }
}
