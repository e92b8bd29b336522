//! Laws of time along a path: how the arc length s goes from 0 to a distance, from rest to rest.
//!
//! Symbols used as names: `s sd sdd sddd` are s and its derivatives with respect to time. The unit of s is
//! the caller's: rad or m along a path, 1 for a share of it. V, A, J are limits or peaks of velocity,
//! acceleration and jerk, D is the distance and T the duration. One law a file:
//!
//! | law | smooth in | under limits on | file |
//! |---|---|---|---|
//! | cubic | velocity | V, A, (J inside) | [`TimeScaling::cubic`] |
//! | quintic | acceleration | V, A, J | [`TimeScaling::quintic`] |
//! | septic | jerk | V, A, J | [`TimeScaling::septic`] |
//! | trapezoid, bang-bang | velocity | V, A | [`TimeScaling::trapezoid`] |
//! | S-curve | acceleration | V, A, J | [`TimeScaling::s_curve`] |
//!
//! Under limits on velocity and acceleration the trapezoid is the fastest law; under limits on jerk too it is
//! the S-curve, which tends to the trapezoid as J grows. Laws between moving ends, with a sign and from another
//! time than 0, are in [`crate::joint_law`].
//!
//! Each law is stored by its shape (how long its phases last), and velocity, acceleration and jerk follow
//! from the shape and the distance. So the distance is met whatever rounding did to a duration, and
//! stretching a law in time is exact.
//!
//! Sources: Biagiotti and Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, sections 2.1
//! (polynomials), 3.2 (trapezoid) and 3.4 (double S); the closed forms are restated where they are used.

use graspcheck_motion::Polynomial;

pub(crate) mod error;
pub(crate) mod pieces;
mod polynomial;
mod profile;
mod s_curve;
mod trapezoid;

use pieces::Pieces;

pub use error::ScalingError;
pub use profile::{Profile, SHORTEST_PHASE};

/// A law of time s(t) from 0 to a distance, from rest to rest, on `[0, duration]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeScaling {
    profile: Profile,
    distance: f64,
    duration: f64,
}

impl TimeScaling {
    /// The same shape over the same distance in exactly this time, s, even if that takes more than the
    /// limits for which it was made: velocity, acceleration and jerk change by the first, second and third
    /// power of the ratio of durations.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let law = TimeScaling::s_curve(1.0, 1.0, 2.0, 10.0)?.stretched_to(3.4)?;
    /// assert_eq!(law.duration(), 3.4);
    /// assert!((law.peaks()[0] - 0.5).abs() < 1e-12 && (law.peaks()[2] - 1.25).abs() < 1e-12);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// When `duration` is not positive and finite, or a coefficient overflows.
    pub fn stretched_to(&self, duration: f64) -> Result<Self, ScalingError> {
        error::positive("duration", duration)?;
        Self::new(self.profile, self.distance, duration)
    }

    /// Shape and durations of the phases.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::{Profile, TimeScaling};
    /// let law = TimeScaling::trapezoid(1.0, 0.5, 1.0)?;
    /// assert_eq!(law.profile(), Profile::Trapezoid { rise: 0.5, cruise: 1.5, fall: 0.5 });
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
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
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let [velocity, acceleration, jerk] = TimeScaling::s_curve(1.0, 1.0, 2.0, 10.0)?.peaks();
    /// assert!((velocity - 1.0).abs() < 1e-12 && (acceleration - 2.0).abs() < 1e-12 && (jerk - 10.0).abs() < 1e-12);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    #[must_use]
    pub fn peaks(&self) -> [f64; 3] {
        self.profile.peaks(self.distance, self.duration)
    }

    /// `[s, sd, sdd, sddd]` at `t`, s; where a piece meets the next, the limit from the right.
    ///
    /// ```
    /// use graspcheck_planner::time_scaling::TimeScaling;
    /// let law = TimeScaling::trapezoid(1.0, 0.5, 1.0)?; // 0.5 s up, 1.5 s at 0.5, 0.5 s down
    /// assert_eq!(law.eval(1.0), [0.375, 0.5, 0.0, 0.0]);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
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
        self.pieces_in_place().eval(t)
    }

    /// When each piece begins, s, and its polynomial in the local time that is 0 there. The first begins at
    /// 0, the last ends at the duration.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = (f64, Polynomial)> {
        let pieces = self.pieces_in_place();
        (0..pieces.starts().len()).map(move |piece| (pieces.starts()[piece], pieces.polynomial(piece)))
    }

    /// The polynomials, which follow from the shape, held in place.
    pub(crate) fn pieces_in_place(&self) -> Pieces {
        self.profile.pieces(0.0, self.distance, self.duration)
    }

    /// The law of this shape with the durations of its phases, slowed where rounding exceeds a limit.
    fn within(profile: Profile, distance: f64, limits: [f64; 3]) -> Result<Self, ScalingError> {
        let profile = profile.without_slivers();
        let duration = profile.phase_sum();
        let peaks = profile.peaks(distance, duration);
        // Rarely is a peak above its limit, and roots take time.
        let keeps = peaks.iter().zip(limits).all(|(peak, limit)| *peak <= limit);
        let factor = if keeps { 1.0 } else { slowdown(peaks, limits).max(1.0) };
        Self::new(profile, distance, factor * duration)
    }

    /// The law of this shape in exactly this time.
    fn new(profile: Profile, distance: f64, duration: f64) -> Result<Self, ScalingError> {
        let profile = profile.without_slivers();
        let profile = profile.stretched(duration / profile.phase_sum());
        if duration.is_finite() && duration > 0.0 && profile.is_finite(distance, duration) {
            Ok(Self { profile, distance, duration })
        } else {
            Err(ScalingError::Overflow { distance, duration })
        }
    }
}

/// The factor by which a law must last longer, or may last shorter, so that its peaks just keep their limits.
fn slowdown(peaks: [f64; 3], limits: [f64; 3]) -> f64 {
    let [velocity, acceleration, jerk] = [0, 1, 2].map(|k| peaks[k] / limits[k]);
    velocity.max(acceleration.sqrt()).max(jerk.cbrt())
}

#[cfg(test)]
mod tests {
    use graspcheck_motion::{ContinuityClass, Trajectory};
    use proptest::prelude::*;

    use super::*;

    fn trajectory(law: &TimeScaling) -> Trajectory {
        let (mut knots, pieces): (Vec<f64>, Vec<Polynomial>) = law.pieces().unzip();
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
        assert!(matches!(law.profile(), Profile::Trapezoid { rise, .. } if (rise - 0.8).abs() < 1e-12));
        assert_near(law.peaks()[1], 31.25, 1e-12);
        let law = TimeScaling::trapezoid_with_acceleration(80.0, 4.0, 25.0).unwrap();
        assert!(matches!(law.profile(), Profile::Trapezoid { rise, .. } if (rise - 1.105_573).abs() < 5e-7));
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
            let Profile::Trapezoid { rise: blend, .. } = law.profile() else { panic!("{:?}", law.profile()) };
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
