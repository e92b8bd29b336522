//! Grasp an object, carry it and put it down: from poses to a sequence of motions.
//!
//! ```text
//! grasp     T_WG = T_WO · T_OH          pre-grasp   T_WG · Tx(−pregrasp distance)
//!                                       lift end    T_WG moved by the departure
//! place     T_WP = T_WO,placed · T_OH   pre-place   T_WP moved by the arrival
//!                                       retreat     T_WP · Tx(−retreat distance)
//! ```
//!
//! T_OH is a handle's frame, or that frame after half a turn about its x axis where the handle allows it;
//! the same one serves for grasp and place, so that the object's pose at its place is the one asked for.
//!
//! Every solution of the inverse kinematics at the grasp pose is continued along the straight moves before
//! and after it, and every one at the place pose likewise. What stays within limits on one branch is
//! combined; the joint moves between may change branch and turns. Combinations are ordered by the time
//! that the arm moves, and the first whose plan is proved clear is chosen. If none is, the fastest is
//! returned all the same: the verdict then names the pair that comes too near, planning does not hide it.

use graspcheck_model::{
    Pose,
    cell::Cell,
    object::{Handle, Object},
    plan::{Grasp, Holding, Plan},
    robot::{JointLimits, RobotModel},
    task::{Pace, PickAndPlace},
};
use graspcheck_motion::Trajectory;
use graspcheck_proof::{Certificate, PairVerdict, Scene, Violation};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::{
    Planned,
    arm::Arm,
    branch::BranchFault,
    candidate::{Candidate, CandidateOutcome, Stage, WristReach},
    error::{NothingReachable, PlanError},
    input::{check_joint_count, check_number},
    joint_move::joint_move_by,
    opening::{GripError, Openings},
    pace::{CheckedPace, PhaseNames},
    sequence::Sequence,
    stop::{Line, Reached, Rejected, Stop},
};

/// Names of the phases that the task can have, in order.
pub const PHASES: [&str; 8] = ["approach", "descend", "close", "lift", "carry", "lower", "open", "retreat"];

/// Times that differ by less count as equal when candidates are ordered, s.
///
/// The reason: candidates that are mirror images of each other take the same time up to rounding, which must
/// not decide between them.
const SAME_TIME: f64 = 1e-9;

/// Finds a plan for the task.
pub(crate) fn find(
    robot: &RobotModel,
    cell: &Cell,
    object: &Object,
    task: &PickAndPlace,
    pace: &Pace,
) -> Result<Planned, PlanError> {
    let pace = CheckedPace::new(pace, PhaseNames { all: &PHASES, joint_moves: &["approach", "carry"] })?;
    check_task(robot, object, task)?;
    let pick = Pick {
        arm: Arm::new(robot).map_err(PlanError::NoInverse)?,
        limits: robot.joints.iter().map(|joint| joint.limits).collect(),
        object,
        task,
        pace,
    };
    let mut rejected = Vec::new();
    let mut grips = Vec::new();
    for grip in pick.grips()? {
        let grasps = pick.reached(&grip, &pick.grasp_stop(&grip), &mut rejected)?;
        let places = pick.reached(&grip, &pick.place_stop(&grip), &mut rejected)?;
        let approaches = grasps.iter().map(|grasp| pick.joint_move("approach", &task.start, &grasp.before));
        let approaches: Vec<Option<Trajectory>> = approaches.collect::<Result<_, _>>()?;
        grips.push((grip, grasps.into_iter().zip(approaches).collect::<Vec<_>>(), places));
    }
    let mut ways = Vec::new();
    for (grip, grasps, places) in &grips {
        for (grasp, approach) in grasps {
            for place in places {
                let carry = pick.joint_move("carry", &grasp.after, &place.before)?;
                let between: f64 = approach.iter().chain(&carry).map(Trajectory::duration).sum();
                let moving = grasp.moving() + place.moving() + between;
                ways.push(Way { grip, approach: approach.as_ref(), grasp, carry, place, moving });
            }
        }
    }
    if ways.is_empty() {
        let placing = grips.iter().any(|(_, grasps, _)| !grasps.is_empty());
        return Err(PlanError::Unreachable(Box::new(pick.nothing_reachable(placing, rejected)?)));
    }
    // A stable sort: equals stay in the order of handles, elbows and turns.
    let rank = |way: &Way| (way.moving / SAME_TIME).round();
    ways.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    pick.choose(&Scene::new(robot, cell, Some(object))?, &ways, rejected)
}

