//! `executed.consistency`: the streams of a log say the same thing, each in its way. Whoever edits one of them
//! contradicts another.
//!
//! | stream | must agree with |
//! |---|---|
//! | all | the same instants |
//! | `measured`, `object`: first row | the plan's start, the declared pose |
//! | `reference`, `reference_tool` | the plan at the same instants: positions, velocities, pose and twist of the tool |
//! | `tool` | kinematics of the measured joints: pose and twist |
//! | `measured` efforts of the arm | the commanded ones, cut off at the limits, where drives are perfect |
//! | `measured` efforts of the fingers | the forces of their contacts with the object |
//! | `measured` and `object`: velocities | differences of positions, before and after the row |
//! | `measured` and `object`: positions | the velocities at both ends of the step, and the way that velocities make from the start |
//! | `object`, `tool`: names | the object of the run, the tool |
//! | `monitor` | phase, tracking error, opening, saturated joints and grip force of the row |

use std::collections::BTreeMap;

use graspcheck_model::{Pose, execution::Controller, robot::JointKind};
use graspcheck_motion::MotionState;
use nalgebra::Vector3;

use crate::{
    evidence::Evidence,
    finding::{Finding, Gap},
    note::Note,
    resolved::Resolved,
    stream::{self, JointStream, PoseSample, seconds},
    verdict::Unit,
};

/// How far numbers may differ that are computed from the same ones, in their SI unit: another system's sines
/// and cosines differ by 1e-16, which a chain of joints makes 1e-14, and rotations stored as quaternions lose
/// half of the digits of small angles.
const SAME: f64 = 1e-7;

/// What a velocity may miss of the differences of positions beside it, and positions of velocities, as a share
/// of the velocity that the joint's largest acceleration gives it in one step: a step of the integrator is of
/// first order in that, and contacts accelerate an arm beyond its limit.
const SHARE_OF_STEP: f64 = 4.0;

/// How far the way by velocities may be from that by positions, as a share of the way of the largest speed in one step.
/// Each step may miss a little, but not always to one side: where speed changes half a step adds up, and constraints
/// between joints and contacts move a body without giving it speed. An edit of less than this is not seen.
const DRIFT_SHARE: f64 = 1.5;

/// What comes on top of that: for a slide or the object, m; for a turn, rad; for a finger, which is held to the other by
/// a constraint, m. Runs at the limits of both arms were seen to have two thirds of it.
const SLIDE_DRIFT: f64 = 3e-4;
const TURN_DRIFT: f64 = 2e-3;
const FINGER_DRIFT: f64 = 5e-3;

/// The same for fingers and the object's points, which contacts accelerate without a limit, m/s: twice and more
/// what runs were seen to have whose fingers close at 20 mm/s or whose cube is dropped.
const CONTACT_SPEED: f64 = 0.1;

/// The faults that were found.
#[derive(Default)]
struct Faults {
    count: usize,
    first: Option<(f64, &'static str, Note)>,
    last: f64,
}

impl Faults {
    /// Two numbers, or the ends of a difference, may be no farther apart than `allowed`.
    fn hold(&mut self, time: f64, stream: &'static str, what: &str, apart: f64, allowed: f64, unit: Unit) {
        if exceeds(apart, allowed) {
            let note = Note::from(format!("stream {stream}: {what} differs by ")).quantity(apart, unit);
            self.add(time, stream, note);
        }
    }

