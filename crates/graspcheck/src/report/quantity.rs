//! Values with units as people read them: degrees and millimetres, with as many digits as matter.

use graspcheck_verify::Unit;

/// How a value that is not exact is rounded when it is shortened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// To the nearest, for values that were met.
    Nearest,
    /// Downwards, for lower bounds.
    Down,
    /// Upwards, for upper bounds.
    Up,
}

/// Digits after the point beyond which two values that differ are shown as they are, equal or not.
const MOST_DECIMALS: usize = 9;

/// The unit for people, the factor from SI to it, and the usual number of digits after the point.
fn display(unit: Unit, magnitude: f64) -> (&'static str, f64, usize) {
    const DEG: f64 = 180.0 / std::f64::consts::PI;
    // Three digits for forces and torques, whatever their size.
    let three_digits = match magnitude {
        m if m >= 100.0 => 0,
        m if m >= 10.0 => 1,
        _ => 2,
    };
    match unit {
        Unit::One => ("", 1.0, 3),
        Unit::Count => ("", 1.0, 0),
        Unit::Second => ("s", 1.0, 3),
        Unit::Steps => ("steps", 1.0, 0),
        Unit::Meter => ("mm", 1e3, 2),
        Unit::MeterPerSecond => ("mm/s", 1e3, 0),
        Unit::MeterPerSecond2 => ("mm/s²", 1e3, 0),
        Unit::MeterPerSecond3 => ("mm/s³", 1e3, 0),
        Unit::Radian => ("°", DEG, 1),
        Unit::RadianPerSecond => ("°/s", DEG, 0),
        Unit::RadianPerSecond2 => ("°/s²", DEG, 0),
        Unit::RadianPerSecond3 => ("°/s³", DEG, 0),
        Unit::Newton => ("N", 1.0, three_digits),
        Unit::NewtonMeter => ("N·m", 1.0, three_digits),
        Unit::Joule => ("J", 1.0, three_digits),
    }
}

/// A number with this many digits after the point.
fn rounded(value: f64, decimals: usize, rounding: Rounding) -> String {
    let scale = 10_f64.powi(i32::try_from(decimals).unwrap_or(0));
    let shortened = match rounding {
        Rounding::Nearest => value,
        Rounding::Down => (value * scale).floor() / scale,
        Rounding::Up => (value * scale).ceil() / scale,
    };
    let text = format!("{shortened:.decimals$}");
    // A value that rounds to nothing has no sign.
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| c == '0' || c == '.') => digits.to_owned(),
        _ => text,
    }
}

fn with_unit(number: &str, symbol: &str) -> String {
    match symbol {
        "" => number.to_owned(),
        s if s.starts_with('°') && s.len() == "°".len() => format!("{number}°"),
        s => format!("{number} {s}"),
    }
}

/// A value in the unit for people.
#[must_use]
pub fn quantity(value: f64, unit: Unit, rounding: Rounding) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let (symbol, factor, decimals) = display(unit, value.abs());
    with_unit(&telling(value * factor, decimals, rounding), symbol)
}

/// A number with this many digits after the point, or with more where it would read as zero and is not.
fn telling(value: f64, usual: usize, rounding: Rounding) -> String {
    let tells = |text: &String| value == 0.0 || text.chars().any(|c| ('1'..='9').contains(&c));
    let shown = (usual..=MOST_DECIMALS).map(|decimals| rounded(value, decimals, rounding)).find(tells);
    shown.unwrap_or_else(|| rounded(value, usual, rounding))
}

/// A value and its limit in the unit for people, with as many digits as it takes for them to differ, and in
/// the right order.
#[must_use]
pub fn against(value: f64, limit: f64, unit: Unit, rounding: Rounding) -> (String, String) {
    match Shown::new(value, limit, unit, rounding) {
        Some(shown) => (with_unit(&shown.value, shown.symbol), with_unit(&shown.limit, shown.symbol)),
        None => (quantity(value, unit, rounding), quantity(limit, unit, Rounding::Nearest)),
    }
}

