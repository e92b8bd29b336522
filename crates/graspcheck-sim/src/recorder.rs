//! Writes what happens into a [`Recording`].

use graspcheck_model::{Pose, plan::Plan, robot::RobotModel};
use graspcheck_motion::MotionState;
use graspcheck_proof::Sampler;
use graspcheck_recording::{
    ContactSample, Event, FrameSeries, JointSeries, Level, MonitorSample, PoseSeries, Recording,
};

use crate::{
    clock::Clock,
    contacts::{Contact, Contacts},
    gripper::FingerCommand,
    plant::{FINGERS, Plant},
    tool,
};

/// The frame of all poses.
const WORLD: &str = "world";

/// Time between two rows of a moving frame, s: viewers draw at 60 Hz or less.
const FRAME_PERIOD: f64 = 0.01;

/// Everything about one step that is recorded.
pub(crate) struct Sample<'a> {
    /// Index of the step.
    pub(crate) step: usize,
    /// Measured positions and velocities, arm then fingers.
    pub(crate) q: &'a [f64],
    /// Measured velocities.
    pub(crate) qd: &'a [f64],
    /// Commanded motion of the arm.
    pub(crate) reference: &'a MotionState,
    /// Commanded opening.
    pub(crate) opening: &'a MotionState,
    /// What the fingers were told.
    pub(crate) fingers: FingerCommand,
    /// Efforts that the controller asked for.
    pub(crate) asked: &'a [f64],
    /// Efforts that the drives applied.
    pub(crate) applied: &'a [f64],
    /// Poses of all bodies before the step.
    pub(crate) world_from_body: &'a [Pose],
    /// Twist of the object before the step.
    pub(crate) object_twist: Option<[f64; 6]>,
    /// Contacts of the step.
    pub(crate) contacts: &'a Contacts,
}

/// Builds the recording row by row.
pub(crate) struct Recorder<'a> {
    robot: &'a RobotModel,
    plan: &'a Plan,
    clock: Clock,
    names: Vec<String>,
    object: Option<usize>,
    fingers: [usize; FINGERS],
    frame_stride: usize,
    world_from_link: Vec<Pose>,
    clearance: Option<Sampler<'a>>,
    recording: Recording,
}

impl<'a> Recorder<'a> {
    /// An empty recording with room for `rows` rows and the events of all phases. Without `clearance` the
    /// monitor has no margin.
    pub(crate) fn new(
        robot: &'a RobotModel,
        plan: &'a Plan,
        plant: &Plant,
        clearance: Option<Sampler<'a>>,
        clock: Clock,
        rows: usize,
    ) -> Self {
        let names = plant.names().to_vec();
        let joints: Vec<String> = robot
            .joints
            .iter()
            .map(|joint| joint.name.clone())
            .chain(robot.gripper.fingers.iter().map(|finger| finger.joint.clone()))
            .collect();
        let frame_stride = ((FRAME_PERIOD / clock.dt()).round() as usize).max(1);
        let moving = names[..=plant.joint_count()].iter().chain(plant.object().map(|index| &names[index]));
        let tool_name = "tool".to_owned();
        let frames = moving
            .chain([&tool_name])
            .map(|child| FrameSeries {
                parent: WORLD.to_owned(),
                child: child.clone(),
                time_ns: Vec::with_capacity(rows / frame_stride + 1),
                pose: Vec::with_capacity(rows / frame_stride + 1),
            })
            .collect();
        let recording = Recording {
            measured: joint_series(joints.clone(), rows),
            reference: joint_series(joints, rows),
            tool: pose_series("tool", rows),
            reference_tool: pose_series("reference_tool", rows),
            object: plant.object().map_or_else(PoseSeries::default, |index| pose_series(&names[index], rows)),
            monitor: Vec::with_capacity(rows),
            frames,
            events: phase_events(plan),
            ..Recording::default()
        };
        Self {
            robot,
            plan,
            clock,
            fingers: std::array::from_fn(|finger| plant.finger(finger)),
            object: plant.object(),
            names,
            frame_stride,
            world_from_link: vec![Pose::identity(); robot.dof()],
            clearance,
            recording,
        }
    }

