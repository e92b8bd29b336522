//! Values with units as people read them: degrees and millimetres.

use serde::Deserialize;

/// The SI unit of a value, as the verdict's JSON names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Unit {
    One,
    Second,
    Steps,
    Meter,
    MeterPerSecond,
    MeterPerSecond2,
    MeterPerSecond3,
    Radian,
    RadianPerSecond,
    RadianPerSecond2,
    RadianPerSecond3,
    Newton,
    NewtonMeter,
    /// A unit of a later version: its number is shown as it is.
    #[serde(other)]
    Unknown,
}

impl Unit {
    /// The unit for people, the factor from SI to it, and the usual number of digits after the point.
    fn shown(self, magnitude: f64) -> (&'static str, f64, usize) {
        const DEGREES: f64 = 180.0 / std::f64::consts::PI;
        let three_digits = match magnitude {
            m if m >= 100.0 => 0,
            m if m >= 10.0 => 1,
            _ => 2,
        };
        match self {
            Self::One => ("", 1.0, 3),
            Self::Second => (" s", 1.0, 3),
            Self::Steps => (" steps", 1.0, 0),
            Self::Meter => (" mm", 1e3, 2),
            Self::MeterPerSecond => (" mm/s", 1e3, 0),
            Self::MeterPerSecond2 => (" mm/s²", 1e3, 0),
            Self::MeterPerSecond3 => (" mm/s³", 1e3, 0),
            Self::Radian => ("°", DEGREES, 1),
            Self::RadianPerSecond => (" °/s", DEGREES, 0),
            Self::RadianPerSecond2 => (" °/s²", DEGREES, 0),
            Self::RadianPerSecond3 => (" °/s³", DEGREES, 0),
            Self::Newton => (" N", 1.0, three_digits),
            Self::NewtonMeter => (" N·m", 1.0, three_digits),
            Self::Unknown => ("", 1.0, 6),
        }
    }
}

/// What a value says about the true one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bound {
    /// It was met.
    None,
    /// The true one is not smaller; rounded down.
    Lower,
    /// The true one is not larger; rounded up.
    Upper,
}

/// Digits after the point beyond which a value and its limit are shown alike.
const MOST_DECIMALS: usize = 9;

/// A value and its limit, with as many digits as it takes for them to differ.
pub(crate) fn pair(value: Option<f64>, bound: Bound, limit: Option<f64>, unit: Unit) -> (String, String) {
    let largest = value.unwrap_or(0.0).abs().max(limit.unwrap_or(0.0).abs());
    let (symbol, factor, usual) = unit.shown(largest);
    let texts =
        |decimals| (number(value, bound, factor, decimals), number(limit, Bound::None, factor, decimals));
    let (mut value_text, mut limit_text) = texts(usual);
    for decimals in usual + 1..=MOST_DECIMALS {
        if value == limit || value_text != limit_text {
            break;
        }
        (value_text, limit_text) = texts(decimals);
    }
    let sign = match bound {
        _ if value.is_none() => "",
        Bound::None => "",
        Bound::Lower => "≥ ",
        Bound::Upper => "≤ ",
    };
    let with_symbol =
        |number: Option<String>| number.map_or("–".to_owned(), |number| format!("{number}{symbol}"));
    (format!("{sign}{}", with_symbol(value_text)), with_symbol(limit_text))
}

/// A value alone.
pub(crate) fn single(value: f64, bound: Bound, unit: Unit) -> String {
    pair(Some(value), bound, None, unit).0
}

fn number(value: Option<f64>, bound: Bound, factor: f64, decimals: usize) -> Option<String> {
    let shown = value? * factor;
    let scale = 10_f64.powi(i32::try_from(decimals).unwrap_or(0));
    let rounded = match bound {
        Bound::None => shown,
        Bound::Lower => (shown * scale).floor() / scale,
        Bound::Upper => (shown * scale).ceil() / scale,
    };
    Some(format!("{rounded:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_in_units_for_people_and_differ_when_they_differ() {
        let of = |value, limit, unit| pair(Some(value), Bound::None, Some(limit), unit);
        assert_eq!(of(0.004_069, 0.005, Unit::Meter), ("4.07 mm".into(), "5.00 mm".into()));
        assert_eq!(of(0.004_999_6, 0.005, Unit::Meter), ("4.9996 mm".into(), "5.0000 mm".into()));
        let (jerk, limit) = (41_505_f64.to_radians(), 40_000_f64.to_radians());
        assert_eq!(of(jerk, limit, Unit::RadianPerSecond3), ("41505 °/s³".into(), "40000 °/s³".into()));
        assert_eq!(of(0.0, 0.0, Unit::Steps), ("0 steps".into(), "0 steps".into()));
        assert_eq!(pair(None, Bound::Upper, None, Unit::Meter), ("–".into(), "–".into()));
    }

    #[test]
    fn bounds_are_rounded_outwards_and_have_a_sign() {
        assert_eq!(single(0.006_999, Bound::Lower, Unit::Meter), "≥ 6.99 mm");
        assert_eq!(single(10.61, Bound::Upper, Unit::NewtonMeter), "≤ 10.7 N·m");
    }
}
