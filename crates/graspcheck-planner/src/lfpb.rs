//! Linear function with parabolic blends (LFPB) through many points, one coordinate.
//!
//! Between two points the coordinate moves at constant velocity, about each point it changes velocity at
//! constant acceleration. It passes *near* inner points, not through them. Field words: multi-segment LSPB,
//! linear segments with parabolic blends.
//!
//! Both conventions for the ends come to the same construction. Each point k has an instant eₖ at which the
//! two lines beside it meet; inner points have eₖ = tₖ. With [`Ends::Centred`] so have the first and the last
//! (Siciliano et al., *Robotics: Modelling, Planning and Control*, section 4.2.2), and the motion begins and
//! ends half a blend outside. With [`Ends::Inside`] the motion begins at t₁ and ends at t_N, so that
//! e₁ = t₁ + b₁/2 and e_N = t_N - b_N/2 (Craig, *Introduction to Robotics*, section 7.3). Then
//! `v = Δq/Δe` on each segment, `a = Δv/b` in each blend, and blends are centred on the eₖ.

use graspcheck_motion::Polynomial;

/// Where the blends of the first and the last point lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// After the first instant and before the last: the motion lasts from t₁ to t_N.
    Inside,
    /// Half before and half after: the motion lasts from t₁ - b₁/2 to t_N + b_N/2.
    Centred,
}

/// Why there is no LFPB motion. Points, blends and segments are counted from 1; segment k leads from point
/// k to point k + 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LfpbError {
    /// Fewer than two points.
    #[error("an LFPB motion needs at least two points, got {count}")]
    TooFewPoints {
        /// How many were given.
        count: usize,
    },
    /// The numbers of times, positions and blends differ.
    #[error(
        "an LFPB motion needs a time, a position and a blend for each point, got {times}, {positions} and {blends}"
    )]
    PointCount {
        /// How many times.
        times: usize,
        /// How many positions.
        positions: usize,
        /// How many blends.
        blends: usize,
    },
    /// A number is NaN or infinite.
    #[error("point {point}: {quantity} {value} must be finite")]
    NotFinite {
        /// Number of the point.
        point: usize,
        /// `time` or `position`.
        quantity: &'static str,
        /// What was given.
        value: f64,
    },
    /// A point does not come after the one before it.
    #[error("point {point}: time {time} s must be later than that of the point before it, {previous} s")]
    TimesNotIncreasing {
        /// Number of the point.
        point: usize,
        /// Its time, s.
        time: f64,
        /// The time of the point before it, s.
        previous: f64,
    },
    /// A blend takes no time, which needs infinite acceleration, or is not a number.
    #[error("point {point}: blend time {blend} s must be a positive finite number")]
    BlendNotPositive {
        /// Number of the point.
        point: usize,
        /// What was given, s.
        blend: f64,
    },
    /// The blends of a segment's points overlap.
    #[error(
        "segment {segment}: its blends take {needed} s of the {available} s from {from} s to {to} s; \
         shorten the blends, or give the segment at least {needed} s"
    )]
    BlendsOverlap {
        /// Number of the segment.
        segment: usize,
        /// When its first point is due, s.
        from: f64,
        /// When its second point is due, s.
        to: f64,
        /// The parts of both blends that lie in the segment, s: the least duration that would do.
        needed: f64,
        /// What the segment has, s.
        available: f64,
    },
    /// The numbers are so far apart that a velocity or an acceleration overflows.
    #[error("point {point}: the acceleration overflows")]
    Overflow {
        /// Number of the point.
        point: usize,
    },
}

/// A linear function with parabolic blends: position and velocity continuous, from rest to rest.
///
/// Time is that of its points, so that it need not begin at 0. Positions have the caller's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Lfpb {
    end: f64,
    pieces: Vec<(f64, Polynomial)>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    misses: Vec<f64>,
}

