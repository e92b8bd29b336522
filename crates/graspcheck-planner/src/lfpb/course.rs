//! From points and blends to the velocities of the lines and the durations of the blends; see the head of
//! [`lfpb`](super) for the law.

use graspcheck_model::via::{Blend, BlendEnds};

use super::error::{LfpbError, Place, Remedy};

/// Times may fall short by this share of a segment, and the square of one by the same share: it is what
/// rounding makes of blends that just touch.
const ROUNDING: f64 = 1e-12;

/// What the motion of one coordinate is made from, pseudo via points included.
pub(super) struct Course {
    pub(super) places: Vec<Place>,
    pub(super) times: Vec<f64>,
    pub(super) positions: Vec<f64>,
    pub(super) blends: Vec<Blend>,
    pub(super) ends: BlendEnds,
}

/// What follows from a [`Course`].
pub(super) struct Solution {
    /// Of the blend at each place, s; 0 where an acceleration has no velocity to change.
    pub(super) durations: Vec<f64>,
    /// When the two lines beside each place meet, s.
    pub(super) meets: Vec<f64>,
    /// Of the line of each segment.
    pub(super) velocities: Vec<f64>,
}

impl Solution {
    /// By how much the velocity changes at a place; before and after the motion is rest.
    pub(super) fn change(&self, place: usize) -> f64 {
        let before = if place == 0 { 0.0 } else { self.velocities[place - 1] };
        let after = self.velocities.get(place).copied().unwrap_or(0.0);
        after - before
    }
}

impl Course {
    /// # Errors
    /// When an acceleration is too small, blends overlap or a velocity overflows.
    pub(super) fn solve(&self) -> Result<Solution, LfpbError> {
        let last = self.times.len() - 1;
        let mut durations = vec![0.0; last + 1];
        let mut meets = self.times.clone();
        if self.ends == BlendEnds::Inside {
            [durations[0], durations[last]] =
                if last == 1 { self.rest_to_rest()? } else { [self.end_blend(0)?, self.end_blend(last)?] };
            meets[0] += 0.5 * durations[0];
            meets[last] -= 0.5 * durations[last];
        }
        let velocities: Vec<f64> = (0..last).map(|k| self.distance(k) / (meets[k + 1] - meets[k])).collect();
        if let Some(segment) = velocities.iter().position(|velocity| !velocity.is_finite()) {
            return Err(LfpbError::Overflow { place: self.places[segment] });
        }
        let mut solution = Solution { durations, meets, velocities };
        for place in (0..=last).filter(|&place| !self.lies_inside(place)) {
            solution.durations[place] = self.duration(place, solution.change(place));
        }
        for segment in 0..last {
            let [first, second] = [segment, segment + 1].map(|place| self.share(place, &solution));
            // A blend that reached beyond the middle would bend the line at the point itself.
            let needed =
                if self.is_bracket(segment) { 2.0 * f64::max(first, second) } else { first + second };
            self.check_room(segment, needed, Some(&solution))?;
        }
        Ok(solution)
    }

    /// Whether a segment joins the pseudo via points of one point, which is to be met in its middle.
    fn is_bracket(&self, segment: usize) -> bool {
        matches!(self.places[segment..segment + 2], [Place::Before(a), Place::After(b)] if a == b)
    }

    /// How long the blend at a place takes for this change of velocity, s.
    fn duration(&self, place: usize, change: f64) -> f64 {
        match self.blends[place] {
            Blend::Duration(duration) => duration,
            Blend::Acceleration(acceleration) => change.abs() / acceleration,
        }
    }

    /// Whether the blend at a place lies as a whole in the first or the last segment.
    pub(super) fn lies_inside(&self, place: usize) -> bool {
        self.ends == BlendEnds::Inside && (place == 0 || place + 1 == self.times.len())
    }

    /// How much of the blend at a place lies in a segment beside it, s.
    fn share(&self, place: usize, solution: &Solution) -> f64 {
        if self.lies_inside(place) { solution.durations[place] } else { 0.5 * solution.durations[place] }
    }

    /// What a segment covers, with sign.
    fn distance(&self, segment: usize) -> f64 {
        self.positions[segment + 1] - self.positions[segment]
    }

