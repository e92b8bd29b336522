//! Following one branch of the inverse kinematics along a path of the tool.
//!
//! At every place of the path the nearest solution is taken, in steps so short that no joint turns by more
//! than [`STEP_TURN`]; a step that cannot be made short enough is a jump. What can go wrong is found,
//! located and explained: part of the path is out of reach, a joint meets its limit, the path comes too
//! near to a singularity, or it leads through one onto the other branch.

use graspcheck_model::{
    Pose,
    inverse::{LIMIT_TOLERANCE, Unreachable},
    robot::JointKind,
};

use crate::arm::Arm;

/// Largest turn of a revolute joint from one place of the path to the next, rad.
///
/// The reason: where the sine of the elbow is at least [`SINE_MIN`] the two elbow branches are at least
/// 0.2 rad apart, so the nearest solution within a quarter of that is on the same branch.
pub const STEP_TURN: f64 = 0.05;

/// Least |sin elbow| along a path that the tool follows by inverse kinematics.
///
/// The reason: joint speeds grow with 1 / |sin elbow|; at 0.1 they are ten times those of a bent arm, and
/// the outermost 0.25 % of an arm's reach is all that is given up.
pub const SINE_MIN: f64 = 0.1;

/// |sin elbow| below which the path touches the singularity itself.
///
/// The reason: near a singularity the sine is the square root of what rounding leaves, about 1e-8.
const SINE_TOUCH: f64 = 1e-6;

/// Share of the path within which the place of a fault is found.
const PLACE_TOLERANCE: f64 = 1e-9;

/// Least number of steps along a path.
const STEPS_MIN: f64 = 32.0;

/// Places at which a stretch of the path is looked at when it is searched for a fault.
const SAMPLES: u32 = 400;

/// Halvings that narrow a place down to the spacing of floating-point numbers.
const BISECTIONS: u32 = 60;

/// Where along a path a branch cannot be followed, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Located {
    /// The place: the path parameter s of a straight line (0 to 1), the time of a timed motion, s.
    pub at: f64,
    /// What is wrong there.
    pub fault: BranchFault,
}

impl Located {
    /// The same fault of a path with places 0 to 1, as whoever follows it from the other end counts places.
    pub(crate) fn seen_from_other_end(self) -> Self {
        match self.fault {
            BranchFault::OutOfReach { until, bound } => {
                Self { at: 1.0 - until, fault: BranchFault::OutOfReach { until: 1.0 - self.at, bound } }
            }
            BranchFault::Jump { joint, from, to } => {
                Self { at: 1.0 - self.at, fault: BranchFault::Jump { joint, from: to, to: from } }
            }
            fault => Self { at: 1.0 - self.at, fault },
        }
    }
}

/// Why a branch of the inverse kinematics cannot be followed along a path.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BranchFault {
    /// The path leaves the workspace.
    #[error(
        "the tool is out of reach up to {until:.4}: {bound}; move the path, or go around by a joint move"
    )]
    OutOfReach {
        /// Where the path is in reach again, or its end.
        until: f64,
        /// The bound just beyond the place, as the inverse kinematics names it.
        bound: Unreachable,
    },
    /// A joint meets a position limit.
    #[error(
        "joint {joint}: the path asks for {value:.6}, beyond {limit:.6} by {excess:.6}; use another branch \
         or turn, or shorten the path"
    )]
    Limit {
        /// Name of the joint.
        joint: String,
        /// The farthest that the path asks for, rad or m.
        value: f64,
        /// The limit, rad or m.
        limit: f64,
        /// How far beyond, rad or m.
        excess: f64,
    },
    /// The path comes too near to a singularity.
    #[error(
        "|sin elbow| {sine:.4} below {least:.4}: the arm is nearly straight or folded and its joints would \
         have to be very fast; move the path, or use a joint move"
    )]
    NearSingular {
        /// The least |sin elbow| on the path.
        sine: f64,
        /// [`SINE_MIN`].
        least: f64,
    },
    /// The path touches the singular circle, where the branches meet.
    #[error(
        "the arm is straight or folded in this one place and goes on on the other elbow branch; move the \
         path away from the singular circle, or use a joint move"
    )]
    BranchChange,
    /// The nearest solution is not near.
    #[error(
        "joint {joint}: the nearest solution jumps from {from:.6} to {to:.6}; no continuous joint motion \
         follows the path, use a joint move"
    )]
    Jump {
        /// Name of the joint that jumps farthest.
        joint: String,
        /// Before, rad or m.
        from: f64,
        /// After, rad or m.
        to: f64,
    },
    /// Quintic pieces do not come near enough to the path.
    #[error(
        "pieces of {length:.3e} s still leave the path by {deviation:.3e} (m or rad), more than \
         {tolerance:.3e}; raise the tolerance or smooth the path"
    )]
    NotConverging {
        /// Length of the shortest piece, s.
        length: f64,
        /// Its deviation, m or rad.
        deviation: f64,
        /// What is allowed.
        tolerance: f64,
    },
}

