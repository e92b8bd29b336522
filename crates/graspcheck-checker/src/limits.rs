//! The proofs of the joints' limits against robot and plan: that each bound holds at every instant, that each
//! peak is met, and that the jumps are all there.
//!
//! Position, velocity, acceleration and jerk are polynomials between knots, of which control values bound the
//! values (see `polynomial`). Efforts are not computed here: of them it is only seen that the robot's limit is
//! the one that is named; the report counts them apart.

use crate::{
    LimitName, LimitQuantity, Place, Quantity, Report,
    demand::{Demands, is_equal},
    documents::{BreakClaim, Documents, Joint, LimitProof, Limits, Trajectory},
    polynomial::{Coefficients, derivative, magnitude, range, value},
};

/// Bounds and peaks are rounded by less than this share of the terms that they are the sum of.
const SAME_SHARE: f64 = 1e-12;

/// A motion that is planned to its limit comes out beyond it by no more than this, in SI units or as a share.
const ROUNDED_SHARE: f64 = 1e-9;

/// A jump that is not larger than this, in SI units or as a share of the largest value of what jumps, is
/// rounding; one that is half as large may be listed or not.
const SMOOTH: f64 = 2e-9;

/// Checks the proofs of limits; what is found goes into the report.
pub(crate) fn check(documents: &Documents, limits: &Limits, report: &mut Report) {
    let mut check = Check { documents, limits, report };
    check.whole();
    for (index, joint) in documents.resolved.robot.joints.iter().enumerate() {
        let orders = Orders::of(&documents.plan.trajectory, index);
        for quantity in LimitQuantity::ALL {
            check.limit(joint, quantity, &orders);
        }
        check.jumps(joint, &orders);
    }
    check.strangers();
}

struct Check<'d> {
    documents: &'d Documents,
    limits: &'d Limits,
    report: &'d mut Report,
}

/// Position, velocity, acceleration and jerk of one joint, piece by piece.
struct Orders<'d> {
    knots: &'d [f64],
    pieces: Vec<[Coefficients; 4]>,
}

impl<'d> Orders<'d> {
    fn of(trajectory: &'d Trajectory, joint: usize) -> Self {
        let orders = |piece: &Vec<Coefficients>| {
            let mut orders = [piece[joint]; 4];
            for order in 1..4 {
                orders[order] = derivative(&orders[order - 1]);
            }
            orders
        };
        Self { knots: &trajectory.knots, pieces: trajectory.coefficients.iter().map(orders).collect() }
    }

    fn duration(&self) -> f64 {
        self.knots[self.knots.len() - 1]
    }

    /// The pieces of one derivative, each with its length, s.
    fn pieces(&self, order: usize) -> impl Iterator<Item = (&Coefficients, f64)> {
        let lengths = self.knots.windows(2).map(|knots| knots[1] - knots[0]);
        self.pieces.iter().map(move |orders| &orders[order]).zip(lengths)
    }

    /// Bounds on all values of a derivative.
    fn range(&self, order: usize) -> [f64; 2] {
        let ranges = self.pieces(order).map(|(piece, length)| range(piece, 0.0, length));
        ranges.fold([f64::INFINITY, f64::NEG_INFINITY], |all, one| [all[0].min(one[0]), all[1].max(one[1])])
    }

    /// What rounding errors of a derivative are relative to.
    fn magnitude(&self, order: usize) -> f64 {
        self.pieces(order).map(|(piece, length)| magnitude(piece, length)).fold(0.0, f64::max)
    }

    /// The values of a derivative at a time, from the left and from the right.
    fn at(&self, order: usize, time: f64) -> [f64; 2] {
        let last = self.pieces.len() - 1;
        let left = self.knots.partition_point(|knot| *knot < time).clamp(1, last + 1) - 1;
        let right = self.knots.partition_point(|knot| *knot <= time).clamp(1, last + 1) - 1;
        [left, right].map(|piece| value(&self.pieces[piece][order], time - self.knots[piece]))
    }

    /// All jumps of a derivative: when, and after less before. The robot is at rest before and after the plan.
    fn jumps(&self, order: usize) -> impl Iterator<Item = (f64, f64)> {
        let last = self.pieces.len() - 1;
        (0..=last + 1).filter(move |knot| order > 0 || (1..=last).contains(knot)).map(move |knot| {
            let before = if knot == 0 {
                0.0
            } else {
                value(&self.pieces[knot - 1][order], self.knots[knot] - self.knots[knot - 1])
            };
            let after = if knot > last { 0.0 } else { self.pieces[knot][order][0] };
            (self.knots[knot], after - before)
        })
    }
}

