//! The laws that get farthest in their time: jerk up, down, up.
//!
//! With limits V, A, J let a joint go from `[q₀, v₀, a₀]` to `[q₁, v₁, a₁]`. Of all laws that take a time T and keep
//! the limits, the one that gets farthest raises its acceleration by jerk J to a top, lowers it by -J to a valley,
//! and raises it again to a₁; at the top and at the valley it stays while the acceleration is at its limit, and
//! between them it cruises while the velocity is (maximum principle: the jerk has the sign of a quadratic in
//! time). The law that stays farthest behind is the same with all signs changed.
//!
//! **One number describes the law.** On an arc of jerk J the number `v - a²/(2J)` is constant; let it be W₀ on the
//! first arc and W₁ on the last: the velocities at which the arcs, carried on where need be, have no acceleration.
//! On the middle arc `v + a²/(2J)` is constant, call it v_p. Let x₀ be the top and x₁ the valley with its sign changed,
//! both as they would be without the limit A; they follow from v_p:
//!
//! `x₀² = J (v_p - W₀)`, `x₁² = J (v_p - W₁)`.
//!
//! The end with the larger W is the *near* one; its x is r, of either sign, and describes the law. The other x is the
//! positive root of `r² + J |W₀ - W₁|`. With `ψ(x) = 2x`, or `x²/A + A` where x is beyond A, and with `b₀ = a₀, b₁ = -a₁`,
//!
//! `J T = Σ ψ(xᵢ) - bᵢ`, `J D = Σ ψ(xᵢ) (Wᵢ + v_p)/2 - Wᵢ bᵢ - bᵢ³/(6J)`,
//!
//! each change of velocity taking its mean velocity times its time. The first and the last arc exist where `xᵢ ≥ bᵢ`,
//! and v_p, the peak velocity where both x are positive, is at most V; then come cruises.
//!
//! **T grows with r. D need not:** `dD/dr = 2/J² (r/x̄ + 1) S` with `S = J v_p + x̄₀ x̄₁/2`, where x̄ is x or A and, on the far
//! end, stands in the quotient; beyond A the 1 is r/A. S grows with r where r > 0 and is convex in r where r < 0, and
//! its roots are those of quadratics. Between them D is monotone, so that every law that covers a distance is found.
//!
//! Without accelerations at the ends this is the classical double S; see Kröger, *On-Line Trajectory Generation in
//! Robotic Systems*, 2010, and Berscheid and Kröger, 2021, who tell the cases apart by decision trees instead.

use super::RateLimits;
use crate::time_scaling::pieces::Pieces;

/// What rounding accounts for, relative to the numbers of which something is a difference.
pub(super) const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// The farthest laws between two states, in the direction of a sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct Farthest {
    sign: f64,
    limits: RateLimits,
    start: [f64; 3],
    end: [f64; 3],
    /// W₀ and W₁, as all that follows with the sign.
    base: [f64; 2],
    /// b₀ and b₁: the least x at each end.
    least: [f64; 2],
    /// Index of the end with the larger W.
    near: usize,
    /// `J |W₀ - W₁|`.
    gap: f64,
}

/// One of these laws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Extreme {
    r: f64,
    /// How long it cruises at the limit of velocity, s.
    cruise: f64,
    /// How long it lasts, s.
    pub(super) duration: f64,
    /// What it covers in the direction of the sign.
    pub(super) distance: f64,
}

impl Farthest {
    /// Those between two states `[position, velocity, acceleration]` that are within the limits.
    pub(super) fn new(sign: f64, start: [f64; 3], end: [f64; 3], limits: RateLimits) -> Self {
        let [[_, v0, a0], [_, v1, a1]] = [start, end].map(|state| state.map(|number| sign * number));
        let half = 0.5 / limits.jerk;
        let base = [v0 - half * a0 * a0, v1 - half * a1 * a1];
        let least = [a0, -a1];
        let difference = base[1] - base[0];
        let rounding = ROUNDING * (v0.abs() + v1.abs() + half * (a0 * a0 + a1 * a1));
        let (near, gap) = if difference.abs() <= rounding {
            // Either may be the near one; only that with room below 0 has all laws.
            (usize::from(least[1] < least[0]), 0.0)
        } else {
            (usize::from(difference > 0.0), limits.jerk * difference.abs())
        };
        Self { sign, limits, start, end, base, least, near, gap }
    }

    /// x at each end.
    fn peaks(&self, r: f64) -> [f64; 2] {
        let mut x = [(self.gap + r * r).sqrt(); 2];
        x[self.near] = r;
        x
    }

    /// The acceleration at top and valley, and how long it stays there, s.
    fn bounded(&self, x: f64) -> (f64, f64) {
        let RateLimits { acceleration, jerk, .. } = self.limits;
        if x > acceleration {
            (acceleration, (x - acceleration) * (x + acceleration) / (jerk * acceleration))
        } else {
            (x, 0.0)
        }
    }