/// Joint positions along a path, near enough to each other to tell the branches apart.
#[derive(Clone, Debug)]
pub(crate) struct Branch {
    places: Vec<f64>,
    positions: Vec<Vec<f64>>,
}

impl Branch {
    /// Joint positions near those at `place`, good enough to choose the solution of the inverse kinematics.
    pub(crate) fn near(&self, place: f64) -> Vec<f64> {
        let right = self.places.partition_point(|&p| p <= place).clamp(1, self.places.len() - 1);
        let (a, b) = (self.places[right - 1], self.places[right]);
        let share = (place - a) / (b - a);
        let joints = self.positions[right - 1].iter().zip(&self.positions[right]);
        joints.map(|(from, to)| from + share * (to - from)).collect()
    }

    /// Joint positions at the end of the path.
    pub(crate) fn end(&self) -> &[f64] {
        &self.positions[self.positions.len() - 1]
    }

    /// The places at which the branch was followed, and the joint positions there.
    pub(crate) fn samples(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.places.iter().copied().zip(self.positions.iter().map(Vec::as_slice))
    }
}

/// A path of the tool: its pose at every place from `start` to `end`.
#[derive(Clone, Copy)]
pub(crate) struct ToolPath<'a> {
    arm: &'a Arm<'a>,
    start: f64,
    end: f64,
    pose: &'a dyn Fn(f64) -> Pose,
}

impl<'a> ToolPath<'a> {
    /// The path with these poses at the places from `start` to `end`.
    pub(crate) fn new(arm: &'a Arm<'a>, start: f64, end: f64, pose: &'a dyn Fn(f64) -> Pose) -> Self {
        Self { arm, start, end, pose }
    }

    /// Follows the branch of `from`, which must be a solution at the first place, to the end.
    ///
    /// # Errors
    /// The first place at which the branch cannot be followed, with the reason.
    pub(crate) fn follow(&self, from: &[f64]) -> Result<Branch, Located> {
        let mut branch = Branch { places: vec![self.start], positions: vec![from.to_vec()] };
        let fault = self.march(&mut branch).err();
        // A limit that is met before something else is wrong comes first.
        self.check_limits(&branch)?;
        fault.map_or(Ok(branch), Err)
    }

    /// Fills `branch` up to the end.
    fn march(&self, branch: &mut Branch) -> Result<(), Located> {
        let step_max = (self.end - self.start) / STEPS_MIN;
        let step_min = (self.end - self.start) * PLACE_TOLERANCE;
        let mut step = step_max;
        let mut at = self.start;
        if self.arm.sine_of_elbow(branch.end()) < SINE_MIN {
            return Err(self.singularity(at, branch.end()));
        }
        while at < self.end {
            let next = if at + step >= self.end - step_min { self.end } else { at + step };
            let here = branch.end();
            match self.arm.solve_near(&(self.pose)(next), here) {
                Ok(q) => {
                    let (joint, turn) = self.largest_turn(here, &q);
                    if turn <= STEP_TURN {
                        branch.places.push(next);
                        branch.positions.push(q);
                        if self.arm.sine_of_elbow(branch.end()) < SINE_MIN {
                            return Err(self.singularity(next, branch.end()));
                        }
                        at = next;
                        step = (2.0 * step).min(step_max);
                        continue;
                    }
                    if step <= step_min {
                        let (from, to) = (here[joint], q[joint]);
                        let joint = self.arm.robot.joints[joint].name.clone();
                        return Err(Located { at, fault: BranchFault::Jump { joint, from, to } });
                    }
                }
                Err(bound) if step <= step_min => {
                    let until = self.in_reach_again(next);
                    return Err(Located { at, fault: BranchFault::OutOfReach { until, bound } });
                }
                Err(_) => {}
            }
            step /= 2.0;
        }
        Ok(())
    }

    /// The revolute joint that turns most between two positions, and by how much, rad.
    fn largest_turn(&self, from: &[f64], to: &[f64]) -> (usize, f64) {
        let mut largest = (0, 0.0);
        for (index, joint) in self.arm.robot.joints.iter().enumerate() {
            let turn = (to[index] - from[index]).abs();
            if joint.kind == JointKind::Revolute && turn > largest.1 {
                largest = (index, turn);
            }
        }
        largest
    }