    /// How long a segment has, s.
    fn available(&self, segment: usize) -> f64 {
        self.times[segment + 1] - self.times[segment]
    }

    /// The duration of the blend that lies inside the first or the last of several segments, s.
    fn end_blend(&self, place: usize) -> Result<f64, LfpbError> {
        let segment = self.segment_of_end(place);
        let duration =
            self.end_duration(place).map_err(|acceleration| self.too_small(place, segment, acceleration))?;
        self.check_room(segment, duration, None)?;
        Ok(duration)
    }

    /// `b = T − √(T² − 2D/A)`, s, whether or not it fits; or the acceleration that is too small.
    fn end_duration(&self, place: usize) -> Result<f64, f64> {
        let segment = self.segment_of_end(place);
        match self.blends[place] {
            Blend::Duration(duration) => Ok(duration),
            Blend::Acceleration(acceleration) => {
                let distance = self.distance(segment).abs();
                line_velocity(self.available(segment), distance, 1.0 / acceleration)
                    .map(|velocity| velocity / acceleration)
                    .ok_or(acceleration)
            }
        }
    }

    fn segment_of_end(&self, place: usize) -> usize {
        place.min(self.times.len() - 2)
    }

    /// The durations of both blends of a motion of one segment: a trapezoid of velocity.
    fn rest_to_rest(&self) -> Result<[f64; 2], LfpbError> {
        let (available, distance) = (self.available(0), self.distance(0).abs());
        let durations = match (self.blends[0], self.blends[1]) {
            (Blend::Duration(first), Blend::Duration(second)) => [first, second],
            (Blend::Acceleration(first), Blend::Acceleration(second)) => {
                let velocity = line_velocity(available, distance, 1.0 / first + 1.0 / second)
                    // The weaker of both is named.
                    .ok_or_else(|| self.too_small(usize::from(second < first), 0, first.min(second)))?;
                [velocity / first, velocity / second]
            }
            (Blend::Acceleration(first), Blend::Duration(second)) => {
                [self.beside_duration(0, first, second)?, second]
            }
            (Blend::Duration(first), Blend::Acceleration(second)) => {
                [first, self.beside_duration(1, second, first)?]
            }
        };
        self.check_room(0, durations[0] + durations[1], None)?;
        Ok(durations)
    }

    /// The duration of a blend of given acceleration when that of the other of one segment is given.
    fn beside_duration(&self, place: usize, acceleration: f64, other: f64) -> Result<f64, LfpbError> {
        self.check_room(0, other, None)?;
        let velocity =
            line_velocity(self.available(0) - 0.5 * other, self.distance(0).abs(), 1.0 / acceleration)
                .ok_or_else(|| self.too_small(place, 0, acceleration))?;
        Ok(velocity / acceleration)
    }

    fn check_room(&self, segment: usize, needed: f64, solution: Option<&Solution>) -> Result<(), LfpbError> {
        let available = self.available(segment);
        if needed <= available * (1.0 + ROUNDING) {
            return Ok(());
        }
        Err(LfpbError::BlendsOverlap {
            from: self.places[segment],
            to: self.places[segment + 1],
            start: self.times[segment],
            end: self.times[segment + 1],
            needed,
            available,
            remedies: self.remedies(segment, solution),
        })
    }

    fn too_small(&self, place: usize, segment: usize, acceleration: f64) -> LfpbError {
        LfpbError::AccelerationTooSmall {
            place: self.places[place],
            acceleration,
            distance: self.distance(segment).abs(),
            available: self.available(segment),
            remedies: self.remedies(segment, None),
        }
    }

    /// For each blend of a segment the least change with which both just fit, where there is one.
    fn remedies(&self, segment: usize, solution: Option<&Solution>) -> Vec<Remedy> {
        let pairs = [(segment, segment + 1), (segment + 1, segment)];
        pairs.into_iter().filter_map(|(place, other)| self.remedy(segment, place, other, solution)).collect()
    }