/// Checks what a task says before anything is computed from it.
fn check_task(robot: &RobotModel, object: &Object, task: &PickAndPlace) -> Result<(), PlanError> {
    check_joint_count("start", &task.start, robot.dof())?;
    let not_negative = "finite and not negative";
    for (place, value) in
        [("pre-grasp distance, m", task.pregrasp_distance), ("retreat distance, m", task.retreat_distance)]
    {
        check_number(place, value, value >= 0.0, not_negative)?;
    }
    for (place, value) in
        [("close duration, s", task.close_duration), ("open duration, s", task.open_duration)]
    {
        check_number(place, value, value > 0.0, "finite and positive")?;
    }
    for (place, vector) in [("departure, m", &task.departure), ("arrival, m", &task.arrival)] {
        for &value in vector {
            check_number(place, value, true, "finite")?;
        }
    }
    let (force, force_max) = (task.grip_force, robot.gripper.force_max);
    if !(force > 0.0 && force <= force_max) {
        return Err(GripError::Force { force, force_max }.into());
    }
    if object.handles.is_empty() {
        return Err(PlanError::NoHandle { object: object.name.clone() });
    }
    Ok(())
}

/// The task with everything that its candidates share.
struct Pick<'a> {
    arm: Arm<'a>,
    limits: Vec<JointLimits>,
    object: &'a Object,
    task: &'a PickAndPlace,
    pace: CheckedPace<'a>,
}

/// A handle, straight or after half a turn.
struct Grip<'a> {
    handle: &'a Handle,
    half_turn: bool,
    object_from_tool: Pose,
    openings: Openings,
}

/// A reachable way to do the whole task.
struct Way<'s> {
    grip: &'s Grip<'s>,
    approach: Option<&'s Trajectory>,
    grasp: &'s Reached,
    carry: Option<Trajectory>,
    place: &'s Reached,
    /// Time that the arm moves, s.
    moving: f64,
}

impl Way<'_> {
    fn candidate(&self, outcome: CandidateOutcome) -> Candidate {
        Candidate {
            handle: self.grip.handle.name.clone(),
            half_turn: self.grip.half_turn,
            grasp: Some(self.grasp.choice.clone()),
            place: Some(self.place.choice.clone()),
            stage: Stage::Complete,
            moving: Some(self.moving),
            outcome,
        }
    }
}