    /// What a path that has come near a singularity at `at` does next: leaves the workspace, touches the
    /// singular circle, or passes by.
    fn singularity(&self, at: f64, near: &[f64]) -> Located {
        let place = |k: u32| at + (self.end - at) * f64::from(k) / f64::from(SAMPLES);
        // |sin elbow| is the same on both branches, so any solution tells it.
        let sine = |u: f64| self.arm.solve_near(&(self.pose)(u), near).map(|q| self.arm.sine_of_elbow(&q));
        let mut least = (0, f64::INFINITY);
        for k in 0..=SAMPLES {
            match sine(place(k)) {
                Ok(value) if value >= SINE_MIN && k > 0 => break,
                Ok(value) if value < least.1 => least = (k, value),
                Ok(_) => {}
                Err(bound) => return self.out_of_reach(place(k.saturating_sub(1)), place(k), bound),
            }
        }
        // Between the neighbours of the least sample, by golden section. A place out of reach between two
        // in reach counts as the singularity itself.
        let (mut a, mut b) = (place(least.0.saturating_sub(1)), place((least.0 + 1).min(SAMPLES)));
        let mut found = (place(least.0), least.1);
        for _ in 0..BISECTIONS {
            let (c, d) = (a + (b - a) * 0.382, a + (b - a) * 0.618);
            let (at_c, at_d) = (sine(c).unwrap_or(0.0), sine(d).unwrap_or(0.0));
            for candidate in [(c, at_c), (d, at_d)] {
                if candidate.1 < found.1 {
                    found = candidate;
                }
            }
            if at_c < at_d {
                b = d;
            } else {
                a = c;
            }
        }
        let (place, sine) = found;
        if sine > SINE_TOUCH {
            return Located { at: place, fault: BranchFault::NearSingular { sine, least: SINE_MIN } };
        }
        match self.arm.solve_near(&(self.pose)(place), near) {
            Err(bound) => self.out_of_reach(at, place, bound),
            Ok(_) => Located { at: place, fault: BranchFault::BranchChange },
        }
    }

    /// The fault of a path that is in reach at `inside` and not at the later place `outside`: out of reach,
    /// or a branch change when no more than a point is.
    fn out_of_reach(&self, inside: f64, outside: f64, bound: Unreachable) -> Located {
        let at = self.edge(inside, outside);
        let until = self.in_reach_again(outside);
        if until - at > SINE_TOUCH * (self.end - self.start) {
            Located { at, fault: BranchFault::OutOfReach { until, bound } }
        } else {
            Located { at, fault: BranchFault::BranchChange }
        }
    }

    /// Whether any joint positions reach the pose at `place`, whatever the limits.
    fn in_reach(&self, place: f64) -> bool {
        self.arm.inverse.solve(&(self.pose)(place)).is_ok()
    }

    /// The last place in reach between `inside`, which is, and `outside`, which is not.
    fn edge(&self, inside: f64, outside: f64) -> f64 {
        let (mut a, mut b) = (inside, outside);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (a + b);
            if self.in_reach(middle) {
                a = middle;
            } else {
                b = middle;
            }
        }
        a
    }

    /// The first place in reach after `outside`, or the end.
    fn in_reach_again(&self, outside: f64) -> f64 {
        let place = |k: u32| outside + (self.end - outside) * f64::from(k) / f64::from(SAMPLES);
        (1..=SAMPLES)
            .find(|&k| self.in_reach(place(k)))
            .map_or(self.end, |k| self.edge(place(k), place(k - 1)))
    }

    /// Checks that the positions of a branch are within the limits.
    fn check_limits(&self, branch: &Branch) -> Result<(), Located> {
        let beyond = |joint: usize, q: &[f64]| self.arm.excess(joint, q[joint]);
        let first = branch.positions.iter().enumerate().find_map(|(index, q)| {
            let joint = (0..q.len()).find(|&joint| beyond(joint, q) > LIMIT_TOLERANCE)?;
            Some((index, joint))
        });
        let Some((index, joint)) = first else { return Ok(()) };
        let mut value = branch.positions[index][joint];
        for q in &branch.positions[index..] {
            if beyond(joint, q) > self.arm.excess(joint, value) {
                value = q[joint];
            }
        }
        let mut at = branch.places[index];
        if index > 0 {
            let (mut inside, mut outside) = (branch.places[index - 1], at);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (inside + outside);
                let solution = self.arm.solve_near(&(self.pose)(middle), &branch.positions[index]);
                if solution.is_ok_and(|q| beyond(joint, &q) <= 0.0) {
                    inside = middle;
                } else {
                    outside = middle;
                }
            }
            at = inside;
        }
        Err(Located { at, fault: self.arm.limit_fault(joint, value) })
    }
}
