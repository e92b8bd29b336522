//! Laws of time along a path: how the arc length s goes from 0 to a distance, from rest to rest.
//!
//! Symbols used as names: `s sd sdd sddd` are s and its derivatives with respect to time. The unit of s is
//! the caller's: rad or m along a path, 1 for a share of it. Field words: LSPB, trapezoidal velocity and
//! 2-1-2 are the trapezoid; double S and seven-segment profile are the S-curve.
//!
//! Each law is stored by its shape (how long its phases last), and velocity, acceleration and jerk follow
//! from the shape and the distance. So the distance is met whatever rounding did to a duration, and
//! stretching a law in time is exact.
//!
//! Sources: Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, sections 2.1
//! (polynomials), 3.2 (trapezoid) and 3.4 (double S); the closed forms for rest to rest are restated below.

use graspcheck_motion::Polynomial;

/// No phase is shorter than this share of the whole motion: one that would be is lengthened, or left out
/// where it is optional, which takes about as much more time and keeps every limit.
///
/// The reason: such a phase is mostly what rounding leaves of one that does not exist (at a distance at which
/// the peak velocity is just reached), and its knots might not stay apart when the motion is moved in time.
const SHORTEST_PHASE: f64 = 1e-9;

/// Why there is no law of time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScalingError {
    /// A distance, limit or duration is not a positive finite number.
    #[error("{quantity} {value} must be a positive finite number")]
    NotPositive {
        /// Which: `distance`, `velocity limit`, …
        quantity: &'static str,
        /// What was given.
        value: f64,
    },
    /// The distance cannot be covered in this time with this cruise velocity.
    #[error(
        "distance {distance} in {duration} s: cruise velocity {velocity} must be above {least} and at most {most}"
    )]
    VelocityDoesNotFit {
        /// Distance to cover.
        distance: f64,
        /// In which time, s.
        duration: f64,
        /// Cruise velocity that was given.
        velocity: f64,
        /// D/T, which takes infinite acceleration.
        least: f64,
        /// 2D/T, which leaves no cruise.
        most: f64,
    },
    /// The distance cannot be covered in this time with so small an acceleration.
    #[error("distance {distance} in {duration} s: acceleration {acceleration} must be at least {least}")]
    AccelerationTooSmall {
        /// Distance to cover.
        distance: f64,
        /// In which time, s.
        duration: f64,
        /// Acceleration that was given.
        acceleration: f64,
        /// 4D/T², which leaves no cruise.
        least: f64,
    },
    /// The numbers are so far apart that a coefficient of the law overflows.
    #[error("distance {distance} in {duration} s: a coefficient of the law overflows")]
    Overflow {
        /// Distance to cover.
        distance: f64,
        /// In which time, s.
        duration: f64,
    },
}

/// The shape of a law of time: how long its phases last, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Profile {
    /// `s = D (3τ² - 2τ³)`, τ = t/T: velocity continuous, the acceleration jumps at both ends.
    Cubic,
    /// `s = D (10τ³ - 15τ⁴ + 6τ⁵)`, τ = t/T: acceleration continuous also at both ends.
    Quintic,
    /// Constant acceleration, cruise, constant deceleration.
    Trapezoid {
        /// Of the acceleration, and of the deceleration.
        blend: f64,
        /// Of the cruise; may be 0.
        cruise: f64,
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

/// A law of time s(t) from 0 to a distance, from rest to rest, on `[0, duration]`.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeScaling {
    profile: Profile,
    distance: f64,
    duration: f64,
    /// When each piece begins, s, and its polynomial in local time; none is empty.
    pieces: Vec<(f64, Polynomial)>,
}

