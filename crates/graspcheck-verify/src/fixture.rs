//! A run made up for tests: a two-joint arm over a table picks a cube, turns it and puts it down, and the
//! recording is what a perfect robot would do. Tests change one thing and look at one check.

use graspcheck_model::{
    Pose,
    cell::{Cell, CellBody, ClearanceRule},
    execution::{ContactModel, Controller, Execution},
    inertia::Inertial,
    object::{Handle, Object},
    plan::{Grasp, Holding, Phase, Plan},
    robot::{Family, Finger, Gripper, Joint, JointKind, JointLimits, Link, RobotModel},
    shape::{PlacedShape, Shape},
    task::{CartesianVia, Elbow, Pace, PickAndPlace, Task, ViaPoint},
    via::ViaLaw,
};
use graspcheck_motion::{MotionState, Polynomial, Trajectory};
use graspcheck_proof::{Certificate, Scene};
use graspcheck_recording::{ContactSample, JointSeries, MonitorSample, PoseSeries, Recording};
use nalgebra::{Matrix3, Point2, Point3, Translation3, UnitQuaternion, Vector3};

use crate::{
    CHECKS, CheckResult, Evidence, EvidenceError, Verdict, attach, judge,
    resolved::{CheckLimits, Expectation, RESOLVED_SCHEMA, Resolved},
};

/// Step of the made-up simulation, s.
pub(crate) const DT: f64 = 0.01;
/// When the lift begins, s.
pub(crate) const LIFT: f64 = 2.3;
/// When the release begins, s.
pub(crate) const OPEN: f64 = 5.3;
/// Force of each finger, N.
pub(crate) const GRIP: f64 = 10.0;
/// Angle by which the cube is turned, rad.
const TURN: f64 = 0.5;

/// A run before its documents are written.
pub(crate) struct Run {
    pub(crate) resolved: Resolved,
    pub(crate) plan: Plan,
    pub(crate) recording: Recording,
    /// In place of the proof that is found, when set.
    pub(crate) certificate: Option<Certificate>,
}

impl Run {
    /// The proof of the plan.
    pub(crate) fn proved(&self) -> Certificate {
        let Resolved { robot, cell, object, .. } = &self.resolved;
        Scene::new(robot, cell, object.as_ref()).unwrap().certify(&self.plan)
    }

    /// The recording with its documents.
    pub(crate) fn written(&self) -> Recording {
        let certificate = self.certificate.clone().unwrap_or_else(|| self.proved());
        let mut recording = self.recording.clone();
        attach(&mut recording, &self.resolved, &self.plan, &certificate);
        recording
    }

    /// What one check finds.
    pub(crate) fn check(&self, name: &str) -> CheckResult {
        let recording = self.written();
        let evidence = Evidence::from_recording(&recording).unwrap();
        CHECKS.iter().find(|check| check.name == name).unwrap().evaluate(&evidence)
    }

    /// Why the recording is no evidence.
    pub(crate) fn refused(&self) -> EvidenceError {
        Evidence::from_recording(&self.written()).unwrap_err()
    }

    /// The verdict on all checks.
    pub(crate) fn judged(&self) -> Verdict {
        judge(&Evidence::from_recording(&self.written()).unwrap())
    }

    /// Adds a contact as the run would have recorded it.
    pub(crate) fn touch(&mut self, contact: ContactSample) {
        self.recording.contacts.push(contact);
        self.count_contacts();
    }

    /// Brings the monitor's counts of contacts up to date.
    pub(crate) fn count_contacts(&mut self) {
        let Recording { monitor, contacts, .. } = &mut self.recording;
        for sample in monitor {
            let there = contacts.iter().filter(|contact| contact.time_ns == sample.time_ns);
            sample.contacts = there.count() as u32;
        }
    }

    /// The rows of the streams at and after a time.
    pub(crate) fn rows_from(&self, time: f64) -> std::ops::Range<usize> {
        let first = self.recording.measured.time_ns.partition_point(|ns| *ns < ns_of(time));
        first..self.recording.measured.len()
    }
}

pub(crate) fn ns_of(time: f64) -> i64 {
    (time * 1e9).round() as i64
}

/// A quintic from rest to rest.
pub(crate) fn rest_to_rest(from: f64, to: f64, duration: f64) -> Polynomial {
    Polynomial::quintic_hermite([from, 0.0, 0.0], [to, 0.0, 0.0], duration)
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::translation(x, y, z)
}

fn cuboid(x: f64, y: f64, z: f64) -> Shape {
    Shape::Box { half_extents: Vector3::new(x, y, z) }
}

fn link(name: &str, shapes: Vec<PlacedShape>) -> Link {
    let inertial = Inertial { mass: 1.0, center: Point3::origin(), tensor: Matrix3::identity() * 0.01 };
    Link { name: name.into(), inertial, shapes }
}

