//! Robot, cell and object as bodies of a rapier world.
//!
//! The robot is one multibody in reduced coordinates with a fixed base; [`builder`](crate::builder) makes it.
//!
//! What rapier does silently and is undone here: damping of 0.1 N·m·s/rad on every revolute joint, mass
//! properties that are only computed at the first step, sleeping, contacts predicted at 2 cm and solved as
//! springs of 30 Hz, contacts that are not computed again until a body has moved by 5 cm, and continuous
//! collision detection, which moves bodies back in time.
//!
//! Not in the plant: limits of velocity, which no drive of ours has. They are for the checks to judge.

use graspcheck_model::{
    Pose,
    cell::Cell,
    object::Object,
    robot::{JointKind, RobotModel},
    shape::PlacedShape,
};
use nalgebra::DMatrix;
use rapier3d::{
    dynamics::{JointAxis, Multibody, MultibodyDofCoupling, MultibodyJointHandle, RigidBodyHandle},
    geometry::{Collider, ContactPair},
    math::Vector,
    pipeline::{PhysicsHooks, PhysicsWorld},
};

pub(crate) use crate::builder::{PlantSettings, Size};
use crate::{
    arc::ArcCorrection,
    builder::{Builder, collision_groups},
    convert,
    error::SimError,
};

/// The number of fingers; the joints of a plant are those of the arm and then these.
pub(crate) const FINGERS: usize = 2;

/// Gain of the fingers' velocity motors, N·s/m: so large that the force limit is reached at any error of
/// velocity that can be seen (1 µm/s asks for 1 N).
const FINGER_MOTOR_GAIN: f64 = 1e6;

/// Gain of the arm's velocity motors, N·m·s/rad or N·s/m. Rapier solves them implicitly, so the inertia of a
/// metre-long arm at steps of 1 ms (some 1e6 N·m·s/rad) slows them by a thousandth.
const SERVO_GAIN: f64 = 1e9;

/// Sweeps over all contacts and joint rows in each substep while the pads press, with and without the
/// correction of depth. With one sweep a cube of 0.1 kg held with 10 N creeps by 0.2 mm in a swing of 0.6 s, with ten by 0.03 mm;
/// more change nothing.
const SWEEPS_IN_GRASP: usize = 10;

/// The same while they do not: what then touches is an object that stands.
const SWEEPS_ELSE: usize = 1;

/// The rapier world of a run.
pub(crate) struct Plant {
    world: PhysicsWorld,
    /// The joint of the first link, by which the multibody is found.
    arm: MultibodyJointHandle,
    /// Kinds of the arm's joints, then of the fingers.
    kinds: Vec<JointKind>,
    /// Bodies of the robot (base, links, fingers), the object, the cell; their colliders carry the index.
    bodies: Vec<RigidBodyHandle>,
    names: Vec<String>,
    sizes: Vec<Size>,
    /// Index of the object among the bodies.
    object: Option<usize>,
}

impl Plant {
    /// The world with the robot at position 0 of all joints, the cell, and the object at its start.
    ///
    /// # Errors
    /// When rapier finds no hull or refuses a joint.
    pub(crate) fn new(
        robot: &RobotModel,
        cell: &Cell,
        object: Option<&Object>,
        settings: &PlantSettings<'_>,
    ) -> Result<Self, SimError> {
        let mut builder = Builder::new(cell.gravity, settings);
        builder.groups = collision_groups(robot)?;
        let base = builder.add_fixed(&robot.base.name, &robot.base.shapes, &robot.world_from_base)?;
        let arm = builder.add_arm(robot, base)?;
        let object = object.map(|object| builder.add_object(object)).transpose()?;
        for body in &cell.bodies {
            let shape = PlacedShape { body_from_shape: Pose::identity(), shape: body.shape.clone() };
            builder.add_fixed(&body.name, &[shape], &body.world_from_shape)?;
        }
        let kinds =
            robot.joints.iter().map(|joint| joint.kind).chain([JointKind::Prismatic; FINGERS]).collect();
        let mut plant = Self {
            world: builder.world,
            arm,
            kinds,
            bodies: builder.bodies,
            names: builder.names,
            sizes: builder.sizes,
            object,
        };
        plant.settle_multibody(robot);
        Ok(plant)
    }

