//! How near the rapier plant comes to the exact equations of motion: the standard comparisons for one robot.
//!
//! [`fidelity`] swings the arm freely, lets its first link be a pendulum, holds it still, moves it under control and
//! puts a block on a slope, and holds each against something that was found in another way: a Runge–Kutta integration
//! of eighth order of the model's own dynamics (Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*,
//! DOP853), the closed form of a pendulum, recursive Newton–Euler, Coulomb's law.
//!
//! The robot's own friction is on, but for the pendulum and the order of convergence. Stops and solids are taken away for
//! the swing, so that it meets nothing.

use std::{cell::RefCell, f64::consts::FRAC_PI_6};

use differential_equations::prelude::{ExplicitRungeKutta, IVP};
use graspcheck_model::{
    Pose,
    cell::{Cell, CellBody, ClearanceRule},
    dynamics::Dynamics,
    execution::{ContactModel, Controller, Execution},
    object::Object,
    plan::{Holding, Phase, Plan},
    robot::{JointKind, RobotModel},
    shape::Shape,
};
use graspcheck_motion::{MotionState, Polynomial, Trajectory, TrajectoryError};
use nalgebra::{DVector, Vector3};

mod pendulum;

use crate::{
    error::SimError,
    exact::{ExactArm, LEAST_STEP},
    plant::{FINGERS, Plant, PlantSettings},
    random::{Random, Stream},
    run::simulate,
};

/// Length of a free swing, s.
const SWING: f64 = 10.0;

/// Time between two comparisons of a swing, s.
const COMPARED: f64 = 5e-3;

/// Tolerance of the eighth-order integration, absolute and relative: a thousandth of what it is to judge.
const EXACT_TOLERANCE: f64 = 1e-11;

/// Gravity, m/s².
const GRAVITY: f64 = 9.81;

/// Why the comparisons could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FidelityError {
    /// A simulation was refused.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The move is no motion.
    #[error("move: {0}")]
    Move(#[from] TrajectoryError),
    /// The exact equations could not be integrated.
    #[error("free swing: the integration gave up at t = {time} s: {reason}")]
    Integration {
        /// When, s.
        time: f64,
        /// What it says.
        reason: String,
    },
    /// The first joint is no pendulum.
    #[error("robot {robot}: its first joint slides or its first link is balanced, so it is no pendulum")]
    NoPendulum {
        /// Name of the robot.
        robot: String,
    },
}

/// What is asked of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// In the world, m/s².
    pub gravity: Vector3<f64>,
    /// Where a free swing starts, rad or m.
    pub swing: Vec<f64>,
    /// The move under control: from rest, to rest, and its duration, s; a quintic in each joint.
    pub from: Vec<f64>,
    /// Its end, rad or m.
    pub to: Vec<f64>,
    /// Its duration, s.
    pub duration: f64,
    /// Bandwidth of the computed torque, rad/s.
    pub bandwidth: f64,
}

impl Trial {
    /// A swing from 30° beside hanging along -y, and a move through the middle half of every joint's range at half
    /// of its limits of velocity and acceleration.
    #[must_use]
    pub fn of(robot: &RobotModel) -> Self {
        let mut swing = vec![0.0; robot.dof()];
        if let Some(first) = swing.first_mut() {
            *first = FRAC_PI_6 - std::f64::consts::FRAC_PI_2;
        }
        let quarter = |share: f64| {
            let at = |joint: &graspcheck_model::robot::Joint| {
                let (low, high) = (joint.limits.position_min, joint.limits.position_max);
                low + share * (high - low)
            };
            robot.joints.iter().map(at).collect::<Vec<f64>>()
        };
        let (from, to) = (quarter(0.25), quarter(0.75));
        // Peaks of a quintic over its way: 15/8 of the mean velocity, 10/√3 of way over duration squared.
        let duration = robot.joints.iter().zip(from.iter().zip(&to)).fold(0.5, |slowest, (joint, (a, b))| {
            let way = (b - a).abs();
            let by_velocity = 1.875 * way / (0.5 * joint.limits.velocity);
            let by_acceleration = (10.0 / 3f64.sqrt() * way / (0.5 * joint.limits.acceleration)).sqrt();
            f64::max(slowest, by_velocity.max(by_acceleration))
        });
        let gravity = Vector3::new(0.0, -GRAVITY, 0.0);
        Self { gravity, swing, from, to, duration, bandwidth: 200.0 }
    }
}

