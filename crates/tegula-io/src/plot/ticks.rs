//! Axes: positions and labels of the ticks.
//!
//! A tick is an integer times 1, 2 or 5 times a power of ten, and its label is printed from that integer, so no
//! label reads 0.30000000000000004. What all labels share, a power of ten or a large constant, is taken out and
//! printed once at the end of the axis.

/// Beyond this size values stand at the edge of the axis, so that differences and steps stay finite.
const LARGEST: f64 = 1e300;

/// A range of values mapped to the interval from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
    log: bool,
}

/// The ticks of an axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ticks {
    /// Places from 0 to 1 with their labels.
    pub major: Vec<(f64, String)>,
    /// Places of thinner grid lines.
    pub minor: Vec<f64>,
    /// Factor common to all labels, for example `×10⁻³`; empty if there is none.
    pub shared: String,
}

impl Axis {
    /// An axis over all values that can be shown on it, with a share of `padding` added at both ends.
    ///
    /// `None` if there is no such value. A single value gets some room around it.
    pub fn around(values: impl Iterator<Item = f64>, log: bool, padding: f64) -> Option<Self> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values.filter(|v| shown(*v, log)) {
            let value = if log { value.log10() } else { value.clamp(-LARGEST, LARGEST) };
            low = low.min(value);
            high = high.max(value);
        }
        if low > high {
            return None;
        }
        let size = low.abs().max(high.abs());
        let half = (high - low) / 2.0;
        let room = if half > 1e-13 * size && half > 1.0 / LARGEST {
            2.0 * padding * half
        } else if log {
            0.5
        } else if size > 0.0 {
            (0.1 * size).max(1.0 / LARGEST)
        } else {
            1.0
        };
        Some(Self { low: low - room, high: high + room, log })
    }

    /// Place of a value, from 0 to 1 within the axis; `None` if it cannot be shown.
    pub fn place(&self, value: f64) -> Option<f64> {
        let value = if self.log { value.log10() } else { value.clamp(-LARGEST, LARGEST) };
        shown(value, false).then(|| (value - self.low) / (self.high - self.low))
    }

    /// About `wanted` ticks, not many more.
    pub fn ticks(&self, wanted: usize) -> Ticks {
        if self.log { self.log_ticks(wanted.max(2)) } else { self.linear_ticks(wanted.max(2)) }
    }

    fn linear_ticks(&self, wanted: usize) -> Ticks {
        let (unit, exponent) = step((self.high - self.low) / wanted as f64);
        let width = f64::from(unit) * 10_f64.powi(exponent);
        let (first, last) =
            ((self.low / width - 1e-9).ceil() as i64, (self.high / width + 1e-9).floor() as i64);
        // In units of 10^exponent.
        let numbers: Vec<i64> =
            (first..=last).take(10 * wanted).map(|k| k.saturating_mul(i64::from(unit))).collect();
        let largest = numbers.iter().map(|n| n.unsigned_abs()).max().unwrap_or(0);
        let mut offset = 0;
        if largest > 99_999 {
            let block = numbers.iter().map(|n| n - numbers[0]).max().unwrap_or(1).max(1) as f64;
            let block = 10_i64.saturating_pow(block.log10().ceil() as u32);
            offset = numbers[0].div_euclid(block).saturating_mul(block);
        }
        let largest = numbers.iter().map(|n| n.saturating_sub(offset).unsigned_abs()).max().unwrap_or(0);
        let magnitude = exponent + (largest.max(1) as f64).log10().floor() as i32;
        let power = if (-3..5).contains(&magnitude) { 0 } else { 3 * magnitude.div_euclid(3) };
        let mut shared = String::new();
        if power != 0 {
            shared = format!("×10{}", superscript(power));
        }
        if offset != 0 {
            let constant = decimal(offset, exponent);
            let trimmed = constant.trim_end_matches('0').trim_end_matches('.');
            let constant = if constant.contains('.') { trimmed } else { &constant };
            let constant = constant.strip_prefix('-').map_or(format!("+ {constant}"), |c| format!("− {c}"));
            shared = if shared.is_empty() { constant } else { format!("{shared} {constant}") };
        }
        let major = numbers
            .iter()
            .map(|&n| {
                let place = (n as f64 * 10_f64.powi(exponent) - self.low) / (self.high - self.low);
                (place, decimal(n.saturating_sub(offset), exponent - power).replace('-', "−"))
            })
            .collect();
        Ticks { major, minor: Vec::new(), shared }
    }

    fn log_ticks(&self, wanted: usize) -> Ticks {
        let place = |exponent: f64| (exponent - self.low) / (self.high - self.low);
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let inside = |exponent: &f64| (self.low - 1e-9..=self.high + 1e-9).contains(exponent);
        let decades: Vec<i32> = (first..=last).filter(|&e| inside(&f64::from(e))).collect();
        let fractions: Vec<(u8, i32)> = (first..=last).flat_map(|e| (2..10).map(move |m| (m, e))).collect();
        let exponent = |m: u8, e: i32| f64::from(m).log10() + f64::from(e);

        let stride = decades.len().div_ceil(wanted).max(1) as i32;
        let plain = first >= -3 && last <= 4;
        let label = |m: u8, e: i32| match (plain, m) {
            (true, _) => decimal(i64::from(m), e),
            (false, 1) => format!("10{}", superscript(e)),
            (false, _) => format!("{m}·10{}", superscript(e)),
        };
        let mut named: Vec<(u8, i32)> =
            decades.iter().filter(|&&e| e.rem_euclid(stride) == 0).map(|&e| (1, e)).collect();
        if decades.len() < 3 {
            // Less than two decades: 2 and 5 get labels, and in a narrow range every digit does.
            let digits = |chosen: &[u8]| -> Vec<(u8, i32)> {
                let more = fractions.iter().filter(|(m, e)| chosen.contains(m) && inside(&exponent(*m, *e)));
                more.copied().chain(decades.iter().map(|&e| (1, e))).collect()
            };
            named = digits(&[2, 5]);
            if named.len() < 3 {
                named = digits(&[2, 3, 4, 5, 6, 7, 8, 9]);
            }
            if named.len() < 2 {
                return self.ticks_of_narrow_log(wanted);
            }
        }
        let major = named.iter().map(|&(m, e)| (place(exponent(m, e)), label(m, e))).collect();
        let minor = if stride > 1 {
            decades.iter().map(|&e| place(f64::from(e))).collect()
        } else if decades.len() <= 8 {
            let places = fractions.iter().map(|&(m, e)| exponent(m, e));
            places.filter(inside).map(place).collect()
        } else {
            Vec::new()
        };
        Ticks { major, minor, shared: String::new() }
    }

    /// A logarithmic axis so short that it is nearly linear.
    fn ticks_of_narrow_log(&self, wanted: usize) -> Ticks {
        let linear = Self { low: 10_f64.powf(self.low), high: 10_f64.powf(self.high), log: false };
        let mut ticks = linear.linear_ticks(wanted);
        for (place, _) in &mut ticks.major {
            let value = linear.low + *place * (linear.high - linear.low);
            *place = (value.log10() - self.low) / (self.high - self.low);
        }
        ticks
    }
}