    /// Adds one row to every series.
    pub(crate) fn push(&mut self, sample: &Sample<'_>) {
        let time_ns = self.clock.nanoseconds(sample.step);
        let dof = self.robot.dof();
        let pad_forces = self.pad_forces(sample.contacts);

        let measured = &mut self.recording.measured;
        measured.time_ns.push(time_ns);
        measured.position.extend_from_slice(sample.q);
        measured.velocity.extend_from_slice(sample.qd);
        measured.effort.extend_from_slice(sample.applied);
        // Rapier does not tell the force of a motor. A finger at rest is held by the opposite of what its
        // pad feels.
        measured.effort.extend(pad_forces.map(|force| -force));

        let reference = &mut self.recording.reference;
        let (finger, finger_velocity) = (sample.opening.q[0] / 2.0, sample.opening.qd[0] / 2.0);
        let finger_effort = if sample.fingers.presses { -sample.fingers.force } else { 0.0 };
        reference.time_ns.push(time_ns);
        reference.position.extend_from_slice(&sample.reference.q);
        reference.position.extend([finger; FINGERS]);
        reference.velocity.extend_from_slice(&sample.reference.qd);
        reference.velocity.extend([finger_velocity; FINGERS]);
        reference.effort.extend_from_slice(sample.asked);
        reference.effort.extend([finger_effort; FINGERS]);

        let tool = self.push_tool(time_ns, &sample.q[..dof], &sample.qd[..dof], Which::Measured);
        let reference_tool =
            self.push_tool(time_ns, &sample.reference.q, &sample.reference.qd, Which::Reference);

        if let (Some(index), Some(twist)) = (self.object, sample.object_twist) {
            let object = &mut self.recording.object;
            object.time_ns.push(time_ns);
            object.pose.push(tool::row(&sample.world_from_body[index]));
            object.twist.push(twist);
        }
        let names = &self.names;
        let rows = sample.contacts.rows().iter();
        self.recording.contacts.extend(rows.map(|contact| contact_sample(names, time_ns, contact)));
        // The margin is computed as often as frames are recorded: it costs as much as a step of the physics.
        let mut clearance_margin_m = None;
        if sample.step.is_multiple_of(self.frame_stride) {
            self.push_frames(sample, time_ns, &tool);
            clearance_margin_m = self.clearance_margin(sample);
        }

        let monitor = MonitorSample {
            time_ns,
            phase: self.plan.phase_index_at(self.clock.seconds(sample.step)) as u32,
            tool_error_m: (tool.translation.vector - reference_tool.translation.vector).norm(),
            tool_error_rad: tool.rotation.angle_to(&reference_tool.rotation),
            velocity_ratio: self.ratio(&sample.reference.qd, |limits| limits.velocity),
            acceleration_ratio: self.ratio(&sample.reference.qdd, |limits| limits.acceleration),
            jerk_ratio: self.ratio(&sample.reference.qddd, |limits| limits.jerk),
            torque_ratio: self.ratio(sample.asked, |limits| limits.effort),
            saturated_joints: self.saturated(sample.asked),
            grip_force_n: f64::min(pad_forces[0], pad_forces[1]),
            opening_m: sample.q[dof..].iter().sum(),
            clearance_margin_m,
            contacts: sample.contacts.rows().len() as u32,
        };
        self.recording.monitor.push(monitor);
    }

    /// The recording with all rows.
    pub(crate) fn finish(self) -> Recording {
        self.recording
    }

    /// Adds a row to one of the two tool series and returns its pose.
    fn push_tool(&mut self, time_ns: i64, q: &[f64], qd: &[f64], which: Which) -> Pose {
        self.robot.forward_into(q, &mut self.world_from_link);
        let pose = tool::world_from_tool(self.robot, &self.world_from_link);
        let series = match which {
            Which::Measured => &mut self.recording.tool,
            Which::Reference => &mut self.recording.reference_tool,
        };
        series.time_ns.push(time_ns);
        series.pose.push(tool::row(&pose));
        series.twist.push(tool::twist(self.robot, &self.world_from_link, qd));
        pose
    }