impl Lfpb {
    /// The motion that passes near `positions` at `times`, s, with these durations of the blends at the
    /// points, s.
    ///
    /// # Errors
    /// When the slices differ in length or have fewer than two entries, a number is not finite, times do
    /// not increase, a blend is not positive, or the blends of a segment overlap.
    pub fn with_blend_times(
        times: &[f64],
        positions: &[f64],
        blends: &[f64],
        ends: Ends,
    ) -> Result<Self, LfpbError> {
        check(times, positions, blends)?;
        let last = times.len() - 1;
        let mut meets = times.to_vec();
        if ends == Ends::Inside {
            meets[0] += 0.5 * blends[0];
            meets[last] -= 0.5 * blends[last];
        }
        let mut velocities = Vec::with_capacity(last);
        for k in 0..last {
            let [from, to] = [times[k], times[k + 1]];
            // Half a blend lies in a segment, or the whole one at an end with its blend inside.
            let needed = 0.5 * (blends[k] + blends[k + 1]) + (meets[k] - from) + (to - meets[k + 1]);
            let available = to - from;
            if needed > available * (1.0 + OVERLAP_TOLERANCE) {
                return Err(LfpbError::BlendsOverlap { segment: k + 1, from, to, needed, available });
            }
            velocities.push((positions[k + 1] - positions[k]) / (meets[k + 1] - meets[k]));
        }
        let mut windows: Vec<[f64; 2]> =
            meets.iter().zip(blends).map(|(meet, blend)| [meet - 0.5 * blend, meet + 0.5 * blend]).collect();
        if ends == Ends::Inside {
            // Exactly, whatever rounding did to the halves.
            windows[0][0] = times[0];
            windows[last][1] = times[last];
        }
        Self::through(times, positions, &meets, &windows, velocities)
    }

    /// When the motion begins, s.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.pieces[0].0
    }

    /// When the motion ends, s.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.end
    }

    /// When each piece begins, s, and its polynomial in the local time that is 0 there: blends and lines by
    /// turns, without those that take no time.
    #[must_use]
    pub fn pieces(&self) -> &[(f64, Polynomial)] {
        &self.pieces
    }

    /// The constant velocity of each segment, per s.
    #[must_use]
    pub fn velocities(&self) -> &[f64] {
        &self.velocities
    }

    /// The constant acceleration of the blend at each point, with sign, per s²; 0 where there is no blend.
    #[must_use]
    pub fn accelerations(&self) -> &[f64] {
        &self.accelerations
    }

    /// How far from each point the motion is at the point's own time, with sign: position minus point,
    /// `a b²/8`. Zero at the ends when their blends lie inside.
    #[must_use]
    pub fn misses(&self) -> &[f64] {
        &self.misses
    }

    /// Position and first three derivatives at `t`, s; where a piece meets the next, the limit from the
    /// right.
    ///
    /// # Panics
    /// When `t` is outside `[start, end]`.
    #[must_use]
    pub fn eval(&self, t: f64) -> [f64; 4] {
        let start = self.start();
        assert!(
            (start..=self.end).contains(&t),
            "t = {t} s is outside the motion, which lasts from {start} s to {} s",
            self.end
        );
        let next = self.pieces.partition_point(|(start, _)| *start <= t);
        let (start, polynomial) = &self.pieces[next.max(1) - 1];
        polynomial.eval(t - start)
    }

    /// The motion whose lines, of these velocities, meet at the points at the instants `meets`, and whose
    /// blends last from and to the instants of `windows`.
    fn through(
        times: &[f64],
        positions: &[f64],
        meets: &[f64],
        windows: &[[f64; 2]],
        velocities: Vec<f64>,
    ) -> Result<Self, LfpbError> {
        let count = positions.len();
        let mut pieces = Vec::with_capacity(2 * count - 1);
        let mut accelerations = Vec::with_capacity(count);
        let mut misses = Vec::with_capacity(count);
        let mut end = f64::INFINITY;
        for (k, (&position, &[from, to])) in positions.iter().zip(windows).enumerate() {
            // At rest before the first point and after the last.
            let before = if k == 0 { 0.0 } else { velocities[k - 1] };
            let after = velocities.get(k).copied().unwrap_or(0.0);
            if from > end {
                let line = Polynomial::new([position - before * (meets[k] - end), before]);
                pieces.push((end, line));
            }
            let acceleration = (after - before) / (to - from);
            let start = position - before * (meets[k] - from);
            let blend = Polynomial::new([start, before, 0.5 * acceleration]);
            if !blend.is_finite() {
                return Err(LfpbError::Overflow { point: k + 1 });
            }
            pieces.push((from, blend));
            accelerations.push(acceleration);
            misses.push(blend.eval(times[k] - from)[0] - position);
            end = to;
        }
        Ok(Self { end, pieces, velocities, accelerations, misses })
    }
}