/// Whether a value can be shown: finite, and positive on a logarithmic axis.
pub fn shown(value: f64, log: bool) -> bool {
    value.is_finite() && (!log || value > 0.0)
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `least`: the digit and the exponent.
fn step(least: f64) -> (u8, i32) {
    let exponent = least.log10().floor() as i32;
    let lead = least / 10_f64.powi(exponent);
    // The tolerance keeps a width of exactly 0.2 from becoming 0.5.
    let unit = [1_u8, 2, 5].into_iter().find(|&u| f64::from(u) >= lead * (1.0 - 1e-9));
    unit.map_or((1, exponent + 1), |u| (u, exponent))
}

/// The number n·10^exponent, written out from its digits.
fn decimal(n: i64, exponent: i32) -> String {
    let digits = n.unsigned_abs().to_string();
    let sign = if n < 0 { "-" } else { "" };
    if exponent >= 0 {
        let zeros = if n == 0 { 0 } else { exponent as usize };
        return format!("{sign}{digits}{}", "0".repeat(zeros));
    }
    let places = exponent.unsigned_abs() as usize;
    let padded = format!("{digits:0>width$}", width = places + 1);
    let (whole, fraction) = padded.split_at(padded.len() - places);
    format!("{sign}{whole}.{fraction}")
}

/// A small raised integer.
fn superscript(n: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '0' | '4'..='9' => char::from_u32(0x2070 + c as u32 - '0' as u32).unwrap_or(c),
        c => c,
    };
    n.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(values: &[f64], log: bool) -> (Vec<String>, String) {
        let ticks = Axis::around(values.iter().copied(), log, 0.0).unwrap().ticks(6);
        (ticks.major.into_iter().map(|t| t.1).collect(), ticks.shared)
    }

    #[test]
    fn labels_are_what_a_person_would_write() {
        let plain = |values: &[f64]| {
            let (labels, shared) = labels(values, false);
            assert_eq!(shared, "");
            labels.join(" ")
        };
        assert_eq!(plain(&[0.0, 0.6]), "0.0 0.1 0.2 0.3 0.4 0.5 0.6");
        assert_eq!(plain(&[-3.0, 3.0]), "−3 −2 −1 0 1 2 3");
        assert_eq!(plain(&[0.0, 12000.0]), "0 2000 4000 6000 8000 10000 12000");
        assert_eq!(plain(&[0.012, 0.031]), "0.015 0.020 0.025 0.030");
        let (small, shared) = labels(&[0.0, 3e-7], false);
        assert_eq!((small.join(" ").as_str(), shared.as_str()), ("0 50 100 150 200 250 300", "×10⁻⁹"));
        let (large, shared) = labels(&[0.0, 2.1e11], false);
        assert_eq!((large.join(" ").as_str(), shared.as_str()), ("0 50 100 150 200", "×10⁹"));
        let (drift, shared) = labels(&[1.234567, 1.234569], false);
        assert_eq!(shared, "×10⁻⁶ + 1.23456", "{drift:?}");
    }

    #[test]
    fn logarithmic_labels() {
        assert_eq!(labels(&[1e-12, 1.0], true).0.join(" "), "10⁻¹² 10⁻⁹ 10⁻⁶ 10⁻³ 10⁰");
        assert_eq!(labels(&[0.01, 100.0], true).0.join(" "), "0.01 0.1 1 10 100");
        assert_eq!(labels(&[4.0, 64.0], true).0.join(" "), "5 20 50 10");
        assert_eq!(labels(&[2.001, 2.002], true).0[0].len(), labels(&[2.001, 2.002], true).0[1].len());
    }

    #[test]
    fn odd_values_are_left_out_and_single_ones_get_room() {
        assert!(Axis::around([f64::NAN, f64::INFINITY].into_iter(), false, 0.0).is_none());
        assert!(Axis::around([0.0, -1.0].into_iter(), true, 0.0).is_none());
        for value in [0.0, 5.0, -1e-300, 1e300, f64::MAX, f64::MIN_POSITIVE] {
            let axis = Axis::around([value, f64::NAN].into_iter(), false, 0.05).unwrap();
            let place = axis.place(value).unwrap();
            assert!((0.0..=1.0).contains(&place), "{value}: {place}");
            let _ = axis.ticks(6);
        }
        let axis = Axis::around([f64::MAX, f64::MIN].into_iter(), false, 0.05);
        assert!(axis.is_none_or(|a| a.ticks(6).major.len() < 60));
        let axis = Axis::around([0.0, 10.0, -1.0].into_iter(), true, 0.0).unwrap();
        assert_eq!(axis.place(0.0), None);
    }

    proptest! {
        #[test]
        fn ticks_lie_on_the_axis_and_are_few(a in -1e12..1e12_f64, width in 1e-9..1e9_f64, log in any::<bool>()) {
            let values = if log { [a.abs() + 1e-9, a.abs() + 1e-9 + width] } else { [a, a + width] };
            let ticks = Axis::around(values.into_iter(), log, 0.05).unwrap().ticks(6);
            prop_assert!(ticks.major.len() <= 12 , "{:?}", ticks);
            prop_assert!(ticks.major.iter().all(|t| (-1e-6..=1.0 + 1e-6).contains(&t.0)), "{:?}", ticks);
            prop_assert!(ticks.major.iter().all(|t| t.1.chars().count() <= 12), "{:?}", ticks);
        }
    }
}
