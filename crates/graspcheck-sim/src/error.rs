//! Why a simulation was refused or given up.

use graspcheck_model::{error::ModelError, plan::PlanFault};

/// Why a plan could not be executed.
///
/// A plan that is executed badly (a joint that saturates, an arm that runs into a wall, an object that is
/// dropped) is not an error: it is recorded, and the checks find it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimError {
    /// The step of the physics does not fit the time base.
    #[error(
        "execution: dt {dt} s must be a whole number of nanoseconds that divides one second; \
         use for example 0.001 s"
    )]
    Step {
        /// The step, s.
        dt: f64,
    },
    /// A setting of the execution is out of range.
    #[error("execution: {setting} {value} must be {requirement}")]
    Setting {
        /// Its name.
        setting: &'static str,
        /// What was given, SI.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A time is no whole number of steps.
    #[error("execution: {setting} {time} s is no whole number of steps of {dt} s; change it or dt")]
    NotWholeSteps {
        /// Its name.
        setting: &'static str,
        /// The time, s.
        time: f64,
        /// Length of a step, s.
        dt: f64,
    },
    /// A list has no value for each joint.
    #[error("execution: {setting} has {count} values for {joints} joints; give one for each, or none")]
    ForEachJoint {
        /// Its name.
        setting: &'static str,
        /// How many values there are.
        count: usize,
        /// How many joints there are.
        joints: usize,
    },
    /// A ripple of torques that are not commanded.
    #[error("execution: an ideal servo has no torque ripple; choose a controller that commands torques")]
    RippleOfServo,
    /// A push on a body that is not there or cannot move.
    #[error("execution: push on {body}, which is none of the bodies that move: {bodies}")]
    PushedBody {
        /// Name of the body.
        body: String,
        /// The names of those that move.
        bodies: String,
    },
    /// A link whose mass properties no body can have.
    #[error("link {link}: {fault}")]
    Inertial {
        /// Name of the link.
        link: String,
        /// What is wrong.
        fault: ModelError,
    },
    /// The parts of the plan do not fit each other or the robot.
    #[error("plan: {0}")]
    Plan(#[from] PlanFault),
    /// The plan opens the gripper farther than it can or closes it beyond touching.
    #[error("plan: opening {opening} m at t = {time} s is not within 0 m and the gripper's {opening_max} m")]
    Opening {
        /// What is commanded, m.
        opening: f64,
        /// Largest opening, m.
        opening_max: f64,
        /// When, s.
        time: f64,
    },
    /// The plan moves the fingers faster than they can.
    #[error(
        "plan: finger speed {speed} m/s exceeds the gripper's {speed_max} m/s at t = {time} s; \
         give the fingers more time"
    )]
    FingerSpeed {
        /// Speed of one finger, m/s.
        speed: f64,
        /// The limit, m/s.
        speed_max: f64,
        /// When, s.
        time: f64,
    },
    /// The plan grasps, but there is nothing to grasp.
    #[error("plan: grasps at handle {handle}, but the run has no object")]
    GraspWithoutObject {
        /// Name of the handle.
        handle: String,
    },
    /// Robot, cell and object do not make a scene.
    #[error(transparent)]
    Scene(#[from] graspcheck_proof::SceneError),
    /// Rapier cannot build a hull.
    #[error(
        "body {body}: rapier finds no hull of its {points} points; give at least four that do not lie in a plane"
    )]
    Hull {
        /// Name of the body.
        body: String,
        /// How many points were given.
        points: usize,
    },
    /// Rapier did not accept the chain of links.
    #[error("link {link}: rapier refuses its joint; every link must hang on the one before it")]
    Chain {
        /// Name of the link.
        link: String,
    },
    /// Too many bodies of the robot may touch others.
    #[error(
        "robot: {count} bodies are named in allowed contacts, at most {limit} can be; merge links that do not \
         move against each other"
    )]
    AllowedBodies {
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// The rapier multibody does not move as the model says.
    #[error(
        "model: {quantity} of joint {joint} is {rapier} in rapier and {model} in the model, \
         more than {tolerance} apart, at q = {q:?}, qd = {qd:?}"
    )]
    ModelMismatch {
        /// `mass matrix` or `bias force`.
        quantity: &'static str,
        /// Name of the joint (for the mass matrix the row with the largest difference).
        joint: String,
        /// What rapier says, SI.
        rapier: f64,
        /// What the model says, SI.
        model: f64,
        /// How far they may be apart, SI.
        tolerance: f64,
        /// Positions of the arm's joints, rad or m.
        q: Vec<f64>,
        /// Velocities of the arm's joints, rad/s or m/s.
        qd: Vec<f64>,
    },
    /// The object overlaps something at the start.
    #[error(
        "object {object}: overlaps {other} by {depth} m at the start, at most {limit} m; \
         move the object or {other}"
    )]
    StartsInPenetration {
        /// Name of the object.
        object: String,
        /// Name of the other body.
        other: String,
        /// How deep, m.
        depth: f64,
        /// How deep it may be, m.
        limit: f64,
    },
    /// A number is NaN or infinite.
    #[error("{place}: {quantity} {value} is not finite at t = {time} s")]
    NotFinite {
        /// Name of the joint or body.
        place: String,
        /// What is not finite.
        quantity: &'static str,
        /// The value.
        value: f64,
        /// When, s.
        time: f64,
    },
    /// Rapier has taken bodies out of the simulation because their state was not finite.
    #[error("body {body}: taken out of the physics at t = {time} s because its state is not finite")]
    Quarantined {
        /// Name of the first such body, or its number when it is none of the scene.
        body: String,
        /// When, s.
        time: f64,
    },
    /// The run would take more steps than a recording can hold.
    #[error(
        "simulation: {duration} s in steps of {dt} s are more than {limit} steps; shorten the motion or \
         settle, or use a longer dt"
    )]
    TooManySteps {
        /// Of plan and settling, s.
        duration: f64,
        /// Length of a step, s.
        dt: f64,
        /// The most steps that are simulated.
        limit: f64,
    },
    /// Two bodies moved so far in one step that they could have passed through each other.
    #[error(
        "bodies {a} and {b}: move by {moved:.6} m against each other in the step before t = {time:.3} s, and \
         together they are {thickness:.6} m thick, so a collision could be missed; move slower or use a \
         shorter dt, and if they overlap, take them apart"
    )]
    StepTooLong {
        /// Name of one body.
        a: String,
        /// Name of the other.
        b: String,
        /// At most by how much they moved against each other, m.
        moved: f64,
        /// Least width of one plus that of the other, m.
        thickness: f64,
        /// End of the step, s.
        time: f64,
    },
    /// A body that must move was put to sleep.
    #[error("body {body}: asleep at t = {time} s, so its motion is frozen")]
    Asleep {
        /// Name of the body.
        body: String,
        /// When, s.
        time: f64,
    },
}