    fn push_frames(&mut self, sample: &Sample<'_>, time_ns: i64, tool: &Pose) {
        let (base, moving) = self.recording.frames.split_at_mut(1);
        if sample.step == 0 {
            base[0].time_ns.push(time_ns);
            base[0].pose.push(tool::row(&sample.world_from_body[0]));
        }
        // The order in which the frames were made: links and fingers, the object, the tool.
        let poses = sample.world_from_body[1..sample.q.len() + 1]
            .iter()
            .chain(self.object.map(|index| &sample.world_from_body[index]))
            .chain([tool]);
        for (frame, pose) in moving.iter_mut().zip(poses) {
            frame.time_ns.push(time_ns);
            frame.pose.push(tool::row(pose));
        }
    }

    /// The least distance minus required distance where everything stands, m.
    fn clearance_margin(&mut self, sample: &Sample<'_>) -> Option<f64> {
        let sampler = self.clearance.as_mut()?;
        let (arm, fingers) = sample.q.split_at(self.robot.dof());
        let world_from_object = self.object.map(|index| &sample.world_from_body[index]);
        let time = self.clock.seconds(sample.step).min(self.plan.duration());
        sampler.margin(time, arm, fingers.iter().sum(), world_from_object)
    }

    /// The normal force between each finger and the object, N.
    fn pad_forces(&self, contacts: &Contacts) -> [f64; FINGERS] {
        self.fingers.map(|finger| self.object.map_or(0.0, |object| contacts.force_between(finger, object)))
    }

    /// How many joints were asked for more than their limit.
    fn saturated(&self, asked: &[f64]) -> u32 {
        let joints = asked.iter().zip(&self.robot.joints);
        joints.map(|(effort, joint)| u32::from(effort.abs() > joint.limits.effort)).sum()
    }

    /// The largest |value| / limit over the joints of the arm.
    fn ratio(&self, values: &[f64], limit: impl Fn(&graspcheck_model::robot::JointLimits) -> f64) -> f64 {
        values
            .iter()
            .zip(&self.robot.joints)
            .fold(0.0, |worst, (value, joint)| f64::max(worst, value.abs() / limit(&joint.limits)))
    }
}

#[derive(Clone, Copy)]
enum Which {
    Measured,
    Reference,
}

fn joint_series(names: Vec<String>, rows: usize) -> JointSeries {
    let values = rows * names.len();
    JointSeries {
        names,
        time_ns: Vec::with_capacity(rows),
        position: Vec::with_capacity(values),
        velocity: Vec::with_capacity(values),
        effort: Vec::with_capacity(values),
    }
}

fn pose_series(child: &str, rows: usize) -> PoseSeries {
    PoseSeries {
        frame: WORLD.to_owned(),
        child: child.to_owned(),
        time_ns: Vec::with_capacity(rows),
        pose: Vec::with_capacity(rows),
        twist: Vec::with_capacity(rows),
    }
}

/// The events that say when each phase of a plan begins; a recording of a plan that is not executed has them,
/// too.
#[must_use]
pub fn phase_events(plan: &Plan) -> Vec<Event> {
    plan.phases.iter().map(phase_event).collect()
}

fn phase_event(phase: &graspcheck_model::plan::Phase) -> Event {
    Event {
        // Phases begin within the hours that fit into 64 bits of nanoseconds.
        time_ns: (phase.start * 1e9).round() as i64,
        level: Level::Info,
        source: "phase".to_owned(),
        message: phase.name.clone(),
    }
}

fn contact_sample(names: &[String], time_ns: i64, contact: &Contact) -> ContactSample {
    ContactSample {
        time_ns,
        body_a: names[contact.a].clone(),
        body_b: names[contact.b].clone(),
        depth_m: contact.depth,
        normal_force_n: contact.force,
        point: contact.point,
        normal: contact.normal,
    }
}