    fn add(&mut self, time: f64, stream: &'static str, note: Note) {
        self.count += 1;
        self.last = self.last.max(time);
        if self.first.as_ref().is_none_or(|(first, ..)| time < *first) {
            self.first = Some((time, stream, note));
        }
    }
}

/// The number of values that contradict another stream, the plan, or what is beside them.
pub(super) fn consistency(evidence: &Evidence<'_>) -> Result<Finding, Gap> {
    stream::requested(evidence)?;
    let log = Streams::of(evidence)?;
    stream::contacts_are_all_there(evidence, f64::NEG_INFINITY..=f64::INFINITY)?;
    let mut faults = Faults::default();
    log.names(&mut faults);
    log.start(&mut faults);
    log.reference(&mut faults);
    log.tool(&mut faults);
    log.efforts(&mut faults);
    log.speeds(&mut faults);
    log.monitor(&mut faults);
    let finding = Finding::at_most(faults.count as f64, 0.0, Unit::Count);
    let Some((time, stream, note)) = faults.first else {
        return Ok(finding.noted(format!("{} rows agree", log.times.len())));
    };
    let note = note.and(format!("; {} such values in all; was the log changed?", faults.count));
    let mut finding = finding.at(time).of([stream]).during(evidence.phase_name(time)).noted(note);
    finding.violated = Some([time, faults.last]);
    Ok(finding)
}

/// All streams of an execution, at the same instants.
struct Streams<'e, 'r> {
    evidence: &'e Evidence<'r>,
    /// s.
    times: Vec<f64>,
    measured: JointStream<'r>,
    fingers: JointStream<'r>,
    commanded: JointStream<'r>,
    commanded_fingers: JointStream<'r>,
    tool: Vec<PoseSample>,
    reference_tool: Vec<PoseSample>,
    /// Empty when the run has no object.
    object: Vec<PoseSample>,
}

impl<'e, 'r> Streams<'e, 'r> {
    fn of(evidence: &'e Evidence<'r>) -> Result<Self, Gap> {
        let measured = JointStream::measured(evidence)?;
        let commanded = JointStream::commanded(evidence)?;
        let (tool, reference_tool) = (stream::tool(evidence)?, stream::reference_tool(evidence)?);
        let object = match &evidence.resolved.object {
            Some(_) => stream::object(evidence)?,
            None => Vec::new(),
        };
        let monitor: Vec<i64> = evidence.recording.monitor.iter().map(|sample| sample.time_ns).collect();
        stream::timed("monitor", &monitor, evidence)?;
        let of_poses = |poses: &[PoseSample]| poses.iter().map(|pose| pose.time_ns).collect::<Vec<i64>>();
        let others = [
            ("reference", commanded.times().to_vec()),
            ("tool", of_poses(&tool)),
            ("reference_tool", of_poses(&reference_tool)),
            ("monitor", monitor),
            ("object", if object.is_empty() { measured.times().to_vec() } else { of_poses(&object) }),
        ];
        for (name, times) in others {
            if times != measured.times() {
                let note = format!("streams measured and {name} have other times");
                return Err(Gap::inconclusive(None, note));
            }
        }
        Ok(Self {
            evidence,
            times: measured.times().iter().map(|time_ns| seconds(*time_ns)).collect(),
            fingers: JointStream::measured_fingers(evidence)?,
            commanded_fingers: JointStream::commanded_fingers(evidence)?,
            measured,
            commanded,
            tool,
            reference_tool,
            object,
        })
    }

    /// The columns of some joints, one after the other, as rows.
    fn rows(stream: &JointStream<'_>, joints: usize, velocity: bool) -> Vec<Vec<f64>> {
        let column = |joint| -> Vec<f64> {
            if velocity { stream.velocities(joint).collect() } else { stream.positions(joint).collect() }
        };
        (0..joints).map(column).collect()
    }

    fn names(&self, faults: &mut Faults) {
        let log = self.evidence.recording;
        let object = self.evidence.resolved.object.as_ref().map(|object| object.name.as_str());
        let expected =
            [("tool", log.tool.child.as_str(), Some("tool")), ("object", log.object.child.as_str(), object)];
        for (stream, found, expected) in expected {
            if expected.is_some_and(|expected| expected != found) {
                faults.add(0.0, stream, Note::from(format!("stream {stream} is of {found}")));
            }
        }
    }

    /// The arm starts where the plan does and the object where it was declared, unless they were told not to.
    fn start(&self, faults: &mut Faults) {
        let Some(execution) = &self.evidence.resolved.execution else { return };
        let (imperfections, time) = (&execution.imperfections, self.times[0]);
        let mut planned = MotionState::zeros(self.evidence.joints().len());
        self.evidence.plan.trajectory.eval_held(time, &mut planned);
        for (joint, model) in self.evidence.joints().iter().enumerate() {
            let offset = imperfections.calibration.get(joint).copied().unwrap_or(0.0);
            let off =
                self.measured.positions(joint).next().map_or(f64::NAN, |q| q + offset - planned.q[joint]);
            let unit = Unit::of_derivative(model.kind, 0);
            faults.hold(time, "measured", &format!("start of {}", model.name), off.abs(), SAME, unit);
        }
        let moved = imperfections.object_offset.iter().chain([&imperfections.object_yaw]);
        let is_moved = moved.into_iter().any(|by| *by != 0.0);
        if let (Some(declared), Some(first), false) =
            (&self.evidence.resolved.object, self.object.first(), is_moved)
        {
            let (there, here) = (&declared.world_from_object, &first.world_from_body);
            let off = (there.translation.vector - here.translation.vector).norm();
            faults.hold(time, "object", "start", off, SAME, Unit::Meter);
            let turned = there.rotation.angle_to(&here.rotation);
            faults.hold(time, "object", "rotation at the start", turned, SAME, Unit::Radian);
        }
    }

