//! Linear function with parabolic blends (LFPB) through many points.
//!
//! Between two points a coordinate moves at constant velocity, about each point it changes velocity at
//! constant acceleration. It passes *near* inner points, not through them. Field words: multi-segment LSPB,
//! linear segments with parabolic blends.
//!
//! ```text
//! v = Δq/Δe      on the line of each segment
//! a = Δv/b       in the blend of each point, of duration b, centred on eₖ
//! a b²/8         is how far the point is missed at its own time
//! ```
//!
//! Each point k has an instant eₖ at which the two lines beside it meet; inner points have eₖ = tₖ. With
//! [`BlendEnds::Centred`] so have the first and the last (Siciliano et al., *Robotics: Modelling, Planning and
//! Control*, section 4.2.2), and the motion begins and ends half a blend outside. With [`BlendEnds::Inside`]
//! the motion begins at t₁ and ends at t_N, so that e₁ = t₁ + b₁/2 and e_N = t_N - b_N/2 (Craig,
//! *Introduction to Robotics*, section 7.3).
//!
//! At each point either b is given or |a| ([`Blend`]), also mixed. With |a| given
//!
//! | point | duration of its blend |
//! |---|---|
//! | inner, or centred | `b = |Δv|/|a|` |
//! | first or last of several segments, inside; T and D of its segment | `b = T − √(T² − 2D/|a|)` |
//! | both of a single segment | `v = (T − √(T² − 2cD))/c`, c = 1/|a₁| + 1/|a₂|, b = v/|a| |
//!
//! A negative number under a root, or blends that overlap, mean that an acceleration is too small or a blend
//! time too long: the error says where, by how much, and the least acceleration or longest time with which the
//! segment's blends just touch ([`Remedy`]).
//!
//! A point that must be met lies on the line between two *pseudo via points* ([`Met`]); only infinite
//! acceleration would meet it otherwise.
//!
//! One coordinate is an [`Lfpb`]; several that move together, in joint space or in x, y and theta, are an
//! [`LfpbMotion`].

mod course;
mod error;
mod motion;
mod pseudo;

pub use error::{LfpbError, Place, Remedy};
pub use graspcheck_model::via::{Blend, BlendEnds};
pub use motion::LfpbMotion;
pub use pseudo::{LfpbPoint, Met};

use course::{Course, Solution};
use graspcheck_motion::{Polynomial, trajectory::SMOOTH_TOLERANCE};

/// The shortest blend as a share of the motion.
///
/// The reason: instants are rounded by 1e-16 of the motion, which must be little in a blend. Where rounding
/// alone makes a line turn, the change of velocity is so small that no blend is needed.
const SHORTEST_BLEND: f64 = 1e-12;

/// A linear function with parabolic blends: position and velocity continuous, from rest to rest.
///
/// Time is that of its points, so that it need not begin at 0. Positions have the caller's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Lfpb {
    end: f64,
    pieces: Vec<(f64, Polynomial)>,
    places: Vec<Place>,
    velocities: Vec<f64>,
    accelerations: Vec<f64>,
    durations: Vec<f64>,
    misses: Vec<f64>,
}

impl Lfpb {
    /// The motion past `points`.
    ///
    /// ```
    /// use graspcheck_planner::lfpb::{Blend, BlendEnds, Lfpb, LfpbError, LfpbPoint, Remedy, Place};
    ///
    /// // 40° to 120° in 4 s by blends of 25°/s²: lines at 27.64°/s, blends of 1.106 s.
    /// let of = |acceleration| {
    ///     let blend = Blend::Acceleration(acceleration);
    ///     Lfpb::new(&[LfpbPoint::near(0.0, 40.0, blend), LfpbPoint::near(4.0, 120.0, blend)], BlendEnds::Inside)
    /// };
    /// let motion = of(25.0)?;
    /// assert!((motion.velocities()[0] - 27.639_320_225).abs() < 1e-9);
    /// assert!((motion.blend_times()[0] - 1.105_572_809).abs() < 1e-9);
    /// // 19°/s² at both ends are too small. With 19 at one, 21.1 at the other would do.
    /// let Err(LfpbError::AccelerationTooSmall { remedies, .. }) = of(19.0) else { panic!() };
    /// let Blend::Acceleration(least) = remedies[0].blend else { panic!() };
    /// assert!((least - 1.0 / (0.1 - 1.0 / 19.0)).abs() < 1e-9);
    /// # Ok::<(), LfpbError>(())
    /// ```
    ///
    /// # Errors
    /// When there are fewer than two points, a number is not finite or not positive, times do not increase,
    /// an acceleration is too small, blends overlap, a pseudo via point passes a neighbour, or an end is to
    /// lie between pseudo via points.
    pub fn new(points: &[LfpbPoint], ends: BlendEnds) -> Result<Self, LfpbError> {
        let course = pseudo::course(points, ends)?;
        let solution = course.solve()?;
        Self::through(course, solution, points.len())
    }

