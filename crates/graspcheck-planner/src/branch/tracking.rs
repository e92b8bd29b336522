//! The search itself: halving the path until every part is proved, or known to fail.
//!
//! A cell of the path is enclosed by interval arithmetic: the cosine of the elbow, and from the slopes of the
//! joints over the whole cell how far each moves in it. It is accepted when the elbow keeps away from the
//! singularity, every joint from its limits, and none turns by more than [`STEP_TURN`] in half of it. Then the
//! nearest solution is on the same branch everywhere in the cell. Else it is halved and the earlier half comes
//! first; a cell too short to halve is where the path fails, whatever is tested there. Nothing between
//! samples is missed, because there are no samples.

use std::f64::consts::TAU;

use graspcheck_model::{
    inverse::{LIMIT_TOLERANCE, Unreachable},
    planar_path::{ElbowAngle, PLANAR_JOINTS, PlanarPath, PlanarTarget},
    robot::JointKind,
    task::Elbow,
};
use graspcheck_motion::{Interval, Jet, Scalar};

use super::{
    SINE_MIN, STEP_TURN,
    fault::{BranchFault, Demand, Located},
    singular::Singularity,
};
use crate::arm::Arm;

/// Share of the path within which the place of a fault is found.
pub(super) const PLACE_TOLERANCE: f64 = 1e-12;

/// How much a wrist may move along a path and still count as standing still, m: a thousand times the rounding
/// of a chain of transforms of an arm of 8 m. The tool may leave its path by that much, which its proved
/// deviation contains.
const STILL_TOLERANCE: f64 = 1e-12;

/// Halvings that narrow a place down to the spacing of floating-point numbers.
const BISECTIONS: u32 = 60;

/// The smaller part of a length divided by the golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Rounding of joint positions that come from the inverse kinematics, rad or m.
const POSITION_ROUNDING: f64 = 1e-13;

/// Positions of all joints; those that the arm does not have are 0.
pub(crate) type Positions = [f64; PLANAR_JOINTS];

/// Joint positions along a path, near enough to each other to tell the turns apart.
#[derive(Clone, Debug)]
pub(crate) struct Branch {
    elbow: Elbow,
    whole_turns: f64,
    /// Joints that do not move at all and keep the positions in which they start.
    held: [bool; PLANAR_JOINTS],
    places: Vec<f64>,
    positions: Vec<Positions>,
}

impl Branch {
    /// Joint positions near those at `place`, good enough to choose the turns of the inverse kinematics.
    fn near(&self, place: f64) -> Positions {
        if self.places.len() < 2 {
            return self.positions[0];
        }
        let right = self.places.partition_point(|&p| p <= place).clamp(1, self.places.len() - 1);
        let (a, b) = (self.places[right - 1], self.places[right]);
        let share = ((place - a) / (b - a)).clamp(0.0, 1.0);
        let [from, to] = [self.positions[right - 1], self.positions[right]];
        std::array::from_fn(|joint| from[joint] + share * (to[joint] - from[joint]))
    }

    /// Joint positions at the end of the path.
    pub(crate) fn end(&self) -> &Positions {
        &self.positions[self.positions.len() - 1]
    }

    /// The joints where the path parameter is `s`, with all derivatives that `s` has. Held joints have none.
    ///
    /// # Errors
    /// When the wrist is out of reach, which no place of the path is that was followed.
    pub(crate) fn joints<const N: usize>(
        &self,
        path: &PlanarPath,
        segment: usize,
        s: Jet<f64, N>,
    ) -> Result<[Jet<f64, N>; PLANAR_JOINTS], Unreachable> {
        let place = s.value();
        let positions = self.solve(path, segment, place, &self.near(place))?;
        let target = path.target(segment, s);
        let mut q = path.joints(&target, &path.elbow_angle(&target, self.elbow), &positions);
        let last = path.dof() - 1;
        if self.held[0] {
            // The wrist stands still, perhaps where the arm is singular: the tool turns by the last joint alone.
            q[last] = target.turn;
            q[last].coefficients[0] = positions[last];
        }
        for (joint, q) in q.iter_mut().enumerate() {
            if self.held[joint] {
                *q = Jet::from(self.positions[0][joint]);
            }
        }
        Ok(q)
    }

    /// Joint positions at a place, in the turns nearest to `near`.
    fn solve(
        &self,
        path: &PlanarPath,
        segment: usize,
        place: f64,
        near: &Positions,
    ) -> Result<Positions, Unreachable> {
        let target = path.target(segment, Jet::<f64, 1>::constant(place));
        let mut q = path.positions(&target, self.elbow, near, self.whole_turns)?;
        for (joint, q) in q.iter_mut().enumerate() {
            if self.held[joint] {
                *q = self.positions[0][joint];
            }
        }
        Ok(q)
    }
}

