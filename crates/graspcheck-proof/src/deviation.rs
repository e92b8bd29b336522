//! How far the tool can be from its path, at every instant, proved.
//!
//! The joints follow polynomials, the path is another formula, and the two differ by an error e(t) that is
//! small and wavy: sampling it proves nothing. Here it is enclosed. On a stretch of time with middle m and
//! half width r
//!
//! ```text
//! e(m + d) = FK(q(m + d)) − p(s(m + d)) = Σₖ₍<₈₎ eₖ dᵏ + e₈ d⁸,     |d| ≤ r
//! ```
//!
//! where the first eight coefficients are those at the middle and the last one is taken from interval
//! arithmetic over the whole stretch: a Taylor model ([`graspcheck_motion::jet`]). The polynomial is bounded
//! by the control points of its Bernstein form, after two halvings: a curve stays in the convex hull of its
//! control points, so the longest of them is a bound on the distance (Farin, *Curves and Surfaces for
//! CAGD*, 2002, section 5.1). Rounding is enclosed throughout. A stretch whose bound is too large is halved, until
//! it is proved, or an instant is found at which the tool *is* too far away.
//!
//! The error is that at the same instant: the tool against where the law of time wants it on the path. The
//! distance from the nearest place of the path is not larger.

use graspcheck_model::planar_path::{PLANAR_JOINTS, PlanarPath};
use graspcheck_motion::{Interval, Jet, Polynomial, Trajectory, taylor_model};

/// Coefficients of a Taylor model: the error is of order eight in the length of a stretch.
const ORDER: usize = 9;

/// Halvings of the control polygon before its points are measured. Two leave it at most a few percent beyond
/// the curve for errors as quintic pieces make them.
const SUBDIVISIONS: usize = 2;

/// A stretch is halved, although it is proved, while what is not known of the error (remainder and rounding) makes
/// up more than this share of a bound that matters: the bounds that are reported are then near the truth.
const BLUR_SHARE: f64 = 0.5;

/// Share of the tolerance below which a bound does not matter so.
const NEGLIGIBLE_SHARE: f64 = 1e-3;

/// Halvings of a stretch of time that cannot be proved before it is given up.
const DEPTH_MAX: usize = 16;

/// Two knots nearer than this share of the motion are one, up to the rounding of a stretch in time.
const SAME_KNOT: f64 = 1e-12;

/// How far the tool is from its path, or may be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Distance of the tool's origin from where it should be, m.
    pub position: f64,
    /// Angle between the tool and how it should be turned, rad.
    pub angle: f64,
}

impl Deviation {
    /// The larger of both, separately for position and angle.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self { position: self.position.max(other.position), angle: self.angle.max(other.angle) }
    }

    /// Whether neither is beyond a tolerance; NaN is.
    #[must_use]
    pub fn is_within(self, tolerance: Self) -> bool {
        self.position <= tolerance.position && self.angle <= tolerance.angle
    }
}

/// A bound on the deviation over a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PieceDeviation {
    /// When the stretch begins, s.
    pub start: f64,
    /// When it ends, s.
    pub end: f64,
    /// The bound over it.
    pub bound: Deviation,
}

/// What a proof of the deviation has found.
#[derive(Clone, Debug, PartialEq)]
pub enum DeviationOutcome {
    /// The tool stays within the tolerance at every instant: bounds over stretches that cover the motion.
    Within(Vec<PieceDeviation>),
    /// It does not: at this instant it is at least so far away.
    Exceeds {
        /// When, s.
        at: f64,
        /// A lower bound.
        deviation: Deviation,
    },
    /// Neither could be shown over a stretch, which ends the search.
    Unknown(PieceDeviation),
}

impl DeviationOutcome {
    /// The bound over the whole motion, if it is proved to be within the tolerance.
    #[must_use]
    pub fn bound(&self) -> Option<Deviation> {
        match self {
            Self::Within(pieces) => {
                Some(pieces.iter().map(|piece| piece.bound).fold(Deviation::default(), Deviation::max))
            }
            Self::Exceeds { .. } | Self::Unknown(_) => None,
        }
    }
}