/// One number of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What is compared, e.g. `free swing, 1 substep: worst joint`.
    pub quantity: String,
    /// How far apart the two are.
    pub value: f64,
    /// Its unit; empty for shares.
    pub unit: &'static str,
}

/// A free swing beside the exact one.
#[derive(Clone, Debug, PartialEq)]
pub struct Swing {
    /// Substeps of the solver.
    pub substeps: usize,
    /// Times, s.
    pub time: Vec<f64>,
    /// Positions of the joints at each time, rad or m.
    pub plant: Vec<Vec<f64>>,
    /// The same by the exact equations.
    pub exact: Vec<Vec<f64>>,
    /// Energy of plant less energy of the exact arm at each time, as a share of the peak kinetic energy.
    pub energy: Vec<f64>,
}

impl Swing {
    /// The largest difference of a joint's position, rad or m.
    #[must_use]
    pub fn worst(&self) -> f64 {
        let rows = self.plant.iter().zip(&self.exact);
        rows.flat_map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b).abs())).fold(0.0, f64::max)
    }

    /// The largest |energy| difference as a share.
    #[must_use]
    pub fn energy_drift(&self) -> f64 {
        self.energy.iter().fold(0.0, |worst, share| worst.max(share.abs()))
    }
}

/// The comparisons of one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Fidelity {
    /// The table.
    pub rows: Vec<Row>,
    /// The free swings with 1 and 4 substeps, to be drawn.
    pub swings: [Swing; 2],
}

/// Makes all comparisons at steps of `dt` seconds.
///
/// # Errors
/// When a simulation is refused or the exact integration gives up.
pub fn fidelity(robot: &RobotModel, trial: &Trial, dt: f64) -> Result<Fidelity, FidelityError> {
    let exact = exact_swing(robot, trial, SWING)?;
    let swings = [swing(robot, trial, &exact, dt, 1)?, swing(robot, trial, &exact, dt, 4)?];
    let mut rows = Vec::new();
    let mut enter = |quantity: String, value: f64, unit| rows.push(Row { quantity, value, unit });
    for swing in &swings {
        let what = format!("free swing of {SWING} s, {} substeps", swing.substeps);
        enter(format!("{what}: worst joint"), swing.worst(), "rad");
        enter(format!("{what}: energy"), swing.energy_drift(), "");
    }
    enter("order of convergence in dt".to_owned(), convergence_order(robot, trial, dt)?, "");
    enter("period of the first link as a pendulum".to_owned(), pendulum::period(robot, dt)?, "");
    enter("torques at rest".to_owned(), static_torques(robot, trial.gravity)?, "");
    let moved = controlled_move(robot, trial, dt, 1)?;
    for (joint, errors) in robot.joints.iter().zip(&moved) {
        let unit = if joint.kind == JointKind::Revolute { "rad" } else { "m" };
        enter(format!("tracking of {}", joint.name), errors.tracking, unit);
        enter(format!("torque of {} against the recorded motion", joint.name), errors.torque, "");
        enter(format!("torque of {} against the commanded motion", joint.name), errors.reference_torque, "");
    }
    let threshold = friction_threshold(robot, dt)?;
    enter(
        "slope at which a block slides over its coefficient of friction, less 1".to_owned(),
        threshold - 1.0,
        "",
    );
    Ok(Fidelity { rows, swings })
}

/// States of an arm over time.
struct States {
    time: Vec<f64>,
    q: Vec<Vec<f64>>,
    energy: Vec<f64>,
    peak_kinetic: f64,
}

