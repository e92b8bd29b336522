//! Bodies, joints and colliders of a rapier world, from robot, cell and object.
//!
//! Rapier's free axis of a joint is the local x axis of the joint's frames, so both frames are turned to bring x
//! onto the joint's axis; then the frame of a body is the frame of the link, with nothing left to correct.
//!
//! Bodies of the robot touch each other like everything else, but for the pairs that the robot allows: the
//! same pairs that the proof excuses, and no others.

use graspcheck_model::{
    Pose,
    execution::ContactModel,
    inertia::Inertial,
    object::Object,
    robot::{JointKind, Link, RobotModel},
    shape::PlacedShape,
};
use nalgebra::{Translation3, Unit, UnitQuaternion, Vector3};
use rapier3d::{
    dynamics::{
        GenericJointBuilder, JointAxesMask, MotorModel, MultibodyJointHandle, RigidBodyBuilder,
        RigidBodyHandle, SpringCoefficients,
    },
    geometry::{ColliderBuilder, Group, InteractionGroups, InteractionTestMode},
    pipeline::{ActiveHooks, PhysicsWorld},
};

use crate::{
    convert,
    error::SimError,
    mass::{mass_properties, massless},
    plant::free_axis,
    solid::{rapier_shape, thickness},
};

/// How many bodies of the robot can have a collision group of their own: rapier has 32, and one is left for
/// all that need none.
const OWN_GROUPS: usize = 31;

/// How large a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Size {
    /// Largest distance of a point of it from its frame's origin, m, or more.
    pub(crate) reach: f64,
    /// Least width of its thinnest solid, m; infinite without a solid.
    pub(crate) thickness: f64,
}

/// How a plant is built.
pub(crate) struct PlantSettings<'a> {
    /// Length of a step, s.
    pub(crate) dt: f64,
    /// Solver substeps in one step.
    pub(crate) substeps: usize,
    /// How contacts are solved.
    pub(crate) contact: &'a ContactModel,
}

/// A joint as rapier needs it.
struct JointData {
    kind: JointKind,
    parent_from_joint: Pose,
    axis: Unit<Vector3<f64>>,
    position_limits: [f64; 2],
}

/// A world that is being filled.
pub(crate) struct Builder {
    pub(crate) world: PhysicsWorld,
    pub(crate) bodies: Vec<RigidBodyHandle>,
    pub(crate) names: Vec<String>,
    pub(crate) sizes: Vec<Size>,
    friction: f64,
    /// What the bodies of the robot touch, which are added first; all others touch everything.
    pub(crate) groups: Vec<InteractionGroups>,
}

impl Builder {
    /// An empty world with this gravity, m/s².
    pub(crate) fn new(gravity: Vector3<f64>, settings: &PlantSettings<'_>) -> Self {
        let mut world = PhysicsWorld::new();
        world.gravity = convert::vector_to_rapier(&gravity);
        let softness = SpringCoefficients::new(settings.contact.frequency, settings.contact.damping_ratio);
        let parameters = &mut world.integration_parameters;
        parameters.dt = settings.dt;
        parameters.num_solver_iterations = settings.substeps;
        parameters.contact_softness = softness;
        parameters.static_contact_softness = softness;
        parameters.normalized_prediction_distance = settings.contact.prediction;
        // A recycled contact reports the depth of an earlier step.
        parameters.contact_recycling = false;
        // Clusters keep impulses away from the points that carry them.
        parameters.contact_clustering = false;
        // Continuous collision detection would set bodies back in time. Without it contacts are found where
        // bodies stand at the beginning of a step: `Stride` gives a run up in which a body moves so far in
        // one step that it could go through another.
        parameters.max_ccd_substeps = 0;
        Self {
            world,
            bodies: Vec::new(),
            names: Vec::new(),
            sizes: Vec::new(),
            friction: settings.contact.friction,
            groups: Vec::new(),
        }
    }

    fn add_body(
        &mut self,
        name: &str,
        shapes: &[PlacedShape],
        friction: f64,
        body: RigidBodyBuilder,
    ) -> Result<RigidBodyHandle, SimError> {
        let index = self.bodies.len();
        let groups = self.groups.get(index).copied().unwrap_or(InteractionGroups::all());
        let handle = self.world.insert_body(body);
        let mut size = Size { reach: 0.0, thickness: f64::INFINITY };
        for placed in shapes {
            let (body_from_shape, shape) = rapier_shape(name, placed)?;
            let offset = placed.body_from_shape.translation.vector.norm();
            size.reach = size.reach.max(offset + placed.shape.extent_radius());
            size.thickness = size.thickness.min(thickness(&placed.shape, &shape));
            let body_from_collider = convert::to_rapier(&body_from_shape);
            let collider = ColliderBuilder::new(shape)
                .position(body_from_collider)
                .mass_properties(massless(&body_from_collider))
                .friction(friction)
                .restitution(0.0)
                .collision_groups(groups)
                .active_hooks(ActiveHooks::MODIFY_SOLVER_CONTACTS)
                .user_data(index as u128);
            self.world.insert_collider(collider, Some(handle));
        }
        self.bodies.push(handle);
        self.names.push(name.to_owned());
        self.sizes.push(size);
        Ok(handle)
    }

    /// Adds a body that does not move.
    pub(crate) fn add_fixed(
        &mut self,
        name: &str,
        shapes: &[PlacedShape],
        world_from_body: &Pose,
    ) -> Result<RigidBodyHandle, SimError> {
        let body = RigidBodyBuilder::fixed().pose(convert::to_rapier(world_from_body));
        self.add_body(name, shapes, self.friction, body)
    }