impl<'a> Pick<'a> {
    /// All handles, with their half turns.
    fn grips(&self) -> Result<Vec<Grip<'a>>, PlanError> {
        let gripper = &self.arm.robot.gripper;
        let half = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let mut grips = Vec::new();
        for handle in &self.object.handles {
            let openings = Openings::at(handle, gripper)?;
            openings.check_speed(gripper, "close", self.dwell("close"))?;
            openings.check_speed(gripper, "open", self.dwell("open"))?;
            let object_from_tool = handle.object_from_handle;
            grips.push(Grip { handle, half_turn: false, object_from_tool, openings });
            if handle.half_turn {
                grips.push(Grip {
                    handle,
                    half_turn: true,
                    object_from_tool: object_from_tool * half,
                    openings,
                });
            }
        }
        Ok(grips)
    }

    /// How long the fingers are given in `close` or `open`, s.
    fn dwell(&self, phase: &str) -> f64 {
        let own = if phase == "close" { self.task.close_duration } else { self.task.open_duration };
        self.pace.duration(phase).unwrap_or(own)
    }

    fn grasp_stop(&self, grip: &Grip) -> Stop {
        let world_from_tool = self.object.world_from_object * grip.object_from_tool;
        Stop {
            world_from_before: world_from_tool * Translation3::new(-self.task.pregrasp_distance, 0.0, 0.0),
            world_from_tool,
            world_from_after: Translation3::from(self.task.departure) * world_from_tool,
            stages: [Stage::Grasp, Stage::Descend, Stage::Lift],
            phases: ["descend", "lift"],
        }
    }

    fn place_stop(&self, grip: &Grip) -> Stop {
        let world_from_tool = self.task.world_from_placed * grip.object_from_tool;
        Stop {
            world_from_before: Translation3::from(self.task.arrival) * world_from_tool,
            world_from_tool,
            world_from_after: world_from_tool * Translation3::new(-self.task.retreat_distance, 0.0, 0.0),
            stages: [Stage::Place, Stage::Lower, Stage::Retreat],
            phases: ["lower", "retreat"],
        }
    }

    /// The branches on which the tool can go to a stop and leave it; the others join the `rejected`.
    fn reached(
        &self,
        grip: &Grip,
        stop: &Stop,
        rejected: &mut Vec<Candidate>,
    ) -> Result<Vec<Reached>, PlanError> {
        let mut reached = Vec::new();
        for branch in stop.branches(&self.arm, &self.pace)? {
            match branch {
                Ok(found) => reached.push(found),
                Err(Rejected { choice, stage, outcome }) => {
                    let (grasp, place) = if stage < Stage::Place { (choice, None) } else { (None, choice) };
                    rejected.push(Candidate {
                        handle: grip.handle.name.clone(),
                        half_turn: grip.half_turn,
                        grasp,
                        place,
                        stage,
                        moving: None,
                        outcome,
                    });
                }
            }
        }
        Ok(reached)
    }

    /// The joint move of a phase; none when there is no way to go.
    fn joint_move(&self, phase: &str, from: &[f64], to: &[f64]) -> Result<Option<Trajectory>, PlanError> {
        if from == to {
            return Ok(None);
        }
        joint_move_by(from, to, &self.limits, self.pace.pacing(phase))
            .map(Some)
            .map_err(|error| PlanError::JointMove { phase: phase.to_owned(), error })
    }

    /// The first way whose plan is proved clear, or the first of all; with what became of the others.
    fn choose(&self, scene: &Scene, ways: &[Way], rejected: Vec<Candidate>) -> Result<Planned, PlanError> {
        let mut clear = None;
        let mut fastest = None;
        let mut outcomes = Vec::with_capacity(ways.len());
        for (index, way) in ways.iter().enumerate() {
            let plan = self.plan(way)?;
            let certificate = scene.certify(&plan);
            if certificate.is_free() {
                clear = Some((index, plan, certificate));
                break;
            }
            outcomes.push(not_clear(&certificate));
            fastest.get_or_insert((0, plan, certificate));
        }
        let (chosen, plan, certificate) = clear.or(fastest).expect("there is a way, and it was tried");
        let slower = |way: &Way| CandidateOutcome::Slower { by: way.moving - ways[chosen].moving };
        outcomes.extend(ways[outcomes.len()..].iter().map(slower));
        outcomes[chosen] = CandidateOutcome::Chosen;
        let mut candidates: Vec<Candidate> =
            ways.iter().zip(outcomes).map(|(way, outcome)| way.candidate(outcome)).collect();
        candidates[..=chosen].rotate_right(1);
        candidates.extend(nearest_miss_first(rejected));
        Ok(Planned { plan, certificate: Some(certificate), candidates })
    }

    /// The plan of a way.
    fn plan(&self, way: &Way) -> Result<Plan, PlanError> {
        let Way { grip, grasp, place, .. } = way;
        let close = Trajectory::hold(&grasp.at, self.dwell("close"))?;
        let open = Trajectory::hold(&place.at, self.dwell("open"))?;
        let motions = [
            ("approach", way.approach, Holding::AtStart),
            ("descend", motion_of(&grasp.arriving), Holding::AtStart),
            ("close", Some(&close), Holding::Closing),
            ("lift", motion_of(&grasp.leaving), Holding::Held),
            ("carry", way.carry.as_ref(), Holding::Held),
            ("lower", motion_of(&place.arriving), Holding::Held),
            ("open", Some(&open), Holding::Opening),
            ("retreat", motion_of(&place.leaving), Holding::Placed),
        ];
        let mut sequence = Sequence::default();
        for (phase, motion, holding) in motions {
            if let Some(motion) = motion {
                sequence.add(phase, motion, holding)?;
            }
        }
        let (trajectory, phases) = sequence.finish()?;
        let lines = [&grasp.arriving, &grasp.leaving, &place.arriving, &place.leaving];
        Ok(Plan {
            opening: grip.openings.over(&phases)?,
            trajectory,
            phases,
            paths: lines.into_iter().flatten().map(|line| line.planned.clone()).collect(),
            grasp: Some(Grasp {
                handle: grip.handle.name.clone(),
                tool_from_object: grip.object_from_tool.inverse(),
                width: grip.handle.width,
                opening: grip.openings.free,
                force: self.task.grip_force,
                world_from_start: self.object.world_from_object,
                world_from_placed: self.task.world_from_placed,
            }),
        })
    }

    /// That nothing can be reached, with the candidates and where the wrist would have to be: for placing
    /// when the grasp can be reached, else for grasping.
    fn nothing_reachable(
        &self,
        placing: bool,
        rejected: Vec<Candidate>,
    ) -> Result<NothingReachable, PlanError> {
        let miss = |reach: &WristReach| reach.shift.map_or(0.0, |shift| shift.norm());
        let wrists = self.grips()?.into_iter().filter_map(|grip| {
            let stop = if placing { self.place_stop(&grip) } else { self.grasp_stop(&grip) };
            self.wrist_reach(&stop.world_from_tool, placing)
        });
        Ok(NothingReachable {
            object: self.object.name.clone(),
            world_from_object: self.object.world_from_object,
            world_from_placed: self.task.world_from_placed,
            wrist: wrists.min_by(|a, b| miss(a).total_cmp(&miss(b))),
            candidates: nearest_miss_first(rejected),
        })
    }

    /// Where the wrist would have to be for a pose of the tool, and where it can be; none when the arm cannot
    /// give its tool that direction at all.
    fn wrist_reach(&self, world_from_tool: &Pose, placing: bool) -> Option<WristReach> {
        let (inverse, world_from_base) = (&self.arm.inverse, &self.arm.robot.world_from_base);
        let distance = inverse.wrist_distance(world_from_tool).ok()?;
        let reach = inverse.reach();
        let nearest = distance.clamp(reach.inner, reach.outer);
        let geometry = inverse.geometry();
        let base_from_tool = world_from_base.inv_mul(world_from_tool);
        let zero_from_now = base_from_tool.rotation * geometry.base_from_tool_zero.inverse();
        let offset = zero_from_now * geometry.tool_offset.push(0.0);
        let outwards = base_from_tool.translation.vector.xy() - offset.xy() - geometry.shoulder.coords;
        let way = nearest - distance;
        let outwards = outwards.try_normalize(0.0)?;
        let shift = (way.abs() > 0.0).then(|| world_from_base.rotation * (way * outwards).push(0.0));
        Some(WristReach { placing, distance, reach, shift })
    }
}