/// Energy of an arm with closed fingers, J.
struct Energy<'a> {
    robot: &'a RobotModel,
    gravity: Vector3<f64>,
    arm: ExactArm,
}

impl<'a> Energy<'a> {
    fn new(robot: &'a RobotModel, gravity: Vector3<f64>) -> Self {
        Self { robot, gravity, arm: ExactArm::new(robot, gravity) }
    }

    /// Kinetic and potential energy.
    fn of(&mut self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        let robot = self.robot;
        let world_from_link = robot.forward(q);
        let last = world_from_link[world_from_link.len() - 1];
        let links = robot.links.iter().zip(&world_from_link).map(|(link, pose)| (&link.inertial, *pose));
        let fingers = (0..FINGERS).map(|finger| {
            let pose = last * robot.gripper.link_from_finger_at(finger, 0.0);
            (&robot.gripper.fingers[finger].link.inertial, pose)
        });
        let potential = links
            .chain(fingers)
            .map(|(inertial, pose)| -inertial.mass * self.gravity.dot(&(pose * inertial.center).coords));
        [self.arm.kinetic(q, qd), potential.sum()]
    }
}

/// The free swing by the exact equations.
fn exact_swing(robot: &RobotModel, trial: &Trial, duration: f64) -> Result<States, FidelityError> {
    let arm = RefCell::new(ExactArm::new(robot, trial.gravity));
    let mut energy = Energy::new(robot, trial.gravity);
    let (mut q, mut qd) = (trial.swing.clone(), vec![0.0; robot.dof()]);
    let mut states = States::starting(&mut energy, &q, &qd);
    let count = (duration / COMPARED).round() as usize;
    for k in 1..=count {
        let end = k as f64 * COMPARED;
        exact_stretch(&arm, &mut q, &mut qd, [end - COMPARED, end])?;
        states.push(end, &mut energy, &q, &qd);
    }
    Ok(states)
}

/// Moves the exact arm on by eighth order, without efforts. A stretch in which a joint turns back against its dry
/// friction is halved until that no longer matters.
fn exact_stretch(
    arm: &RefCell<ExactArm>,
    q: &mut [f64],
    qd: &mut [f64],
    [start, end]: [f64; 2],
) -> Result<(), FidelityError> {
    let dof = q.len();
    let idle = vec![0.0; dof];
    arm.borrow_mut().begin(q, qd, &idle);
    let slope = |_: f64, state: &Vec<f64>, slope: &mut Vec<f64>| {
        let (q, qd) = state.split_at(dof);
        slope[..dof].copy_from_slice(qd);
        arm.borrow_mut().acceleration(q, qd, &idle, &mut slope[dof..]);
    };
    let state: Vec<f64> = q.iter().chain(qd.iter()).copied().collect();
    let gave_up = |reason: String| FidelityError::Integration { time: start, reason };
    let solution = IVP::ode_from_fn(slope, 0.0, end - start, state)
        .method(ExplicitRungeKutta::dop853().rtol(EXACT_TOLERANCE).atol(EXACT_TOLERANCE))
        .solve()
        .map_err(|error| gave_up(format!("{error:?}")))?;
    let reached = solution.y.last().ok_or_else(|| gave_up("no state".to_owned()))?;
    if arm.borrow().turned_back(&reached[dof..]) && end - start > LEAST_STEP {
        let middle = 0.5 * (start + end);
        exact_stretch(arm, q, qd, [start, middle])?;
        return exact_stretch(arm, q, qd, [middle, end]);
    }
    q.copy_from_slice(&reached[..dof]);
    qd.copy_from_slice(&reached[dof..]);
    arm.borrow().end(qd);
    Ok(())
}

impl States {
    fn starting(energy: &mut Energy<'_>, q: &[f64], qd: &[f64]) -> Self {
        let mut states = Self { time: Vec::new(), q: Vec::new(), energy: Vec::new(), peak_kinetic: 0.0 };
        states.push(0.0, energy, q, qd);
        states
    }

