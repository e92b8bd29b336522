//! Names of branches, reasons for poses out of reach, and distances to singular poses.

use std::f64::consts::{FRAC_PI_2, PI};

use graspcheck_model::{
    Pose,
    chain::SerialChain,
    inverse::{BranchName, InverseKinematics, InverseSolution, Unreachable},
    reach::OutOfReach,
    robot::RobotModel,
    singularity::SingularPose,
    task::Elbow,
};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::arms;

fn inverse(robot: &RobotModel) -> InverseKinematics {
    InverseKinematics::new(robot).expect("a closed form")
}

/// The SCARA's tool pointing down at x, y with its wrist joint free to choose.
fn at(x: f64, y: f64) -> Pose {
    let tool = arms::scara().world_from_tool(&[0.0, 0.0, -0.1, 0.0]);
    Pose::from_parts(Vector3::new(x, y, tool.translation.z).into(), tool.rotation)
}

#[test]
fn every_branch_has_a_name_of_its_own() {
    let robot = arms::scara();
    for (wrist, turns) in [(345.0_f64, 4), (-15.0, 4), (339.0, 3), (1.0, 3), (700.0, 4)] {
        let pose = robot.world_from_tool(&[0.2, 0.7, -0.1, wrist.to_radians()]);
        let legal = inverse(&robot).legal(&pose).expect("within reach");
        let left: Vec<String> =
            legal.iter().filter(|s| s.elbow == Elbow::Left).map(|s| s.name.to_string()).collect();
        assert_eq!(left.len(), turns, "{wrist}°: {left:?}");
        let mut names: Vec<BranchName> = legal.iter().map(|solution| solution.name).collect();
        names.dedup();
        assert_eq!(names.len(), legal.len());
        for solution in &legal {
            assert_eq!((solution.name.elbow, solution.name.last_turn), (solution.elbow, solution.turn));
        }
    }
    // 345° is −15° and three turns more.
    let pose = robot.world_from_tool(&[0.2, 0.7, -0.1, 345.0_f64.to_radians()]);
    let legal = inverse(&robot).legal(&pose).expect("within reach");
    let name = |turn| format!("elbow left, last joint at turn {turn}");
    for (solution, turn) in legal.iter().zip(0..4) {
        assert_eq!(solution.name.to_string(), name(turn));
        assert!((solution.q[3].to_degrees() - (f64::from(turn) * 360.0 - 15.0)).abs() < 1e-9);
    }
    // The shoulder of the planar arm has more than one turn, and its name says which.
    let robot = arms::rrr();
    let pose = robot.world_from_tool(&[200.0_f64.to_radians(), 0.5, 0.1]);
    let names: Vec<String> =
        inverse(&robot).legal(&pose).expect("within reach").iter().map(|s| s.name.to_string()).collect();
    assert!(names.contains(&"elbow left, last joint at turn 0".to_owned()), "{names:?}");
    assert!(names.contains(&"elbow left, shoulder at turn 1, last joint at turn 0".to_owned()), "{names:?}");
}