/// An arm on a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tracker<'a> {
    pub(super) arm: &'a Arm<'a>,
    pub(super) path: &'a PlanarPath,
}

/// Why a cell of the path is not accepted.
enum Doubt {
    /// The elbow may come too near to straight or folded.
    Singular,
    /// A joint may leave its limits.
    Limit(usize),
    /// A joint may turn too far to tell its turns apart.
    Turn,
}

impl<'a> Tracker<'a> {
    pub(crate) fn new(arm: &'a Arm<'a>, path: &'a PlanarPath) -> Self {
        Self { arm, path }
    }

    /// Follows the branch of `from`, which must be a solution at the beginning of the path, to its end.
    ///
    /// # Errors
    /// The first place at which the branch cannot be followed, with the reason.
    pub(crate) fn follow(&self, from: &[f64]) -> Result<Branch, Located> {
        let mut branch = self.beginning(from);
        let Err((at, doubt)) = self.march(&mut branch, true) else { return Ok(branch) };
        Err(match doubt {
            Doubt::Limit(joint) => self.limit_fault(at, joint, branch),
            // Only at the singularity itself are slopes without bound.
            Doubt::Singular | Doubt::Turn => Singularity::new(self, &branch).explain(at),
        })
    }

    /// The branch as it begins, with the joints that stand still.
    fn beginning(&self, from: &[f64]) -> Branch {
        let mut start = [0.0; PLANAR_JOINTS];
        start[..from.len()].copy_from_slice(from);
        let [wrist_moves, rise_moves, turn_moves] = self.movements();
        let last = self.path.dof() - 1;
        let mut held = [false; PLANAR_JOINTS];
        held[0] = !wrist_moves;
        held[1] = !wrist_moves;
        held[last] = !wrist_moves && !turn_moves;
        if let Some(quill) = self.path.geometry().quill {
            held[quill] = !rise_moves;
        }
        Branch {
            elbow: self.arm.elbow(from),
            whole_turns: self.path.whole_turns(self.path.start(), &start),
            held,
            places: vec![self.path.start()],
            positions: vec![start],
        }
    }

    /// Whether wrist, rise and ψ move along the path by more than rounding.
    fn movements(&self) -> [bool; 3] {
        let mut moves = [false; 3];
        let first = self.path.target(0, Jet::<f64, 1>::constant(self.path.start()));
        for segment in 0..self.path.segment_count() {
            let [start, end] = self.path.segment(segment);
            let all = self.path.target(segment, Jet::<Interval, 2>::variable(Interval::between(start, end)));
            let moved = |jet: &Jet<Interval, 2>, from: f64, at_start: f64| {
                // Over a segment by the slope, and from segment to segment by the value.
                jet.coefficients[1].magnitude() * (end - start) > STILL_TOLERANCE
                    || (at_start - from).abs() > STILL_TOLERANCE
            };
            let here = self.path.target(segment, Jet::<f64, 1>::constant(start));
            moves[0] |= (0..2).any(|k| moved(&all.wrist[k], first.wrist[k].value(), here.wrist[k].value()));
            moves[1] |= moved(&all.rise, first.rise.value(), here.rise.value());
            moves[2] |= moved(&all.turn, first.turn.value(), here.turn.value());
        }
        moves
    }

    /// Fills `branch` from where it ends to the end of the path; the first place at which it cannot be.
    fn march(&self, branch: &mut Branch, limits: bool) -> Result<(), (f64, Doubt)> {
        let shortest = PLACE_TOLERANCE * (self.path.end() - self.path.start());
        let first = self.path.segment_at(branch.places[branch.places.len() - 1]);
        let mut todo = Vec::with_capacity(64);
        for segment in first..self.path.segment_count() {
            let [start, end] = self.path.segment(segment);
            todo.push((start.max(branch.places[branch.places.len() - 1]), end));
            while let Some((start, end)) = todo.pop() {
                let middle = 0.5 * (start + end);
                match self.cell(branch, segment, start, end, limits) {
                    Ok(positions) => {
                        // The middle is known already; the end is what the next cell begins with.
                        branch.places.push(middle);
                        branch.positions.push(positions);
                        let Ok(positions) = branch.solve(self.path, segment, end, &positions) else {
                            return Err((end, Doubt::Singular));
                        };
                        branch.places.push(end);
                        branch.positions.push(positions);
                    }
                    Err(doubt) if end - start <= shortest => return Err((start, doubt)),
                    Err(_) => {
                        todo.push((middle, end));
                        todo.push((start, middle));
                    }
                }
            }
        }
        Ok(())
    }