    fn push(&mut self, time: f64, energy: &mut Energy<'_>, q: &[f64], qd: &[f64]) {
        let [kinetic, potential] = energy.of(q, qd);
        self.time.push(time);
        self.q.push(q.to_vec());
        self.energy.push(kinetic + potential);
        self.peak_kinetic = self.peak_kinetic.max(kinetic);
    }
}

/// The plant of a robot alone in the world.
fn plant_of(
    robot: &RobotModel,
    gravity: Vector3<f64>,
    dt: f64,
    substeps: usize,
) -> Result<Plant, FidelityError> {
    let contact = contact();
    Ok(Plant::new(robot, &nothing_around(gravity), None, &PlantSettings { dt, substeps, contact: &contact })?)
}

/// The free swing of the plant beside an exact one.
fn swing(
    robot: &RobotModel,
    trial: &Trial,
    exact: &States,
    dt: f64,
    substeps: usize,
) -> Result<Swing, FidelityError> {
    let free = unhindered(robot);
    let dof = robot.dof();
    let mut plant = plant_of(&free, trial.gravity, dt, substeps)?;
    let (mut q, mut qd) = (vec![0.0; dof + FINGERS], vec![0.0; dof + FINGERS]);
    q[..dof].copy_from_slice(&trial.swing);
    plant.set_state(&q, &qd);
    let mut energy = Energy::new(robot, trial.gravity);
    let stride = ((COMPARED / dt).round() as usize).max(1);
    let mut swing = Swing {
        substeps,
        time: exact.time.clone(),
        plant: Vec::new(),
        exact: exact.q.clone(),
        energy: Vec::new(),
    };
    for exact_energy in &exact.energy {
        plant.read_state(&mut q, &mut qd);
        let [kinetic, potential] = energy.of(&q[..dof], &qd[..dof]);
        swing.plant.push(q[..dof].to_vec());
        swing.energy.push((kinetic + potential - exact_energy) / exact.peak_kinetic);
        for _ in 0..stride {
            plant.drive_fingers(0.0, robot.gripper.force_max);
            plant.step(&());
        }
    }
    Ok(swing)
}

/// The robot without stops and without solids, so that it meets nothing.
fn unhindered(robot: &RobotModel) -> RobotModel {
    let mut robot = robot.clone();
    for joint in &mut robot.joints {
        joint.limits.position_min = f64::NEG_INFINITY;
        joint.limits.position_max = f64::INFINITY;
    }
    let fingers = robot.gripper.fingers.iter_mut().map(|finger| &mut finger.link);
    robot.links.iter_mut().chain([&mut robot.base]).chain(fingers).for_each(|link| link.shapes.clear());
    robot
}

/// log2 of the gain in accuracy when the step is halved, over the first second of the swing: 1 for a first-order
/// integrator. Dry friction, whose kinks blur the order, is off.
fn convergence_order(robot: &RobotModel, trial: &Trial, dt: f64) -> Result<f64, FidelityError> {
    let mut robot = robot.clone();
    robot.joints.iter_mut().for_each(|joint| joint.friction = 0.0);
    let robot = &robot;
    let exact = exact_swing(robot, trial, 1.0)?;
    let coarse = swing(robot, trial, &exact, dt, 1)?.worst();
    let fine = swing(robot, trial, &exact, dt / 2.0, 1)?.worst();
    Ok((coarse / fine).log2())
}

