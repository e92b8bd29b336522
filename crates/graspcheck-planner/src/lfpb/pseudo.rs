//! Points that must be met: each is bracketed by two pseudo via points, so that it lies on a line.

use graspcheck_model::via::{Blend, BlendEnds, velocity_by_signs};

use super::{
    course::Course,
    error::{LfpbError, Place},
};
use crate::via::ViaError;

/// A point that a coordinate passes, near or exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LfpbPoint {
    /// When, s.
    pub time: f64,
    /// Where, rad or m.
    pub position: f64,
    /// The blend there; where the point must be met, that of both pseudo via points.
    pub blend: Blend,
    /// How the point is met; it is passed near where there is nothing.
    pub met: Option<Met>,
}

/// How a point is met: on the line between two pseudo via points.
///
/// With the bracket δ and the velocity v these are q - v δ at t - δ and q + v δ at t + δ. The line is left of
/// 2δ after half a blend at each end, which must not overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// How long before and after the point the pseudo via points are due, s.
    pub bracket: f64,
    /// The velocity of the line through the point; without one, that of the rule of signs
    /// ([`computed`](crate::via::computed)): the mean of the slopes beside the point, 0 where they differ in sign.
    pub velocity: Option<f64>,
}

impl LfpbPoint {
    /// A point to be passed near.
    #[must_use]
    pub fn near(time: f64, position: f64, blend: Blend) -> Self {
        Self { time, position, blend, met: None }
    }

    /// A point to be met on a line between pseudo via points that are due `bracket` seconds before and
    /// after it, at the velocity of the rule of signs.
    ///
    /// ```
    /// use graspcheck_planner::lfpb::{Blend, BlendEnds, Lfpb, LfpbPoint};
    /// let blend = Blend::Duration(0.2);
    /// let points = [
    ///     LfpbPoint::near(0.0, 0.0, blend),
    ///     LfpbPoint::met(1.0, 1.0, blend, 0.3),
    ///     LfpbPoint::near(2.0, 3.0, blend),
    /// ];
    /// let motion = Lfpb::new(&points, BlendEnds::Inside)?;
    /// // Met, at the mean of the slopes 1 and 2.
    /// assert!((motion.eval(1.0)[0] - 1.0).abs() < 1e-15 && (motion.eval(1.0)[1] - 1.5).abs() < 1e-14);
    /// # Ok::<(), graspcheck_planner::lfpb::LfpbError>(())
    /// ```
    #[must_use]
    pub fn met(time: f64, position: f64, blend: Blend, bracket: f64) -> Self {
        Self { time, position, blend, met: Some(Met { bracket, velocity: None }) }
    }

    fn check(&self, point: usize) -> Result<(), LfpbError> {
        let velocity = self.met.and_then(|met| met.velocity).unwrap_or(0.0);
        for (quantity, value) in [("time", self.time), ("position", self.position), ("velocity", velocity)] {
            if !value.is_finite() {
                let place = format!("point {point}");
                return Err(ViaError::NotFinite { place, quantity, value }.into());
            }
        }
        let blend = match self.blend {
            Blend::Duration(duration) => ("blend time", duration),
            Blend::Acceleration(acceleration) => ("blend acceleration", acceleration),
        };
        for (quantity, value) in [blend].into_iter().chain(self.met.map(|met| ("bracket", met.bracket))) {
            if !(value > 0.0 && value.is_finite()) {
                return Err(LfpbError::NotPositive { point, quantity, value });
            }
        }
        Ok(())
    }
}

/// The course through the points, with pseudo via points in the place of those that must be met.
///
/// # Errors
/// When there are fewer than two points, a number is not finite or not positive, times do not increase, an
/// end is to be met by pseudo via points, or a bracket is too wide.
pub(super) fn course(points: &[LfpbPoint], ends: BlendEnds) -> Result<Course, LfpbError> {
    if points.len() < 2 {
        return Err(ViaError::TooFewPoints { count: points.len() }.into());
    }
    for (k, point) in points.iter().enumerate() {
        point.check(k + 1)?;
    }
    for (k, pair) in points.windows(2).enumerate() {
        let [previous, time] = [pair[0].time, pair[1].time];
        if time <= previous {
            return Err(ViaError::TimesNotIncreasing { point: k + 2, time, previous }.into());
        }
    }
    let mut course = Course { places: vec![], times: vec![], positions: vec![], blends: vec![], ends };
    let mut add = |place, time, position, blend| {
        course.places.push(place);
        course.times.push(time);
        course.positions.push(position);
        course.blends.push(blend);
    };
    // The last place so far with its time, for messages.
    let mut previous = (Place::Point(0), f64::NEG_INFINITY);
    for (k, point) in points.iter().enumerate() {
        let number = k + 1;
        let &LfpbPoint { time, position, blend, .. } = point;
        let Some(Met { bracket, velocity }) = point.met else {
            add(Place::Point(number), time, position, blend);
            previous = (Place::Point(number), time);
            continue;
        };
        let (Some(before), Some(after)) = (k.checked_sub(1).map(|k| &points[k]), points.get(k + 1)) else {
            return Err(LfpbError::EndBracketed { point: number });
        };
        let slope = |a: &LfpbPoint, b: &LfpbPoint| (b.position - a.position) / (b.time - a.time);
        let velocity =
            velocity.unwrap_or_else(|| velocity_by_signs(slope(before, point), slope(point, after)));
        let wide = |below, neighbour| LfpbError::BracketTooWide { point: number, bracket, below, neighbour };
        if time - bracket <= previous.1 {
            return Err(wide(time - previous.1, previous.0));
        }
        if time + bracket >= after.time {
            return Err(wide(after.time - time, Place::Point(number + 1)));
        }
        add(Place::Before(number), time - bracket, position - velocity * bracket, blend);
        add(Place::After(number), time + bracket, position + velocity * bracket, blend);
        previous = (Place::After(number), time + bracket);
    }
    Ok(course)
}