    /// The motion that passes near `positions` at `times`, s, with these durations of the blends at the
    /// points, s.
    ///
    /// ```
    /// use graspcheck_planner::lfpb::{BlendEnds, Lfpb};
    /// // x of the worked example: the second point, 0, is missed by qdd t²/8 = -11/7 · 0.25/8.
    /// let x = Lfpb::with_blend_times(&[0.0, 2.0, 4.0, 7.0], &[-4.0, 0.0, 3.0, 4.0], &[0.5; 4], BlendEnds::Inside)?;
    /// assert!((x.misses()[1] + 11.0 / 224.0).abs() < 1e-14);
    /// # Ok::<(), graspcheck_planner::lfpb::LfpbError>(())
    /// ```
    ///
    /// # Errors
    /// When the slices differ in length; as [`Lfpb::new`].
    pub fn with_blend_times(
        times: &[f64],
        positions: &[f64],
        blends: &[f64],
        ends: BlendEnds,
    ) -> Result<Self, LfpbError> {
        Self::with_blends(times, positions, blends, Blend::Duration, ends)
    }

    /// The motion that passes near `positions` at `times`, s, with these magnitudes of the acceleration in the
    /// blends at the points, per s².
    ///
    /// ```
    /// use graspcheck_planner::lfpb::{BlendEnds, Lfpb};
    /// // 40° to 120° in 4 s: 20°/s² are the least that do, and leave no linear part.
    /// let motion = Lfpb::with_accelerations(&[0.0, 4.0], &[40.0, 120.0], &[20.0; 2], BlendEnds::Inside)?;
    /// assert!((motion.velocities()[0] - 40.0).abs() < 1e-6);
    /// # Ok::<(), graspcheck_planner::lfpb::LfpbError>(())
    /// ```
    ///
    /// # Errors
    /// When the slices differ in length; as [`Lfpb::new`].
    pub fn with_accelerations(
        times: &[f64],
        positions: &[f64],
        accelerations: &[f64],
        ends: BlendEnds,
    ) -> Result<Self, LfpbError> {
        Self::with_blends(times, positions, accelerations, Blend::Acceleration, ends)
    }