impl TimeScaling {
    /// The cubic of least duration under limits on velocity, acceleration and the jerk inside:
    /// `T = max(3D/(2V), √(6D/A), ∛(12D/J))`. Its acceleration jumps by 6D/T² at both ends, where no jerk
    /// limit can hold.
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn cubic(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<Self, ScalingError> {
        Self::of_fixed_shape(Profile::Cubic, distance, [velocity, acceleration, jerk])
    }

    /// The quintic of least duration under limits on velocity, acceleration and jerk:
    /// `T = max(15D/(8V), √(10D/(√3 A)), ∛(60D/J))`.
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn quintic(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<Self, ScalingError> {
        Self::of_fixed_shape(Profile::Quintic, distance, [velocity, acceleration, jerk])
    }

    /// The law of least duration under limits on velocity and acceleration alone:
    /// `T = D/V + V/A` if `D ≥ V²/A`, else `2 √(D/A)`.
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn trapezoid(distance: f64, velocity: f64, acceleration: f64) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &[velocity, acceleration])?;
        let full_blend = velocity / acceleration;
        let profile = if distance / velocity >= full_blend {
            Profile::Trapezoid { blend: full_blend, cruise: distance / velocity - full_blend }
        } else {
            Profile::Trapezoid { blend: (distance / acceleration).sqrt(), cruise: 0.0 }
        };
        Self::within(profile, distance, [velocity, acceleration, f64::INFINITY])
    }

    /// The trapezoid of the given duration and cruise velocity: `t_b = T - D/V`.
    ///
    /// # Errors
    /// When an argument is not positive and finite, or not `D/T < V ≤ 2D/T`.
    pub fn trapezoid_with_velocity(
        distance: f64,
        duration: f64,
        velocity: f64,
    ) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &[velocity])?;
        positive("duration", duration)?;
        let (least, most) = (distance / duration, 2.0 * distance / duration);
        if velocity <= least || velocity > most {
            return Err(ScalingError::VelocityDoesNotFit { distance, duration, velocity, least, most });
        }
        let blend = duration - distance / velocity;
        Self::new(Profile::Trapezoid { blend, cruise: (duration - 2.0 * blend).max(0.0) }, distance, duration)
    }

    /// The trapezoid of the given duration and acceleration: `t_b = T/2 - √(T² - 4D/A)/2`.
    ///
    /// # Errors
    /// When an argument is not positive and finite, or not `A ≥ 4D/T²`.
    pub fn trapezoid_with_acceleration(
        distance: f64,
        duration: f64,
        acceleration: f64,
    ) -> Result<Self, ScalingError> {
        positive("distance", distance)?;
        positive("duration", duration)?;
        positive("acceleration", acceleration)?;
        let least = 4.0 * distance / (duration * duration);
        if acceleration < least {
            return Err(ScalingError::AccelerationTooSmall { distance, duration, acceleration, least });
        }
        let cruise = (duration * duration - 4.0 * distance / acceleration).max(0.0).sqrt();
        // (T - c)/2 without cancellation, as (T² - c²)/4 = D/A.
        let blend = 2.0 * (distance / acceleration) / (duration + cruise);
        Self::new(Profile::Trapezoid { blend, cruise }, distance, duration)
    }

    /// The law of least duration under limits on velocity, acceleration and jerk: seven phases, fewer where
    /// a limit is not reached.
    ///
    /// With `t_j = A/J, t_a = V/A + t_j` if `VJ ≥ A²`, else `t_j = √(V/J), t_a = 2 t_j`:
    /// if `D/V ≥ t_a` then `T = D/V + t_a`; else if `D ≥ 2A³/J²` then `T = t_j + 2 √(t_j²/4 + D/A)`; else
    /// `T = 4 ∛(D/(2J))`.
    ///
    /// # Errors
    /// When an argument is not positive and finite.
    pub fn s_curve(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &[velocity, acceleration, jerk])?;
        let ramp = acceleration / jerk;
        // Phases with jerk and with constant acceleration on the way to the velocity limit.
        let to_limit = [ramp, velocity / acceleration - ramp];
        let [t_j, t_c] = if to_limit[1] >= 0.0 { to_limit } else { [(velocity / jerk).sqrt(), 0.0] };
        let cruise = distance / velocity - (2.0 * t_j + t_c);
        let profile = if cruise >= 0.0 {
            Profile::SCurve { jerk: t_j, acceleration: t_c, cruise }
        } else if distance / acceleration >= 2.0 * ramp * ramp {
            // x (x + t_j) = D/A for x = t_j + t_c; this form of the root does not cancel.
            let strokes = distance / acceleration;
            let x = strokes / (0.5 * ramp + (0.25 * ramp * ramp + strokes).sqrt());
            Profile::SCurve { jerk: ramp, acceleration: (x - ramp).max(0.0), cruise: 0.0 }
        } else {
            Profile::SCurve { jerk: (0.5 * distance / jerk).cbrt(), acceleration: 0.0, cruise: 0.0 }
        };
        Self::within(profile, distance, [velocity, acceleration, jerk])
    }

    /// The same shape over the same distance in exactly this time, s, even if that takes more than the
    /// limits for which it was made: velocity, acceleration and jerk change by the first, second and third
    /// power of the ratio of durations.
    ///
    /// # Errors
    /// When `duration` is not positive and finite, or a coefficient overflows.
    pub fn stretched_to(&self, duration: f64) -> Result<Self, ScalingError> {
        positive("duration", duration)?;
        Self::new(self.profile, self.distance, duration)
    }

    /// Shape and durations of the phases.
    #[must_use]
    pub fn profile(&self) -> Profile {
        self.profile
    }

    /// The distance that s covers.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// How long it takes, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The largest velocity, acceleration and jerk, in the unit of s per s, s² and s³, in closed form. The
    /// steps of acceleration that a trapezoid, and a cubic at its ends, makes do not count as jerk.
    #[must_use]
    pub fn peaks(&self) -> [f64; 3] {
        self.profile.peaks(self.distance, self.duration)
    }

    /// `[s, sd, sdd, sddd]` at `t`, s; where a piece meets the next, the limit from the right.
    ///
    /// # Panics
    /// When `t` is outside `[0, duration]`.
    #[must_use]
    pub fn eval(&self, t: f64) -> [f64; 4] {
        assert!(
            (0.0..=self.duration).contains(&t),
            "t = {t} s is outside the law, which lasts from 0 s to {} s",
            self.duration
        );
        let next = self.pieces.partition_point(|(start, _)| *start <= t);
        let (start, polynomial) = &self.pieces[next.max(1) - 1];
        polynomial.eval(t - start)
    }

    /// When each piece begins, s, and its polynomial in the local time that is 0 there. The first begins at
    /// 0, the last ends at the duration.
    #[must_use]
    pub fn pieces(&self) -> Vec<(f64, Polynomial)> {
        self.pieces.clone()
    }

    fn of_fixed_shape(profile: Profile, distance: f64, limits: [f64; 3]) -> Result<Self, ScalingError> {
        check_distance_and_limits(distance, &limits)?;
        let duration = slowdown(profile.peaks(distance, 1.0), limits);
        Self::new(profile, distance, duration)
    }

    /// The law of this shape with the durations of its phases, slowed where rounding exceeds a limit.
    fn within(profile: Profile, distance: f64, limits: [f64; 3]) -> Result<Self, ScalingError> {
        let profile = profile.without_slivers();
        let duration = profile.phase_sum();
        let factor = slowdown(profile.peaks(distance, duration), limits).max(1.0);
        Self::new(profile, distance, factor * duration)
    }

    /// The law of this shape in exactly this time.
    fn new(profile: Profile, distance: f64, duration: f64) -> Result<Self, ScalingError> {
        let profile = profile.without_slivers();
        let profile = profile.stretched(duration / profile.phase_sum());
        let pieces = profile.pieces(distance, duration);
        let is_sound = duration.is_finite()
            && duration > 0.0
            && pieces.iter().all(|(start, polynomial)| start.is_finite() && polynomial.is_finite());
        if is_sound {
            Ok(Self { profile, distance, duration, pieces })
        } else {
            Err(ScalingError::Overflow { distance, duration })
        }
    }
}

