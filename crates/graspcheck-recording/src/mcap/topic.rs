//! The topics of a recording, in the order in which messages of one instant are written.

/// One topic.
///
/// The order of the variants is the order at equal stamps. Frames come first: a viewer shows a marker only
/// when it knows a frame at or before its stamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Topic {
    StaticFrames,
    Frames,
    RobotDescription,
    Markers,
    Measured,
    Reference,
    ToolPose,
    ToolTwist,
    ReferenceToolPose,
    ReferenceToolTwist,
    ObjectPose,
    ObjectTwist,
    Contacts,
    Monitor,
    Events,
    Diagnostics,
    Verdict,
}

impl Topic {
    pub(super) const ALL: [Self; 17] = [
        Self::StaticFrames,
        Self::Frames,
        Self::RobotDescription,
        Self::Markers,
        Self::Measured,
        Self::Reference,
        Self::ToolPose,
        Self::ToolTwist,
        Self::ReferenceToolPose,
        Self::ReferenceToolTwist,
        Self::ObjectPose,
        Self::ObjectTwist,
        Self::Contacts,
        Self::Monitor,
        Self::Events,
        Self::Diagnostics,
        Self::Verdict,
    ];

    /// Its name in the file, as ROS 2 tools expect it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::StaticFrames => "/tf_static",
            Self::Frames => "/tf",
            Self::RobotDescription => "/robot_description",
            Self::Markers => "/scene/markers",
            Self::Measured => "/joint_states",
            Self::Reference => "/reference/joint_states",
            Self::ToolPose => "/tcp/pose",
            Self::ToolTwist => "/tcp/twist",
            Self::ReferenceToolPose => "/reference/tcp/pose",
            Self::ReferenceToolTwist => "/reference/tcp/twist",
            Self::ObjectPose => "/object/pose",
            Self::ObjectTwist => "/object/twist",
            Self::Contacts => "/contacts",
            Self::Monitor => "/checks/monitor",
            Self::Events => "/rosout",
            Self::Diagnostics => "/diagnostics",
            Self::Verdict => "/verdict",
        }
    }

    /// The type of its messages, `package/msg/Type`.
    pub(super) fn message_type(self) -> &'static str {
        match self {
            Self::StaticFrames | Self::Frames => "tf2_msgs/msg/TFMessage",
            Self::RobotDescription | Self::Verdict => "std_msgs/msg/String",
            Self::Markers => "visualization_msgs/msg/MarkerArray",
            Self::Measured | Self::Reference => "sensor_msgs/msg/JointState",
            Self::ToolPose | Self::ReferenceToolPose | Self::ObjectPose => "geometry_msgs/msg/PoseStamped",
            Self::ToolTwist | Self::ReferenceToolTwist | Self::ObjectTwist => {
                "geometry_msgs/msg/TwistStamped"
            }
            Self::Contacts => "graspcheck_msgs/msg/Contact",
            Self::Monitor => "graspcheck_msgs/msg/Monitor",
            Self::Events => "rcl_interfaces/msg/Log",
            Self::Diagnostics => "diagnostic_msgs/msg/DiagnosticArray",
        }
    }

    /// The topic of this name.
    pub(super) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|topic| topic.name() == name)
    }

    /// The complete quality of service as ROS 2 bags store it; readers stop at a missing key.
    ///
    /// Numbers are those of `rmw`: history keep-last 1, reliable 1, liveliness automatic 1, durability
    /// transient-local 1 for what a late subscriber must get, else volatile 2.
    pub(super) fn quality_of_service(self) -> String {
        let latched =
            matches!(self, Self::StaticFrames | Self::RobotDescription | Self::Markers | Self::Verdict);
        let (depth, durability) = if latched { (1, 1) } else { (10, 2) };
        const FOREVER: &str = "\n    sec: 9223372036\n    nsec: 854775807\n";
        format!(
            "- history: 1\n  depth: {depth}\n  reliability: 1\n  durability: {durability}\n  \
             deadline:{FOREVER}  lifespan:{FOREVER}  liveliness: 1\n  \
             liveliness_lease_duration:{FOREVER}  avoid_ros_namespace_conventions: false\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_topics_are_listed_in_order_and_found_by_name() {
        assert!(Topic::ALL.is_sorted());
        for topic in Topic::ALL {
            assert_eq!(Topic::named(topic.name()), Some(topic));
        }
        assert_eq!(Topic::named("/camera"), None);
    }
}
