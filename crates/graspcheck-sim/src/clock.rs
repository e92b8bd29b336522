//! The time base: whole nanoseconds.

use crate::error::SimError;

const NANOSECONDS_PER_SECOND: i64 = 1_000_000_000;

/// How far `dt` may be from a whole number of nanoseconds, as a share of itself. A decimal such as 0.001
/// is stored with a relative error of 1e-16; one that is off by 1e-12 was meant as something else.
const ROUNDING_SHARE: f64 = 1e-12;

/// Simulated time in steps of a whole number of nanoseconds that divides one second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Clock {
    step_ns: i64,
}

impl Clock {
    /// The clock with steps of `dt` seconds.
    ///
    /// # Errors
    /// When `dt` is not a positive whole number of nanoseconds that divides one second.
    pub(crate) fn new(dt: f64) -> Result<Self, SimError> {
        let nanoseconds = dt * 1e9;
        let rounded = nanoseconds.round();
        let whole = nanoseconds.is_finite()
            && (1.0..=1e9).contains(&rounded)
            && (nanoseconds - rounded).abs() <= ROUNDING_SHARE * rounded;
        // The cast is exact: the value is whole and at most 1e9.
        let step_ns = if whole { rounded as i64 } else { 0 };
        if step_ns == 0 || NANOSECONDS_PER_SECOND % step_ns != 0 {
            return Err(SimError::Step { dt });
        }
        Ok(Self { step_ns })
    }

    /// The length of a step, s.
    pub(crate) fn dt(self) -> f64 {
        self.seconds(1)
    }

    /// The time at which a step begins, ns.
    pub(crate) fn nanoseconds(self, step: usize) -> i64 {
        step as i64 * self.step_ns
    }

    /// The time at which a step begins, s: the double nearest to the nanoseconds.
    pub(crate) fn seconds(self, step: usize) -> f64 {
        self.nanoseconds(step) as f64 / 1e9
    }

    /// The number of steps that cover `duration` seconds. A duration that is a whole number of steps up to
    /// rounding is covered by that number.
    pub(crate) fn steps_in(self, duration: f64) -> usize {
        (duration / self.dt() - 1e-6).ceil().max(0.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_whole_nanoseconds() {
        let clock = Clock::new(0.001).unwrap();
        assert_eq!(clock.nanoseconds(4321), 4_321_000_000);
        assert!((clock.seconds(4321) - 4.321).abs() < 1e-15);
        assert_eq!(clock.steps_in(4.321), 4321);
        assert_eq!(clock.steps_in(4.3213), 4322);
        assert_eq!(clock.steps_in(0.0), 0);
    }

    #[test]
    fn a_step_that_does_not_divide_one_second_is_an_error() {
        for dt in [0.003, 1.0 / 240.0, 0.0, -0.001, 2.0, f64::NAN, f64::INFINITY, 1e-10, 0.000_999_999_9] {
            assert!(matches!(Clock::new(dt), Err(SimError::Step { .. })), "{dt}");
        }
        for dt in [0.001, 0.0005, 0.002, 0.00025, 0.004, 1.0] {
            assert!(Clock::new(dt).is_ok(), "{dt}");
        }
    }
}