/// What a certificate that is not free says against its plan: the violation that is deepest of those found,
/// or a pair that is not decided.
fn not_clear(certificate: &Certificate) -> CandidateOutcome {
    let margin = |violation: &Violation| violation.distance - violation.required;
    let deepest = certificate.violations().min_by(|(_, a), (_, b)| margin(a).total_cmp(&margin(b)));
    if let Some((pair, violation)) = deepest {
        return CandidateOutcome::TooNear {
            a: pair.a.clone(),
            b: pair.b.clone(),
            distance: violation.distance,
            required: violation.required,
            time: violation.time,
            phase: violation.phase.clone(),
        };
    }
    let undecided = certificate.pairs.iter().find(|pair| !matches!(pair.verdict, PairVerdict::Free { .. }));
    let (a, b) = undecided.map(|pair| (pair.a.clone(), pair.b.clone())).unwrap_or_default();
    CandidateOutcome::Undecided { a, b }
}

/// The motion on a line, if there is one.
fn motion_of(line: &Option<Line>) -> Option<&Trajectory> {
    line.as_ref().map(|line| &line.motion)
}

/// The rejected candidates in order: those that got farthest first, and of these the smallest excess.
fn nearest_miss_first(mut rejected: Vec<Candidate>) -> Vec<Candidate> {
    let excess = |candidate: &Candidate| match &candidate.outcome {
        CandidateOutcome::Limit { excess, .. }
        | CandidateOutcome::Line { fault: BranchFault::Limit { excess, .. }, .. } => *excess,
        CandidateOutcome::Line { fault: BranchFault::OtherBranch { value, limit, .. }, .. } => {
            (value - limit).abs()
        }
        _ => f64::INFINITY,
    };
    rejected.sort_by(|a, b| b.stage.cmp(&a.stage).then(excess(a).total_cmp(&excess(b))));
    rejected
}
