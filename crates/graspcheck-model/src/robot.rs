//! A serial arm with a two-finger gripper.

use nalgebra::{Unit, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Pose, inertia::Inertial, shape::PlacedShape};

/// A serial arm with a parallel gripper at its end.
///
/// `joints[k]` moves `links[k]`; the frame of link k is the frame of joint k at its child side, so that
/// `world_from_link[k] = world_from_link[k - 1] * joints[k].parent_from_joint * motion(q[k])`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotModel {
    /// The name of the asset folder.
    pub name: String,
    /// Which closed-form kinematics fits, found from the structure.
    pub family: Family,
    /// From the base frame to the world.
    pub world_from_base: Pose,
    /// The link that does not move.
    pub base: Link,
    /// Joints of the arm from base to tool.
    pub joints: Vec<Joint>,
    /// The links that move, one for each joint.
    pub links: Vec<Link>,
    /// From the tool frame (x out of the gripper, y along the closing direction) to the last link.
    pub link_from_tool: Pose,
    /// The gripper on the last link.
    pub gripper: Gripper,
    /// Pairs of bodies of the robot that may touch or overlap, each with its reason.
    pub allowed_contacts: Vec<AllowedContact>,
}

/// The structures with closed-form inverse kinematics. Lengths in m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// R-R-P-R, all axes along the base's z.
    Scara {
        /// From axis 1 to axis 2.
        upper: f64,
        /// From axis 2 to axis 4.
        fore: f64,
    },
    /// R-R-R, all axes along the base's z.
    PlanarRrr {
        /// From axis 1 to axis 2.
        upper: f64,
        /// From axis 2 to axis 3 (the wrist).
        fore: f64,
        /// From axis 3 to the tool frame.
        hand: f64,
    },
    /// Any other serial chain.
    General,
}

/// A rigid link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// Its name, unique among all bodies of a scene.
    pub name: String,
    /// Mass properties in the link's frame.
    pub inertial: Inertial,
    /// Convex solids that collide; their union is the link.
    pub shapes: Vec<PlacedShape>,
}

/// One joint of the arm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// From the frame of the joint at position 0 to the frame of the link before it.
    pub parent_from_joint: Pose,
    /// The axis in the frame of the joint.
    pub axis: Unit<Vector3<f64>>,
    /// What the joint may do.
    pub limits: JointLimits,
    /// Viscous friction, N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Dry friction, N·m or N.
    pub friction: f64,
    /// Inertia of the rotor seen at the joint, kg·m² or kg.
    pub rotor_inertia: f64,
}

/// The kind of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Turns about its axis, rad.
    Revolute,
    /// Slides along its axis, m.
    Prismatic,
}

/// The limits of a joint, SI units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointLimits {
    /// Lowest position, rad or m.
    pub position_min: f64,
    /// Highest position, rad or m.
    pub position_max: f64,
    /// Largest speed, rad/s or m/s.
    pub velocity: f64,
    /// Largest magnitude of the acceleration, rad/s² or m/s².
    pub acceleration: f64,
    /// Largest magnitude of the jerk, rad/s³ or m/s³.
    pub jerk: f64,
    /// Largest magnitude of torque or force, N·m or N.
    pub effort: f64,
}

/// A parallel gripper: two fingers that move apart symmetrically along the tool's y axis.
///
/// The *opening* is the distance between the pads, m: a finger stands at half of it from the middle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gripper {
    /// The two fingers.
    pub fingers: [Finger; 2],
    /// Largest opening, m.
    pub opening_max: f64,
    /// Opening beyond the object's width, on each side, with which the gripper approaches, m.
    pub free_opening: f64,
    /// Largest force of one finger, N.
    pub force_max: f64,
    /// Speed at which one finger closes and opens, m/s.
    pub finger_speed: f64,
}

/// One finger: a prismatic joint on the last link, at position 0 when the pads touch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finger {
    /// The finger's body.
    pub link: Link,
    /// Name of its joint.
    pub joint: String,
    /// From the frame of the finger at position 0 to the last link of the arm.
    pub link_from_finger: Pose,
    /// Direction of opening, in the frame of the finger.
    pub axis: Unit<Vector3<f64>>,
}

/// A pair of bodies that may touch or overlap.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AllowedContact {
    /// Name of one body.
    pub a: String,
    /// Name of the other.
    pub b: String,
    /// Why.
    pub reason: String,
}

impl RobotModel {
    /// The number of joints of the arm; the fingers do not count.
    #[must_use]
    pub fn dof(&self) -> usize {
        self.joints.len()
    }
}
