//! How the plan is executed: `[controller]` and `[simulation]`; what is not as the plan believes is read in
//! [`imperfections`](crate::imperfections).

use std::f64::consts::TAU;

use graspcheck_model::{
    execution::{ContactModel, Controller, Execution},
    robot::RobotModel,
};

use crate::{
    fault::Fault,
    imperfections::imperfections,
    quantity::Quantity,
    section::{Bound, Section},
};

/// Step of the physics when the scenario does not say, s.
pub const STEP_DEFAULT: f64 = 1e-3;
/// Substeps of the solver in one step when the scenario does not say: a friction grasp needs more than one.
pub const SUBSTEPS_DEFAULT: usize = 4;
/// How long the simulation goes on at rest after the plan's end when the scenario does not say, s.
pub const SETTLE_DEFAULT: f64 = 0.2;
/// Bandwidth of the controller when the scenario does not say, Hz: a thirtieth of the usual step rate.
pub const BANDWIDTH_DEFAULT: f64 = 30.0;
/// Damping ratio of the controller when the scenario does not say: critical, no overshoot.
pub const DAMPING_RATIO_DEFAULT: f64 = 1.0;
/// Contacts when the scenario does not say: stiff enough that fingers of 10 N sink in by less than 0.1 mm at
/// steps of 1 ms; rapier's own default (30 Hz, 10) is made for games and lets them sink in by 3 mm.
pub const CONTACT_DEFAULT: ContactModel =
    ContactModel { frequency: 300.0, damping_ratio: 5.0, prediction: 0.002, friction: 0.8 };

/// `[controller]` as far as it could be read.
struct ReadController {
    controller: Controller,
    /// Time between two commands, s.
    period: Option<f64>,
}

/// Reads `[controller]`, `[simulation]` and `[imperfections]`; the inner option is none when the run is not to be
/// executed.
pub(crate) fn execution(
    scenario: &Section<'_>,
    robot: Option<&RobotModel>,
    seed: u64,
) -> Option<Option<Execution>> {
    let controller = match scenario.section("controller", "a controller") {
        Some(section) => controller(section),
        None => Some(ReadController { controller: default_controller(), period: None }),
    };
    let imperfections = imperfections(scenario, robot);
    let Some(section) = scenario.section("simulation", "a simulation") else {
        let ReadController { controller, period } = controller?;
        return Some(Some(Execution {
            dt: STEP_DEFAULT,
            substeps: SUBSTEPS_DEFAULT,
            settle: SETTLE_DEFAULT,
            controller,
            control_period: period,
            contact: CONTACT_DEFAULT,
            seed,
            imperfections: imperfections?,
        }));
    };
    let execute = section.flag("execute", true);
    let dt = step(&section);
    let substeps = match section.has("substeps") {
        true => section.whole("substeps", 1, 100).and_then(|value| usize::try_from(value).ok()),
        false => Some(SUBSTEPS_DEFAULT),
    };
    let settle = section.measure_or("settle", Quantity::Time, Bound::NotNegative, SETTLE_DEFAULT);
    let contact = match section.section("contact", "a contact model") {
        Some(section) => contact(section),
        None => Some(CONTACT_DEFAULT),
    };
    section.finish();
    let ReadController { controller, period } = controller?;
    let execution = Execution {
        dt: dt?,
        substeps: substeps?,
        settle: settle?,
        controller,
        control_period: period,
        contact: contact?,
        seed,
        imperfections: imperfections?,
    };
    execute.map(|execute| execute.then_some(execution))
}

fn default_controller() -> Controller {
    Controller::ComputedTorque { bandwidth: TAU * BANDWIDTH_DEFAULT, damping_ratio: DAMPING_RATIO_DEFAULT }
}

/// The laws, as the scenario names them.
#[derive(Clone, Copy)]
enum Law {
    ComputedTorque,
    GravityPd,
    JointPd,
    IdealServo,
}

const LAWS: [(&str, Law); 4] = [
    ("computed_torque", Law::ComputedTorque),
    ("gravity_pd", Law::GravityPd),
    ("joint_pd", Law::JointPd),
    ("ideal_servo", Law::IdealServo),
];

fn controller(section: Section<'_>) -> Option<ReadController> {
    let law = section.word("kind", &LAWS, Some(Law::ComputedTorque));
    // A servo has no gains: its keys would be unknown ones.
    let gains = match law {
        Some(Law::IdealServo) => Some((0.0, 0.0)),
        _ => {
            let bandwidth =
                section.measure_or("bandwidth", Quantity::Frequency, Bound::Positive, BANDWIDTH_DEFAULT);
            let damping_ratio = section.plain_or("damping_ratio", Bound::Positive, DAMPING_RATIO_DEFAULT);
            bandwidth.zip(damping_ratio)
        }
    };
    let period = section.measure("period", Quantity::Time, Bound::Positive);
    let period_fails = section.mentions("period") && period.is_none();
    section.finish();
    let (bandwidth, damping_ratio) = gains?;
    let bandwidth = TAU * bandwidth;
    let controller = match law? {
        Law::ComputedTorque => Controller::ComputedTorque { bandwidth, damping_ratio },
        Law::GravityPd => Controller::GravityPd { bandwidth, damping_ratio },
        Law::JointPd => Controller::JointPd { bandwidth, damping_ratio },
        Law::IdealServo => Controller::IdealServo,
    };
    (!period_fails).then_some(ReadController { controller, period })
}

/// The step of the physics. It divides one second, so that times in a recording are whole nanoseconds or
/// near to them and rates are whole numbers.
fn step(section: &Section<'_>) -> Option<f64> {
    let given = section.measure_at("dt", Quantity::Time, Bound::Positive);
    if !section.mentions("dt") {
        return Some(STEP_DEFAULT);
    }
    let (dt, at) = given?;
    let rate = (1.0 / dt).round();
    if rate >= 1.0 && (rate * dt - 1.0).abs() < 1e-9 {
        return Some(dt);
    }
    let title = format!("dt is {} ms, which does not divide one second", dt * 1000.0);
    section.faults().report(Fault::new("range", at, title, "write for example 1, 0.5 or 0.25"));
    None
}

fn contact(section: Section<'_>) -> Option<ContactModel> {
    let frequency =
        section.measure_or("frequency", Quantity::Frequency, Bound::Positive, CONTACT_DEFAULT.frequency);
    let prediction =
        section.measure_or("prediction", Quantity::Length, Bound::Positive, CONTACT_DEFAULT.prediction);
    let damping_ratio = section.plain_or("damping_ratio", Bound::NotNegative, CONTACT_DEFAULT.damping_ratio);
    let friction = section.plain_or("friction", Bound::NotNegative, CONTACT_DEFAULT.friction);
    section.finish();
    Some(ContactModel {
        frequency: frequency?,
        damping_ratio: damping_ratio?,
        prediction: prediction?,
        friction: friction?,
    })
}