/// The room between a value and its limit, with its sign, as [`against`] shows both: the difference of the
/// numbers that are read. It is never zero where they differ.
///
/// `room` is the margin itself, SI; where it is not what value and limit differ by, it is shown as by
/// [`margin`].
#[must_use]
pub(super) fn margin_between(value: f64, limit: f64, room: f64, unit: Unit, rounding: Rounding) -> String {
    let is_difference = ((value - limit).abs() - room.abs()).abs() <= 1e-9 * room.abs();
    let Some(shown) = Shown::new(value, limit, unit, rounding).filter(|shown| is_difference && shown.differ)
    else {
        return margin(room, false, unit);
    };
    let difference = (as_read(&shown.value) - as_read(&shown.limit)).abs();
    let sign = if room < 0.0 { "-" } else { "+" };
    with_unit(&format!("{sign}{difference:.*}", shown.decimals), shown.symbol)
}

/// A value and its limit as digits.
struct Shown {
    value: String,
    limit: String,
    symbol: &'static str,
    decimals: usize,
    differ: bool,
}

impl Shown {
    /// None when one is not finite.
    fn new(value: f64, limit: f64, unit: Unit, rounding: Rounding) -> Option<Self> {
        if !(value.is_finite() && limit.is_finite()) {
            return None;
        }
        let (symbol, factor, usual) = display(unit, value.abs().max(limit.abs()));
        let (value, limit) = (value * factor, limit * factor);
        let are_equal = (value - limit).abs() <= f64::EPSILON * limit.abs();
        let mut decimals = usual;
        loop {
            let (v, l) = (rounded(value, decimals, rounding), rounded(limit, decimals, Rounding::Nearest));
            let differ = v != l;
            let in_order = || (as_read(&v) < as_read(&l)) == (value < limit);
            // A limit that is not zero does not read as zero.
            let tells = || limit == 0.0 || as_read(&l).abs() > 0.0;
            if are_equal || (differ && in_order() && tells()) || decimals >= MOST_DECIMALS {
                return Some(Self { value: v, limit: l, symbol, decimals, differ });
            }
            decimals += 1;
        }
    }
}

/// The number that was written.
fn as_read(digits: &str) -> f64 {
    digits.parse().expect("a finite number was written with digits")
}

/// A margin with its sign: a share of the limit in percent, or a length, angle or count in its unit.
///
/// Room that is left is never shown larger than it is. An excess is shown to the nearest, and never as
/// nothing.
#[must_use]
pub fn margin(value: f64, is_share: bool, unit: Unit) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    let (symbol, factor, usual) = if is_share { ("%", 100.0, 1) } else { display(unit, value.abs()) };
    if value >= 0.0 {
        return with_unit(&format!("+{}", telling(value * factor, usual, Rounding::Down)), symbol);
    }
    let excess = |decimals| rounded(value * factor, decimals, Rounding::Nearest);
    let tells = |decimals: &usize| excess(*decimals).starts_with('-');
    match (usual..=MOST_DECIMALS).find(tells) {
        Some(decimals) => with_unit(&excess(decimals), symbol),
        None => format!("-{:.1e} {symbol}", -value * factor).trim_end().to_owned(),
    }
}