    /// Computes mass properties and sets damping, dry friction and rotor inertia.
    fn settle_multibody(&mut self, robot: &RobotModel) {
        let world = &mut self.world;
        for handle in &self.bodies {
            world.bodies[*handle].recompute_mass_properties_from_colliders(&world.colliders);
        }
        let (multibody, _) =
            world.multibody_joints.get_mut(self.arm).expect("the joint was inserted by the constructor");
        // Until the first forward kinematics the fixed base still counts six degrees of freedom.
        multibody.forward_kinematics(&world.bodies, true);
        multibody.damping_mut().fill(0.0);
        for (index, joint) in robot.joints.iter().enumerate() {
            multibody.damping_mut()[index] = joint.damping;
            multibody.frictions_mut()[index] = joint.friction;
            multibody.armature_mut()[index] = joint.rotor_inertia;
        }
        multibody.add_dof_coupling(MultibodyDofCoupling {
            link1: robot.dof() + 1,
            dof1: 0,
            axis1: JointAxis::LinX as usize,
            link2: robot.dof() + 2,
            dof2: 0,
            axis2: JointAxis::LinX as usize,
            coeff: 1.0,
            offset: 0.0,
        });
        multibody.update_rigid_bodies(&mut world.bodies, true);
    }

    /// The number of joints, fingers included.
    pub(crate) fn joint_count(&self) -> usize {
        self.kinds.len()
    }

    /// The names of all bodies: base, links, fingers, then the object if there is one, then the cell.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The sizes of all bodies.
    pub(crate) fn sizes(&self) -> &[Size] {
        &self.sizes
    }

    /// Whether two bodies are held against each other: they have solids, one of them can move, and they are
    /// not an allowed pair of the robot.
    pub(crate) fn are_held_against_each_other(&self, a: usize, b: usize) -> bool {
        let bodies = [a, b].map(|body| &self.world.bodies[self.bodies[body]]);
        let [Some(in_a), Some(in_b)] = bodies.map(|body| {
            body.colliders().first().map(|first| self.world.colliders[*first].collision_groups())
        }) else {
            return false;
        };
        bodies.iter().any(|body| body.is_dynamic()) && in_a.test(in_b)
    }

    /// The index of the object among the bodies.
    pub(crate) fn object(&self) -> Option<usize> {
        self.object
    }

    /// The index of a finger among the bodies.
    pub(crate) fn finger(&self, finger: usize) -> usize {
        self.joint_count() - FINGERS + 1 + finger
    }

    fn multibody(&self) -> &Multibody {
        self.world.multibody_joints.get(self.arm).expect("the joint is never removed").0
    }

    /// Puts all joints, fingers included, at `q` with velocities `qd`.
    pub(crate) fn set_state(&mut self, q: &[f64], qd: &[f64]) {
        let mut displacement = vec![0.0; self.joint_count()];
        self.read_positions(&mut displacement);
        for (value, target) in displacement.iter_mut().zip(q) {
            *value = target - *value;
        }
        let world = &mut self.world;
        let (multibody, _) = world.multibody_joints.get_mut(self.arm).expect("the joint is never removed");
        multibody.apply_displacements(&displacement);
        multibody.forward_kinematics(&world.bodies, true);
        multibody.update_rigid_bodies(&mut world.bodies, true);
        multibody.generalized_velocity_mut().copy_from_slice(qd);
    }

    fn read_positions(&self, q: &mut [f64]) {
        // Link 0 is the base; the links of the joints follow in order of insertion.
        for ((value, kind), link) in q.iter_mut().zip(&self.kinds).zip(self.multibody().links().skip(1)) {
            *value = link.joint.coords()[free_axis(*kind) as usize];
        }
    }

    /// Reads positions and velocities of all joints, fingers included.
    pub(crate) fn read_state(&self, q: &mut [f64], qd: &mut [f64]) {
        self.read_positions(q);
        qd.copy_from_slice(self.multibody().generalized_velocity().as_slice());
    }

    /// Reads the pose of every body in the world.
    pub(crate) fn read_poses(&self, world_from_body: &mut [Pose]) {
        for (pose, handle) in world_from_body.iter_mut().zip(&self.bodies) {
            *pose = convert::from_rapier(self.world.bodies[*handle].position());
        }
    }

    /// The velocity of the object's origin and its angular velocity, in the world.
    pub(crate) fn object_twist(&self) -> Option<[f64; 6]> {
        let body = &self.world.bodies[self.bodies[self.object?]];
        let linear = body.velocity_at_point(body.position().translation);
        let angular = body.angvel();
        Some([linear.x, linear.y, linear.z, angular.x, angular.y, angular.z])
    }

    /// Takes all forces off robot and object; what follows is for the next step.
    pub(crate) fn clear_forces(&mut self) {
        let moving =
            self.bodies[1..=self.kinds.len()].iter().chain(self.object.map(|index| &self.bodies[index]));
        for handle in moving {
            self.world.bodies[*handle].reset_forces(false);
            self.world.bodies[*handle].reset_torques(false);
        }
    }

