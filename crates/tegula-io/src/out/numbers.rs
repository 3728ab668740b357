//! Formatting of numbers for readers: the console and reports.

/// A number with at most `digits` significant digits, without trailing zeros; with an exponent where it is very
/// large or small.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{}", x + 0.0);
    }
    let scientific = format!("{x:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let plain = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if (-4..7).contains(&exponent) {
        let decimals = usize::try_from(digits as i64 - 1 - i64::from(exponent)).unwrap_or(0);
        plain(&format!("{x:.decimals$}"))
    } else {
        format!("{}e{exponent}", plain(mantissa))
    }
}

/// A count in groups of three digits.
pub fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push(' ');
        }
        out.push(digit);
    }
    out
}

/// A count with its noun, in the plural unless it is 1.
pub fn counted(count: u64, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", grouped(usize::try_from(count).unwrap_or(usize::MAX)))
}

/// A time in seconds, minutes or hours.
pub fn duration(seconds: f64) -> String {
    let whole = seconds as u64;
    match whole {
        0..10 => format!("{} s", significant(seconds, 2)),
        10..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_say_something() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (0.1 + 0.2, "0.3"),
            (-1234.5678, "-1234.57"),
            (123_456.0, "123456"),
            (1_234_567.0, "1234567"),
            (12_345_678.0, "1.23457e7"),
            (0.000_123_456_7, "0.000123457"),
            (1.5e-7, "1.5e-7"),
            (999_999.9, "1000000"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ];
        for (x, text) in cases {
            assert_eq!(significant(x, 6), text);
        }
        assert_eq!([7, 1234, 24_960, 1_234_567].map(grouped), ["7", "1234", "24 960", "1 234 567"]);
        assert_eq!(counted(1, "step") + ", " + &counted(2, "step"), "1 step, 2 steps");
    }

    #[test]
    fn times_are_said_in_words() {
        let words = [0.0123, 5.04, 65.0, 3700.0].map(duration);
        assert_eq!(words, ["0.012 s", "5 s", "1 min 05 s", "1 h 01 min"]);
    }
}
