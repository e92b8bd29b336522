//! What a path does that has come near a singularity: it leaves the workspace, touches the singular circle, or
//! passes by.
//!
//! The measure is g = ±cos φ₂, with the sign with which it comes near: the arm is singular where g is 1 and out
//! of reach where it is more. All three questions are answered by halving the path and enclosing g over the
//! halves.

use std::ops::ControlFlow;

use graspcheck_motion::{Interval, Jet, Scalar};

use super::{
    BranchFault, Located, SINE_MIN,
    tracking::{Branch, PLACE_TOLERANCE, Tracker},
};

/// Share of the path up to which a stretch that may be out of reach counts as a single place.
///
/// The reason: where g touches 1 it is within rounding of it over a way that is the root of that, about 1e-8.
const TOUCH: f64 = 1e-6;

/// Share of the path to which such a stretch is resolved.
const RESOLUTION: f64 = 1e-10;

/// A path near a singularity.
pub(super) struct Singularity<'a> {
    tracker: &'a Tracker<'a>,
    branch: &'a Branch,
    length: f64,
}

impl<'a> Singularity<'a> {
    pub(super) fn new(tracker: &'a Tracker<'a>, branch: &'a Branch) -> Self {
        Self { tracker, branch, length: tracker.path.end() - tracker.path.start() }
    }

    /// Explains the singularity to which the path has come near at `at`.
    pub(super) fn explain(&self, at: f64) -> Located {
        let path = self.tracker.path;
        let near = self.cosine_at(at.max(path.start()));
        let sign = if near < 0.0 { -1.0 } else { 1.0 };
        // The stretch near the singularity; at its beginning g is at the threshold itself.
        let threshold = (1.0 - SINE_MIN * SINE_MIN).sqrt() - PLACE_TOLERANCE.sqrt();
        let back = self.first_place(at, path.end(), |g| g.lower() > threshold, sign).unwrap_or(path.end());
        let Some(outside) = self.first_place(at, back, |g| g.upper() < 1.0, sign) else {
            let place = self.place_of_largest(at, back, sign);
            let sine = self.sine_at(place);
            let demand = self.tracker.demand(self.branch, place);
            return Located { at: place, fault: BranchFault::NearSingular { sine, least: SINE_MIN, demand } };
        };
        let until = self.end_of_outside(outside, path.end(), sign);
        let worst = self.place_of_largest(outside, until, sign);
        let segment = path.segment_at(worst);
        if until - outside <= TOUCH * self.length && until < path.end() {
            let slope = self.slope_of_touch(worst);
            return Located { at: worst, fault: BranchFault::BranchChange { slope } };
        }
        let target = path.target(segment, Jet::<f64, 1>::constant(worst));
        match path.positions(&target, self.tracker.arm.elbow(self.branch.end()), self.branch.end(), 0.0) {
            Err(bound) => Located { at: outside, fault: BranchFault::OutOfReach { until, bound } },
            // The path ends on the singular circle, up to rounding.
            Ok(_) => {
                let demand = self.tracker.demand(self.branch, at);
                Located {
                    at: worst,
                    fault: BranchFault::NearSingular { sine: self.sine_at(worst), least: SINE_MIN, demand },
                }
            }
        }
    }

    /// cos φ₂ at a place.
    fn cosine_at(&self, at: f64) -> f64 {
        let path = self.tracker.path;
        path.elbow_cosine(&path.target(path.segment_at(at), Jet::<f64, 1>::constant(at))).value()
    }

    /// |sin φ₂| at a place, from the product of the distances to both singular circles.
    fn sine_at(&self, at: f64) -> f64 {
        let cos = self.cosine_at(at);
        ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt()
    }

    /// Looks at the path between two places cell by cell, in order: `look` says of a cell of a segment whether its
    /// halves are to be looked at in its place, or that the search ends.
    fn walk(&self, from: f64, to: f64, mut look: impl FnMut(usize, f64, f64) -> ControlFlow<(), bool>) {
        let path = self.tracker.path;
        let mut todo = Vec::with_capacity(64);
        for segment in path.segment_at(from)..path.segment_count() {
            let [start, end] = path.segment(segment);
            if start >= to {
                return;
            }
            todo.push((start.max(from), end.min(to)));
            while let Some((start, end)) = todo.pop() {
                match look(segment, start, end) {
                    ControlFlow::Break(()) => return,
                    ControlFlow::Continue(false) => {}
                    ControlFlow::Continue(true) => {
                        let middle = 0.5 * (start + end);
                        todo.push((middle, end));
                        todo.push((start, middle));
                    }
                }
            }
        }
    }

    /// Bounds on g over a cell.
    fn enclosed(&self, segment: usize, start: f64, end: f64, sign: f64) -> Interval {
        let (_, cos) = self.tracker.cosine(segment, start, end);
        cos.value().scaled(sign)
    }

    /// The first place between two at which g is not proved to be as `holds` says.
    fn first_place(&self, from: f64, to: f64, holds: impl Fn(Interval) -> bool, sign: f64) -> Option<f64> {
        let shortest = PLACE_TOLERANCE * self.length;
        let mut found = None;
        self.walk(from, to, |segment, start, end| {
            if holds(self.enclosed(segment, start, end, sign)) {
                return ControlFlow::Continue(false);
            }
            if end - start <= shortest {
                found = Some(start);
                return ControlFlow::Break(());
            }
            ControlFlow::Continue(true)
        });
        found
    }

    /// Where the path is in reach again after `outside`, or its end: steps grow while they are proved to be out
    /// of reach, and shrink where nothing is proved.
    fn end_of_outside(&self, outside: f64, end: f64, sign: f64) -> f64 {
        let path = self.tracker.path;
        let shortest = RESOLUTION * self.length;
        let mut at = outside;
        let mut step = shortest;
        while at < end {
            let segment = path.segment_at(at);
            let next = (at + step).min(path.segment(segment)[1]).min(end);
            let g = self.enclosed(segment, at, next, sign);
            if g.lower() > 1.0 {
                at = next;
                step *= 2.0;
            } else if step > shortest {
                step = (0.5 * step).max(shortest);
            } else if g.upper() < 1.0 {
                return at;
            } else {
                at = next;
            }
        }
        end
    }

    /// The place between two at which g is largest.
    fn place_of_largest(&self, from: f64, to: f64, sign: f64) -> f64 {
        let g = |at: f64| sign * self.cosine_at(at);
        let mut best = if g(from) >= g(to) { (from, g(from)) } else { (to, g(to)) };
        let shortest = RESOLUTION * self.length;
        self.walk(from, to, |segment, start, end| {
            let middle = 0.5 * (start + end);
            let at_middle = g(middle);
            if at_middle > best.1 {
                best = (middle, at_middle);
            }
            // Rounding of g is what a place cannot be better by.
            let most = self.enclosed(segment, start, end, sign).upper();
            ControlFlow::Continue(most > best.1 + 4.0 * f64::EPSILON && end - start > shortest)
        });
        best.0
    }

    /// How fast the elbow passes the singularity that the path touches, rad/m: near it `φ = √|g''| s`, from
    /// `cos φ = 1 − φ²/2`.
    fn slope_of_touch(&self, at: f64) -> f64 {
        let path = self.tracker.path;
        let target = path.target(path.segment_at(at), Jet::<f64, 3>::variable(at));
        let [_, _, second] = path.elbow_cosine(&target).derivatives();
        let way = target.wrist[0].coefficients[1].hypot(target.wrist[1].coefficients[1]);
        second.abs().sqrt() / way
    }
}