    /// The index of the body with this name.
    pub(crate) fn body_named(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Adds a force on a body at its centre of mass, in the world, N, for the next step.
    pub(crate) fn push(&mut self, body: usize, force: [f64; 3]) {
        self.world.bodies[self.bodies[body]].add_force(force.into(), false);
    }

    /// Drives the arm's joints at these velocities, rad/s or m/s, by any effort within their limits.
    pub(crate) fn drive_arm(&mut self, robot: &RobotModel, velocities: &[f64]) {
        let (multibody, _) =
            self.world.multibody_joints.get_mut(self.arm).expect("the joint is never removed");
        for (index, (joint, velocity)) in robot.joints.iter().zip(velocities).enumerate() {
            let link = multibody.link_mut(index + 1).expect("every joint has its link");
            let axis = free_axis(joint.kind);
            link.joint.data.set_motor_velocity(axis, *velocity, SERVO_GAIN);
            link.joint.data.set_motor_max_force(axis, joint.limits.effort);
        }
    }

    /// Adds the efforts of the arm's joints, N·m or N, for the next step.
    ///
    /// Each acts as an equal and opposite pair on the two links of its joint, along the axis as it stands
    /// now; between substeps the pair keeps its direction in the world.
    pub(crate) fn apply_efforts(&mut self, efforts: &[f64]) {
        let world = &mut self.world;
        let (multibody, _) = world.multibody_joints.get(self.arm).expect("the joint is never removed");
        for (index, (effort, link)) in efforts.iter().zip(multibody.links().skip(1)).enumerate() {
            let world_from_joint = *link.local_to_world() * link.joint.data.local_frame2;
            let wrench = world_from_joint.rotation * Vector::X * *effort;
            let (parent, child) = (self.bodies[index], self.bodies[index + 1]);
            for (body, sign) in [(child, 1.0), (parent, -1.0)] {
                let body = &mut world.bodies[body];
                if !body.is_dynamic() {
                    continue;
                }
                match self.kinds[index] {
                    JointKind::Revolute => body.add_torque(wrench * sign, false),
                    JointKind::Prismatic => {
                        // Not `add_force_at_point`: its centre of mass lags by one substep.
                        let center = *body.position() * body.local_center_of_mass();
                        let arm = world_from_joint.translation - center;
                        body.add_force(wrench * sign, false);
                        body.add_torque(arm.cross(wrench * sign), false);
                    }
                }
            }
        }
    }

    /// Sets what the motors of both fingers do: reach `velocity` (positive opens), m/s, with at most
    /// `force`, N, each.
    pub(crate) fn drive_fingers(&mut self, velocity: f64, force: f64) {
        let first = self.finger(0);
        let (multibody, _) =
            self.world.multibody_joints.get_mut(self.arm).expect("the joint is never removed");
        for finger in first..first + FINGERS {
            let link = multibody.link_mut(finger).expect("the fingers are the last links");
            link.joint.data.set_motor_velocity(JointAxis::LinX, velocity, FINGER_MOTOR_GAIN);
            link.joint.data.set_motor_max_force(JointAxis::LinX, force);
        }
    }

    /// Solves contacts as a grasp needs it, or faster while the pads do not press.
    pub(crate) fn solve_for_grasp(&mut self, presses: bool) {
        let sweeps = if presses { SWEEPS_IN_GRASP } else { SWEEPS_ELSE };
        self.world.integration_parameters.num_internal_pgs_iterations = sweeps;
        self.world.integration_parameters.num_internal_stabilization_iterations = sweeps;
    }

    /// Advances by one step.
    pub(crate) fn step(&mut self, hooks: &dyn PhysicsHooks) {
        self.world.step_with_events(hooks, &());
    }

    /// The correction of friction for hand and object of this plant.
    pub(crate) fn arc_correction(&self, robot: &RobotModel) -> ArcCorrection {
        let fingers = [self.bodies[self.finger(0)], self.bodies[self.finger(1)]];
        let dt = self.world.integration_parameters.dt;
        ArcCorrection::new(robot, dt, fingers, self.object.map(|object| self.bodies[object]))
    }

    /// Computes contacts where everything stands.
    pub(crate) fn detect_contacts(&mut self) {
        // A step of zero length. `PhysicsWorld::detect_collisions` panics before the first step.
        let dt = std::mem::replace(&mut self.world.integration_parameters.dt, 0.0);
        self.world.step();
        self.world.integration_parameters.dt = dt;
    }

    /// The pairs of colliders whose bounds meet, with the contacts found at the beginning of the last step.
    pub(crate) fn contact_pairs(&self) -> impl Iterator<Item = &ContactPair> {
        self.world.contact_pairs()
    }

    /// The index of the body that carries a collider, and the pose of the collider in it.
    pub(crate) fn collider(&self, handle: rapier3d::geometry::ColliderHandle) -> (usize, Pose) {
        let collider = &self.world.colliders[handle];
        let body_from_collider = collider.position_wrt_parent().expect("every collider is on a body");
        (collider.user_data as usize, convert::from_rapier(body_from_collider))
    }

    /// The name of a body that rapier took out of the simulation in the last step; of one that this plant
    /// does not know, rapier's number.
    pub(crate) fn quarantined(&self) -> Option<String> {
        let quarantine = self.world.quarantine();
        if quarantine.is_empty() {
            return None;
        }
        let of_collider = |handle| self.world.colliders.get(handle).and_then(Collider::parent);
        let body = quarantine
            .bodies()
            .first()
            .copied()
            .or_else(|| quarantine.colliders().first().and_then(|collider| of_collider(*collider)));
        let known = body.and_then(|body| self.bodies.iter().position(|handle| *handle == body));
        Some(match (known, body) {
            (Some(index), _) => self.names[index].clone(),
            (None, Some(body)) => format!("number {}", body.into_raw_parts().0),
            (None, None) => "unknown".to_owned(),
        })
    }

    /// The name of a body of robot or object that sleeps.
    pub(crate) fn asleep(&self) -> Option<&str> {
        let index = self.bodies.iter().position(|handle| {
            let body = &self.world.bodies[*handle];
            body.is_dynamic() && body.is_sleeping()
        })?;
        Some(&self.names[index])
    }

    /// The mass matrix of all joints where they stand, rotor inertia included, with neither damping nor
    /// the step in it.
    pub(crate) fn mass_matrix(&mut self) -> DMatrix<f64> {
        let world = &mut self.world;
        let (multibody, _) = world.multibody_joints.get_mut(self.arm).expect("the joint is never removed");
        // Assembles the matrix for a step of zero length, which drops the implicit damping.
        multibody.dof_inverse_inertia(&world.bodies);
        let factors = multibody.inv_augmented_mass();
        let mut mass = factors.l() * factors.u();
        factors.p().inv_permute_rows(&mut mass);
        mass
    }

    /// The accelerations of all joints in the last substep before contacts, limits, motors and dry
    /// friction, which rapier solves afterwards.
    pub(crate) fn unconstrained_acceleration(&self, qdd: &mut [f64]) {
        qdd.copy_from_slice(self.multibody().generalized_acceleration().as_slice());
    }
}

/// The coordinate of rapier's joint that is free.
pub(crate) fn free_axis(kind: JointKind) -> JointAxis {
    match kind {
        JointKind::Revolute => JointAxis::AngX,
        JointKind::Prismatic => JointAxis::LinX,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{fixtures, solid::hull_thickness};
    use graspcheck_model::dynamics::Dynamics;
    use nalgebra::{DVector, UnitQuaternion, Vector3};
    use rapier3d::{dynamics::RigidBodyBuilder, geometry::SharedShape};

    fn plant(robot: &RobotModel, gravity: Vector3<f64>, dt: f64, substeps: usize) -> Plant {
        let contact = fixtures::execution().contact;
        let settings = PlantSettings { dt, substeps, contact: &contact };
        Plant::new(robot, &fixtures::empty_cell(gravity), None, &settings).unwrap()
    }

    #[test]
    fn bodies_stand_where_the_forward_kinematics_says() {
        for robot in [fixtures::scara(), fixtures::rrr(), fixtures::tilted()] {
            let mut plant = plant(&robot, fixtures::GRAVITY, 1e-3, 1);
            let mut q: Vec<f64> = (0..robot.dof()).map(|k| -0.1 + 0.13 * k as f64).collect();
            let mut expected = robot.forward(&q);
            expected.insert(0, robot.world_from_base);
            for finger in 0..FINGERS {
                expected.push(expected[robot.dof()] * robot.gripper.link_from_finger_at(finger, 0.05));
            }
            q.extend([0.025; FINGERS]);
            plant.set_state(&q, &vec![0.0; q.len()]);
            let mut poses = vec![Pose::identity(); expected.len()];
            plant.read_poses(&mut poses);
            for ((pose, expected), name) in poses.iter().zip(&expected).zip(plant.names()) {
                let off = pose.inverse() * expected;
                assert!(off.translation.vector.norm() < 1e-12, "{name}");
                assert!(off.rotation.angle() < 1e-7, "{name}");
            }
        }
    }

    /// The pairs of bodies of the robot whose colliders rapier holds against each other.
    fn held_against_each_other(robot: &RobotModel) -> Vec<[String; 2]> {
        let plant = plant(robot, fixtures::GRAVITY, 1e-3, 1);
        let groups = |body: usize| {
            let collider = plant.world.bodies[plant.bodies[body]].colliders()[0];
            plant.world.colliders[collider].collision_groups()
        };
        let count = plant.names().len();
        (0..count)
            .flat_map(|a| (a + 1..count).map(move |b| (a, b)))
            .filter(|&(a, b)| groups(a).test(groups(b)))
            .map(|(a, b)| [a, b].map(|body| plant.names()[body].clone()))
            .collect()
    }

    #[test]
    fn exactly_the_allowed_pairs_pass_through_each_other() {
        let mut robot = fixtures::scara();
        let bodies = robot.dof() + 1 + FINGERS;
        let all = held_against_each_other(&robot);
        let dropped: Vec<[&str; 2]> =
            robot.allowed_contacts.iter().map(|pair| [pair.a.as_str(), pair.b.as_str()]).collect();
        assert_eq!(all.len() + dropped.len(), bodies * (bodies - 1) / 2);
        for [a, b] in &all {
            assert!(!dropped.iter().any(|pair| pair.contains(&a.as_str()) && pair.contains(&b.as_str())));
        }
        robot.allowed_contacts.clear();
        assert_eq!(held_against_each_other(&robot).len(), bodies * (bodies - 1) / 2);
    }

    #[test]
    fn a_collider_or_body_that_rapier_takes_out_is_found_whoever_owns_it() {
        let mut plant = plant(&fixtures::scara(), fixtures::GRAVITY, 1e-3, 1);
        plant.step(&());
        assert_eq!(plant.quarantined(), None);
        // A body that the plant has not added itself.
        let body = RigidBodyBuilder::dynamic().additional_mass(1.0).linvel(Vector::new(f64::NAN, 0.0, 0.0));
        plant.world.insert_body(body);
        plant.step(&());
        assert!(plant.quarantined().is_some_and(|name| name.starts_with("number ")));
    }

    #[test]
    fn the_least_width_of_a_hull_is_between_faces_or_between_edges() {
        let width = |points: Vec<[f64; 3]>| {
            let points: Vec<Vector> = points.into_iter().map(|[x, y, z]| Vector::new(x, y, z)).collect();
            hull_thickness(SharedShape::convex_hull(&points).unwrap().as_convex_polyhedron().unwrap())
        };
        let ends = [-1.0, 1.0];
        // A box that is turned about two axes.
        let turn = UnitQuaternion::from_euler_angles(0.4, 0.7, 0.0);
        let corners = ends.iter().flat_map(|x| ends.iter().flat_map(move |y| ends.map(|z| [*x, *y, z])));
        let plate = corners.map(|[x, y, z]| (turn * Vector3::new(0.3 * x, 0.005 * y, 0.2 * z)).into());
        assert!((width(plate.collect()) - 0.01).abs() < 1e-12);
        // A regular tetrahedron with edges of 2 √2: the distance of two opposite edges is 2, its height 2.31.
        let tetrahedron = vec![[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        assert!((width(tetrahedron) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn efforts_act_along_their_joints() {
        let robot = fixtures::tilted();
        let gravity = Vector3::new(1.0, -2.0, -9.0);
        let mut plant = plant(&robot, gravity, 1e-9, 1);
        let (q, qd, effort) = ([0.3, 0.1, -0.8], [0.9, -0.4, 1.3], [35.0, -60.0, 12.0]);
        plant.set_state(&[0.3, 0.1, -0.8, 0.01, 0.01], &[0.9, -0.4, 1.3, 0.0, 0.0]);
        let mass = plant.mass_matrix();
        plant.apply_efforts(&effort);
        plant.step(&());
        let mut acceleration = vec![0.0; 5];
        plant.unconstrained_acceleration(&mut acceleration);
        let inertial = mass * DVector::from_vec(acceleration);
        let mut dynamics = Dynamics::new(&robot, gravity);
        dynamics.set_load(0.02, None);
        let mut bias = [0.0; 3];
        dynamics.inverse(&q, &qd, &[0.0; 3], &mut bias);
        for joint in 0..3 {
            let felt = inertial[joint] + bias[joint] + robot.joints[joint].damping * qd[joint];
            assert!((felt - effort[joint]).abs() < 1e-5, "joint {joint}: {felt} is not {}", effort[joint]);
        }
    }
}