    /// Joint positions in the middle of a cell, if all of it is proved to be as it should.
    fn cell(
        &self,
        branch: &Branch,
        segment: usize,
        start: f64,
        end: f64,
        limits: bool,
    ) -> Result<Positions, Doubt> {
        let middle = 0.5 * (start + end);
        let half = (end - middle).max(middle - start);
        let near = branch.end();
        let positions = branch.solve(self.path, segment, middle, near).map_err(|_| Doubt::Singular)?;
        let slopes = self.slopes(branch, segment, start, end)?;
        let joints = &self.arm.robot.joints;
        for (joint, slope) in slopes.iter().enumerate().take(joints.len()) {
            if branch.held[joint] {
                continue;
            }
            let reach = (Interval::between(-half, half) * *slope).widened(POSITION_ROUNDING);
            if joints[joint].kind == JointKind::Revolute && reach.magnitude() > STEP_TURN {
                return Err(Doubt::Turn);
            }
            let range = reach + Interval::point(positions[joint]);
            let allowed = &joints[joint].limits;
            let inside = range.lower() >= allowed.position_min - LIMIT_TOLERANCE
                && range.upper() <= allowed.position_max + LIMIT_TOLERANCE;
            if limits && !inside {
                return Err(Doubt::Limit(joint));
            }
        }
        Ok(positions)
    }

    /// What each joint moves per unit of s, over a cell in which the elbow keeps away from the singularity.
    fn slopes(
        &self,
        branch: &Branch,
        segment: usize,
        start: f64,
        end: f64,
    ) -> Result<[Interval; PLANAR_JOINTS], Doubt> {
        if branch.held[0] {
            // The wrist stands still: the elbow is where it was, near a singularity or not.
            let all = self.path.target(segment, Jet::<Interval, 2>::variable(Interval::between(start, end)));
            let mut slopes = [Interval::ZERO; PLANAR_JOINTS];
            if let Some(quill) = self.path.geometry().quill {
                slopes[quill] = all.rise.coefficients[1];
            }
            slopes[self.path.dof() - 1] = all.turn.coefficients[1];
            return Ok(slopes);
        }
        let (target, cos) = self.cosine(segment, start, end);
        let allowed = (1.0 - SINE_MIN * SINE_MIN).sqrt();
        if cos.value().magnitude() > allowed {
            return Err(Doubt::Singular);
        }
        let sin = (Jet::from(1.0) - cos.square()).sqrt();
        let elbow = ElbowAngle { cos, sin: if branch.elbow == Elbow::Left { sin } else { -sin } };
        let q = self.path.joints(&target, &elbow, &[Interval::ZERO; PLANAR_JOINTS]);
        Ok(q.map(|q| q.coefficients[1]))
    }

    /// What the path asks for over a cell, and the cosine of the elbow, both with first derivatives; the value
    /// of the cosine by the mean-value form.
    pub(super) fn cosine(
        &self,
        segment: usize,
        start: f64,
        end: f64,
    ) -> (PlanarTarget<Interval, 2>, Jet<Interval, 2>) {
        let middle = 0.5 * (start + end);
        let half = (end - middle).max(middle - start);
        let all = self.path.target(segment, Jet::<Interval, 2>::variable(Interval::between(start, end)));
        let at_middle = self.path.target(segment, Jet::<Interval, 1>::constant(Interval::point(middle)));
        let mut cos = self.path.elbow_cosine(&all);
        let around =
            self.path.elbow_cosine(&at_middle).value() + Interval::between(-half, half) * cos.coefficients[1];
        if let Some(common) = around.intersection(cos.value()) {
            cos.coefficients[0] = common;
        }
        (all, cos)
    }

    /// The fault of a joint that meets a limit at `at`: how far the path would take it, and whether its end is
    /// on another branch.
    fn limit_fault(&self, at: f64, joint: usize, mut branch: Branch) -> Located {
        let accepted = branch.positions.len() - 1;
        let at = self.where_limit_is_met(&branch, joint, at);
        // Where the branch goes on to if the limits are left aside; as far as it does.
        let whole = self.march(&mut branch, false).is_ok();
        let value = self.farthest(&branch, joint, accepted);
        let limits = &self.arm.robot.joints[joint].limits;
        let limit = if value > limits.position_max { limits.position_max } else { limits.position_min };
        let name = self.arm.robot.joints[joint].name.clone();
        let other = if branch.elbow == Elbow::Left { Elbow::Right } else { Elbow::Left };
        let same_end = self.end_is_legal(branch.elbow);
        // The branch arrives at its end: that is legal, or only another turn of it is.
        let end = branch.end();
        let arrives = (0..self.path.dof()).all(|joint| self.arm.excess(joint, end[joint]) <= LIMIT_TOLERANCE);
        let elsewhere = match (whole, arrives, same_end) {
            (true, true, _) | (false, _, true) => None,
            (true, false, true) => Some(branch.elbow),
            (_, _, false) => self.end_is_legal(other).then_some(other),
        };
        let fault = if let Some(elbow) = elsewhere {
            let same_elbow = elbow == branch.elbow;
            BranchFault::OtherBranch { joint: name, value, limit, elbow, same_elbow }
        } else {
            let hole = (joint == 1).then(|| self.arm.wrist_distance_at(limit));
            BranchFault::Limit { joint: name, value, limit, excess: self.arm.excess(joint, value), hole }
        };
        Located { at, fault }
    }