proptest! {
    #[test]
    fn visiting_and_solving_are_the_same(shares in proptest::array::uniform4(0.0..=1.0_f64), planar in any::<bool>()) {
        let robot = if planar { arms::askew_rrr() } else { arms::askew_scara() };
        let q: Vec<f64> = robot
            .joints
            .iter()
            .zip(shares)
            .map(|(joint, s)| joint.limits.position_min * (1.0 - s) + joint.limits.position_max * s)
            .collect();
        let (pose, inverse) = (robot.world_from_tool(&q), inverse(&robot));
        let mut solutions = inverse.solve(&pose).expect("within reach").into_iter();
        inverse
            .visit(&pose, |name, q| {
                let solution = solutions.next().expect("as many");
                assert_eq!((solution.name, &solution.q[..]), (name, q));
                assert_eq!(solution.is_legal(), inverse.is_within_limits(q));
            })
            .expect("within reach");
        prop_assert!(solutions.next().is_none());
        let legal = inverse.legal(&pose).expect("the positions it was made from are legal");
        prop_assert!(!legal.is_empty() && legal.iter().all(InverseSolution::is_legal));
    }

    /// `√det(Jᵀ J)` of the product of transforms is `l₁ l₂ |sin φ₂|`, whatever the rest of the arm.
    #[test]
    fn the_formula_of_the_determinant_is_that_of_the_jacobian(
        q in proptest::array::uniform4(-PI..PI), which in 0..4_usize,
    ) {
        let robot = [arms::scara, arms::askew_scara, arms::rrr, arms::askew_rrr][which]();
        let q = &q[..robot.dof()];
        let closed = inverse(&robot).singularity(q);
        let dexterity = SerialChain::of(&robot).dexterity(q, 1.0);
        prop_assert!((closed.determinant - dexterity.manipulability).abs() < 1e-12 * 12.0, "{closed} {dexterity:?}");
        prop_assert!(dexterity.singular_values.is_sorted_by(|a, b| a >= b));
        // No joint speed of norm 1 moves the tool less than the least singular value, and one does as little.
        let slowest = (SerialChain::of(&robot).jacobian(q) * &dexterity.idlest).norm();
        prop_assert!((slowest - dexterity.smallest()).abs() < 1e-12);
    }

    #[test]
    fn the_wrist_is_as_far_from_the_singular_circle_as_said(q2 in -PI..PI) {
        let robot = arms::scara();
        let found = inverse(&robot).singularity(&[0.0, q2, 0.0, 0.0]);
        let distance = (0.25 + 0.2 * q2.cos()).hypot(0.2 * q2.sin());
        let expected = match found.nearest {
            SingularPose::Straight => 0.45 - distance,
            SingularPose::Folded => distance - 0.05,
        };
        prop_assert!((found.wrist_distance - expected).abs() < 1e-15 && found.wrist_distance >= 0.0, "{found}");
        prop_assert!((0.0..=FRAC_PI_2).contains(&found.angle));
    }
}

#[test]
fn the_nearer_singular_pose_is_named() {
    let robot = inverse(&arms::rrr());
    let straight = robot.singularity(&[1.0, 0.01, 0.5]);
    assert_eq!(straight.nearest, SingularPose::Straight);
    // 4 · 3 · 0.01² / (2 · 7) to first order.
    assert!((straight.wrist_distance - 12.0 * 1e-4 / 14.0).abs() < 1e-9, "{straight:?}");
    let folded = robot.singularity(&[1.0, 3.0, 0.5]);
    assert_eq!(folded.nearest, SingularPose::Folded);
    assert!((folded.angle - (PI - 3.0)).abs() < 1e-15);
    assert!(folded.to_string().starts_with("elbow 0.141593 rad from folded, wrist "), "{folded}");
    let best = robot.singularity(&[0.0, FRAC_PI_2, 0.0]);
    assert!((best.determinant - 12.0).abs() < 1e-14);
    // Folded onto itself, two equal links have the wrist on axis 1.
    let mut equal = arms::scara();
    equal.joints[2].parent_from_joint = arms::pose([0.25, 0.0, 0.0], [0.0; 3]);
    let folded = inverse(&equal).singularity(&[0.0, PI, 0.0, 0.0]);
    assert!(folded.wrist_distance.abs() < 1e-15 && folded.angle.abs() < 1e-15, "{folded:?}");
}

#[test]
fn a_chain_without_closed_form_has_its_singular_poses_found() {
    let chain = SerialChain::of(&arms::six());
    let at = |q5: f64| [0.1, 0.2, 0.8, 0.3, q5, 0.4];
    let determinant = |q5: f64| chain.jacobian(&at(q5)).fixed_view::<6, 6>(0, 0).determinant();
    // With the wrist bent one way and the other the determinant has opposite signs; half-way tests find where it
    // changes.
    let [mut low, mut high] = [-1.2, 1.2];
    assert!(determinant(low) * determinant(high) < 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if determinant(low) * determinant(middle) <= 0.0 { high = middle } else { low = middle }
    }
    let (good, singular) = (chain.dexterity(&at(1.2), 1.0), chain.dexterity(&at(low), 1.0));
    assert_eq!(good.singular_values.len(), 6);
    assert!(good.smallest() > 0.02 && singular.smallest() < 1e-14, "{good:?} {singular:?}");
    assert!((good.manipulability - determinant(1.2).abs()).abs() < 1e-15);
    // The hardest direction of the tool is one in which no joint moves it.
    let moved = chain.jacobian(&at(low)).tr_mul(&singular.hardest);
    assert!(moved.amax() < 1e-14, "{moved}");
}