    /// What was commanded is what the plan says.
    fn reference(&self, faults: &mut Faults) {
        let (robot, plan) = (&self.evidence.resolved.robot, &self.evidence.plan);
        let dof = robot.dof();
        let [q, qd] = [false, true].map(|velocity| Self::rows(&self.commanded, dof, velocity));
        let [p, pd] = [false, true].map(|velocity| Self::rows(&self.commanded_fingers, 2, velocity));
        let (mut arm, mut opening) = (MotionState::zeros(dof), MotionState::zeros(1));
        let mut kinematics = Kinematics::new(self.evidence);
        for (row, &time) in self.times.iter().enumerate() {
            plan.trajectory.eval_held(time, &mut arm);
            plan.opening.eval_held(time, &mut opening);
            for (joint, model) in robot.joints.iter().enumerate() {
                for (order, found, planned) in
                    [(0, q[joint][row], arm.q[joint]), (1, qd[joint][row], arm.qd[joint])]
                {
                    let unit = Unit::of_derivative(model.kind, order);
                    faults.hold(time, "reference", &model.name, (found - planned).abs(), SAME, unit);
                }
            }
            for (finger, model) in robot.gripper.fingers.iter().enumerate() {
                let [off, off_rate] =
                    [p[finger][row] - 0.5 * opening.q[0], pd[finger][row] - 0.5 * opening.qd[0]];
                faults.hold(time, "reference", &model.joint, off.abs(), SAME, Unit::Meter);
                faults.hold(time, "reference", &model.joint, off_rate.abs(), SAME, Unit::MeterPerSecond);
            }
            kinematics.compare(faults, "reference_tool", &self.reference_tool[row], &arm.q, &arm.qd);
        }
    }

    /// The measured tool is where the measured joints have it.
    fn tool(&self, faults: &mut Faults) {
        let dof = self.evidence.joints().len();
        let [q, qd] = [false, true].map(|velocity| Self::rows(&self.measured, dof, velocity));
        let mut kinematics = Kinematics::new(self.evidence);
        let (mut position, mut velocity) = (vec![0.0; dof], vec![0.0; dof]);
        for (row, tool) in self.tool.iter().enumerate() {
            for joint in 0..dof {
                (position[joint], velocity[joint]) = (q[joint][row], qd[joint][row]);
            }
            kinematics.compare(faults, "tool", tool, &position, &velocity);
        }
    }

    /// What was applied is what was asked for, as far as the motors can; fingers feel what their contacts say.
    fn efforts(&self, faults: &mut Faults) {
        if self.has_perfect_drives() {
            for (joint, model) in self.evidence.joints().iter().enumerate() {
                let (limit, unit) = (model.limits.effort, Unit::of_effort(model.kind));
                let what = format!("effort of joint {}", model.name);
                let rows = self.measured.efforts(joint).zip(self.commanded.efforts(joint)).zip(&self.times);
                for ((applied, asked), &time) in rows {
                    let off = (applied - asked.clamp(-limit, limit)).abs();
                    faults.hold(time, "measured", &what, off, SAME * limit, unit);
                }
            }
        }
        let forces = self.pad_forces();
        for (finger, model) in self.evidence.resolved.robot.gripper.fingers.iter().enumerate() {
            let what = format!("force of {}", model.link.name);
            for (row, (effort, &time)) in self.fingers.efforts(finger).zip(&self.times).enumerate() {
                let off = (effort + forces[row][finger]).abs();
                faults.hold(time, "contacts", &what, off, SAME, Unit::Newton);
            }
        }
    }

    /// Whether the drives apply what is asked for at once.
    fn has_perfect_drives(&self) -> bool {
        self.evidence.resolved.execution.as_ref().is_some_and(|execution| {
            let imperfections = &execution.imperfections;
            let is_servo = matches!(execution.controller, Controller::IdealServo);
            imperfections.latency == 0.0 && imperfections.torque_ripple == 0.0 && !is_servo
        })
    }