/// The largest difference between the torque that holds the plant still and that of the model, as a share of the
/// largest torque, at twenty places.
fn static_torques(robot: &RobotModel, gravity: Vector3<f64>) -> Result<f64, FidelityError> {
    const PLACES: usize = 20;
    /// So short that the acceleration is that of the beginning, s.
    const STEP: f64 = 1e-9;
    let dof = robot.dof();
    let mut plant = plant_of(robot, gravity, STEP, 1)?;
    let mut dynamics = Dynamics::new(robot, gravity);
    let mut random = Random::new(0, Stream::SelfTest);
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for _ in 0..PLACES {
        let mut q: Vec<f64> = robot
            .joints
            .iter()
            .map(|joint| {
                let limits = &joint.limits;
                limits.position_min + (limits.position_max - limits.position_min) * random.unit()
            })
            .collect();
        let (mut torque, rest) = (vec![0.0; dof], vec![0.0; dof]);
        dynamics.inverse(&q, &rest, &rest, &mut torque);
        q.extend([0.0; FINGERS]);
        plant.set_state(&q, &vec![0.0; dof + FINGERS]);
        let mass = plant.mass_matrix();
        plant.step(&());
        let mut qdd = vec![0.0; dof + FINGERS];
        plant.unconstrained_acceleration(&mut qdd);
        let falling = mass * DVector::from_vec(qdd);
        for joint in 0..dof {
            worst = worst.max((torque[joint] + falling[joint]).abs());
            largest = largest.max(torque[joint].abs());
        }
    }
    Ok(if largest > 0.0 { worst / largest } else { worst })
}

/// What a move under control shows of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct MoveErrors {
    /// rad or m.
    tracking: f64,
    /// Applied torque against inverse dynamics at the recorded state, as a share of the joint's peak.
    torque: f64,
    /// The same at the commanded state.
    reference_torque: f64,
}

fn controlled_move(
    robot: &RobotModel,
    trial: &Trial,
    dt: f64,
    substeps: usize,
) -> Result<Vec<MoveErrors>, FidelityError> {
    let Trial { from, to, duration, .. } = trial;
    let pieces = from
        .iter()
        .zip(to)
        .map(|(from, to)| Polynomial::quintic_hermite([*from, 0.0, 0.0], [*to, 0.0, 0.0], *duration));
    let trajectory = Trajectory::new(robot.dof(), vec![0.0, *duration], pieces.collect())?;
    let plan = plan_of(trajectory)?;
    let recording = simulate(
        robot,
        &nothing_around(trial.gravity),
        None,
        &plan,
        &execution(trial.bandwidth, dt, substeps),
        &mut |_, _| {},
    )?;
    let dof = robot.dof();
    let mut dynamics = Dynamics::new(robot, trial.gravity);
    let mut reference = MotionState::zeros(dof);
    let mut errors = vec![MoveErrors::default(); dof];
    let mut peaks = vec![0.0_f64; dof];
    let (mut qdd, mut torque, mut friction) = (vec![0.0; dof], vec![0.0; dof], vec![0.0; dof]);
    let measured = &recording.measured;
    let moving = (duration / dt).floor() as usize;
    // The first and the last steps are at rest, where dry friction may be anything.
    for row in 1..moving.min(measured.len() - 1) {
        let (q, qd) = (&measured.position_row(row)[..dof], &measured.velocity_row(row)[..dof]);
        let (next, applied) = (&measured.velocity_row(row + 1)[..dof], &measured.effort_row(row)[..dof]);
        plan.trajectory.eval_held(row as f64 * dt, &mut reference);
        for ((qdd, next), qd) in qdd.iter_mut().zip(next).zip(qd) {
            *qdd = (next - qd) / dt;
        }
        let compare = |error: fn(&mut MoveErrors) -> &mut f64,
                       torque: &[f64],
                       friction: &[f64],
                       errors: &mut [MoveErrors]| {
            for joint in 0..dof {
                let apart = (applied[joint] - torque[joint] - friction[joint]).abs();
                let worst = error(&mut errors[joint]);
                *worst = worst.max(apart);
            }
        };
        dynamics.set_load(measured.position_row(row)[dof..].iter().sum(), None);
        dynamics.inverse(q, qd, &qdd, &mut torque);
        dynamics.friction(qd, &mut friction);
        compare(|errors| &mut errors.torque, &torque, &friction, &mut errors);
        dynamics.inverse(&reference.q, &reference.qd, &reference.qdd, &mut torque);
        dynamics.friction(&reference.qd, &mut friction);
        compare(|errors| &mut errors.reference_torque, &torque, &friction, &mut errors);
        for joint in 0..dof {
            errors[joint].tracking = errors[joint].tracking.max((q[joint] - reference.q[joint]).abs());
            peaks[joint] = peaks[joint].max(applied[joint].abs());
        }
    }
    for (errors, peak) in errors.iter_mut().zip(peaks) {
        errors.torque /= peak;
        errors.reference_torque /= peak;
    }
    Ok(errors)
}