impl Profile {
    /// The duration of all phases; 1 for shapes without phases.
    fn phase_sum(self) -> f64 {
        match self {
            Self::Cubic | Self::Quintic => 1.0,
            Self::Trapezoid { blend, cruise } => 2.0 * blend + cruise,
            Self::SCurve { jerk, acceleration, cruise } => 4.0 * jerk + 2.0 * acceleration + cruise,
        }
    }

    /// All phases longer by this factor.
    fn stretched(self, factor: f64) -> Self {
        match self {
            Self::Cubic | Self::Quintic => self,
            Self::Trapezoid { blend, cruise } => {
                Self::Trapezoid { blend: factor * blend, cruise: factor * cruise }
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
    fn without_slivers(self) -> Self {
        let shortest = SHORTEST_PHASE * self.phase_sum();
        let kept = |phase: f64| if phase > shortest { [phase, 0.0] } else { [0.0, phase] };
        match self {
            Self::Cubic | Self::Quintic => self,
            Self::Trapezoid { blend, cruise } => {
                let [cruise, lost] = kept(cruise);
                Self::Trapezoid { blend: blend.max(shortest) + lost, cruise }
            }
            Self::SCurve { jerk, acceleration, cruise } => {
                let [cruise, lost_cruise] = kept(cruise);
                let [acceleration, lost_acceleration] = kept(acceleration);
                let jerk = jerk.max(shortest) + 0.5 * lost_cruise + lost_acceleration;
                Self::SCurve { jerk, acceleration, cruise }
            }
        }
    }

    /// The largest velocity, acceleration and jerk.
    fn peaks(self, distance: f64, duration: f64) -> [f64; 3] {
        match self {
            Self::Cubic | Self::Quintic => {
                let mean = distance / duration;
                let factors =
                    if self == Self::Cubic { [1.5, 6.0, 12.0] } else { [1.875, 10.0 / 3.0_f64.sqrt(), 60.0] };
                [factors[0] * mean, factors[1] * mean / duration, factors[2] * mean / duration / duration]
            }
            Self::Trapezoid { blend, cruise } => {
                let velocity = distance / (blend + cruise);
                [velocity, velocity / blend, 0.0]
            }
            Self::SCurve { jerk, acceleration, cruise } => {
                let velocity = distance / (2.0 * jerk + acceleration + cruise);
                let peak = velocity / (jerk + acceleration);
                [velocity, peak, peak / jerk]
            }
        }
    }

    fn pieces(self, distance: f64, duration: f64) -> Vec<(f64, Polynomial)> {
        let [velocity, acceleration, jerk] = self.peaks(distance, duration);
        let powers = |k: i32| distance / duration.powi(k);
        match self {
            Self::Cubic => vec![(0.0, Polynomial::new([0.0, 0.0, 3.0 * powers(2), -2.0 * powers(3)]))],
            Self::Quintic => {
                let c = [0.0, 0.0, 0.0, 10.0 * powers(3), -15.0 * powers(4), 6.0 * powers(5)];
                vec![(0.0, Polynomial::new(c))]
            }
            Self::Trapezoid { blend, cruise } => {
                let rise = [(blend, Polynomial::new([0.0, 0.0, 0.5 * acceleration]))];
                symmetric(&rise, cruise, velocity, distance, duration)
            }
            Self::SCurve { jerk: t_j, acceleration: t_c, cruise } => {
                let sixth = jerk / 6.0;
                let first = Polynomial::new([0.0, 0.0, 0.0, sixth]);
                let [s, sd, ..] = first.eval(t_j);
                let second = Polynomial::new([s, sd, 0.5 * acceleration]);
                let [s, sd, ..] = second.eval(t_c);
                let third = Polynomial::new([s, sd, 0.5 * acceleration, -sixth]);
                let rise = [(t_j, first), (t_c, second), (t_j, third)];
                symmetric(&rise, cruise, velocity, distance, duration)
            }
        }
    }
}

/// The pieces of a law that rises, cruises, and falls as it rose: `s(t) = D - s(T - t)`. Built from both
/// ends, so that it ends at rest at its distance to the last bits, as it starts.
fn symmetric(
    rise: &[(f64, Polynomial)],
    cruise: f64,
    velocity: f64,
    distance: f64,
    duration: f64,
) -> Vec<(f64, Polynomial)> {
    let mut pieces = Vec::with_capacity(2 * rise.len() + 1);
    let mut t = 0.0;
    let mut fall = Vec::with_capacity(rise.len());
    let mut covered = 0.0;
    for &(length, polynomial) in rise.iter().filter(|(length, _)| *length > 0.0) {
        pieces.push((t, polynomial));
        t += length;
        let [s, sd, sdd, sddd] = polynomial.eval(length);
        fall.push((duration - t, Polynomial::new([distance - s, sd, -0.5 * sdd, sddd / 6.0])));
        covered = s;
    }
    if cruise > 0.0 {
        pieces.push((t, Polynomial::new([covered, velocity])));
    }
    pieces.extend(fall.into_iter().rev());
    pieces
}

/// The factor by which a law must be slower so that none of its peaks is above its limit.
fn slowdown(peaks: [f64; 3], limits: [f64; 3]) -> f64 {
    let [velocity, acceleration, jerk] = [0, 1, 2].map(|k| peaks[k] / limits[k]);
    velocity.max(acceleration.sqrt()).max(jerk.cbrt())
}

fn check_distance_and_limits(distance: f64, limits: &[f64]) -> Result<(), ScalingError> {
    positive("distance", distance)?;
    let names = ["velocity", "acceleration", "jerk"];
    limits.iter().zip(names).try_for_each(|(&limit, name)| positive(name, limit))
}

fn positive(quantity: &'static str, value: f64) -> Result<(), ScalingError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ScalingError::NotPositive { quantity, value }) }
}

#[cfg(test)]
mod tests {
    use graspcheck_motion::{ContinuityClass, Trajectory};
    use proptest::prelude::*;

    use super::*;

    fn trajectory(law: &TimeScaling) -> Trajectory {
        let (mut knots, pieces): (Vec<f64>, Vec<Polynomial>) = law.pieces().into_iter().unzip();
        knots.push(law.duration());
        Trajectory::new(1, knots, pieces).unwrap()
    }

    fn assert_near(value: f64, expected: f64, tolerance: f64) {
        assert!((value - expected).abs() <= tolerance, "{value} is not {expected}");
    }

    #[test]
    fn s_curve_durations_of_the_worked_examples() {
        for (distance, duration, pieces) in
            [(1.0, 1.7, 7), (0.2, 0.863_325, 6), (0.16, 0.8, 4), (0.01, 0.317_480, 4)]
        {
            let law = TimeScaling::s_curve(distance, 1.0, 2.0, 10.0).unwrap();
            assert_near(law.duration(), duration, 5e-7);
            assert_eq!(law.pieces().len(), pieces, "distance {distance}");
        }
    }

    #[test]
    fn degenerate_s_curves_have_no_slivers() {
        // D = 2A³/J² exactly and one ulp beside it: other generators fail here.
        let boundary = 1.6875_f64;
        for distance in [boundary, boundary.next_down(), boundary.next_up()] {
            let law = TimeScaling::s_curve(distance, 100.0, 1.5, 2.0).unwrap();
            assert_eq!(law.pieces().len(), 4, "distance {distance}");
            assert_near(law.duration(), 3.0, 1e-8);
        }
        // The velocity limit is just reached: D = V t_a = 0.7, no cruise.
        assert_eq!(TimeScaling::s_curve(0.7, 1.0, 2.0, 10.0).unwrap().pieces().len(), 6);
        // VJ = A²: no phase of constant acceleration, with a cruise and without.
        assert_eq!(TimeScaling::s_curve(5.0, 0.4, 2.0, 10.0).unwrap().pieces().len(), 5);
        assert_eq!(TimeScaling::s_curve(0.16, 0.4, 2.0, 10.0).unwrap().pieces().len(), 4);
        // VJ < A²: the acceleration limit is never reached.
        let law = TimeScaling::s_curve(5.0, 0.1, 2.0, 10.0).unwrap();
        assert_eq!(law.pieces().len(), 5);
        assert_near(law.duration(), 50.0 + 2.0 * 0.1, 1e-9);
        assert_near(law.peaks()[1], (0.1_f64 * 10.0).sqrt(), 1e-12);
    }

    #[test]
    fn trapezoids_of_the_worked_examples() {
        // lspb-1 and lspb-2: 40° -> 120° in 4 s.
        let law = TimeScaling::trapezoid_with_velocity(80.0, 4.0, 25.0).unwrap();
        assert!(matches!(law.profile(), Profile::Trapezoid { blend, .. } if (blend - 0.8).abs() < 1e-12));
        assert_near(law.peaks()[1], 31.25, 1e-12);
        let law = TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 25.0).unwrap();
        assert!(
            matches!(law.profile(), Profile::Trapezoid { blend, .. } if (blend - 1.105_573).abs() < 5e-7)
        );
        assert_near(law.peaks()[0], 27.639_320, 5e-7);
        let law = TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 20.0).unwrap();
        assert_near(law.peaks()[0], 40.0, 1e-12);
        assert_eq!(law.pieces().len(), 2);
        // The fastest ones under (V, A), with a cruise and without.
        assert_near(TimeScaling::trapezoid(1.0, 0.6, 10.0).unwrap().duration(), 1.726_666_666, 1e-8);
        assert_near(TimeScaling::trapezoid(1.0, 10.0, 1.0).unwrap().duration(), 2.0, 1e-12);
        assert_near(TimeScaling::trapezoid(1.0, 0.6, 1.0).unwrap().duration(), 2.266_666_666, 1e-8);
    }

    #[test]
    fn a_trapezoid_that_does_not_fit_says_what_would() {
        assert_eq!(
            TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 19.0),
            Err(ScalingError::AccelerationTooSmall {
                distance: 80.0,
                duration: 4.0,
                acceleration: 19.0,
                least: 20.0
            })
        );
        for velocity in [20.0, 40.1] {
            assert!(matches!(
                TimeScaling::trapezoid_with_velocity(80.0, 4.0, velocity),
                Err(ScalingError::VelocityDoesNotFit { least: 20.0, most: 40.0, .. })
            ));
        }
        assert!(TimeScaling::trapezoid_with_velocity(80.0, 4.0, 40.0).is_ok());
    }

