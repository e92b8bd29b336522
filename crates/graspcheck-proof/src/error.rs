//! Why a scene cannot be built.

/// Why a [`crate::Scene`] cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// The numbers of joints and of moving links differ, or there is no joint.
    #[error("robot {robot}: {joints} joints and {links} moving links must be as many, and at least one")]
    JointsAndLinks {
        /// Name of the robot.
        robot: String,
        /// How many joints there are.
        joints: usize,
        /// How many moving links there are.
        links: usize,
    },
    /// A shape has no extent that can be used.
    #[error("body {body}, shape {shape}: {fault}")]
    Shape {
        /// Name of the body.
        body: String,
        /// Index of the shape in the body.
        shape: usize,
        /// What is wrong with it.
        fault: String,
    },
    /// A pose, an axis or an offset is not finite.
    #[error("body {body}: a pose, axis or offset is not finite")]
    NotFinite {
        /// Name of the body.
        body: String,
    },
    /// Two bodies have the same name.
    #[error("body {body}: the name is used twice; every body of robot, cell and object needs its own")]
    NameTwice {
        /// The name.
        body: String,
    },
    /// A body is named like a group of bodies.
    #[error("body {body}: `gripper` and `robot` are names of groups; use another name")]
    NameOfGroup {
        /// The name.
        body: String,
    },
    /// A clearance rule or an allowed contact names nothing that is there.
    #[error("{place}: there is no body named `{name}`; there are {known}")]
    UnknownBody {
        /// Where it is named.
        place: String,
        /// The name.
        name: String,
        /// The names that exist, with commas between.
        known: String,
    },
    /// A required clearance is negative or not finite.
    #[error("{place}: required clearance {required} m must be finite and not negative")]
    Required {
        /// Which rule.
        place: String,
        /// Its value, m.
        required: f64,
    },
}