    /// Adds the object and returns its index among the bodies.
    pub(crate) fn add_object(&mut self, object: &Object) -> Result<usize, SimError> {
        let inertial = object.shape.inertial(object.mass);
        let body = dynamic(&inertial)
            .pose(convert::to_rapier(&object.world_from_object))
            .gyroscopic_forces_enabled(true);
        let shape = PlacedShape { body_from_shape: Pose::identity(), shape: object.shape.clone() };
        self.add_body(&object.name, &[shape], object.friction, body)?;
        Ok(self.bodies.len() - 1)
    }

    /// Adds links and fingers; returns the joint of the first link.
    pub(crate) fn add_arm(
        &mut self,
        robot: &RobotModel,
        base: RigidBodyHandle,
    ) -> Result<MultibodyJointHandle, SimError> {
        let mut parent = base;
        let mut first = None;
        for (joint, link) in robot.joints.iter().zip(&robot.links) {
            let data = JointData {
                kind: joint.kind,
                parent_from_joint: joint.parent_from_joint,
                axis: joint.axis,
                position_limits: [joint.limits.position_min, joint.limits.position_max],
            };
            let (body, handle) = self.add_link(link, parent, &data)?;
            parent = body;
            first = first.or(Some(handle));
        }
        for finger in &robot.gripper.fingers {
            let data = JointData {
                kind: JointKind::Prismatic,
                parent_from_joint: finger.link_from_finger,
                axis: finger.axis,
                position_limits: [0.0, robot.gripper.opening_max / 2.0],
            };
            let (_, handle) = self.add_link(&finger.link, parent, &data)?;
            first = first.or(Some(handle));
        }
        Ok(first.expect("the fingers have joints"))
    }

    fn add_link(
        &mut self,
        link: &Link,
        parent: RigidBodyHandle,
        joint: &JointData,
    ) -> Result<(RigidBodyHandle, MultibodyJointHandle), SimError> {
        let body = self.add_body(&link.name, &link.shapes, self.friction, dynamic(&link.inertial))?;
        let joint_from_axis = turn_x_onto(&joint.axis);
        let (locked, free) = match joint.kind {
            JointKind::Revolute => (JointAxesMask::LOCKED_REVOLUTE_AXES, free_axis(joint.kind)),
            JointKind::Prismatic => (JointAxesMask::LOCKED_PRISMATIC_AXES, free_axis(joint.kind)),
        };
        let mut builder = GenericJointBuilder::new(locked)
            .local_frame1(convert::to_rapier(&(joint.parent_from_joint * joint_from_axis)))
            .local_frame2(convert::to_rapier(&joint_from_axis))
            .motor_model(free, MotorModel::ForceBased);
        if joint.position_limits.iter().all(|limit| limit.is_finite()) {
            builder = builder.limits(free, joint.position_limits);
        }
        let handle = self
            .world
            .insert_multibody_joint(parent, body, builder.build())
            .ok_or_else(|| SimError::Chain { link: link.name.clone() })?;
        Ok((body, handle))
    }
}

/// What each body of the robot touches, in the order base, links, fingers: everything but the bodies that
/// it is allowed to pass through.
///
/// Two bodies touch when the filter of each holds a group of the other. A body that is named in an allowed
/// contact has one group, its own, so that exactly the allowed pairs are dropped.
///
/// # Errors
/// When there are more such bodies than groups.
pub(crate) fn collision_groups(robot: &RobotModel) -> Result<Vec<InteractionGroups>, SimError> {
    let links = std::iter::once(&robot.base).chain(&robot.links);
    let fingers = robot.gripper.fingers.iter().map(|finger| &finger.link);
    let names: Vec<&str> = links.chain(fingers).map(|link| link.name.as_str()).collect();
    let pairs: Vec<[&str; 2]> =
        robot.allowed_contacts.iter().map(|pair| [pair.a.as_str(), pair.b.as_str()]).collect();
    let named: Vec<&str> =
        names.iter().copied().filter(|name| pairs.iter().any(|pair| pair.contains(name))).collect();
    if named.len() > OWN_GROUPS {
        return Err(SimError::AllowedBodies { count: named.len(), limit: OWN_GROUPS });
    }
    let own = |name: &str| {
        let index = named.iter().position(|other| *other == name)?;
        Some(Group::from_bits_retain(1 << index))
    };
    let groups = names.iter().map(|name| {
        let Some(group) = own(name) else { return InteractionGroups::all() };
        let partners = pairs.iter().filter_map(|[a, b]| match name {
            _ if a == name => own(b),
            _ if b == name => own(a),
            _ => None,
        });
        let filter = partners.fold(Group::ALL, Group::difference);
        InteractionGroups::new(group, filter, InteractionTestMode::And)
    });
    Ok(groups.collect())
}

/// A body that moves and never sleeps: rapier would freeze slow motion.
fn dynamic(inertial: &Inertial) -> RigidBodyBuilder {
    RigidBodyBuilder::dynamic().can_sleep(false).additional_mass_properties(mass_properties(inertial))
}

/// The rotation that brings x onto `axis`.
fn turn_x_onto(axis: &Unit<Vector3<f64>>) -> Pose {
    // Undefined only for the opposite direction, where half a turn about z does it.
    let rotation = UnitQuaternion::rotation_between(&Vector3::x(), axis)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
    Pose::from_parts(Translation3::identity(), rotation)
}