#[test]
fn a_pose_out_of_reach_names_the_bound_and_what_is_lacking() {
    let scara = inverse(&arms::scara());
    // In the hole of 0.229129 m that 120° of the elbow leave, though the links could fold to 0.05 m.
    let error = scara.legal(&at(0.2, 0.0)).expect_err("in the hole");
    let OutOfReach::InsideElbowLimit { hole, limit, shortfall, .. } = &error else { panic!("{error}") };
    assert!((hole - 0.229_128_784_747_792).abs() < 1e-15 && (shortfall - (hole - 0.2)).abs() < 1e-15);
    assert!((limit.abs() - 120.0_f64.to_radians()).abs() < 1e-15);
    assert!(error.to_string().starts_with(
        "wrist: 0.200000 m from axis 1 is inside the hole of radius 0.229129 m that joint elbow leaves at its limit of "
    ), "{error}");
    assert!(
        error.to_string().ends_with(" rad, by 0.029129 m: move the pose outwards or widen the limit"),
        "{error}"
    );
    // Just outside the hole it is reached, just inside not.
    assert!(scara.legal(&at(0.2292, 0.0)).is_ok() && scara.legal(&at(0.2291, 0.0)).is_err());
    // Where no limit is in the way the links are.
    assert!(matches!(scara.legal(&at(0.02, 0.0)), Err(OutOfReach::Whatever(Unreachable::TooNear { .. }))));
    assert!(matches!(scara.legal(&at(0.5, 0.0)), Err(OutOfReach::Whatever(Unreachable::TooFar { .. }))));
    assert_eq!(scara.legal(&at(f64::NAN, 0.0)), Err(OutOfReach::Whatever(Unreachable::NotFinite)));
    // Behind the arm: 85° of the shoulder do not reach (−0.3, 0).
    let error = scara.legal(&at(-0.3, 0.0)).expect_err("behind");
    let OutOfReach::JointLimit { joint, violation, .. } = &error else { panic!("{error}") };
    assert_eq!((joint.as_str(), violation.joint), ("shoulder", 0));
    assert!(error.to_string().contains("even on the nearest branch (elbow "), "{error}");
    // An elbow that cannot be stretched has a reach below the sum of the links.
    let mut bent = arms::scara();
    bent.joints[1].limits.position_min = 1.0;
    let error = inverse(&bent).legal(&at(0.44, 0.0)).expect_err("too far for a bent elbow");
    let OutOfReach::BeyondElbowLimit { reach, excess, limit, .. } = &error else { panic!("{error}") };
    let expected = (0.25 + 0.2 * 1.0_f64.cos()).hypot(0.2 * 1.0_f64.sin());
    assert!((reach - expected).abs() < 1e-15 && (excess - (0.44 - expected)).abs() < 1e-15);
    assert!((limit - 1.0).abs() < 1e-15);
}

/// Section 7 of the worked examples: l₁ = 4, l₂ = 3, the line y = 1 touches the circle of the folded arm.
#[test]
fn a_line_that_touches_the_inner_circle_folds_the_arm_in_one_point_and_changes_its_branch() {
    let robot = arms::rrr();
    let inverse = inverse(&robot);
    // Wrist at (x, 1); the hand points along x.
    let pose = |x: f64| {
        Pose::from_parts(Vector3::new(x + 1.0, 1.0, 0.0).into(), nalgebra::UnitQuaternion::identity())
    };
    for x in [-3.0, -1.0, -0.1, 0.0, 0.5, 2.0] {
        for solution in inverse.solve(&pose(x)).expect("on or outside the circle") {
            assert!((solution.q[1].cos() - (-1.0 + x * x / 24.0)).abs() < 1e-12, "{solution:?}");
        }
    }
    let folded = inverse.singularity(&inverse.solve(&pose(0.0)).expect("on the circle")[0].q);
    assert_eq!(folded.nearest, SingularPose::Folded);
    assert!(folded.angle < 1e-6 && folded.wrist_distance < 1e-12, "{folded}");
    // The elbow passes π with 1/√12 rad/m: left of the middle on one branch, right of it on the other.
    let elbow = |x: f64, side: Elbow| {
        let mut q = [0.0; 3];
        inverse.solve_near(&pose(x), side, &[0.0, PI, 0.0], &mut q).expect("outside the circle");
        q[1]
    };
    let step = 1e-3;
    let slope = (elbow(step, Elbow::Right) - elbow(-step, Elbow::Left)) / (2.0 * step);
    assert!((slope - 1.0 / 12.0_f64.sqrt()).abs() < 1e-6, "{slope}");
}