    /// The normal forces between each finger and the object, N, row by row.
    fn pad_forces(&self) -> Vec<[f64; 2]> {
        let Some(object) = &self.evidence.resolved.object else { return vec![[0.0; 2]; self.times.len()] };
        let fingers =
            self.evidence.resolved.robot.gripper.fingers.each_ref().map(|finger| finger.link.name.as_str());
        let mut forces: BTreeMap<i64, [f64; 2]> = BTreeMap::new();
        for contact in &self.evidence.recording.contacts {
            let bodies = [contact.body_a.as_str(), contact.body_b.as_str()];
            for (finger, name) in fingers.iter().enumerate() {
                if bodies.contains(name) && bodies.contains(&object.name.as_str()) {
                    forces.entry(contact.time_ns).or_default()[finger] += contact.normal_force_n;
                }
            }
        }
        self.measured.times().iter().map(|time_ns| forces.get(time_ns).copied().unwrap_or_default()).collect()
    }

    /// Positions and velocities tell of the same motion.
    fn speeds(&self, faults: &mut Faults) {
        let resolved = &self.evidence.resolved;
        let dt = resolved.execution.as_ref().map_or(0.0, |execution| execution.dt);
        let hit = self.rows_with_a_crash();
        for (joint, model) in resolved.robot.joints.iter().enumerate() {
            let smooth = SHARE_OF_STEP * dt * model.limits.acceleration;
            let allowed: Vec<f64> = hit.iter().map(|hit| if *hit { f64::INFINITY } else { smooth }).collect();
            let unit = Unit::of_derivative(model.kind, 1);
            let positions: Vec<f64> = self.measured.positions(joint).collect();
            let velocities: Vec<f64> = self.measured.velocities(joint).collect();
            let rest = if model.kind == JointKind::Revolute { TURN_DRIFT } else { SLIDE_DRIFT };
            let drift = rest + DRIFT_SHARE * dt * largest(velocities.iter().copied());
            let column = Column { stream: "measured", name: &model.name, allowed: &allowed, drift, unit };
            column.check(faults, &self.times, &positions, &velocities);
        }
        for (finger, model) in resolved.robot.gripper.fingers.iter().enumerate() {
            let (positions, velocities) = (self.fingers.positions(finger), self.fingers.velocities(finger));
            // Both are tied to each other, so that what hits one moves the other.
            let names = resolved.robot.gripper.fingers.each_ref().map(|finger| finger.link.name.as_str());
            let allowed = self.contact_speeds(&names, model.link.inertial.mass);
            let column = Column {
                stream: "measured",
                name: &model.joint,
                allowed: &allowed,
                drift: FINGER_DRIFT,
                unit: Unit::MeterPerSecond,
            };
            column.check(
                faults,
                &self.times,
                &positions.collect::<Vec<_>>(),
                &velocities.collect::<Vec<_>>(),
            );
        }
        let Some(object) = &resolved.object else { return };
        let allowed = self.contact_speeds(&[object.name.as_str()], object.mass);
        let fastest = largest(self.object.iter().map(|sample| sample.linear.norm()));
        for axis in 0..3 {
            let positions: Vec<f64> =
                self.object.iter().map(|sample| sample.world_from_body.translation.vector[axis]).collect();
            let velocities: Vec<f64> = self.object.iter().map(|sample| sample.linear[axis]).collect();
            let column = Column {
                stream: "object",
                name: "its origin",
                allowed: &allowed,
                drift: SLIDE_DRIFT + DRIFT_SHARE * dt * fastest,
                unit: Unit::MeterPerSecond,
            };
            column.check(faults, &self.times, &positions, &velocities);
        }
        self.turning(faults, &allowed);
    }

    /// The rows at or beside which something presses against the arm that is not the object: what it does to
    /// the joints within a step has no bound, and it is a fault by itself.
    fn rows_with_a_crash(&self) -> Vec<bool> {
        let Resolved { robot, object, .. } = &self.evidence.resolved;
        let links = robot.links.iter().chain(robot.gripper.fingers.iter().map(|finger| &finger.link));
        let names: Vec<&str> = links.map(|link| link.name.as_str()).collect();
        let object = object.as_ref().map(|object| object.name.as_str());
        let mut hit = vec![false; self.times.len()];
        for contact in &self.evidence.recording.contacts {
            let bodies = [contact.body_a.as_str(), contact.body_b.as_str()];
            let is_crash = bodies.iter().any(|body| names.contains(body))
                && !bodies.iter().any(|body| object == Some(*body))
                && contact.normal_force_n > 0.0;
            if let (true, Ok(row)) = (is_crash, self.measured.times().binary_search(&contact.time_ns)) {
                hit[row.saturating_sub(2)..(row + 3).min(self.times.len())].fill(true);
            }
        }
        hit
    }

