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

/// A value and its limit, with as many digits as it takes for them to differ.
pub(crate) fn pair(value: Option<f64>, limit: Option<f64>, unit: Unit) -> (String, String) {
    const MOST_DECIMALS: usize = 9;
    let largest = value.unwrap_or(0.0).abs().max(limit.unwrap_or(0.0).abs());
    let (symbol, factor, mut decimals) = unit.shown(largest);
    let text = |number: Option<f64>, decimals: usize| match number {
        Some(number) => format!("{:.decimals$}{symbol}", number * factor),
        None => "–".to_owned(),
    };
    while value != limit && text(value, decimals) == text(limit, decimals) && decimals < MOST_DECIMALS {
        decimals += 1;
    }
    (text(value, decimals), text(limit, decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_in_units_for_people_and_differ_when_they_differ() {
        let of = |value, limit, unit| pair(Some(value), Some(limit), unit);
        assert_eq!(of(0.004_069, 0.005, Unit::Meter), ("4.07 mm".into(), "5.00 mm".into()));
        assert_eq!(of(0.004_999_6, 0.005, Unit::Meter), ("4.9996 mm".into(), "5.0000 mm".into()));
        let (jerk, limit) = (41_505_f64.to_radians(), 40_000_f64.to_radians());
        assert_eq!(of(jerk, limit, Unit::RadianPerSecond3), ("41505 °/s³".into(), "40000 °/s³".into()));
        assert_eq!(pair(Some(10.6), None, Unit::NewtonMeter), ("10.6 N·m".into(), "–".into()));
        assert_eq!(of(0.0, 0.0, Unit::Steps), ("0 steps".into(), "0 steps".into()));
    }
}