    fn remedy(
        &self,
        segment: usize,
        place: usize,
        other: usize,
        solution: Option<&Solution>,
    ) -> Option<Remedy> {
        let (available, distance) = (self.available(segment), self.distance(segment).abs());
        // The longest blend that fits, and the change of velocity that it then makes.
        let (longest, change) = match (self.lies_inside(place), self.lies_inside(other)) {
            (false, _) => {
                let solution = solution?;
                let is_half = self.is_bracket(segment);
                if is_half && self.share(other, solution) > 0.5 * available * (1.0 + ROUNDING) {
                    return None;
                }
                let room = if is_half { 0.5 * available } else { available - self.share(other, solution) };
                (2.0 * room, solution.change(place).abs())
            }
            // No line is left of a single segment: the mean velocity is half of the peak.
            (true, true) => {
                let peak = 2.0 * distance / available;
                (available - self.duration(other, peak), peak)
            }
            (true, false) => {
                let longest = match self.blends[other] {
                    Blend::Duration(duration) => available - 0.5 * duration,
                    Blend::Acceleration(acceleration) => {
                        self.longest_beside(segment, place, other, acceleration)?
                    }
                };
                (longest, distance / (available - 0.5 * longest))
            }
        };
        let blend = match self.blends[place] {
            Blend::Duration(given) => (longest < given).then_some(Blend::Duration(longest)),
            Blend::Acceleration(given) => {
                // Rounded up, so that it does do.
                let least = change / longest * (1.0 + 4.0 * f64::EPSILON);
                (least > given && least.is_finite()).then_some(Blend::Acceleration(least))
            }
        };
        (longest > 0.0).then_some(())?;
        Some(Remedy { place: self.places[place], blend: blend? })
    }

    /// The longest blend at an end that leaves room for one of given acceleration at the other place of its
    /// segment, whose duration depends on it, s.
    ///
    /// With `u = T − b/2` the velocity of the line is Δ/u, and the blends touch when
    /// `|v − Δ/u|/(2A) = 2u − T`, v being the velocity of the next line. For both signs of the difference
    /// this is `4A u² − (2AT ± v) u ± Δ = 0`.
    fn longest_beside(&self, segment: usize, place: usize, other: usize, acceleration: f64) -> Option<f64> {
        let (available, distance) = (self.available(segment), self.distance(segment));
        let next = self.next_velocity(segment, other)?;
        // As u stands now; there is none when the acceleration is too small for any.
        let given = self.end_duration(place).map_or(0.0, |duration| available - 0.5 * duration);
        [1.0, -1.0]
            .into_iter()
            .flat_map(|sign| {
                let linear = -(2.0 * acceleration * available + sign * next);
                roots(4.0 * acceleration, linear, sign * distance)
            })
            .filter(|&u| u > given.max(0.5 * available) && u < available)
            .min_by(f64::total_cmp)
            .map(|u| 2.0 * (available - u))
    }

    /// The velocity of the line at the other side of an inner place.
    fn next_velocity(&self, segment: usize, place: usize) -> Option<f64> {
        let next = if place == segment { segment - 1 } else { segment + 1 };
        let mut duration = self.available(next);
        for end in [next, next + 1] {
            if self.lies_inside(end) {
                duration -= 0.5 * self.end_duration(end).ok()?;
            }
        }
        (duration > 0.0).then(|| self.distance(next) / duration)
    }
}

/// The magnitude of the velocity of the line that follows, and is followed by, blends whose inverse
/// accelerations add up to `inverse`: of the solutions of `v (T − v · inverse/2) = D` the smaller one. None
/// when the accelerations are too small, `T² < 2D · inverse`.
fn line_velocity(available: f64, distance: f64, inverse: f64) -> Option<f64> {
    let square = available * available;
    let rest = square - 2.0 * distance * inverse;
    (rest >= -ROUNDING * square).then(|| 2.0 * distance / (available + rest.max(0.0).sqrt()))
}

/// The real roots of `a x² + b x + c`, without cancellation.
fn roots(a: f64, b: f64, c: f64) -> impl Iterator<Item = f64> {
    let discriminant = b * b - 4.0 * a * c;
    let larger = -0.5 * (b + discriminant.sqrt().copysign(b));
    [larger / a, c / larger].into_iter().filter(move |_| discriminant >= 0.0)
}