/// An instant, s.
#[must_use]
pub fn instant(t: f64) -> String {
    format!("{t:.3} s")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_millimetres_and_angles_degrees() {
        assert_eq!(quantity(0.004_069, Unit::Meter, Rounding::Nearest), "4.07 mm");
        assert_eq!(quantity(std::f64::consts::PI, Unit::Radian, Rounding::Nearest), "180.0°");
        assert_eq!(quantity(9.0_f64.to_radians(), Unit::RadianPerSecond, Rounding::Nearest), "9 °/s");
        assert_eq!(quantity(3500.0, Unit::NewtonMeter, Rounding::Nearest), "3500 N·m");
        assert_eq!(quantity(10.63, Unit::NewtonMeter, Rounding::Up), "10.7 N·m");
    }

    #[test]
    fn what_is_not_zero_does_not_read_as_zero() {
        assert_eq!(margin(0.000_93, false, Unit::MeterPerSecond), "+0.9 mm/s");
        assert_eq!(margin(0.000_4, true, Unit::One), "+0.04 %");
        assert_eq!(quantity(0.000_93, Unit::MeterPerSecond, Rounding::Down), "0.9 mm/s");
        assert_eq!(quantity(2e-6, Unit::Meter, Rounding::Nearest), "0.002 mm");
        assert_eq!(quantity(0.0, Unit::Meter, Rounding::Nearest), "0.00 mm");
        let (force, limit) = against(22.859, 0.01, Unit::Newton, Rounding::Nearest);
        assert_eq!((force.as_str(), limit.as_str()), ("22.86 N", "0.01 N"));
    }

    #[test]
    fn bounds_round_outwards() {
        assert_eq!(quantity(0.006_999, Unit::Meter, Rounding::Down), "6.99 mm");
        assert_eq!(quantity(0.006_991, Unit::Meter, Rounding::Up), "7.00 mm");
    }

    #[test]
    fn value_and_limit_have_digits_enough_to_differ() {
        let (value, limit) = against(0.004_999_6, 0.005, Unit::Meter, Rounding::Nearest);
        assert_eq!((value.as_str(), limit.as_str()), ("4.9996 mm", "5.0000 mm"));
        let (value, limit) = against(0.005, 0.005, Unit::Meter, Rounding::Nearest);
        assert_eq!((value.as_str(), limit.as_str()), ("5.00 mm", "5.00 mm"));
    }

    #[test]
    fn margins_carry_a_sign_and_never_flatter() {
        assert_eq!(margin(0.1, true, Unit::One), "+10.0 %");
        assert_eq!(margin(0.0999, true, Unit::One), "+9.9 %");
        assert_eq!(margin(0.001_999, false, Unit::Meter), "+1.99 mm");
        assert_eq!(margin(0.0, false, Unit::Meter), "+0.00 mm");
    }

    #[test]
    fn an_excess_is_shown_to_the_nearest_and_never_as_nothing() {
        assert_eq!(margin(-0.0376, true, Unit::One), "-3.8 %");
        assert_eq!(margin(-0.0371, true, Unit::One), "-3.7 %");
        assert_eq!(margin(-0.000_931, false, Unit::Meter), "-0.93 mm");
        assert_eq!(margin(-1e-5, true, Unit::One), "-0.001 %");
        assert_eq!(margin(-4e-9, false, Unit::Meter), "-0.000004 mm");
        assert_eq!(margin(-1e-15, false, Unit::Meter), "-1.0e-12 mm");
        assert_eq!(margin(-1.0, false, Unit::Steps), "-1 steps");
    }

    /// Value, limit and margin as they are printed.
    fn printed(value: f64, limit: f64, room: f64, unit: Unit, rounding: Rounding) -> [String; 3] {
        let (shown, held) = against(value, limit, unit, rounding);
        [shown, held, margin_between(value, limit, room, unit, rounding)]
    }

    #[test]
    fn value_limit_and_margin_agree_as_they_are_read() {
        let angle = 86.04_f64.to_radians();
        let limit = 85.0_f64.to_radians();
        assert_eq!(
            printed(angle, limit, limit - angle, Unit::Radian, Rounding::Nearest),
            ["86.0°", "85.0°", "-1.0°"]
        );
        let (value, limit) = (0.005_004, 0.005_996);
        assert_eq!(
            printed(value, limit, value - limit, Unit::Meter, Rounding::Nearest),
            ["5.00 mm", "6.00 mm", "-1.00 mm"]
        );
        // A failure by 2 nm is told apart, and by how much.
        assert_eq!(
            printed(0.004_999_998, 0.005, -2e-9, Unit::Meter, Rounding::Nearest),
            ["4.999998 mm", "5.000000 mm", "-0.000002 mm"]
        );
        // Rounded down, 5.006 would fall below 5.0055.
        assert_eq!(
            printed(0.005_006, 0.005_005_5, 5e-7, Unit::Meter, Rounding::Down),
            ["5.0060 mm", "5.0055 mm", "+0.0005 mm"]
        );
        assert_eq!(
            printed(-0.0005, -0.0005, 0.0, Unit::Meter, Rounding::Nearest),
            ["-0.50 mm", "-0.50 mm", "+0.00 mm"]
        );
        let limit = f64::NAN;
        assert_eq!(printed(1.0, limit, limit, Unit::Meter, Rounding::Nearest)[2], "NaN");
    }

    #[test]
    fn what_is_not_finite_is_shown_as_such() {
        assert_eq!(quantity(f64::NAN, Unit::Meter, Rounding::Nearest), "NaN");
        assert_eq!(margin(f64::INFINITY, false, Unit::Meter), "inf");
    }
}