/// Why motion, law and path do not belong together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DeviationError {
    /// Numbers of joints differ.
    #[error("deviation: the motion has {motion} joints, the arm of the path {path}; plan for the same arm")]
    JointCount {
        /// Of the motion.
        motion: usize,
        /// Of the path's arm.
        path: usize,
    },
    /// The law is not one of a single parameter.
    #[error("deviation: the law of time has {count} parameters; it must be s alone")]
    LawCount {
        /// How many.
        count: usize,
    },
    /// The law does not last as long as the motion.
    #[error("deviation: the motion lasts {motion} s, the law of time {law} s; stretch both alike")]
    Duration {
        /// Of the motion, s.
        motion: f64,
        /// Of the law, s.
        law: f64,
    },
}

/// Proves that the tool stays within `tolerance` of `path` while the joints make `motion`, s being where it
/// should be on the path (`law`, a motion of one "joint").
///
/// # Errors
/// When the three do not belong together.
pub fn prove_deviation(
    path: &PlanarPath,
    law: &Trajectory,
    motion: &Trajectory,
    tolerance: Deviation,
) -> Result<DeviationOutcome, DeviationError> {
    if motion.dof() != path.dof() {
        return Err(DeviationError::JointCount { motion: motion.dof(), path: path.dof() });
    }
    if law.dof() != 1 {
        return Err(DeviationError::LawCount { count: law.dof() });
    }
    let duration = motion.duration();
    if (law.duration() - duration).abs() > SAME_KNOT * duration {
        return Err(DeviationError::Duration { motion: duration, law: law.duration() });
    }
    let mut proved = Vec::with_capacity(motion.piece_count());
    for [start, end] in stretches(law, motion) {
        let middle = 0.5 * (start + end);
        let piece = motion.piece_at(middle);
        let law_piece = law.piece_at(middle.min(law.duration()));
        let stretch = Stretch {
            path,
            segment: path.segment_at(law.piece(law_piece, 0).eval(middle - law.knots()[law_piece])[0]),
            law: law.piece(law_piece, 0),
            law_start: law.knots()[law_piece],
            joints: motion.piece_of_all(piece),
            joints_start: motion.knots()[piece],
        };
        let mut todo = vec![(start, end, 0)];
        while let Some((start, end, depth)) = todo.pop() {
            let (bound, blur) = stretch.bound(start, end);
            let blurred = blur > BLUR_SHARE * bound.position
                && bound.position > NEGLIGIBLE_SHARE * tolerance.position
                && depth < DEPTH_MAX;
            if bound.is_within(tolerance) && !blurred {
                proved.push(PieceDeviation { start, end, bound });
                continue;
            }
            let middle = 0.5 * (start + end);
            if bound.is_within(tolerance) {
                todo.push((middle, end, depth + 1));
                todo.push((start, middle, depth + 1));
                continue;
            }
            let least = stretch.least_at(middle);
            if !least.is_within(tolerance) {
                return Ok(DeviationOutcome::Exceeds { at: middle, deviation: least });
            }
            if depth == DEPTH_MAX {
                return Ok(DeviationOutcome::Unknown(PieceDeviation { start, end, bound }));
            }
            todo.push((middle, end, depth + 1));
            todo.push((start, middle, depth + 1));
        }
    }
    Ok(DeviationOutcome::Within(proved))
}

/// A bound on the deviation over one piece of a motion in making: `law` and the quintics `joints` are
/// polynomials in the local times that begin `law_before` and 0 seconds before the piece, which lasts
/// `duration` seconds. The bound is only as tight as it takes to be within `tolerance`, if it can be.
#[must_use]
pub fn piece_deviation(
    path: &PlanarPath,
    segment: usize,
    law: &Polynomial,
    law_before: f64,
    joints: &[Polynomial],
    duration: f64,
    tolerance: Deviation,
) -> Deviation {
    let stretch = Stretch { path, segment, law, law_start: -law_before, joints, joints_start: 0.0 };
    let (whole, _) = stretch.bound(0.0, duration);
    if whole.is_within(tolerance) {
        return whole;
    }
    // Halves know more: the remainder falls with the eighth power of the length.
    let middle = 0.5 * duration;
    stretch.bound(0.0, middle).0.max(stretch.bound(middle, duration).0)
}