/// The slope from which on a block slides, over its coefficient of friction, found by halving.
fn friction_threshold(robot: &RobotModel, dt: f64) -> Result<f64, FidelityError> {
    const FRICTION: f64 = 0.5;
    const HALVINGS: usize = 7;
    let [mut holds, mut slides] = [0.8, 1.2];
    for _ in 0..HALVINGS {
        let slope = 0.5 * (holds + slides);
        // At a hundredth above the threshold the block is gone by 5 mm in half a second.
        if slid(robot, FRICTION, slope * FRICTION, dt)? > 5e-4 { slides = slope } else { holds = slope }
    }
    Ok(0.5 * (holds + slides))
}

/// How far a block slides down a slope in half a second, m.
fn slid(robot: &RobotModel, friction: f64, slope: f64, dt: f64) -> Result<f64, FidelityError> {
    // Gravity is turned instead of the slope. The arm stands far away and holds itself.
    const AWAY: f64 = 100.0;
    let down = Vector3::new(slope, 0.0, -1.0).normalize() * GRAVITY;
    let mut cell = nothing_around(down);
    cell.bodies.push(CellBody {
        name: "slope".to_owned(),
        shape: Shape::Box { half_extents: Vector3::new(1.0, 1.0, 0.1) },
        world_from_shape: Pose::translation(AWAY, 0.0, -0.1),
    });
    let block = Object {
        name: "block".to_owned(),
        shape: Shape::Box { half_extents: Vector3::new(0.05, 0.05, 0.02) },
        mass: 1.0,
        friction,
        world_from_object: Pose::translation(AWAY, 0.0, 0.02),
        handles: Vec::new(),
    };
    let middle = |joint: &graspcheck_model::robot::Joint| {
        0.5 * (joint.limits.position_min + joint.limits.position_max)
    };
    let hold = Trajectory::hold(&robot.joints.iter().map(middle).collect::<Vec<f64>>(), 0.5)?;
    let mut execution = execution(50.0, dt, 4);
    execution.contact.friction = friction;
    let recording = simulate(robot, &cell, Some(&block), &plan_of(hold)?, &execution, &mut |_, _| {})?;
    let rows = &recording.object.pose;
    Ok(rows.last().map_or(0.0, |last| (last[0] - rows[0][0]).abs()))
}

fn plan_of(trajectory: Trajectory) -> Result<Plan, FidelityError> {
    let duration = trajectory.duration();
    let phase = Phase { name: "trial".to_owned(), start: 0.0, end: duration, holding: Holding::Nothing };
    let opening = Trajectory::hold(&[0.0], duration)?;
    Ok(Plan { trajectory, opening, phases: vec![phase], grasp: None, paths: Vec::new() })
}

fn nothing_around(gravity: Vector3<f64>) -> Cell {
    Cell { gravity, bodies: Vec::new(), clearance: ClearanceRule { required: 0.0, pairs: Vec::new() } }
}

fn contact() -> ContactModel {
    ContactModel { frequency: 300.0, damping_ratio: 5.0, prediction: 0.002, friction: 0.5 }
}

fn execution(bandwidth: f64, dt: f64, substeps: usize) -> Execution {
    Execution {
        dt,
        substeps,
        settle: 0.0,
        controller: Controller::ComputedTorque { bandwidth, damping_ratio: 1.0 },
        control_period: None,
        contact: contact(),
        seed: 0,
        imperfections: Default::default(),
    }
}

#[cfg(test)]
mod tests;