    /// What positions and velocities of a body may miss of each other in each row, m/s: a little, and twice (for
    /// friction) what the contacts of the rows around it can change of its speed by their impulse. Normal
    /// forces that hold the body from both sides cancel.
    fn contact_speeds(&self, bodies: &[&str], mass: f64) -> Vec<f64> {
        let dt = self.evidence.resolved.execution.as_ref().map_or(0.0, |execution| execution.dt);
        let mut forces = vec![Vector3::zeros(); self.times.len()];
        for contact in &self.evidence.recording.contacts {
            let Ok(row) = self.measured.times().binary_search(&contact.time_ns) else { continue };
            let force = Vector3::from(contact.normal) * contact.normal_force_n;
            let is_in = |body: &String| bodies.contains(&body.as_str());
            forces[row] += match (is_in(&contact.body_a), is_in(&contact.body_b)) {
                (true, false) => -force,
                (false, true) => force,
                _ => Vector3::zeros(),
            };
        }
        let around = |row: usize| -> f64 {
            let rows = row.saturating_sub(2)..(row + 3).min(forces.len());
            forces[rows].iter().map(Vector3::norm).sum()
        };
        (0..forces.len()).map(|row| CONTACT_SPEED + 2.0 * around(row) * dt / mass).collect()
    }

    /// The object turns as fast as its rotations differ.
    fn turning(&self, faults: &mut Faults, allowed: &[f64]) {
        let mean = |pair: &[PoseSample]| {
            let [a, b] = [&pair[0], &pair[1]];
            let turned = b.world_from_body.rotation * a.world_from_body.rotation.inverse();
            turned.scaled_axis() / (b.time() - a.time())
        };
        let rates: Vec<Vector3<f64>> = self.object.windows(2).map(mean).collect();
        // An impulse at the edge of a solid block turns it by up to three times its speed over the radius.
        let allowed = |row: usize| 3.0 * allowed[row] / self.object_radius();
        let unit = Unit::RadianPerSecond;
        for axis in 0..3 {
            for (step, rate) in rates.iter().enumerate() {
                let ends = [self.object[step].angular[axis], self.object[step + 1].angular[axis]];
                let (time, off) = (self.times[step + 1], outside(rate[axis], ends));
                faults.hold(time, "object", "rotation, as a speed,", off, allowed(step + 1), unit);
                if step > 0 {
                    let off = outside(self.object[step].angular[axis], [rates[step - 1][axis], rate[axis]]);
                    faults.hold(self.times[step], "object", "angular velocity", off, allowed(step), unit);
                }
            }
        }
    }

    fn object_radius(&self) -> f64 {
        self.evidence.resolved.object.as_ref().map_or(1.0, |object| object.shape.extent_radius())
    }

    /// The scalars of each row are those that its streams give.
    fn monitor(&self, faults: &mut Faults) {
        let forces = self.pad_forces();
        let fingers: Vec<Vec<f64>> = (0..2).map(|finger| self.fingers.positions(finger).collect()).collect();
        let asked: Vec<(f64, Vec<f64>)> = self
            .evidence
            .joints()
            .iter()
            .enumerate()
            .map(|(joint, model)| (model.limits.effort, self.commanded.efforts(joint).collect()))
            .collect();
        for (row, sample) in self.evidence.recording.monitor.iter().enumerate() {
            let time = self.times[row];
            let phase = self.evidence.plan.phase_index_at(time);
            let saturated = asked.iter().filter(|(limit, efforts)| efforts[row].abs() > *limit).count();
            let (tool, planned) =
                (&self.tool[row].world_from_body, &self.reference_tool[row].world_from_body);
            let error = (tool.translation.vector - planned.translation.vector).norm();
            let counts = [
                ("phase", f64::from(sample.phase), phase as f64),
                ("saturated joints", f64::from(sample.saturated_joints), saturated as f64),
            ];
            for (what, found, expected) in counts {
                faults.hold(time, "monitor", what, (found - expected).abs(), 0.0, Unit::Count);
            }
            let opening = fingers[0][row] + fingers[1][row];
            faults.hold(
                time,
                "monitor",
                "tool error",
                (sample.tool_error_m - error).abs(),
                SAME,
                Unit::Meter,
            );
            faults.hold(time, "monitor", "opening", (sample.opening_m - opening).abs(), SAME, Unit::Meter);
            let grip = forces[row][0].min(forces[row][1]);
            faults.hold(
                time,
                "monitor",
                "grip force",
                (sample.grip_force_n - grip).abs(),
                SAME,
                Unit::Newton,
            );
        }
    }
}

/// Positions and velocities of one coordinate.
struct Column<'c> {
    stream: &'static str,
    name: &'c str,
    /// What they may miss of each other in each row, rad/s or m/s.
    allowed: &'c [f64],
    /// How far the way by velocities may be from that by positions, rad or m.
    drift: f64,
    unit: Unit,
}