/// The stretches between the knots of law and motion.
fn stretches(law: &Trajectory, motion: &Trajectory) -> Vec<[f64; 2]> {
    let mut knots: Vec<f64> = law.knots().iter().chain(motion.knots()).copied().collect();
    knots.sort_by(f64::total_cmp);
    let duration = motion.duration();
    // What is nearer than rounding to a knot is that knot; the sliver between them belongs to the stretch
    // before it, whose polynomials go on there as they are.
    knots.dedup_by(|later, earlier| *later - *earlier <= SAME_KNOT * duration);
    let last = knots.len() - 1;
    knots[last] = duration;
    knots.windows(2).map(|two| [two[0], two[1]]).collect()
}

/// A time in which neither law nor joints nor path change their formula.
struct Stretch<'a> {
    path: &'a PlanarPath,
    segment: usize,
    law: &'a Polynomial,
    law_start: f64,
    joints: &'a [Polynomial],
    joints_start: f64,
}

impl Stretch<'_> {
    /// Errors of position and ψ as functions of time at all times in `t`.
    fn error<const N: usize>(&self, t: Interval) -> [Jet<Interval, N>; 4] {
        let s = Jet::of_polynomial(self.law, t - Interval::point(self.law_start));
        let local = t - Interval::point(self.joints_start);
        let mut q = [Jet::<Interval, N>::from(0.0); PLANAR_JOINTS];
        for (q, polynomial) in q.iter_mut().zip(self.joints) {
            *q = Jet::of_polynomial(polynomial, local);
        }
        let (position, turn) = self.path.forward(&q);
        let wanted = self.path.point(self.segment, s);
        let mut turn = turn - self.path.turn(self.segment, s);
        // The joints may stand whole turns away from the path's angle.
        let turns = (turn.value().middle() / std::f64::consts::TAU).round();
        let tau = Interval::between(std::f64::consts::TAU, std::f64::consts::TAU.next_up());
        turn.coefficients[0] = turn.value() - tau * turns;
        let [x, y, z] = std::array::from_fn(|axis| position[axis] - wanted[axis]);
        [x, y, z, turn]
    }

    /// A bound over the time from `start` to `end`, and how much of the position's is remainder and rounding, m.
    fn bound(&self, start: f64, end: f64) -> (Deviation, f64) {
        let middle = 0.5 * (start + end);
        let half = (end - middle).max(middle - start);
        let at_middle = self.error::<ORDER>(Interval::point(middle));
        let over_all = self.error::<ORDER>(Interval::between(start, end));
        let models: [[Interval; ORDER]; 4] =
            std::array::from_fn(|k| scaled(taylor_model(&at_middle[k], &over_all[k]), half));
        let slack = self.path.slack();
        let [x, y, z, turn] = &models;
        let (position, blur) = largest([x, y, z]);
        let (angle, _) = largest([turn]);
        (Deviation { position: position + slack.position, angle: angle + slack.angle }, blur)
    }

    /// A lower bound at one instant.
    fn least_at(&self, t: f64) -> Deviation {
        let [x, y, z, turn] = self.error::<1>(Interval::point(t)).map(|jet| jet.value());
        let slack = self.path.slack();
        let distance = (x.square() + y.square() + z.square()).sqrt();
        Deviation {
            position: (distance.lower() - slack.position).max(0.0),
            angle: (turn.mignitude() - slack.angle).max(0.0),
        }
    }
}