fn joint(name: &str, kind: JointKind, range: [f64; 2]) -> Joint {
    Joint {
        name: name.into(),
        kind,
        parent_from_joint: Pose::identity(),
        axis: Vector3::z_axis(),
        limits: JointLimits {
            position_min: range[0],
            position_max: range[1],
            velocity: 1.0,
            acceleration: 5.0,
            jerk: 60.0,
            effort: 50.0,
        },
        damping: 0.0,
        friction: 0.0,
        rotor_inertia: 0.0,
    }
}

fn finger(name: &str, side: f64) -> Finger {
    let pad = PlacedShape { body_from_shape: at(0.0, side * 0.005, 0.01), shape: cuboid(0.01, 0.005, 0.02) };
    Finger {
        link: link(name, vec![pad]),
        joint: format!("{name}_joint"),
        link_from_finger: Pose::identity(),
        axis: nalgebra::Unit::new_normalize(Vector3::new(0.0, side, 0.0)),
    }
}

/// The tool frame is the frame of the last link turned so that its x axis points down.
fn link_from_tool() -> Pose {
    let down = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
    Pose::from_parts(Translation3::identity(), down)
}

fn gantry() -> RobotModel {
    let carriage = PlacedShape { body_from_shape: at(0.0, 0.0, 0.16), shape: cuboid(0.05, 0.05, 0.02) };
    let palm = PlacedShape { body_from_shape: at(0.0, 0.0, 0.09), shape: cuboid(0.04, 0.06, 0.01) };
    RobotModel {
        name: "gantry".into(),
        family: Family::General,
        world_from_base: Pose::identity(),
        base: link("base", Vec::new()),
        joints: vec![
            joint("lift", JointKind::Prismatic, [0.0, 0.3]),
            joint("turn", JointKind::Revolute, [-1.0, 1.0]),
        ],
        links: vec![link("carriage", vec![carriage]), link("palm", vec![palm])],
        link_from_tool: link_from_tool(),
        gripper: Gripper {
            fingers: [finger("left_finger", 1.0), finger("right_finger", -1.0)],
            opening_max: 0.08,
            free_opening: 0.01,
            force_max: 20.0,
            finger_speed: 0.1,
        },
        allowed_contacts: Vec::new(),
    }
}

fn standing(turn: f64) -> Pose {
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
    Pose::from_parts(Translation3::new(0.0, 0.0, 0.02), rotation)
}

fn table() -> Cell {
    let body = CellBody {
        name: "table".into(),
        shape: cuboid(0.5, 0.5, 0.05),
        world_from_shape: at(0.0, 0.0, -0.05),
    };
    Cell {
        gravity: Vector3::new(0.0, 0.0, -9.81),
        bodies: vec![body],
        clearance: ClearanceRule { required: 0.005, pairs: Vec::new() },
    }
}

fn cube() -> Object {
    Object {
        name: "cube".into(),
        shape: cuboid(0.02, 0.02, 0.02),
        mass: 0.05,
        friction: 0.8,
        world_from_object: standing(0.0),
        handles: vec![Handle {
            name: "top".into(),
            object_from_handle: link_from_tool(),
            width: 0.04,
            half_turn: true,
        }],
    }
}

fn execution() -> Execution {
    Execution {
        dt: DT,
        substeps: 4,
        settle: 0.0,
        controller: Controller::ComputedTorque { bandwidth: 60.0, damping_ratio: 1.0 },
        contact: ContactModel { frequency: 300.0, damping_ratio: 5.0, prediction: 0.002, friction: 0.8 },
        seed: 0,
        control_period: None,
        imperfections: Default::default(),
    }
}

