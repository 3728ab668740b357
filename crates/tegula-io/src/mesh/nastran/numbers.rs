//! Numbers of Nastran.

/// A real number: it has a decimal point, and its exponent may begin with E, D or its sign, as in `7.0E-3`, `7.D-3` and `7.-3`.
pub fn real(text: &str) -> Option<f64> {
    let (sign, rest) = match text.strip_prefix('-') {
        Some(rest) => ("-", rest),
        None => ("", text.strip_prefix('+').unwrap_or(text)),
    };
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
    let (mantissa, exponent) = rest.split_at_checked(end)?;
    let points = mantissa.bytes().filter(|b| *b == b'.').count();
    if points != 1 || mantissa.len() < 2 {
        return None;
    }
    let exponent = match exponent.strip_prefix(['e', 'E', 'd', 'D']) {
        Some("") => return None,
        Some(digits) => digits,
        None => exponent,
    };
    let digits = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
    if !digits.bytes().all(|b| b.is_ascii_digit()) || (digits.is_empty() && !exponent.is_empty()) {
        return None;
    }
    let exponent = if exponent.is_empty() { "0" } else { exponent };
    format!("{sign}{mantissa}e{exponent}").parse().ok().filter(|x: &f64| x.is_finite())
}

/// A whole number.
pub fn integer(text: &str) -> Option<i64> {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let plain = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|_| plain)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{integer, real};

    #[test]
    fn real_numbers_have_a_point_and_any_exponent() {
        for (text, expected) in [
            ("1.+5", 1e5_f64),
            ("7.-3", 7e-3),
            ("1.0E+3", 1e3),
            ("1.D3", 1e3),
            ("1.d-3", 1e-3),
            ("-1.5", -1.5),
            ("+.7", 0.7),
            ("-.7E1", -7.0),
            ("210.", 210.0),
            ("0.0", 0.0),
            ("1.e3", 1e3),
            ("2.5-12", 2.5e-12),
        ] {
            assert_eq!(real(text).unwrap().to_bits(), expected.to_bits(), "{text}");
        }
        for text in [
            "1", "0", "1E3", "1+5", ".", "", "1.2.3", "1.E", "1.+", "1.5x", "nan", "inf", "1.E+", "1.0E999",
            "--1.", "1. 5", "E3", "1.-+3",
        ] {
            assert_eq!(real(text), None, "{text}");
        }
    }

    #[test]
    fn whole_numbers_have_no_point() {
        assert_eq!((integer("12"), integer("-1"), integer("+3")), (Some(12), Some(-1), Some(3)));
        for text in ["", "1.", "+", "1 2", "0x1", "99999999999999999999"] {
            assert_eq!(integer(text), None, "{text}");
        }
    }
}