    /// The peak velocity v_p.
    fn peak_velocity(&self, r: f64) -> f64 {
        self.base[self.near] + r * r / self.limits.jerk
    }

    /// ψ(x)/J, s.
    fn change_time(&self, x: f64) -> f64 {
        let (bounded, stay) = self.bounded(x);
        2.0 * bounded / self.limits.jerk + stay
    }

    /// How long the law without a cruise lasts, s, and its derivative by r.
    fn duration(&self, r: f64) -> [f64; 2] {
        let RateLimits { acceleration, jerk, .. } = self.limits;
        let x = self.peaks(r);
        let time =
            self.change_time(x[0]) - self.least[0] / jerk + self.change_time(x[1]) - self.least[1] / jerk;
        let far = x[1 - self.near];
        let by_far = if far > 0.0 { r / far.min(acceleration) } else { r.signum() };
        [time.max(0.0), 2.0 * (by_far + (r / acceleration).max(1.0)) / jerk]
    }

    /// What the law without a cruise covers, and its derivative by r.
    fn distance(&self, r: f64) -> [f64; 2] {
        let RateLimits { acceleration, jerk, .. } = self.limits;
        let (x, peak) = (self.peaks(r), self.peak_velocity(r));
        let mut covered = 0.0;
        for ((x, base), least) in x.into_iter().zip(self.base).zip(self.least) {
            covered += 0.5 * (base + peak) * self.change_time(x);
            covered -= least / jerk * (base + least * least / (6.0 * jerk));
        }
        let far = x[1 - self.near];
        let by_far = if far > 0.0 { r / far.min(acceleration) } else { r.signum() };
        let slope = 2.0 / (jerk * jerk) * (by_far + (r / acceleration).max(1.0)) * self.slope_factor(r);
        [covered, slope]
    }

    /// S.
    fn slope_factor(&self, r: f64) -> f64 {
        let [x0, x1] = self.peaks(r).map(|x| x.min(self.limits.acceleration));
        self.limits.jerk * self.peak_velocity(r) + 0.5 * x0 * x1
    }

    /// The intervals of r whose laws have their first and last arc and keep the limit of velocity; an empty one is
    /// NaN at both ends.
    fn intervals(&self) -> [[f64; 2]; 2] {
        let RateLimits { velocity, jerk, .. } = self.limits;
        let [near, far] = [self.least[self.near], self.least[1 - self.near]];
        let most = (jerk * (velocity - self.base[self.near])).max(0.0).sqrt();
        // Below this the far end would lack its arc.
        let hidden = if far > 0.0 { far * far - self.gap } else { 0.0 };
        if hidden <= 2.0 * ROUNDING * far * far {
            return [[near, most.max(near)], [f64::NAN; 2]];
        }
        let hidden = hidden.sqrt();
        let above = near.max(hidden);
        let below =
            if near <= -hidden * (1.0 - ROUNDING) { [near, near.max(-hidden)] } else { [f64::NAN; 2] };
        [below, [above, most.max(above)]]
    }

    /// The law of r without a cruise.
    fn at(&self, r: f64) -> Extreme {
        Extreme { r, cruise: 0.0, duration: self.duration(r)[0], distance: self.distance(r)[0] }
    }

    /// The law that cruises.
    fn cruising(&self, r: f64, cruise: f64) -> Extreme {
        let Extreme { duration, distance, .. } = self.at(r);
        let covered = self.limits.velocity * cruise;
        Extreme { r, cruise, duration: duration + cruise, distance: distance + covered }
    }

    /// Shows every law that covers a distance in the direction of the sign to `visit`.
    pub(super) fn covering(&self, distance: f64, mut visit: impl FnMut(Extreme)) {
        let size = distance.abs() + self.start[0].abs() + self.end[0].abs();
        let [mut most, mut missing] = [f64::NAN, 0.0];
        for [low, high] in self.intervals().into_iter().filter(|[low, _]| !low.is_nan()) {
            // Between its places the distance is monotone.
            let mut places = [low; 10];
            let mut count = 1;
            // Where r is positive S grows with it, and begins with J W of the near end.
            if low < 0.0 || self.base[self.near] < 0.0 {
                for place in self.turning_points().into_iter().filter(|place| low < *place && *place < high) {
                    places[count] = place;
                    count += 1;
                }
                places[..count].sort_unstable_by(f64::total_cmp);
            }
            places[count] = high;
            count += 1;
            let mut before: Option<(f64, f64)> = None;
            for &r in &places[..count] {
                let [covered, _] = self.distance(r);
                let excess = covered - distance;
                if excess.abs() <= ROUNDING * (size + covered.abs()) {
                    visit(self.at(r));
                    before = None;
                    continue;
                }
                if let Some((low, _)) = before.filter(|(_, other)| (*other < 0.0) != (excess < 0.0)) {
                    let beyond = |r| {
                        let [covered, slope] = self.distance(r);
                        [covered - distance, slope]
                    };
                    visit(self.at(root_between(beyond, [low, r], excess > 0.0, f64::EPSILON * size)));
                }
                before = Some((r, excess));
            }
            missing = before.map_or(0.0, |(_, excess)| -excess);
            most = high;
        }
        // At the largest r of all it can cruise.
        if missing > 0.0 {
            visit(self.cruising(most, missing / self.limits.velocity));
        }
    }

