//! The shape of a law of time.

use graspcheck_motion::Polynomial;

use super::pieces::{Pieces, VelocityChange};

/// No phase is shorter than this share of the whole motion: one that would be is lengthened, or left out
/// where it is optional. The motion takes longer by at most about this share, and keeps every limit.
///
/// The reason: such a phase is mostly what rounding leaves of one that does not exist (at a distance at which
/// the peak velocity is just reached), and its knots might not stay apart when the motion is moved in time.
pub const SHORTEST_PHASE: f64 = 1e-9;

/// The shape of a law of time: how long its phases last, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// `s = D (3τ² - 2τ³)`, τ = t/T: velocity continuous, the acceleration jumps at both ends.
    Cubic,
    /// `s = D (10τ³ - 15τ⁴ + 6τ⁵)`, τ = t/T: acceleration continuous also at both ends.
    Quintic,
    /// `s = D (35τ⁴ - 84τ⁵ + 70τ⁶ - 20τ⁷)`, τ = t/T: jerk continuous also at both ends.
    Septic,
    /// Constant acceleration, cruise, constant deceleration.
    Trapezoid {
        /// Of the acceleration.
        rise: f64,
        /// Of the cruise; may be 0.
        cruise: f64,
        /// Of the deceleration.
        fall: f64,
    },
    /// Seven phases of constant jerk: jerk up, constant acceleration, jerk down, cruise, and the same
    /// backwards.
    SCurve {
        /// Of each of the four phases with jerk.
        jerk: f64,
        /// Of each phase of constant acceleration; may be 0.
        acceleration: f64,
        /// Of the cruise; may be 0.
        cruise: f64,
    },
}

impl Profile {
    /// The duration of all phases; 1 for shapes without phases.
    pub(super) fn phase_sum(self) -> f64 {
        match self {
            Self::Cubic | Self::Quintic | Self::Septic => 1.0,
            Self::Trapezoid { rise, cruise, fall } => rise + cruise + fall,
            Self::SCurve { jerk, acceleration, cruise } => 4.0 * jerk + 2.0 * acceleration + cruise,
        }
    }

    /// All phases longer by this factor.
    pub(super) fn stretched(self, factor: f64) -> Self {
        match self {
            Self::Cubic | Self::Quintic | Self::Septic => self,
            Self::Trapezoid { rise, cruise, fall } => {
                Self::Trapezoid { rise: factor * rise, cruise: factor * cruise, fall: factor * fall }
            }
            Self::SCurve { jerk, acceleration, cruise } => Self::SCurve {
                jerk: factor * jerk,
                acceleration: factor * acceleration,
                cruise: factor * cruise,
            },
        }
    }

    /// With every phase at least [`SHORTEST_PHASE`] long or left out. What is left out is added to the phases
    /// beside it, so that no peak grows.
    pub(super) fn without_slivers(self) -> Self {
        let shortest = SHORTEST_PHASE * self.phase_sum();
        let kept = |phase: f64| if phase > shortest { [phase, 0.0] } else { [0.0, phase] };
        match self {
            Self::Cubic | Self::Quintic | Self::Septic => self,
            Self::Trapezoid { rise, cruise, fall } => {
                let [cruise, lost] = kept(cruise);
                Self::Trapezoid { rise: rise.max(shortest) + lost, cruise, fall: fall.max(shortest) + lost }
            }
            Self::SCurve { jerk, acceleration, cruise } => {
                let [cruise, lost_cruise] = kept(cruise);
                let [acceleration, lost_acceleration] = kept(acceleration);
                let jerk = jerk.max(shortest) + 0.5 * lost_cruise + lost_acceleration;
                Self::SCurve { jerk, acceleration, cruise }
            }
        }
    }

    /// The largest velocity, acceleration and jerk over this distance in this time.
    pub(super) fn peaks(self, distance: f64, duration: f64) -> [f64; 3] {
        let of_shape = |[velocity, acceleration, jerk]: [f64; 3]| {
            let mean = distance / duration;
            [velocity * mean, acceleration * mean / duration, jerk * mean / duration / duration]
        };
        match self {
            Self::Cubic => of_shape([1.5, 6.0, 12.0]),
            Self::Quintic => of_shape([1.875, 10.0 / 3.0_f64.sqrt(), 60.0]),
            Self::Septic => of_shape([2.1875, 84.0 * 5.0_f64.sqrt() / 25.0, 52.5]),
            Self::Trapezoid { rise, cruise, fall } => {
                let velocity = distance / (0.5 * (rise + fall) + cruise);
                [velocity, velocity / rise.min(fall), 0.0]
            }
            Self::SCurve { jerk, acceleration, cruise } => {
                let velocity = distance / (2.0 * jerk + acceleration + cruise);
                let peak = velocity / (jerk + acceleration);
                [velocity, peak, peak / jerk]
            }
        }
    }

    /// Whether every coefficient of its polynomials is finite.
    pub(super) fn is_finite(self, distance: f64, duration: f64) -> bool {
        match self {
            Self::Cubic | Self::Quintic | Self::Septic => self.pieces(0.0, distance, duration).is_finite(),
            // Their coefficients are the distance and shares of the peaks.
            Self::Trapezoid { .. } | Self::SCurve { .. } => {
                let [velocity, acceleration, jerk] = self.peaks(distance, duration);
                velocity.is_finite() && acceleration.is_finite() && jerk.is_finite()
            }
        }
    }

    /// The polynomials from one position to another in this time, which is the sum of the phases if there are any.
    pub(crate) fn pieces(self, from: f64, to: f64, duration: f64) -> Pieces {
        let distance = to - from;
        let powers = |k: i32| distance / duration.powi(k);
        match self {
            Self::Cubic => Pieces::one(Polynomial::new([from, 0.0, 3.0 * powers(2), -2.0 * powers(3)])),
            Self::Quintic => {
                let [c3, c4, c5] = [10.0 * powers(3), -15.0 * powers(4), 6.0 * powers(5)];
                Pieces::one(Polynomial::new([from, 0.0, 0.0, c3, c4, c5]))
            }
            Self::Septic => {
                let [c4, c5, c6, c7] =
                    [35.0 * powers(4), -84.0 * powers(5), 70.0 * powers(6), -20.0 * powers(7)];
                Pieces::one(Polynomial::new([from, 0.0, 0.0, 0.0, c4, c5, c6, c7]))
            }
            Self::Trapezoid { rise, cruise, fall } => {
                let velocity = distance / (0.5 * (rise + fall) + cruise);
                let [rise, fall] = [rise, fall].map(|acceleration| VelocityChange {
                    change: velocity,
                    jerk: 0.0,
                    acceleration,
                });
                Pieces::between([from, 0.0], rise, (cruise, velocity), fall, [to, 0.0], duration)
            }
            Self::SCurve { jerk, acceleration, cruise } => {
                let velocity = distance / (2.0 * jerk + acceleration + cruise);
                let change = VelocityChange { change: velocity, jerk, acceleration };
                Pieces::between([from, 0.0], change, (cruise, velocity), change, [to, 0.0], duration)
            }
        }
    }
}