    #[test]
    fn polynomial_laws_reach_the_limit_that_binds() {
        // Table of section 3 with D = 0.8, T = 0.5.
        let (distance, duration) = (0.8, 0.5_f64);
        for (make, factors, class) in [
            (TimeScaling::cubic as fn(f64, f64, f64, f64) -> _, [1.5, 6.0, 12.0], 2),
            (TimeScaling::quintic, [1.875, 5.773_502_691_896_258, 60.0], 3),
        ] {
            let peaks: [f64; 3] =
                std::array::from_fn(|k| factors[k] * distance / duration.powi(k as i32 + 1));
            for binding in 0..3 {
                let limits: [f64; 3] =
                    std::array::from_fn(|k| if k == binding { peaks[k] } else { 2.0 * peaks[k] });
                let law: TimeScaling = make(distance, limits[0], limits[1], limits[2]).unwrap();
                assert_near(law.duration(), duration, 1e-12);
                let motion = trajectory(&law);
                for (k, peak) in peaks.iter().enumerate() {
                    assert_near(motion.peak(0, k + 1).value.abs(), *peak, 1e-11 * peak);
                }
                let [_, sd, sdd, _] = law.eval(law.duration());
                assert_near(sd, 0.0, 1e-13);
                assert_eq!(sdd.abs() < 1e-9, class == 3, "only the quintic ends without acceleration");
            }
        }
    }

