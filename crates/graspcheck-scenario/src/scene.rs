//! What robot, cell and object must have in common: names, and a grasp that the gripper can make.

use graspcheck_model::{
    cell::CellBody,
    robot::{Family, RobotModel},
};
use graspcheck_planner::opening::least_duration;
use nalgebra::Vector3;

use crate::{
    cell::PlacedBody,
    fault::{Fault, Faults, Place},
    motion::GripPace,
    object::PlacedObject,
    suggest::nearest,
    support::{Unsupported, unsupported},
};

/// Names that stand for something else: groups of bodies, and frames in a recording.
const RESERVED: [&str; 4] = ["gripper", "robot", "tool", "world"];

/// Names of groups of bodies in `[check.clearance] pairs`.
const GROUPS: [&str; 2] = ["gripper", "robot"];

/// Robot, cell and object, as far as they could be read.
pub(crate) struct Scene<'a> {
    pub(crate) robot: Option<&'a RobotModel>,
    pub(crate) bodies: &'a [PlacedBody<'a>],
    pub(crate) object: Option<&'a PlacedObject<'a>>,
    pub(crate) faults: &'a Faults,
}

impl<'a> Scene<'a> {
    fn robot_names(&self) -> impl Iterator<Item = &'a str> {
        self.robot.into_iter().flat_map(|robot| {
            let arm = [&robot.base].into_iter().chain(&robot.links);
            arm.chain(robot.gripper.fingers.iter().map(|finger| &finger.link)).map(|link| link.name.as_str())
        })
    }

    fn named_in_files(&self) -> impl Iterator<Item = (&'a str, &'a Place)> {
        let object = self.object.map(|placed| (placed.object.name.as_str(), placed.name_at));
        self.bodies.iter().map(|placed| (placed.body.name.as_str(), placed.name_at)).chain(object)
    }

    /// Reports names of bodies and object that are taken.
    pub(crate) fn check_names(&self) {
        let mut taken: Vec<&str> = self.robot_names().collect();
        for (name, at) in self.named_in_files() {
            let why = if RESERVED.contains(&name) {
                "it stands for something else"
            } else if taken.contains(&name) {
                "another body, a link or a finger has it"
            } else if name.is_empty() {
                "it is empty"
            } else {
                taken.push(name);
                continue;
            };
            self.faults.report(Fault::new(
                "name",
                at,
                format!("the name `{name}` cannot be used: {why}"),
                "choose another",
            ));
        }
    }

    /// Reports names in clearance pairs that no body has. Without a robot its links are not known.
    pub(crate) fn check_pairs(&self, names: &[(&str, &Place)]) {
        if self.robot.is_none() {
            return;
        }
        let known: Vec<&str> =
            self.robot_names().chain(self.named_in_files().map(|(name, _)| name)).chain(GROUPS).collect();
        for (name, at) in names {
            if known.contains(name) {
                continue;
            }
            let fault =
                Fault::new("unknown-body", at, format!("unknown body `{name}`"), "no body has this name");
            self.faults.report(match nearest(name, known.iter().copied()) {
                Some(near) => fault.replace(format!("did you mean \"{near}\"?"), format!("\"{near}\"")),
                None => fault.help(format!("the bodies are {}", known.join(", "))),
            });
        }
    }

    /// Reports an object that floats or is inside a body, under `gravity`, m/s².
    pub(crate) fn check_support(&self, gravity: &Vector3<f64>) {
        let Some(placed) = self.object else { return };
        let bodies: Vec<&CellBody> = self.bodies.iter().map(|placed| &placed.body).collect();
        let Some(wrong) = unsupported(&placed.object, &bodies, self.robot, gravity) else { return };
        let name = &placed.object.name;
        let fault = |title: String, label| Fault::new("support", placed.at, title, label);
        let (fault, body) = match &wrong {
            Unsupported::Inside { body, depth } => {
                let title = format!("{name} is {:.2} mm inside {body} at the start", depth * 1e3);
                (fault(title, "move it out"), Some(body))
            }
            Unsupported::Above { body, fall } => {
                let lowest = placed.object.world_from_object.translation.vector
                    + gravity.try_normalize(0.0).unwrap_or_default() * *fall;
                let [x, y, z] = [lowest.x, lowest.y, lowest.z].map(|v| (v * 1e5).round() / 100.0);
                let title =
                    format!("nothing supports {name}: its lowest point is {:.2} mm above {body}", fall * 1e3);
                let help = format!("it stands on {body} at_mm = [{x}, {y}, {z}]");
                (fault(title, "it would fall at once").help(help), Some(body))
            }
            Unsupported::Nothing => {
                let title = format!("nothing supports {name}: there is no body below it");
                let fault = fault(title, "it would fall at once");
                (fault.help("stand it on a body of the cell, or write gravity = \"none\""), None)
            }
        };
        let other = body.and_then(|body| self.bodies.iter().find(|placed| placed.body.name == *body));
        self.faults.report(match other {
            Some(other) => fault.second(other.name_at, "this body"),
            None => fault,
        });
    }

    /// Reports a force that the gripper does not have, and handles that it can never hold.
    pub(crate) fn check_grasp(&self, grip: Option<&GripPace>) {
        let Some(robot) = self.robot else { return };
        let gripper = &robot.gripper;
        if let Some(grip) = grip
            && grip.force > gripper.force_max
        {
            let title = format!("grip force {} N exceeds {} N", grip.force, gripper.force_max);
            let label = format!("{} N too much", grip.force - gripper.force_max);
            self.faults.report(
                Fault::new("outside-limit", &grip.force_at, title, label)
                    .help("the limit is `force_max_n` in the robot's robot.toml"),
            );
        }
        let Some(placed) = self.object else { return };
        if let Some(grip) = grip {
            self.check_finger_speed(placed, grip, robot);
        }
        let planar = matches!(robot.family, Family::PlanarRrr { .. });
        for (handle, place) in placed.object.handles.iter().zip(&placed.handles) {
            if handle.width >= gripper.opening_max {
                let (width, most) = (handle.width * 1000.0, gripper.opening_max * 1000.0);
                let title = format!(
                    "handle {}: width {width:.1} mm does not fit an opening of {most:.1} mm",
                    handle.name
                );
                self.faults.report(Fault::new("outside-limit", place.at, title, "too wide for the gripper"));
            }
            if planar && place.down {
                let title = format!("handle {}: a planar arm cannot approach across its plane", handle.name);
                let fault =
                    Fault::new("handle", place.at, title, "write a direction such as approach = [0, -1]");
                self.faults.report(fault);
            }
        }
    }

    /// Reports durations of closing and opening that are too short for the fingers.
    fn check_finger_speed(&self, placed: &PlacedObject<'_>, grip: &GripPace, robot: &RobotModel) {
        let gripper = &robot.gripper;
        let durations =
            placed.object.handles.iter().filter_map(|handle| least_duration(handle, gripper).ok());
        let least = durations.fold(0.0, f64::max);
        let [close_at, open_at] = &grip.durations_at;
        for (phase, given, at) in [("close", grip.close, close_at), ("open", grip.open, open_at)] {
            if given >= least {
                continue;
            }
            let title = format!(
                "phase {phase}: {given:.3} s is too short, the fingers need {least:.4} s at {} mm/s",
                gripper.finger_speed * 1e3
            );
            let written = (least * 1e3).ceil() / 1e3;
            self.faults.report(match at {
                Some(at) => Fault::new("outside-limit", at, title, "too fast for the fingers")
                    .replace("the least that does, in seconds", format!("{written}")),
                None => {
                    Fault::new("outside-limit", &grip.force_at, title, "the default duration is too short")
                        .help(format!("write [phase.{phase}] duration_s = {written}"))
                }
            });
        }
    }
}