impl Column<'_> {
    /// A velocity lies between the mean speeds of the steps before and after it, and the mean speed of a step
    /// between the velocities at its ends: both hold for any step in which the velocity goes one way, however
    /// hard something is hit.
    fn check(&self, faults: &mut Faults, times: &[f64], positions: &[f64], velocities: &[f64]) {
        self.check_way(faults, times, positions, velocities);
        let mean = |step: usize| (positions[step + 1] - positions[step]) / (times[step + 1] - times[step]);
        for step in 0..positions.len().saturating_sub(1) {
            let off = outside(mean(step), [velocities[step], velocities[step + 1]]);
            if exceeds(off, self.allowed[step + 1]) {
                let what = format!("position of {}, as a speed,", self.name);
                faults.hold(times[step + 1], self.stream, &what, off, self.allowed[step + 1], self.unit);
            }
            if step > 0 {
                let off = outside(velocities[step], [mean(step - 1), mean(step)]);
                if exceeds(off, self.allowed[step]) {
                    let what = format!("velocity of {}", self.name);
                    faults.hold(times[step], self.stream, &what, off, self.allowed[step], self.unit);
                }
            }
        }
    }
}

impl Column<'_> {
    /// Positions go where velocities lead, until something crashes into the arm.
    fn check_way(&self, faults: &mut Faults, times: &[f64], positions: &[f64], velocities: &[f64]) {
        let mut way = 0.0;
        for step in 0..positions.len().saturating_sub(1) {
            let dt = times[step + 1] - times[step];
            way += 0.5 * (velocities[step] + velocities[step + 1]) * dt;
            if self.allowed[step + 1] == f64::INFINITY {
                return;
            }
            let off = (positions[step + 1] - positions[0] - way).abs();
            if exceeds(off, self.drift) {
                let what = format!("way of {}", self.name);
                let unit = if self.unit == Unit::RadianPerSecond { Unit::Radian } else { Unit::Meter };
                // Once it is off it stays off.
                faults.hold(times[step + 1], self.stream, &what, off, self.drift, unit);
                return;
            }
        }
    }
}

/// The largest magnitude.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| f64::max(most, value.abs()))
}

/// Whether something is farther apart than allowed. A NaN is a fault.
fn exceeds(apart: f64, allowed: f64) -> bool {
    apart > allowed || apart.is_nan()
}

/// How far a number lies outside the range of two others; 0 inside.
fn outside(value: f64, [a, b]: [f64; 2]) -> f64 {
    // Written so that a NaN stays one.
    let beyond = if value > a.max(b) { value - a.max(b) } else { a.min(b) - value };
    if beyond < 0.0 { 0.0 } else { beyond }
}

/// Where joints have the tool, and how fast it moves.
struct Kinematics<'e, 'r> {
    evidence: &'e Evidence<'r>,
    world_from_link: Vec<Pose>,
}

impl<'e, 'r> Kinematics<'e, 'r> {
    fn new(evidence: &'e Evidence<'r>) -> Self {
        Self { evidence, world_from_link: vec![Pose::identity(); evidence.joints().len()] }
    }