    #[test]
    fn bad_input_names_the_quantity() {
        for (arguments, quantity) in [
            ([0.0, 1.0, 1.0, 1.0], "distance"),
            ([1.0, -1.0, 1.0, 1.0], "velocity"),
            ([1.0, 1.0, f64::NAN, 1.0], "acceleration"),
            ([1.0, 1.0, 1.0, f64::INFINITY], "jerk"),
        ] {
            let [d, v, a, j] = arguments;
            for law in [TimeScaling::s_curve(d, v, a, j), TimeScaling::quintic(d, v, a, j)] {
                assert!(matches!(law, Err(ScalingError::NotPositive { quantity: q, .. }) if q == quantity));
            }
        }
        let law = TimeScaling::s_curve(1.0, 1.0, 1.0, 1.0).unwrap();
        assert!(matches!(law.stretched_to(0.0), Err(ScalingError::NotPositive { quantity: "duration", .. })));
        assert!(TimeScaling::cubic(1e300, 1e300, 1e300, 1e300).is_ok());
        assert!(matches!(law.stretched_to(1e-200), Err(ScalingError::Overflow { .. })));
    }

    /// The least time by another way: the peak velocity is found by bisection on the distance that a motion
    /// to this velocity and back covers.
    fn least_duration_by_search(distance: f64, velocity: f64, acceleration: f64, jerk: f64) -> f64 {
        let rise = |peak: f64| {
            if peak * jerk >= acceleration * acceleration {
                peak / acceleration + acceleration / jerk
            } else {
                2.0 * (peak / jerk).sqrt()
            }
        };
        // To a peak and back without a cruise covers peak × rise time.
        let (mut low, mut high) = (0.0, velocity);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle * rise(middle) <= distance { low = middle } else { high = middle }
        }
        2.0 * rise(low) + (distance - low * rise(low)) / low
    }

    proptest! {
        #[test]
        fn s_curves_keep_the_limits_reach_one_and_are_the_fastest(
            logs in prop::array::uniform4(-3.0..3.0_f64)
        ) {
            let [distance, v, a, j] = logs.map(|log| 10.0_f64.powf(log));
            let law = TimeScaling::s_curve(distance, v, a, j).unwrap();
            let motion = trajectory(&law);
            prop_assert_eq!(motion.continuity().class, ContinuityClass::C2);
            let used = [v, a, j].into_iter().zip(1..).map(|(l, order)| motion.peak(0, order).value.abs() / l);
            let used: Vec<f64> = used.collect();
            for (k, (share, peak)) in used.iter().zip(law.peaks()).enumerate() {
                // A knot is rounded to the spacing of floats near T; the next derivative times that.
                let knots = f64::EPSILON * law.duration();
                let rounding = 1e-12 + [a / v, j / a, 0.0][k] * knots;
                prop_assert!(*share <= 1.0 + rounding, "{:?}", used);
                prop_assert!((share - peak / [v, a, j][k]).abs() < rounding, "{} {}", share, peak);
            }
            // The jerk limit is always reached, but for what a sliver adds to a phase.
            let Profile::SCurve { jerk: phase, .. } = law.profile() else { panic!("{:?}", law.profile()) };
            prop_assert!(used[2] > 1.0 - 4.0 * SHORTEST_PHASE * law.duration() / phase - 1e-9, "{:?}", used);
            let least = least_duration_by_search(distance, v, a, j);
            prop_assert!((law.duration() / least - 1.0).abs() < 1e-8, "{} is not {least}", law.duration());
            let [s, sd, sdd, _] = law.eval(law.duration());
            prop_assert!((s / distance - 1.0).abs() < 1e-14);
            let knots = f64::EPSILON * law.duration();
            prop_assert!(sd.abs() < 1e-12 * v + a * knots && sdd.abs() < 1e-12 * a + j * knots, "{sd} {sdd}");
            let [low, high] = motion.position_range(0, 0.0, law.duration());
            prop_assert!(low >= -1e-14 * distance && high <= distance * (1.0 + 1e-14));
        }

        #[test]
        fn trapezoids_keep_the_limits_and_reach_one(logs in prop::array::uniform3(-3.0..3.0_f64)) {
            let [distance, v, a] = logs.map(|log| 10.0_f64.powf(log));
            let law = TimeScaling::trapezoid(distance, v, a).unwrap();
            let motion = trajectory(&law);
            prop_assert!(motion.peak(0, 1).value <= v * (1.0 + 1e-12));
            let acceleration = motion.peak(0, 2).value.abs() / a;
            let Profile::Trapezoid { blend, .. } = law.profile() else { panic!("{:?}", law.profile()) };
            prop_assert!(acceleration <= 1.0 + 1e-12);
            prop_assert!(acceleration > 1.0 - 4.0 * SHORTEST_PHASE * law.duration() / blend - 1e-9);
            let expected = if distance >= v * v / a { distance / v + v / a } else { 2.0 * (distance / a).sqrt() };
            prop_assert!((law.duration() / expected - 1.0).abs() < 1e-8);
            // The S-curve tends to it as the jerk grows.
            let smooth = TimeScaling::s_curve(distance, v, a, 1e9 * a / law.duration()).unwrap();
            prop_assert!((smooth.duration() / law.duration() - 1.0).abs() < 1e-6);
        }

        #[test]
        fn stretching_scales_time_alone(
            logs in prop::array::uniform4(-2.0..2.0_f64), ratio in 0.1..10.0_f64, share in 0.0..1.0_f64
        ) {
            let [distance, v, a, j] = logs.map(|log| 10.0_f64.powf(log));
            for law in [TimeScaling::s_curve(distance, v, a, j), TimeScaling::trapezoid(distance, v, a),
                        TimeScaling::quintic(distance, v, a, j)] {
                let law = law.unwrap();
                let target = ratio * law.duration();
                let stretched = law.stretched_to(target).unwrap();
                prop_assert_eq!(stretched.duration().to_bits(), target.to_bits());
                let t = share * law.duration();
                let (before, after) = (law.eval(t), stretched.eval((share * target).min(target)));
                prop_assert!((before[0] - after[0]).abs() < 1e-12 * distance);
                prop_assert!((before[1] - ratio * after[1]).abs() < 1e-11 * law.peaks()[0]);
            }
        }
    }
}