    fn with_blends(
        times: &[f64],
        positions: &[f64],
        blends: &[f64],
        blend: fn(f64) -> Blend,
        ends: BlendEnds,
    ) -> Result<Self, LfpbError> {
        if times.len() != positions.len() || times.len() != blends.len() {
            return Err(LfpbError::PointCount {
                times: times.len(),
                positions: positions.len(),
                blends: blends.len(),
            });
        }
        let point = |k: usize| LfpbPoint::near(times[k], positions[k], blend(blends[k]));
        Self::new(&(0..times.len()).map(point).collect::<Vec<_>>(), ends)
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

    /// The places in order of time: the points, and in the place of one that must be met its two pseudo via
    /// points. Lines lead from each to the next, and each has a blend.
    #[must_use]
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// The duration of the blend at each place, s; 0 where an acceleration is given and the velocity does not
    /// change.
    #[must_use]
    pub fn blend_times(&self) -> &[f64] {
        &self.durations
    }

    /// The constant acceleration of the blend at each place, with sign, per s²; 0 where there is no blend.
    #[must_use]
    pub fn accelerations(&self) -> &[f64] {
        &self.accelerations
    }

    /// How far from each point the motion is at the point's own time, with sign: position minus point,
    /// `a b²/8`. Zero at points that are met, and at the ends when their blends lie inside.
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

    fn through(course: Course, mut solution: Solution, points: usize) -> Result<Self, LfpbError> {
        let count = course.times.len();
        let span = course.times[count - 1] - course.times[0];
        let mut pieces = Vec::with_capacity(2 * count - 1);
        let mut accelerations = Vec::with_capacity(count);
        let mut misses = vec![0.0; points];
        let mut end = f64::INFINITY;
        for (k, &position) in course.positions.iter().enumerate() {
            let meet = solution.meets[k];
            // At rest before the first point and after the last.
            let before = if k == 0 { 0.0 } else { solution.velocities[k - 1] };
            let (change, duration) = (solution.change(k), solution.durations[k]);
            let [from, to] = window(&course, k, meet, duration);
            if from > end {
                let line = Polynomial::new([position - before * (meet - end), before]);
                pieces.push((end, line));
            }
            if duration <= SHORTEST_BLEND * span {
                let scale = before.abs().max((before + change).abs()).max(1.0);
                if change.abs() > SMOOTH_TOLERANCE * scale {
                    let least = SHORTEST_BLEND * span;
                    return Err(LfpbError::BlendTooShort { place: course.places[k], duration, least });
                }
                solution.durations[k] = 0.0;
                accelerations.push(0.0);
                end = meet;
                continue;
            }
            // In the time that is left between the rounded instants, so that the velocity is continuous.
            let start = position - before * (meet - from);
            let blend = Polynomial::new([start, before, 0.5 * change / (to - from)]);
            if !blend.is_finite() {
                return Err(LfpbError::Overflow { place: course.places[k] });
            }
            pieces.push((from, blend));
            accelerations.push(change / duration);
            if let Place::Point(number) = course.places[k]
                && !course.lies_inside(k)
            {
                misses[number - 1] = change * duration / 8.0;
            }
            end = to;
        }
        let Course { places, .. } = course;
        let Solution { durations, velocities, .. } = solution;
        Ok(Self { end, pieces, places, velocities, accelerations, durations, misses })
    }
}

/// When a blend begins and ends, s.
fn window(course: &Course, place: usize, meet: f64, duration: f64) -> [f64; 2] {
    let last = course.times.len() - 1;
    let [mut from, mut to] = [meet - 0.5 * duration, meet + 0.5 * duration];
    if course.lies_inside(place) {
        // Exactly, whatever rounding did to the halves.
        if place == 0 {
            from = course.times[0];
        }
        if place == last {
            to = course.times[last];
        }
    }
    [from, to]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::via::ViaError;

    const TIMES: [f64; 4] = [0.0, 2.0, 4.0, 7.0];
    const BLENDS: [f64; 4] = [0.5; 4];
    /// The RRR example of section 6 of the worked examples: x, y in m, θ in degrees.
    const POINTS: [[f64; 4]; 3] = [[-4.0, 0.0, 3.0, 4.0], [0.0, 3.0, 3.0, 0.0], [90.0, 45.0, 30.0, 0.0]];

    fn example() -> [Lfpb; 3] {
        POINTS.map(|points| Lfpb::with_blend_times(&TIMES, &points, &BLENDS, BlendEnds::Inside).unwrap())
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
        let motion = Lfpb::with_blend_times(&TIMES, &POINTS[0], &BLENDS, BlendEnds::Centred).unwrap();
        assert_all_near(motion.velocities(), &[2.0, 1.5, 1.0 / 3.0], 1e-12);
        assert_all_near(motion.accelerations(), &[4.0, -1.0, -7.0 / 3.0, -2.0 / 3.0], 1e-12);
        assert_all_near(&[motion.start(), motion.end()], &[-0.25, 7.25], 1e-12);
        assert_all_near(motion.misses(), &[0.125, -1.0 / 32.0, -7.0 / 96.0, -1.0 / 48.0], 1e-12);
        assert_all_near(&[motion.eval(-0.25)[0], motion.eval(7.25)[0]], &[-4.0, 4.0], 1e-12);
    }

    #[test]
    fn one_segment_is_the_trapezoid() {
        // lspb-1: 40° -> 120° in 4 s at 25°/s has blends of 0.8 s.
        let motion =
            Lfpb::with_blend_times(&[0.0, 4.0], &[40.0, 120.0], &[0.8; 2], BlendEnds::Inside).unwrap();
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
            of(&blends, BlendEnds::Inside).unwrap_err().to_string(),
            "segment from point 2 to point 3: its blends take 2.25 s of the 2 s from 2 s to 4 s, 0.25 s too much; \
             shorten the blend at point 2 to at most 2.5 s, or shorten the blend at point 3 to at most 1 s"
        );
        // The last blend lies within the last segment as a whole, or by half.
        assert!(matches!(
            of(&[0.5, 0.5, 0.5, 3.0], BlendEnds::Inside),
            Err(LfpbError::BlendsOverlap { from: Place::Point(3), .. })
        ));
        assert!(of(&[0.5, 0.5, 0.5, 3.0], BlendEnds::Centred).is_ok());
        // Blends that touch leave no line between them.
        assert_eq!(of(&[0.5, 3.0, 1.0, 0.5], BlendEnds::Inside).unwrap().pieces().len(), 5);
    }

    #[test]
    fn bad_input_names_the_point() {
        let of = |times: &[f64], positions: &[f64], blends: &[f64]| {
            Lfpb::with_blend_times(times, positions, blends, BlendEnds::Inside).unwrap_err()
        };
        assert_eq!(of(&[0.0], &[1.0], &[0.1]), LfpbError::Points(ViaError::TooFewPoints { count: 1 }));
        assert!(matches!(of(&[0.0, 1.0], &[1.0], &[0.1; 2]), LfpbError::PointCount { positions: 1, .. }));
        assert!(matches!(
            of(&[0.0, 1.0], &[1.0, f64::NAN], &[0.1; 2]),
            LfpbError::Points(ViaError::NotFinite { quantity: "position", .. })
        ));
        assert!(matches!(
            of(&[0.0, 0.0], &[1.0, 2.0], &[0.1; 2]),
            LfpbError::Points(ViaError::TimesNotIncreasing { point: 2, .. })
        ));
        assert!(matches!(
            of(&[0.0, 1.0], &[1.0, 2.0], &[0.1, 0.0]),
            LfpbError::NotPositive { point: 2, quantity: "blend time", .. }
        ));
        assert!(matches!(
            of(&[0.0, 1.0], &[-1e308, 1e308], &[0.1; 2]),
            LfpbError::Overflow { place: Place::Point(1) }
        ));
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
            let ends = if centred { BlendEnds::Centred } else { BlendEnds::Inside };
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