    fn compare(
        &mut self,
        faults: &mut Faults,
        stream: &'static str,
        tool: &PoseSample,
        q: &[f64],
        qd: &[f64],
    ) {
        let robot = &self.evidence.resolved.robot;
        robot.forward_into(q, &mut self.world_from_link);
        let world_from_tool = self.world_from_link[q.len() - 1] * robot.link_from_tool;
        let point = world_from_tool.translation.vector;
        let (mut linear, mut angular) = (Vector3::zeros(), Vector3::zeros());
        for ((joint, link), speed) in robot.joints.iter().zip(&self.world_from_link).zip(qd) {
            let axis = link.rotation * joint.axis.into_inner() * *speed;
            match joint.kind {
                JointKind::Revolute => {
                    linear += axis.cross(&(point - link.translation.vector));
                    angular += axis;
                }
                JointKind::Prismatic => linear += axis,
            }
        }
        let found = &tool.world_from_body;
        let off = (found.translation.vector - point).norm();
        let turned = found.rotation.angle_to(&world_from_tool.rotation);
        for (what, apart, unit) in [
            ("position", off, Unit::Meter),
            ("rotation", turned, Unit::Radian),
            ("velocity", (tool.linear - linear).norm(), Unit::MeterPerSecond),
            ("angular velocity", (tool.angular - angular).norm(), Unit::RadianPerSecond),
        ] {
            faults.hold(tool.time(), stream, what, apart, SAME, unit);
        }
    }
}

#[cfg(test)]
mod tests {
    use graspcheck_recording::Recording;

    use crate::{
        Outcome,
        fixture::{self},
    };

    #[test]
    fn a_perfect_log_agrees_with_itself() {
        let result = fixture::pick().check("executed.consistency");
        assert_eq!((result.outcome, result.value), (Outcome::Pass, Some(0.0)), "{result:?}");
    }

    #[test]
    fn one_edited_value_of_any_stream_contradicts_another() {
        type Edit = (&'static str, fn(&mut Recording));
        const ROW: usize = 450;
        let edits: [Edit; 18] = [
            ("reference", |log| log.reference.position[4 * ROW] += 1e-5),
            ("reference", |log| log.reference.velocity[4 * ROW + 1] += 1e-5),
            ("reference", |log| log.reference.position[4 * ROW + 2] += 1e-5),
            ("reference_tool", |log| log.reference_tool.pose[ROW][0] += 1e-5),
            ("reference_tool", |log| log.reference_tool.twist[ROW][5] += 1e-5),
            ("tool", |log| log.tool.pose[ROW][2] += 1e-5),
            ("tool", |log| log.tool.twist[ROW][0] += 1e-5),
            ("tool", |log| log.measured.position[4 * ROW + 1] += 1e-5),
            ("tool", |log| log.measured.velocity[4 * ROW] += 1e-5),
            ("measured", |log| log.measured.velocity[4 * ROW + 2] += 0.5),
            ("measured", |log| log.measured.effort[4 * ROW] += 1e-3),
            ("measured", |log| log.reference.effort[4 * ROW + 1] = -60.0),
            ("contacts", |log| log.measured.effort[4 * ROW + 3] += 1e-3),
            ("object", |log| log.object.pose[ROW][1] += 0.01),
            ("object", |log| log.object.twist[ROW][1] += 1.0),
            ("object", |log| log.object.twist[ROW][4] += 30.0),
            ("monitor", |log| log.monitor[ROW].phase = 0),
            ("monitor", |log| log.monitor[ROW].tool_error_m = 1e-3),
        ];
        for (index, (stream, edit)) in edits.into_iter().enumerate() {
            let mut run = fixture::pick();
            edit(&mut run.recording);
            let result = run.check("executed.consistency");
            assert_eq!(result.outcome, Outcome::Fail, "edit {index}: {result:?}");
            assert_eq!(result.place.subjects, [stream], "edit {index}: {result:?}");
            let time = result.time.unwrap();
            assert!((time - 4.5).abs() < 0.011, "edit {index}: {result:?}");
        }
    }

    #[test]
    fn a_stream_of_another_thing_is_a_fault() {
        let mut run = fixture::pick();
        run.recording.object.child = "another".into();
        assert_eq!(run.check("executed.consistency").outcome, Outcome::Fail);
    }

    #[test]
    fn streams_at_other_times_are_undecided() {
        let mut run = fixture::pick();
        for sample in &mut run.recording.monitor {
            sample.time_ns += 1_000_000;
        }
        assert_eq!(run.check("executed.consistency").outcome, Outcome::Inconclusive);
    }
}