    /// The position of a joint that is farthest beyond its limits, from the place with this index on.
    fn farthest(&self, branch: &Branch, joint: usize, first: usize) -> f64 {
        let excess = |index: &usize| self.arm.excess(joint, branch.positions[*index][joint]);
        let last = branch.places.len() - 1;
        let index =
            (first..=last).max_by(|a, b| excess(a).total_cmp(&excess(b))).expect("there is a first place");
        // Between the neighbours of the farthest place, by golden section.
        let position = |place: f64| {
            let q = branch.solve(self.path, self.path.segment_at(place), place, &branch.near(place));
            q.map_or(branch.positions[index][joint], |q| q[joint])
        };
        let (mut a, mut b) =
            (branch.places[index.saturating_sub(1).max(first)], branch.places[(index + 1).min(last)]);
        for _ in 0..BISECTIONS {
            let (c, d) = (a + GOLDEN * (b - a), b - GOLDEN * (b - a));
            if self.arm.excess(joint, position(c)) > self.arm.excess(joint, position(d)) {
                b = d;
            } else {
                a = c;
            }
        }
        let found = position(0.5 * (a + b));
        if self.arm.excess(joint, found) > excess(&index) { found } else { branch.positions[index][joint] }
    }

    /// Where a joint meets the limit that it is beyond at `beyond`; the branch so far is within all of them.
    fn where_limit_is_met(&self, branch: &Branch, joint: usize, beyond: f64) -> f64 {
        let mut inside = branch.places[branch.places.len() - 1];
        let mut outside = beyond.max(inside) + PLACE_TOLERANCE * (self.path.end() - self.path.start());
        outside = outside.min(self.path.end());
        // A place accepted within the tolerance of a limit may be beyond the limit itself.
        let before = branch.places.iter().zip(&branch.positions).rev();
        for (&place, q) in before {
            inside = place;
            if self.arm.excess(joint, q[joint]) <= 0.0 {
                break;
            }
            outside = place;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            let q = branch.solve(self.path, self.path.segment_at(middle), middle, &branch.near(middle));
            if q.is_ok_and(|q| self.arm.excess(joint, q[joint]) <= 0.0) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }

    /// Whether the end of the path can be reached within all limits on an elbow's branch, in some turns.
    fn end_is_legal(&self, elbow: Elbow) -> bool {
        let segment = self.path.segment_count() - 1;
        let target = self.path.target(segment, Jet::<f64, 1>::constant(self.path.end()));
        let Ok(q) = self.path.positions(&target, elbow, &[0.0; PLANAR_JOINTS], 0.0) else { return false };
        self.arm.robot.joints.iter().zip(&q).all(|(joint, &q)| {
            let least = joint.limits.position_min - LIMIT_TOLERANCE;
            let most = joint.limits.position_max + LIMIT_TOLERANCE;
            match joint.kind {
                JointKind::Revolute => q + TAU * ((least - q) / TAU).ceil() <= most,
                JointKind::Prismatic => (least..=most).contains(&q),
            }
        })
    }

    /// What following the path asks of the joints at a place.
    pub(super) fn demand(&self, branch: &Branch, at: f64) -> Demand {
        let segment = self.path.segment_at(at);
        let s = Jet::<f64, 3>::variable(at);
        let target = self.path.target(segment, s);
        let way = target.wrist[0].coefficients[1].hypot(target.wrist[1].coefficients[1]);
        let elbow = self.path.elbow_angle(&target, branch.elbow);
        let q = self.path.joints(&target, &elbow, branch.end());
        let joints = &self.arm.robot.joints;
        let mut demand =
            Demand { fastest: joints[0].name.clone(), slope: 0.0, speed: f64::INFINITY, bend: 0.0 };
        for (joint, q) in joints.iter().zip(&q) {
            let [_, slope, bend] = q.derivatives();
            let (slope, speed) = ((slope / way).abs(), (joint.limits.velocity * way / slope).abs());
            if speed < demand.speed {
                demand = Demand { fastest: joint.name.clone(), slope, speed, ..demand };
            }
            demand.bend = demand.bend.max((bend / (way * way)).abs());
        }
        demand
    }
}