/// Blends may overlap by this share of a segment, which is what rounding makes of two that just touch; the
/// line between them is then left out.
const OVERLAP_TOLERANCE: f64 = 1e-12;

fn check(times: &[f64], positions: &[f64], blends: &[f64]) -> Result<(), LfpbError> {
    if times.len() != positions.len() || times.len() != blends.len() {
        return Err(LfpbError::PointCount {
            times: times.len(),
            positions: positions.len(),
            blends: blends.len(),
        });
    }
    if times.len() < 2 {
        return Err(LfpbError::TooFewPoints { count: times.len() });
    }
    for (quantity, values) in [("time", times), ("position", positions)] {
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(LfpbError::NotFinite { point: index + 1, quantity, value: values[index] });
        }
    }
    if let Some(index) = blends.iter().position(|&blend| !(blend > 0.0 && blend.is_finite())) {
        return Err(LfpbError::BlendNotPositive { point: index + 1, blend: blends[index] });
    }
    match times.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(k) => {
            Err(LfpbError::TimesNotIncreasing { point: k + 2, time: times[k + 1], previous: times[k] })
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const TIMES: [f64; 4] = [0.0, 2.0, 4.0, 7.0];
    const BLENDS: [f64; 4] = [0.5; 4];
    /// The RRR example of section 6 of the worked examples: x, y in m, θ in degrees.
    const POINTS: [[f64; 4]; 3] = [[-4.0, 0.0, 3.0, 4.0], [0.0, 3.0, 3.0, 0.0], [90.0, 45.0, 30.0, 0.0]];

    fn example() -> [Lfpb; 3] {
        POINTS.map(|points| Lfpb::with_blend_times(&TIMES, &points, &BLENDS, Ends::Inside).unwrap())
    }

    fn assert_all_near(found: &[f64], expected: &[f64], tolerance: f64) {
        assert_eq!(found.len(), expected.len());
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() <= tolerance, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn velocities_accelerations_and_misses_of_the_rrr_example() {
        let [x, y, theta] = example();
        assert_all_near(x.velocities(), &[16.0 / 7.0, 1.5, 4.0 / 11.0], 1e-9);
        assert_all_near(y.velocities(), &[12.0 / 7.0, 0.0, -12.0 / 11.0], 1e-9);
        assert_all_near(theta.velocities(), &[-180.0 / 7.0, -7.5, -120.0 / 11.0], 1e-9);
        assert_all_near(x.accelerations(), &[32.0 / 7.0, -11.0 / 7.0, -25.0 / 11.0, -8.0 / 11.0], 1e-9);
        assert_all_near(y.accelerations(), &[24.0 / 7.0, -24.0 / 7.0, -24.0 / 11.0, 24.0 / 11.0], 1e-9);
        let expected = [-360.0 / 7.0, 255.0 / 7.0, -75.0 / 11.0, 240.0 / 11.0];
        assert_all_near(theta.accelerations(), &expected, 1e-9);
        assert_all_near(x.misses(), &[0.0, -11.0 / 224.0, -25.0 / 352.0, 0.0], 1e-9);
        assert_all_near(y.misses(), &[0.0, -3.0 / 28.0, -3.0 / 44.0, 0.0], 1e-9);
        assert_all_near(theta.misses(), &[0.0, 255.0 / 224.0, -75.0 / 352.0, 0.0], 1e-9);
    }

    #[test]
    fn pieces_and_values_of_the_rrr_example() {
        let motions = example();
        for motion in &motions {
            let starts: Vec<f64> = motion.pieces().iter().map(|(start, _)| *start).collect();
            assert_all_near(&starts, &[0.0, 0.5, 1.75, 2.25, 3.75, 4.25, 6.5], 1e-12);
            assert_all_near(&[motion.start(), motion.end()], &[0.0, 7.0], 1e-12);
        }
        for (t, expected) in [
            (0.0, [-4.0, 0.0, 90.0]),
            (0.5, [-3.428_571, 0.428_571, 83.571_429]),
            (2.0, [-0.049_107, 2.892_857, 46.138_393]),
            (4.0, [2.928_977, 2.931_818, 29.786_932]),
            (5.0, [3.363_636, 1.909_091, 19.090_909]),
            (6.5, [3.909_091, 0.272_727, 2.727_273]),
            (7.0, [4.0, 0.0, 0.0]),
        ] {
            let found = [0, 1, 2].map(|k: usize| motions[k].eval(t)[0]);
            assert_all_near(&found, &expected, 1e-6);
        }
    }

    #[test]
    fn centred_ends_begin_and_end_outside_the_points() {
        // Every v = Δq/Δt; the first blend from -0.25 s to 0.25 s passes the first point at a b²/8.
        let motion = Lfpb::with_blend_times(&TIMES, &POINTS[0], &BLENDS, Ends::Centred).unwrap();
        assert_all_near(motion.velocities(), &[2.0, 1.5, 1.0 / 3.0], 1e-12);
        assert_all_near(motion.accelerations(), &[4.0, -1.0, -7.0 / 3.0, -2.0 / 3.0], 1e-12);
        assert_all_near(&[motion.start(), motion.end()], &[-0.25, 7.25], 1e-12);
        assert_all_near(motion.misses(), &[0.125, -1.0 / 32.0, -7.0 / 96.0, -1.0 / 48.0], 1e-12);
        assert_all_near(&[motion.eval(-0.25)[0], motion.eval(7.25)[0]], &[-4.0, 4.0], 1e-12);
    }

    #[test]
    fn one_segment_is_the_trapezoid() {
        // lspb-1: 40° -> 120° in 4 s at 25°/s has blends of 0.8 s.
        let motion = Lfpb::with_blend_times(&[0.0, 4.0], &[40.0, 120.0], &[0.8; 2], Ends::Inside).unwrap();
        assert_all_near(motion.velocities(), &[25.0], 1e-12);
        assert_all_near(motion.accelerations(), &[31.25, -31.25], 1e-12);
        assert_eq!(motion.pieces().len(), 3);
    }

    #[test]
    fn blends_that_overlap_name_the_segment_and_what_would_do() {
        let blends = [0.5, 3.0, 1.5, 0.5];
        let of = |blends: &[f64; 4], ends| Lfpb::with_blend_times(&TIMES, &POINTS[0], blends, ends);
        // Segment 1 takes 0.5 s and half of 3 s, its 2 s just suffice; segment 2 takes 2.25 s.
        assert_eq!(
            of(&blends, Ends::Inside),
            Err(LfpbError::BlendsOverlap { segment: 2, from: 2.0, to: 4.0, needed: 2.25, available: 2.0 })
        );
        let message = of(&blends, Ends::Inside).unwrap_err().to_string();
        assert!(
            message.starts_with("segment 2: its blends take 2.25 s of the 2 s from 2 s to 4 s"),
            "{message}"
        );
        // The last blend lies within the last segment as a whole, or by half.
        assert!(matches!(
            of(&[0.5, 0.5, 0.5, 3.0], Ends::Inside),
            Err(LfpbError::BlendsOverlap { segment: 3, .. })
        ));
        assert!(of(&[0.5, 0.5, 0.5, 3.0], Ends::Centred).is_ok());
        // Blends that touch leave no line between them.
        assert_eq!(of(&[0.5, 3.0, 1.0, 0.5], Ends::Inside).unwrap().pieces().len(), 5);
    }

    #[test]
    fn bad_input_names_the_point() {
        let of = |times: &[f64], positions: &[f64], blends: &[f64]| {
            Lfpb::with_blend_times(times, positions, blends, Ends::Inside).unwrap_err()
        };
        assert_eq!(of(&[0.0], &[1.0], &[0.1]), LfpbError::TooFewPoints { count: 1 });
        assert!(matches!(of(&[0.0, 1.0], &[1.0], &[0.1; 2]), LfpbError::PointCount { positions: 1, .. }));
        assert!(matches!(
            of(&[0.0, 1.0], &[1.0, f64::NAN], &[0.1; 2]),
            LfpbError::NotFinite { point: 2, quantity: "position", .. }
        ));
        assert!(matches!(
            of(&[0.0, 0.0], &[1.0, 2.0], &[0.1; 2]),
            LfpbError::TimesNotIncreasing { point: 2, .. }
        ));
        assert!(matches!(
            of(&[0.0, 1.0], &[1.0, 2.0], &[0.1, 0.0]),
            LfpbError::BlendNotPositive { point: 2, .. }
        ));
        assert!(matches!(of(&[0.0, 1.0], &[-1e308, 1e308], &[0.1; 2]), LfpbError::Overflow { point: 1 }));
    }

    proptest! {
        #[test]
        fn velocity_is_continuous_and_misses_follow_the_formula(
            segments in prop::collection::vec((0.5..3.0_f64, -5.0..5.0_f64), 1..6),
            shares in prop::array::uniform6(0.01..1.0_f64),
            start in -2.0..2.0_f64,
            centred in any::<bool>(),
        ) {
            let mut times = vec![start];
            let mut positions = vec![0.3];
            for (duration, position) in &segments {
                times.push(times[times.len() - 1] + duration);
                positions.push(*position);
            }
            // Blends that fit: at most 0.33 s at both ends of a segment of 0.5 s or more.
            let blends: Vec<f64> = (0..times.len()).map(|k| 0.33 * shares[k]).collect();
            let ends = if centred { Ends::Centred } else { Ends::Inside };
            let motion = Lfpb::with_blend_times(&times, &positions, &blends, ends).unwrap();
            let pieces = motion.pieces();
            for (k, (from, piece)) in pieces.iter().enumerate() {
                let to = pieces.get(k + 1).map_or(motion.end(), |next| next.0);
                let [q, qd, ..] = piece.eval(to - from);
                let [next_q, next_qd, ..] =
                    pieces.get(k + 1).map_or([positions[positions.len() - 1], 0.0, 0.0, 0.0], |next| next.1.eval(0.0));
                prop_assert!((q - next_q).abs() < 1e-12 && (qd - next_qd).abs() < 1e-9, "after piece {k}");
            }
            prop_assert_eq!(motion.eval(motion.start())[1].to_bits(), 0.0_f64.to_bits());
            for k in 0..times.len() {
                let is_met = !centred && (k == 0 || k == times.len() - 1);
                let formula = if is_met { 0.0 } else { motion.accelerations()[k] * blends[k].powi(2) / 8.0 };
                prop_assert!((motion.misses()[k] - formula).abs() < 1e-12);
                prop_assert!((motion.eval(times[k])[0] - positions[k] - formula).abs() < 1e-12);
            }
        }
    }
}
