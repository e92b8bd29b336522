//! Laws of an exact duration between two states, under limits.

use super::{
    JointLaw, RateLimits,
    extremal::{Extreme, Farthest, ROUNDING},
    fastest::check,
};
use crate::time_scaling::{ScalingError, error::positive, pieces::Pieces};

impl JointLaw {
    /// A law of exactly this duration, s, between two states `[position, velocity, acceleration]` under limits on the
    /// magnitudes of velocity, acceleration and jerk; an error if there is none.
    ///
    /// Of all laws of this duration one gets farthest and one stays farthest behind, by D₊ and D₋; both are known (see
    /// [`JointLaw::fastest`]). Their mixture `(1 - λ) q₋ + λ q₊` with `λ = (D - D₋)/(D₊ - D₋)` covers D and keeps every limit,
    /// because the limits are convex; and where D is not between D₋ and D₊ no law does it. From rest to rest the mixture is
    /// the farthest law on a smaller scale.
    ///
    /// Durations that can be met may have gaps: see [`JointLaw::possible_durations`].
    ///
    /// ```
    /// use graspcheck_planner::joint_law::{JointLaw, RateLimits};
    /// let limits = RateLimits { velocity: 1.0, acceleration: 2.0, jerk: 10.0 };
    /// let law = JointLaw::lasting([0.0, 0.2, 1.0], [1.0, 0.0, 0.0], limits, 2.0)?;
    /// assert_eq!((law.duration(), law.end()[0]), (2.0, 1.0));
    /// let error = JointLaw::lasting([0.0; 3], [1.0, 0.0, 0.0], limits, 1.0).unwrap_err();
    /// assert!(error.to_string().contains("the least duration is 1.7"), "{error}");
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// As [`JointLaw::fastest`], when the duration is not positive and finite, or when it cannot be met; the error then
    /// says which durations can.
    pub fn lasting(
        start: [f64; 3],
        end: [f64; 3],
        limits: RateLimits,
        duration: f64,
    ) -> Result<Self, ScalingError> {
        check(start, end, limits)?;
        positive("duration", duration)?;
        let [least, most] = [-1.0, 1.0].map(|sign| Farthest::new(sign, start, end, limits));
        let distance = end[0] - start[0];
        let Some((behind, ahead, share)) = mixture(&least, &most, distance, duration) else {
            return Err(not_possible(&Self::possible_durations(start, end, limits)?, duration));
        };
        let [behind, ahead] =
            [least.pieces(behind, start[0] - behind.distance), most.pieces(ahead, start[0] + ahead.distance)];
        Self::new(distance, duration, Pieces::mixed(&behind, &ahead, share, end[0], duration))
    }

    /// The durations, s, in which the motion between two states `[position, velocity, acceleration]` can be made under
    /// limits: intervals `[from, to]` in order of time, the last of which is endless.
    ///
    /// There is one from rest to rest. Between moving ends there may be gaps: a joint that goes backwards at both ends
    /// can cover a little way backwards at once, or turn round twice; in between it can do neither.
    ///
    /// ```
    /// use graspcheck_planner::joint_law::{JointLaw, RateLimits};
    /// let limits = RateLimits { velocity: 1.0, acceleration: 2.0, jerk: 10.0 };
    /// let possible = JointLaw::possible_durations([0.0, 0.5, 0.0], [0.1, 0.5, 0.0], limits)?;
    /// assert_eq!(possible.len(), 2);
    /// assert!(possible[0][0] < 0.2 && possible[0][1] < possible[1][0] && possible[1][1] == f64::INFINITY);
    /// # Ok::<(), graspcheck_planner::time_scaling::ScalingError>(())
    /// ```
    ///
    /// # Errors
    /// As [`JointLaw::fastest`].
    pub fn possible_durations(
        start: [f64; 3],
        end: [f64; 3],
        limits: RateLimits,
    ) -> Result<Vec<[f64; 2]>, ScalingError> {
        check(start, end, limits)?;
        let distance = end[0] - start[0];
        let both = [-1.0, 1.0].map(|sign| Farthest::new(sign, start, end, limits));
        // Where the answer can change.
        let mut ends: Vec<f64> =
            both.iter().flat_map(Farthest::duration_ends).filter(|t| !t.is_nan()).collect();
        let mut shortest = f64::INFINITY;
        for (laws, sign) in both.iter().zip([-1.0, 1.0]) {
            laws.covering(sign * distance, |law| {
                ends.push(law.duration);
                shortest = shortest.min(law.duration);
            });
        }
        ends.sort_unstable_by(f64::total_cmp);
        ends.dedup_by(|next, kept| *next - *kept <= 16.0 * ROUNDING * *next);
        let mut possible: Vec<[f64; 2]> = Vec::new();
        let after = ends.iter().skip(1).copied().chain([f64::INFINITY]);
        for (&from, to) in ends.iter().zip(after) {
            let within = if to.is_finite() {
                0.5 * (from + to)
            } else {
                2.0 * from + limits.acceleration / limits.jerk
            };
            if mixture(&both[0], &both[1], distance, within).is_some() {
                match possible.last_mut() {
                    Some(last) if last[1] >= from => last[1] = to,
                    _ => possible.push([from, to]),
                }
            }
        }
        // The least duration may stand alone.
        if possible.first().is_none_or(|[from, _]| shortest < from * (1.0 - 32.0 * ROUNDING)) {
            possible.insert(0, [shortest; 2]);
        }
        Ok(possible)
    }
}

/// The laws of this duration that stay farthest behind and get farthest, and the share of the second in the mixture that
/// covers the distance; `None` if there is none.
fn mixture(
    least: &Farthest,
    most: &Farthest,
    distance: f64,
    duration: f64,
) -> Option<(Extreme, Extreme, f64)> {
    let (behind, ahead) = (least.lasting(duration)?, most.lasting(duration)?);
    let [from, to] = [-behind.distance, ahead.distance];
    let rounding = 16.0 * ROUNDING * (from.abs() + to.abs() + distance.abs());
    if distance < from - rounding || distance > to + rounding {
        return None;
    }
    let share = if to - from > rounding { ((distance - from) / (to - from)).clamp(0.0, 1.0) } else { 0.5 };
    Some((behind, ahead, share))
}

/// The error that says which durations could be met instead.
fn not_possible(possible: &[[f64; 2]], duration: f64) -> ScalingError {
    let before = possible.iter().map(|[_, to]| *to).rfind(|to| *to < duration);
    let after = possible.iter().map(|[from, _]| *from).find(|from| *from > duration);
    let least = possible.first().map_or(duration, |[from, _]| *from);
    ScalingError::DurationNotPossible { duration, least, before, after: after.unwrap_or(f64::INFINITY) }
}
