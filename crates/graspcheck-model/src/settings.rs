//! What a `robot.toml` says about an arm, in SI units: everything that its URDF cannot or must not say.
//!
//! The URDF gives structure, geometry, mass properties and the limits of position, velocity and effort.
//! Acceleration and jerk limits, rotor inertias, the tool frame, the gripper's numbers and the allowed
//! contacts stand here and only here, so that no number has two sources.

use serde::{Deserialize, Serialize};

use crate::{Pose, robot::AllowedContact};

/// What a `robot.toml` says, SI units and radians.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotSettings {
    /// From the frame of the URDF's root link to the world.
    pub world_from_base: Pose,
    /// Every joint of the arm, in any order; the fingers' joints are not among them.
    pub joints: Vec<JointSettings>,
    /// The tool frame.
    pub tool: ToolSettings,
    /// The gripper.
    pub gripper: GripperSettings,
    /// Pairs of bodies of the robot that may touch or overlap, each with its reason. The pairs of links
    /// that a joint connects stand here too, where they overlap.
    pub allowed_contacts: Vec<AllowedContact>,
}

/// What a URDF cannot say about a joint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointSettings {
    /// Name of the joint in the URDF.
    pub name: String,
    /// Largest magnitude of the acceleration, rad/s² or m/s²; positive.
    pub acceleration: f64,
    /// Largest magnitude of the jerk, rad/s³ or m/s³; positive.
    pub jerk: f64,
    /// Inertia of the rotor seen at the joint (gear ratio squared times its own), kg·m² or kg; 0 or more.
    pub rotor_inertia: f64,
}

/// Where the tool frame sits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolSettings {
    /// Name of the link that carries it: the last link of the arm.
    pub link: String,
    /// From the tool frame (x out of the gripper, y along the closing direction, origin between the pads)
    /// to that link.
    pub link_from_tool: Pose,
}

/// The numbers of the gripper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GripperSettings {
    /// Names of the fingers' joints in the URDF, in any order; one of them mimics the other.
    pub fingers: [String; 2],
    /// Largest distance between the pads, m.
    pub opening_max: f64,
    /// Opening beyond the object's width, on each side, with which the gripper approaches, m.
    pub free_opening: f64,
    /// Largest force of one finger, N.
    pub force_max: f64,
    /// Speed at which one finger closes and opens, m/s.
    pub finger_speed: f64,
}