/// Coefficients of the same polynomial in d/half, from −1 to 1.
fn scaled(mut model: [Interval; ORDER], half: f64) -> [Interval; ORDER] {
    let mut power = Interval::point(1.0);
    for coefficient in &mut model {
        *coefficient = *coefficient * power;
        power = power * half;
    }
    model
}

/// A bound on the length of a vector whose coordinates are polynomials with interval coefficients on [−1, 1], and
/// how much of it the widths of the coefficients make up.
fn largest<const D: usize>(coordinates: [&[Interval; ORDER]; D]) -> (f64, f64) {
    let mut control = [[0.0; D]; ORDER];
    let mut blur_square = 0.0;
    for (axis, coefficients) in coordinates.into_iter().enumerate() {
        let mut magnitude = 0.0;
        let mut blur = 0.0;
        for (k, coefficient) in coefficients.iter().enumerate() {
            let middle = coefficient.middle();
            magnitude += middle.abs();
            blur += (coefficient.upper() - middle).max(middle - coefficient.lower());
            for (point, row) in control.iter_mut().zip(&BERNSTEIN) {
                point[axis] += row[k] * middle;
            }
        }
        // Each control point is a sum of ORDER products, each halving averages ORDER times; 1 + ORDER
        // roundings of terms that are not larger than the sum of magnitudes.
        blur = (blur + ROUNDINGS * f64::EPSILON * magnitude) * (1.0 + ROUNDINGS * f64::EPSILON);
        blur_square += blur * blur;
    }
    let blur = blur_square.sqrt();
    ((longest(&mut control, SUBDIVISIONS) + blur) * (1.0 + ROUNDINGS * f64::EPSILON), blur)
}

/// A number of roundings beyond those of a control point and its halvings, in units of the last place.
const ROUNDINGS: f64 = 64.0;

/// The longest control point after halving `times` times.
fn longest<const D: usize>(control: &mut [[f64; D]; ORDER], times: usize) -> f64 {
    if times == 0 {
        let square = |point: &[f64; D]| point.iter().map(|x| x * x).sum::<f64>();
        // Coefficients without bound blur the result without bound, whatever is found here.
        return control.iter().map(square).fold(0.0, f64::max).sqrt();
    }
    // De Casteljau at the middle: the left half's points are left behind, the right half remains.
    let mut left = *control;
    for (level, first) in left.iter_mut().enumerate().skip(1) {
        for k in 0..ORDER - level {
            let next = control[k + 1];
            for (x, y) in control[k].iter_mut().zip(next) {
                *x = 0.5 * (*x + y);
            }
        }
        *first = control[0];
    }
    // In place, `control[k]` now holds the point of level ORDER − 1 − k: the right half in order.
    let (a, b) = (longest(&mut left, times - 1), longest(control, times - 1));
    if a >= b { a } else { b }
}

/// Entry `[i][k]` is the i-th Bernstein coefficient of uᵏ on [−1, 1] for degree ORDER − 1:
/// `Σⱼ C(i, j) C(n−i, k−j) (−1)ᵏ⁻ʲ / C(n, k)`, none larger than 1.
const BERNSTEIN: [[f64; ORDER]; ORDER] = {
    let n = ORDER - 1;
    let mut table = [[0.0; ORDER]; ORDER];
    let mut i = 0;
    while i <= n {
        let mut k = 0;
        while k <= n {
            let mut sum = 0.0;
            let mut j = 0;
            while j <= k {
                let sign = if (k - j) % 2 == 0 { 1.0 } else { -1.0 };
                sum += sign * choose(i, j) * choose(n - i, k - j);
                j += 1;
            }
            table[i][k] = sum / choose(n, k);
            k += 1;
        }
        i += 1;
    }
    table
};

/// C(n, k), 0 for k > n.
const fn choose(n: usize, k: usize) -> f64 {
    if k > n {
        return 0.0;
    }
    let mut value = 1.0;
    let mut i = 0;
    while i < k {
        value = value * ((n - i) as f64) / ((i + 1) as f64);
        i += 1;
    }
    value
}