    /// The law of a duration, s; `None` if no law between the velocities and accelerations of the ends lasts so.
    pub(super) fn lasting(&self, duration: f64) -> Option<Extreme> {
        let mut most = f64::NAN;
        for [low, high] in self.intervals() {
            let [shortest, longest] = [low, high].map(|r| self.duration(r)[0]);
            let rounding = 4.0 * ROUNDING * duration;
            if duration >= shortest - rounding && duration <= longest + rounding {
                let beyond = |r| {
                    let [time, slope] = self.duration(r);
                    [time - duration, slope]
                };
                let r = if duration <= shortest {
                    low
                } else if duration >= longest {
                    high
                } else {
                    root_between(beyond, [low, high], true, f64::EPSILON * duration)
                };
                return Some(Extreme { duration, ..self.at(r) });
            }
            most = if high.is_nan() { most } else { high };
        }
        let [longest, _] = self.duration(most);
        (duration > longest).then(|| Extreme { duration, ..self.cruising(most, duration - longest) })
    }

    /// The durations at which laws between these velocities and accelerations begin or cease to exist, s; NaN for none.
    pub(super) fn duration_ends(&self) -> [f64; 3] {
        let [[a, b], [c, _]] = self.intervals();
        // At the largest r cruises go on.
        let b = if c.is_nan() { c } else { b };
        [a, b, c].map(|r| if r.is_nan() { r } else { self.duration(r)[0] })
    }

    /// The places at which S is zero, and some more.
    fn turning_points(&self) -> [f64; 8] {
        let RateLimits { acceleration, jerk, .. } = self.limits;
        let w = jerk * self.base[self.near];
        // Both x within the limit: (w + z)² = z (z + gap)/4 for z = r².
        let b = 2.0 * w - 0.25 * self.gap;
        let root = (b * b - 3.0 * w * w).sqrt();
        let [z0, z1] = [(root - b) / 1.5, (-root - b) / 1.5].map(f64::sqrt);
        // The far one at the limit: w + r² + A r/2 = 0. Both: w + r² + A²/2 = 0.
        let quarter = 0.25 * acceleration;
        let root = (quarter * quarter - w).sqrt();
        let both = (-w - 0.5 * acceleration * acceleration).sqrt();
        [z0, -z0, z1, -z1, root - quarter, -root - quarter, both, -both]
    }

    /// The polynomials of a law. It ends at its distance from the start.
    pub(super) fn pieces(&self, law: Extreme, end_position: f64) -> Pieces {
        let jerk = self.limits.jerk;
        let [(top, stay_top), (valley, stay_valley)] = self.peaks(law.r).map(|x| self.bounded(x));
        // The middle arc is cut where the acceleration is zero, and built from both ends.
        let below = top.min(valley).min(0.0);
        let middle = [top, valley].map(|x| (x + below).max(0.0) / jerk);
        let signed = self.sign * jerk;
        let rise = [((top - self.least[0]) / jerk, signed), (stay_top, 0.0), (middle[0], -signed)];
        let fall = [((valley - self.least[1]) / jerk, signed), (stay_valley, 0.0), (middle[1], -signed)];
        let [_, v1, a1] = self.end;
        let cruise = (law.cruise, self.sign * self.limits.velocity);
        Pieces::of_jerks(self.start, rise, cruise, fall, [end_position, v1, a1], law.duration)
    }
}

/// The root of a monotone function, given with its derivative, between two places at which its signs differ:
/// Newton's method kept inside a bracket. Ends where the value is no more than `noise`.
fn root_between(
    function: impl Fn(f64) -> [f64; 2],
    [mut low, mut high]: [f64; 2],
    rising: bool,
    noise: f64,
) -> f64 {
    /// Bisection alone needs about 60 steps from an end of the bracket to the last bit; Newton's method takes five.
    const MOST_STEPS: usize = 200;

    let mut place = high;
    for _ in 0..MOST_STEPS {
        let [value, slope] = function(place);
        if value.abs() <= noise {
            break;
        }
        if (value > 0.0) == rising {
            high = place;
        } else {
            low = place;
        }
        let newton = place - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - place).abs() <= 2.0 * f64::EPSILON * place.abs() {
            break;
        }
        place = next;
    }
    place
}