/// Name, duration, where the object is, end of `lift` and `turn`, end of the opening.
type Leg = (&'static str, f64, Holding, [f64; 2], f64);

fn pick_plan() -> Plan {
    let legs: [Leg; 8] = [
        ("approach", 1.0, Holding::AtStart, [0.1, 0.0], 0.06),
        ("descend", 1.0, Holding::AtStart, [0.02, 0.0], 0.06),
        ("close", 0.3, Holding::Closing, [0.02, 0.0], 0.036),
        ("lift", 1.0, Holding::Held, [0.15, 0.0], 0.036),
        ("carry", 1.0, Holding::Held, [0.15, TURN], 0.036),
        ("lower", 1.0, Holding::Held, [0.02, TURN], 0.036),
        ("open", 0.3, Holding::Opening, [0.02, TURN], 0.06),
        ("retreat", 1.0, Holding::Placed, [0.15, TURN], 0.06),
    ];
    let (mut q, mut opening, mut time) = ([0.2, 0.0], 0.06, 0.0);
    let (mut knots, mut arm, mut pads, mut phases) = (vec![0.0], Vec::new(), Vec::new(), Vec::new());
    for (name, duration, holding, to, open) in legs {
        arm.extend((0..2).map(|joint| rest_to_rest(q[joint], to[joint], duration)));
        pads.push(rest_to_rest(opening, open, duration));
        phases.push(Phase { name: name.into(), start: time, end: time + duration, holding });
        (q, opening, time) = (to, open, time + duration);
        knots.push(time);
    }
    Plan {
        trajectory: Trajectory::new(2, knots.clone(), arm).unwrap(),
        opening: Trajectory::new(1, knots, pads).unwrap(),
        phases,
        paths: Vec::new(),
        grasp: Some(Grasp {
            handle: "top".into(),
            tool_from_object: link_from_tool().inverse(),
            width: 0.04,
            opening: 0.06,
            force: GRIP,
            world_from_start: standing(0.0),
            world_from_placed: standing(TURN),
        }),
    }
}

/// The whole run of a pick: planned, executed without a fault.
pub(crate) fn pick() -> Run {
    let (robot, cell, plan) = (gantry(), table(), pick_plan());
    let recording = executed(&robot, &plan);
    let task = Task::PickAndPlace(PickAndPlace {
        start: vec![0.2, 0.0],
        world_from_placed: standing(TURN),
        pregrasp_distance: 0.08,
        departure: Vector3::new(0.0, 0.0, 0.13),
        arrival: Vector3::new(0.0, 0.0, 0.13),
        retreat_distance: 0.13,
        grip_force: GRIP,
        close_duration: 0.3,
        open_duration: 0.3,
    });
    let resolved = Resolved {
        schema: RESOLVED_SCHEMA,
        name: "gantry::pick".into(),
        title: "pick a cube, turn it, put it down".into(),
        robot,
        cell,
        object: Some(cube()),
        task,
        pace: Pace {
            share: 0.9,
            law: Default::default(),
            sync: Default::default(),
            phases: Vec::new(),
            set_points: None,
        },
        execution: Some(execution()),
        checks: CheckLimits {
            tracking: Some(1e-3),
            slip: Some(5e-4),
            place: Some(1e-3),
            place_angle: Some(0.02),
            saturated_steps: Some(0),
            ..CheckLimits::default()
        },
        expect: Expectation::Pass,
    };
    let mut run = Run { resolved, plan, recording, certificate: None };
    run.count_contacts();
    run
}

/// A planar arm that moves by parabolic blends past two points, planned only.
pub(crate) fn blends() -> Run {
    let mut robot = gantry();
    robot.name = "planar".into();
    robot.family = Family::PlanarRrr { upper: 0.4, fore: 0.3, hand: 0.1 };
    let revolute = |name, x| Joint {
        parent_from_joint: at(x, 0.0, 0.0),
        ..joint(name, JointKind::Revolute, [-3.0, 3.0])
    };
    robot.joints = vec![revolute("shoulder", 0.0), revolute("elbow", 0.4), revolute("wrist", 0.3)];
    let part = |x: f64| PlacedShape { body_from_shape: at(x, 0.0, 0.5), shape: cuboid(0.05, 0.02, 0.02) };
    robot.links =
        vec![link("upper", vec![part(0.2)]), link("fore", vec![part(0.15)]), link("palm", vec![part(0.05)])];
    robot.link_from_tool = at(0.1, 0.0, 0.0);
    // From rest with 1 rad/s² for 1 s, on at 1 rad/s for 1 s, to rest with -1 rad/s² for 1 s.
    let pieces = [[0.0, 0.0, 0.5], [0.5, 1.0, 0.0], [1.5, 1.0, -0.5]]
        .iter()
        .flat_map(|piece| [Polynomial::new(*piece), Polynomial::constant(1.0), Polynomial::constant(0.0)])
        .collect();
    let trajectory = Trajectory::new(3, vec![0.0, 1.0, 2.0, 3.0], pieces).unwrap();
    let wrist_at = |t: f64| {
        let wrist = robot.world_from_wrist(&trajectory.eval(t).q).translation.vector;
        Point2::new(wrist.x, wrist.y)
    };
    let points = [0.0, 1.5, 3.0].map(|t| ViaPoint { t, wrist: wrist_at(t), theta: 0.0 }).to_vec();
    let mut run = pick();
    let law = ViaLaw::blends_of(1.0, points.len(), 3);
    run.resolved.task = Task::CartesianVia(CartesianVia { points, law, elbow: Elbow::Left, tolerance: 1e-5 });
    run.resolved.name = "planar::blends".into();
    run.resolved.robot = robot;
    run.resolved.object = None;
    run.resolved.execution = None;
    run.resolved.checks = CheckLimits { via_miss: Some(1e-3), ..CheckLimits::default() };
    run.plan = Plan {
        trajectory,
        opening: Trajectory::hold(&[0.08], 3.0).unwrap(),
        phases: vec![Phase { name: "via".into(), start: 0.0, end: 3.0, holding: Holding::Nothing }],
        grasp: None,
        paths: Vec::new(),
    };
    run.recording = Recording::default();
    run
}

/// What a robot without any error would have recorded.
fn executed(robot: &RobotModel, plan: &Plan) -> Recording {
    let grasp = plan.grasp.as_ref().unwrap();
    let names = vec!["lift".into(), "turn".into(), "left_finger_joint".into(), "right_finger_joint".into()];
    let (mut measured, mut reference) = (JointSeries::new(names.clone()), JointSeries::new(names));
    let series =
        |child: &str| PoseSeries { frame: "world".into(), child: child.into(), ..Default::default() };
    let (mut tool, mut object, mut contacts) = (series("tool"), series("cube"), Vec::new());
    let (mut state, mut opening) = (MotionState::zeros(2), MotionState::zeros(1));
    let steps = (plan.duration() / DT).round() as i64;
    for step in 0..=steps {
        let time_ns = step * ns_of(DT);
        let time = time_ns as f64 / 1e9;
        plan.trajectory.eval_held(time, &mut state);
        plan.opening.eval_held(time, &mut opening);
        let commanded = opening.q[0];
        let between =
            matches!(plan.phase_at(time).holding, Holding::Closing | Holding::Held | Holding::Opening);
        let pads = 0.5 * if between { commanded.max(grasp.width) } else { commanded };
        measured.time_ns.push(time_ns);
        measured.position.extend(state.q.iter().chain(&[pads, pads]));
        let is_stopped = between && commanded < grasp.width;
        let pad_speed = if is_stopped { 0.0 } else { 0.5 * opening.qd[0] };
        measured.velocity.extend(state.qd.iter().chain(&[pad_speed, pad_speed]));
        let world_from_tool = robot.world_from_tool(&state.q);
        let phase = plan.phase_at(time);
        let gripped =
            phase.holding == Holding::Held || (phase.holding == Holding::Closing && phase.end - time < 0.1);
        let pressed = if gripped { -GRIP } else { 0.0 };
        measured.effort.extend([10.0, 0.5, pressed, pressed]);
        reference.time_ns.push(time_ns);
        reference.position.extend(state.q.iter().chain(&[0.5 * opening.q[0]; 2]));
        reference.velocity.extend(state.qd.iter().chain(&[0.5 * opening.qd[0]; 2]));
        reference.effort.extend([10.0, 0.5, pressed, pressed]);
        let world_from_object = match phase.holding {
            Holding::Held => world_from_tool * grasp.tool_from_object,
            Holding::Opening | Holding::Placed => grasp.world_from_placed,
            _ => grasp.world_from_start,
        };
        tool.time_ns.push(time_ns);
        tool.pose.push(row(&world_from_tool));
        // Both bodies stand on the axis about which the arm turns.
        let twist = [0.0, 0.0, state.qd[0], 0.0, 0.0, state.qd[1]];
        tool.twist.push(twist);
        object.time_ns.push(time_ns);
        object.pose.push(row(&world_from_object));
        object.twist.push(if phase.holding == Holding::Held { twist } else { [0.0; 6] });
        for (finger, side) in [("left_finger", 1.0), ("right_finger", -1.0)] {
            if gripped {
                let normal = [0.0, side, 0.0];
                contacts.push(ContactSample { normal, ..contact(time_ns, "cube", finger, 1e-5, GRIP) });
            }
        }
        if phase.holding != Holding::Held {
            contacts.push(contact(time_ns, "cube", "table", 1e-6, 0.5));
        }
    }
    let monitor = measured.time_ns.iter().enumerate().map(|(row, &time_ns)| MonitorSample {
        time_ns,
        phase: plan.phase_index_at(time_ns as f64 / 1e9) as u32,
        opening_m: measured.position_row(row)[2..].iter().sum(),
        grip_force_n: -measured.effort_row(row)[2],
        ..Default::default()
    });
    let monitor = monitor.collect();
    Recording {
        monitor,
        reference,
        measured,
        reference_tool: PoseSeries { child: "reference_tool".into(), ..tool.clone() },
        tool,
        object,
        contacts,
        ..Default::default()
    }
}

/// A contact of two bodies, named in alphabetical order.
pub(crate) fn contact(time_ns: i64, a: &str, b: &str, depth: f64, force: f64) -> ContactSample {
    ContactSample {
        time_ns,
        body_a: a.into(),
        body_b: b.into(),
        depth_m: depth,
        normal_force_n: force,
        point: [0.0; 3],
        normal: [0.0, 0.0, 1.0],
    }
}

/// A pose as a row of a recording.
pub(crate) fn row(pose: &Pose) -> [f64; 7] {
    let (p, q) = (pose.translation.vector, pose.rotation.coords);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}