impl Check<'_> {
    fn whole(&mut self) {
        let planned = self.documents.plan.duration();
        let mut demands = Demands::default();
        let stated = self.limits.duration;
        demands.that(is_equal(stated, planned), Quantity::Duration, stated, planned);
        self.report(demands, [0.0, planned], &Place::Whole);
    }

    /// One quantity of a joint: what is claimed must be there once and be so.
    fn limit(&mut self, joint: &Joint, quantity: LimitQuantity, orders: &Orders) {
        let place = Place::Limit(LimitName { joint: joint.name.clone(), quantity });
        let limits = self.limits;
        let is_it = |claim: &&LimitProof| claim.quantity == quantity && claim.joint == joint.name;
        let claims = || limits.limits.iter().filter(is_it);
        let is_left_out = quantity == LimitQuantity::Effort && limits.effort_unproved.is_some();
        let mut demands = Demands::default();
        demands.occurs(claims().count(), usize::from(!is_left_out));
        self.report(demands, [0.0, orders.duration()], &place);
        for claim in claims() {
            self.claim(joint, claim, orders, &place);
        }
    }

    fn claim(&mut self, joint: &Joint, claim: &LimitProof, orders: &Orders, place: &Place) {
        let LimitProof { quantity, limit, bound, peak, time, .. } = claim;
        let limits = &joint.limits;
        let (order, expected) = match quantity {
            LimitQuantity::PositionMin => (Some(0), limits.position_min),
            LimitQuantity::PositionMax => (Some(0), limits.position_max),
            LimitQuantity::Velocity => (Some(1), limits.velocity),
            LimitQuantity::Acceleration => (Some(2), limits.acceleration),
            LimitQuantity::Jerk => (Some(3), limits.jerk),
            LimitQuantity::Effort => (None, limits.effort),
        };
        let mut of_limit = Demands::default();
        of_limit.that(is_equal(*limit, expected), Quantity::Limit, *limit, expected);
        let mut of_peak = Demands::default();
        let is_within = (0.0..=orders.duration()).contains(time);
        of_peak.that(is_within, Quantity::Duration, *time, orders.duration());
        // A least position is bounded from below, all others from above.
        let sign = if *quantity == LimitQuantity::PositionMin { -1.0 } else { 1.0 };
        let reached = if order == Some(0) { *peak } else { peak.abs() };
        if let Some(order) = order {
            let [low, high] = orders.range(order);
            let farthest = match quantity {
                LimitQuantity::PositionMin => low,
                LimitQuantity::PositionMax => high,
                _ => high.max(-low),
            };
            let same = SAME_SHARE * (1.0 + orders.magnitude(order));
            let holds = sign * bound >= sign * farthest - same;
            of_limit.that(holds, Quantity::Bound, *bound, farthest);
            let values = orders.at(order, *time);
            let found =
                if (values[0] - peak).abs() < (values[1] - peak).abs() { values[0] } else { values[1] };
            // Time is rounded, too: what changes fast changes by more than its own rounding.
            let next = (order + 1).min(3);
            let drift = f64::EPSILON * (1.0 + time) * orders.magnitude(next);
            of_peak.that((found - peak).abs() <= same + 4.0 * drift, Quantity::Peak, *peak, found);
            self.report.limits += 1;
        } else {
            self.report.unchecked_limits += 1;
        }
        of_peak.that(sign * reached <= sign * bound, Quantity::Peak, reached, *bound);
        if sign * (reached - limit) > ROUNDED_SHARE * limit.abs().max(1.0) {
            let LimitProof { joint, quantity, .. } = claim;
            self.report.exceeded.push(LimitName { joint: joint.clone(), quantity: *quantity });
        }
        self.report(of_limit, [0.0, orders.duration()], place);
        self.report(of_peak, [*time; 2], place);
    }

    /// Every jump of a joint must be listed once, with its size.
    fn jumps(&mut self, joint: &Joint, orders: &Orders) {
        for order in 0..3 {
            let limits = self.limits;
            let place = Place::Break(joint.name.clone(), order);
            let [low, high] = orders.range(order);
            let smooth = SMOOTH * high.max(-low).max(1.0);
            let same = SAME_SHARE * (1.0 + orders.magnitude(order));
            let claims = || limits.breaks.iter().filter(|it| it.order == order && it.joint == joint.name);
            for (time, size) in orders.jumps(order) {
                let mut demands = Demands::default();
                let count = claims().filter(|claim| is_equal(claim.time, time)).count();
                if size.abs() > smooth || count > 1 {
                    demands.occurs(count, 1);
                } else if size.abs() < 0.25 * smooth {
                    demands.occurs(count, 0);
                }
                for BreakClaim { size: stated, .. } in claims().filter(|claim| is_equal(claim.time, time)) {
                    demands.that((stated - size).abs() <= same, Quantity::Jump, *stated, size);
                }
                self.report(demands, [time; 2], &place);
            }
        }
    }

    /// Nothing is claimed of what is not there: other joints, other instants.
    fn strangers(&mut self) {
        let joints = &self.documents.resolved.robot.joints;
        let is_known = |name: &str| joints.iter().any(|joint| joint.name == name);
        let duration = self.documents.plan.duration();
        for LimitProof { joint, quantity, .. } in self.limits.limits.iter().filter(|it| !is_known(&it.joint))
        {
            let mut demands = Demands::default();
            demands.occurs(1, 0);
            let limit = LimitName { joint: joint.clone(), quantity: *quantity };
            self.report(demands, [0.0, duration], &Place::Limit(limit));
        }
        let knots = &self.documents.plan.trajectory.knots;
        for BreakClaim { joint, order, time, .. } in &self.limits.breaks {
            let is_there = is_known(joint) && *order < 3 && knots.iter().any(|knot| is_equal(*knot, *time));
            let mut demands = Demands::default();
            demands.occurs(1, usize::from(is_there));
            self.report(demands, [*time; 2], &Place::Break(joint.clone(), *order));
        }
    }

    fn report(&mut self, demands: Demands, interval: [f64; 2], place: &Place) {
        demands.report(&mut self.report.findings, interval, || place.clone());
    }
}
