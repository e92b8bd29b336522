//! Paths of the tool on both arms: where they lead, how the joints follow with all derivatives, what is proved
//! about the motion, and the three ways to fail of the worked examples, section 7, with exact numbers.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::robots::{pose, rrr, scara};
use graspcheck_model::{Pose, inverse::Unreachable, planar_path::PlanarPath, robot::RobotModel, task::Elbow};
use graspcheck_motion::{Polynomial, Trajectory};
use graspcheck_planner::{
    branch::BranchFault,
    path::{
        FollowedPath, JointLine, Path, PathError, PathMotion, ToolPath, along,
        arc::{ArcTurn, arc_about, arc_through},
        followed::FollowError,
        line::{straight_line, straight_line_turning},
        motion::{AlongError, PATH_TOLERANCE},
        rounded_polyline::{Corner, rounded_polyline},
        screw::screw_motion,
        spline::{through_coordinates, through_poses},
    },
};
use graspcheck_proof::deviation::{Deviation, DeviationError, DeviationOutcome, prove_deviation};
use nalgebra::{UnitQuaternion, Vector3};

/// Pose of the SCARA's tool, pointing down, with its wrist at (x, y), turned by `yaw`.
fn down(x: f64, y: f64, z: f64, yaw: f64) -> Pose {
    pose([x, y, z], [0.0, 0.0, yaw]) * pose([0.0; 3], [0.0, FRAC_PI_2, 0.0])
}

/// Joint positions at the beginning of a path, on an elbow's branch, in the middle of the turns that are legal.
fn start_of(robot: &RobotModel, path: &ToolPath, elbow: Elbow) -> Vec<f64> {
    let solutions = robot.inverse(&path.pose(path.start())).unwrap();
    let mut legal: Vec<Vec<f64>> =
        solutions.into_iter().filter(|s| s.elbow == elbow && s.is_legal()).map(|s| s.q).collect();
    let size = |q: &[f64]| q[..2].iter().map(|q| q.abs()).fold(0.0, f64::max);
    legal.sort_by(|a, b| size(a).total_cmp(&size(b)));
    let least = size(&legal[0]);
    legal.retain(|q| size(q) - least < 1e-9);
    legal.swap_remove(legal.len() / 2)
}

/// Paths of every kind for the SCARA, with joint positions at their beginning.
fn scara_paths() -> Vec<(&'static str, ToolPath)> {
    let start = down(0.32, -0.1, 0.2, 0.3);
    let end = down(0.28, 0.12, 0.15, 1.4);
    let vertices = [start, down(0.36, 0.05, 0.2, 0.3), down(0.25, 0.2, 0.2, 1.0), end];
    let spline = Trajectory::new(
        4,
        vec![0.0, 1.0, 3.0],
        vec![
            Polynomial::new([0.3, 0.04, 0.0, -0.02]),
            Polynomial::new([-0.1, 0.1]),
            Polynomial::new([0.2, 0.0, -0.03]),
            Polynomial::new([0.0, 0.5, 0.0, 0.1]),
            Polynomial::new([0.32, -0.02, -0.06, 0.02]),
            Polynomial::new([0.0, 0.1]),
            Polynomial::new([0.17, -0.06, -0.03, 0.02]),
            Polynomial::new([0.6, 0.8, 0.3, -0.1]),
        ],
    );
    let pointing_down = pose([0.0; 3], [0.0, FRAC_PI_2, 0.0]).rotation;
    let through = Vector3::new(0.36, 0.0, 0.2);
    vec![
        ("line", straight_line(&start, &end).unwrap()),
        ("line of a turn", straight_line_turning(&start, &end, &Vector3::z_axis(), 1.1 - TAU).unwrap()),
        ("screw", screw_motion(&start, &end).unwrap()),
        ("arc", arc_through(&start, &through, &end.translation.vector, ArcTurn::To(end.rotation)).unwrap()),
        (
            "arc about a center",
            arc_about(&start, &Vector3::new(0.3, 0.0, 0.0), &Vector3::z_axis(), 3.0, ArcTurn::Along).unwrap(),
        ),
        ("blends", rounded_polyline(&vertices, Corner::Blend { tolerance: 0.004 }).unwrap()),
        ("arcs", rounded_polyline(&vertices, Corner::ArcWithin { tolerance: 0.004 }).unwrap()),
        ("sharp", rounded_polyline(&vertices, Corner::Sharp).unwrap()),
        ("spline", through_coordinates(&spline.unwrap(), &pointing_down, &Vector3::z_axis()).unwrap()),
        ("spline of poses", through_poses(&vertices).unwrap()),
    ]
}

/// Paths of every kind for the R-R-R.
fn rrr_paths() -> Vec<(&'static str, ToolPath)> {
    let start = pose([5.0, -1.0, 0.0], [0.0, 0.0, -0.4]);
    let end = pose([4.0, 3.0, 0.0], [0.0, 0.0, 0.9]);
    let vertices = [start, pose([6.0, 1.0, 0.0], [0.0; 3]), end];
    let through = Vector3::new(6.2, 0.8, 0.0);
    vec![
        ("line", straight_line(&start, &end).unwrap()),
        ("screw", screw_motion(&start, &end).unwrap()),
        ("arc", arc_through(&start, &through, &end.translation.vector, ArcTurn::Fixed).unwrap()),
        ("blends", rounded_polyline(&vertices, Corner::Blend { tolerance: 0.05 }).unwrap()),
        ("arcs", rounded_polyline(&vertices, Corner::Arc { radius: 0.3 }).unwrap()),
        ("spline of poses", through_poses(&vertices).unwrap()),
    ]
}

/// Every path with its arm.
fn all_paths() -> Vec<(String, RobotModel, ToolPath)> {
    let named = |robot: RobotModel, paths: Vec<(&str, ToolPath)>| {
        let name = robot.name.clone();
        paths
            .into_iter()
            .map(move |(kind, path)| (format!("{name} {kind}"), robot.clone(), path))
            .collect::<Vec<_>>()
    };
    let mut base_moved = scara();
    base_moved.name = "turned scara".to_owned();
    base_moved.world_from_base = pose([0.4, -0.2, 0.1], [0.3, -0.8, 2.1]);
    let world_from_base = base_moved.world_from_base;
    let moved = vec![(
        "line",
        straight_line(
            &(world_from_base * down(0.32, -0.1, 0.2, 0.3)),
            &(world_from_base * down(0.28, 0.12, 0.15, 1.4)),
        )
        .unwrap(),
    )];
    [named(scara(), scara_paths()), named(rrr(), rrr_paths()), named(base_moved, moved)].concat()
}

#[test]
fn followed_paths_lead_where_the_path_does_with_consistent_derivatives() {
    for (name, robot, path) in all_paths() {
        let from = start_of(&robot, &path, Elbow::Left);
        let followed = FollowedPath::new(&robot, &path, &from).unwrap();
        let [start, end] = followed.range();
        let step = 1e-5 * (end - start);
        let corners: Vec<f64> = path.junctions().iter().map(|junction| junction.s).collect();
        for k in 0..=60 {
            let s = start + (end - start) * f64::from(k) / 60.0;
            let here = followed.eval(s);
            let (tool, wanted) = (robot.world_from_tool(&here.q), path.pose(s));
            assert!((tool.translation.vector - wanted.translation.vector).norm() < 1e-12, "{name} at {s}");
            assert!(tool.rotation.angle_to(&wanted.rotation) < 1e-7, "{name} at {s}");
            if s < start + step
                || s > end - step
                || corners.iter().any(|corner| (corner - s).abs() < 2.0 * step)
            {
                continue;
            }
            let (before, after) = (followed.eval(s - step), followed.eval(s + step));
            for joint in 0..robot.dof() {
                let slope = |of: &dyn Fn(usize) -> (f64, f64)| {
                    let (low, high) = of(joint);
                    (high - low) / (2.0 * step)
                };
                for (found, expected) in [
                    (here.q_s[joint], slope(&|j| (before.q[j], after.q[j]))),
                    (here.q_ss[joint], slope(&|j| (before.q_s[j], after.q_s[j]))),
                    (here.q_sss[joint], slope(&|j| (before.q_ss[j], after.q_ss[j]))),
                ] {
                    let scale = 1.0 + found.abs();
                    assert!(
                        (found - expected).abs() < 1e-5 * scale,
                        "{name} at {s}: {found} is not {expected}"
                    );
                }
            }
        }
    }
}

/// Largest distance and angle between the tool and where the law wants it on the path, sampled densely.
fn sampled(robot: &RobotModel, path: &ToolPath, found: &PathMotion) -> Deviation {
    let samples = 60 * found.motion.piece_count();
    let mut worst = Deviation::default();
    for k in 0..=samples {
        let t = (found.motion.duration() * k as f64 / samples as f64).min(found.motion.duration());
        let tool = robot.world_from_tool(&found.motion.eval(t).q);
        let wanted = path.pose(found.law.eval(t).q[0].clamp(path.start(), path.end()));
        worst = worst.max(Deviation {
            position: (tool.translation.vector - wanted.translation.vector).norm(),
            angle: tool.rotation.angle_to(&wanted.rotation),
        });
    }
    worst
}

#[test]
fn motions_along_paths_are_proved_and_the_proof_is_near_the_truth() {
    for (name, robot, path) in all_paths() {
        let from = start_of(&robot, &path, Elbow::Left);
        let found = along(&robot, &path, &from, 0.8, None, PATH_TOLERANCE).unwrap();
        let (bound, seen) = (found.deviation(), sampled(&robot, &path, &found));
        println!(
            "{name}: {} pieces, {:.3e} m of {:.3e} m",
            found.motion.piece_count(),
            seen.position,
            bound.position
        );
        assert!(bound.is_within(PATH_TOLERANCE));
        assert!(seen.position <= bound.position, "{name}: {seen:?} beyond {bound:?}");
        assert!(seen.angle <= bound.angle.max(1e-7), "{name}: {seen:?} beyond {bound:?}");
        assert!(bound.position <= 3.0 * seen.position + 1e-11, "{name}: {bound:?} far beyond {seen:?}");
        // It moves smoothly, and stops only where the path has a corner or a step of curvature.
        assert!(found.motion.breaks().is_empty(), "{name}: {:?}", found.motion.breaks());
        let stops = path.junctions().iter().filter(|junction| junction.class < 2).count();
        let rests = (1..found.motion.piece_count())
            .filter(|&piece| {
                found.motion.eval(found.motion.knots()[piece]).qd.iter().all(|qd| qd.abs() < 1e-9)
            })
            .count();
        assert_eq!(rests, stops, "{name}");
        let mut used: f64 = 0.0;
        for (joint, limits) in robot.joints.iter().map(|joint| joint.limits).enumerate() {
            for (order, limit) in [(1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)] {
                used = used.max(found.motion.peak(joint, order).value.abs() / (0.8 * limit));
            }
        }
        assert!(used <= 1.0 + 1e-12 && used > 1.0 - 1e-8, "{name}: uses {used}");
        // Whoever has path, law and motion proves the same.
        let planar = PlanarPath::new(&robot, &path).unwrap();
        let again = prove_deviation(&planar, &found.law, &found.motion, PATH_TOLERANCE).unwrap();
        assert_eq!(again.bound(), Some(bound), "{name}");
    }
}

/// The SCARA's line of 0.1 m.
fn short_line() -> (RobotModel, ToolPath, PathMotion) {
    let robot = scara();
    let path = straight_line(&down(0.32, -0.05, 0.2, 0.3), &down(0.32, 0.05, 0.2, 0.3)).unwrap();
    let from = start_of(&robot, &path, Elbow::Left);
    let found = along(&robot, &path, &from, 1.0, None, PATH_TOLERANCE).unwrap();
    (robot, path, found)
}

#[test]
fn a_sabotaged_piece_is_refuted_at_an_instant_that_proves_it() {
    let (robot, path, found) = short_line();
    let planar = PlanarPath::new(&robot, &path).unwrap();
    let PathMotion { motion, law, .. } = &found;
    for piece in 0..motion.piece_count() {
        for joint in 0..robot.dof() {
            // A bump in the middle of one piece of one joint that no knot shows: b τ³ (h − τ)³.
            let duration = motion.knots()[piece + 1] - motion.knots()[piece];
            let mut pieces: Vec<Polynomial> =
                (0..motion.piece_count()).flat_map(|k| motion.piece_of_all(k).to_vec()).collect();
            let bump = 2e-4 / (0.5 * duration).powi(6);
            let mut c = *pieces[piece * robot.dof() + joint].coefficients();
            for (power, factor) in
                [(3, duration.powi(3)), (4, -3.0 * duration.powi(2)), (5, 3.0 * duration), (6, -1.0)]
            {
                c[power] += bump * factor;
            }
            pieces[piece * robot.dof() + joint] = Polynomial::new(c);
            let sabotaged = Trajectory::new(robot.dof(), motion.knots().to_vec(), pieces).unwrap();
            let outcome = prove_deviation(&planar, law, &sabotaged, PATH_TOLERANCE).unwrap();
            let DeviationOutcome::Exceeds { at, deviation } = outcome else { panic!("{outcome:?}") };
            let tool = robot.world_from_tool(&sabotaged.eval(at).q);
            let wanted = path.pose(law.eval(at).q[0]);
            let distance = (tool.translation.vector - wanted.translation.vector).norm();
            let angle = tool.rotation.angle_to(&wanted.rotation);
            assert!(distance > 1e-5 || angle > 1e-5, "piece {piece}, joint {joint}: {distance}, {angle}");
            assert!(distance >= deviation.position && angle + 1e-7 >= deviation.angle);
        }
    }
}

#[test]
fn a_law_of_another_motion_is_refuted_or_refused() {
    let (robot, path, found) = short_line();
    let planar = PlanarPath::new(&robot, &path).unwrap();
    let reversed = straight_line(&path.pose(1.0), &path.pose(0.0)).unwrap();
    let wrong_way = PlanarPath::new(&robot, &reversed).unwrap();
    let outcome = prove_deviation(&wrong_way, &found.law, &found.motion, PATH_TOLERANCE).unwrap();
    assert!(matches!(outcome, DeviationOutcome::Exceeds { .. }), "{outcome:?}");
    let short = Trajectory::new(1, vec![0.0, 0.1], vec![Polynomial::constant(0.0)]).unwrap();
    let error = prove_deviation(&planar, &short, &found.motion, PATH_TOLERANCE).unwrap_err();
    assert!(matches!(error, DeviationError::Duration { .. }), "{error}");
    let error = prove_deviation(&planar, &found.motion, &found.motion, PATH_TOLERANCE).unwrap_err();
    assert_eq!(error, DeviationError::LawCount { count: 4 });
    let error = prove_deviation(&planar, &found.law, &found.law, PATH_TOLERANCE).unwrap_err();
    assert_eq!(error, DeviationError::JointCount { motion: 1, path: 4 });
    // A tolerance below the deviation that there is: neither proved nor refuted in vain, but refuted.
    let tight = Deviation { position: 0.5 * sampled(&robot, &path, &found).position, angle: 1e-5 };
    let outcome = prove_deviation(&planar, &found.law, &found.motion, tight).unwrap();
    assert!(matches!(outcome, DeviationOutcome::Exceeds { .. }), "{outcome:?}");
}

#[test]
fn a_tighter_tolerance_is_met_by_more_pieces() {
    let (robot, path, found) = short_line();
    let from = start_of(&robot, &path, Elbow::Left);
    let tight = Deviation { position: 1e-9, angle: 1e-9 };
    let fine = along(&robot, &path, &from, 1.0, None, tight).unwrap();
    assert!(fine.deviation().is_within(tight));
    assert!(fine.motion.piece_count() > found.motion.piece_count());
}

#[test]
fn turns_are_literal_and_the_wrist_makes_them_all() {
    let robot = scara();
    let (start, end) = (down(0.32, -0.05, 0.2, 0.3), down(0.32, 0.05, 0.2, 0.3));
    for turns in [-1.0, 1.0, 2.0] {
        let path = straight_line_turning(&start, &end, &Vector3::z_axis(), turns * TAU).unwrap();
        let solutions = robot.inverse(&start).unwrap();
        // In the middle of its range there is room for a turn either way; two turns on need the lowest.
        let turn = if turns > 1.5 { 0 } else { 1 };
        let from = solutions.iter().filter(|s| s.elbow == Elbow::Left && s.is_legal()).nth(turn).unwrap();
        let found = along(&robot, &path, &from.q, 1.0, None, PATH_TOLERANCE).unwrap();
        let at_end = found.motion.eval(found.motion.duration()).q;
        let psi = |q: &[f64]| q[0] + q[1] + q[3];
        assert!((psi(&at_end) - psi(&from.q) - turns * TAU).abs() < 1e-9, "{turns}");
    }
    // Three turns do not fit into 1100°, whatever the start; a turn fewer would.
    let path = straight_line_turning(&start, &end, &Vector3::z_axis(), 4.0 * TAU).unwrap();
    let from = start_of(&robot, &path, Elbow::Left);
    let error = FollowedPath::new(&robot, &path, &from).unwrap_err();
    let FollowError::Branch { at, fault: BranchFault::OtherBranch { joint, same_elbow: true, .. } } = error
    else {
        panic!("{error}")
    };
    assert_eq!(joint, "wrist");
    assert!(at > 0.2 && at < 1.0, "{at}");
}

#[test]
fn in_the_plane_an_angle_is_the_shortest_or_literal() {
    let start = pose([5.0, -1.0, 0.0], [0.0, 0.0, 0.0]);
    let end = pose([5.0, 1.0, 0.0], [0.0, 0.0, -FRAC_PI_2]);
    let shortest = straight_line(&start, &end).unwrap();
    assert!((shortest.eval(0.5).derivatives[0][5] + FRAC_PI_2).abs() < 1e-12);
    let literal = straight_line_turning(&start, &end, &Vector3::z_axis(), 1.5 * PI).unwrap();
    assert!((literal.eval(0.5).derivatives[0][5] - 1.5 * PI).abs() < 1e-15);
    let error = straight_line_turning(&start, &end, &Vector3::z_axis(), 1.4 * PI).unwrap_err();
    let PathError::WrongAngle { miss, nearest, .. } = error else { panic!("{error}") };
    assert!((miss - 0.1 * PI).abs() < 1e-12 && (nearest - 1.5 * PI).abs() < 1e-12);
    let error = straight_line_turning(&start, &end, &Vector3::x_axis(), 0.0).unwrap_err();
    assert!(matches!(error, PathError::NotInPlane { .. }), "{error}");
}

// The three ways to fail, and the exception.

fn fault(robot: &RobotModel, path: &ToolPath, elbow: Elbow) -> (f64, BranchFault) {
    let error = FollowedPath::new(robot, path, &start_of(robot, path, elbow)).unwrap_err();
    let FollowError::Branch { at, fault } = error else { unreachable!("not a fault of the branch: {error}") };
    (at, fault)
}

#[test]
fn the_hole_of_a_scara_is_that_of_its_elbow_limit() {
    // At |q2| = 120° the wrist is √0.0525 = 0.229129 m from the axis. The line x = 0.22 enters that circle at
    // y = -√(0.0525 - 0.0484) = -0.064031.
    let path = straight_line(&down(0.22, -0.3, 0.2, 0.0), &down(0.22, 0.3, 0.2, 0.0)).unwrap();
    let (at, fault) = fault(&scara(), &path, Elbow::Right);
    let BranchFault::Limit { joint, value, limit, hole, .. } = fault else { panic!("{fault}") };
    assert_eq!(joint, "elbow");
    assert!((hole.unwrap() - 0.0525_f64.sqrt()).abs() < 1e-12, "{hole:?}");
    assert!((limit + 120.0_f64.to_radians()).abs() < 1e-12);
    assert!((at - (0.3 - 0.0041_f64.sqrt()) / 0.6).abs() < 1e-9, "{at}");
    // The nearest that it comes is 0.22 m: cos q2 = (0.0484 - 0.0625 - 0.04) / 0.1.
    assert!((value + (-0.541_f64).acos()).abs() < 1e-9, "{value}");
}

#[test]
fn an_arc_that_leaves_the_reach_for_a_moment_is_caught() {
    // A circle about (0.3, 0) whose farthest point is 1 µm beyond the outer reach of 0.45 m: out of reach for
    // 0.4 % of its way, which samples would miss.
    let radius = 0.150_001;
    let path = arc_about(
        &down(0.3, -radius, 0.2, 0.0),
        &Vector3::new(0.3, 0.0, 0.2),
        &Vector3::z_axis(),
        PI,
        ArcTurn::Fixed,
    )
    .unwrap();
    let (at, fault) = fault(&scara(), &path, Elbow::Left);
    let BranchFault::OutOfReach { until, bound: Unreachable::TooFar { reach, excess, .. } } = fault else {
        panic!("{fault}")
    };
    assert!((reach - 0.45).abs() < 1e-12 && (excess - 1e-6).abs() < 1e-9, "{excess}");
    // r² = 0.09 + ρ² + 0.6 ρ cos(θ) = 0.2025.
    let half = ((0.2025 - 0.09 - radius * radius) / (0.6 * radius)).acos() / PI;
    assert!((at - (0.5 - half)).abs() < 1e-8 && (until - (0.5 + half)).abs() < 1e-8, "{at} to {until}");
}

#[test]
fn an_end_that_is_on_the_other_branch_is_named() {
    let at = |angle: f64| down(0.4 * angle.to_radians().cos(), 0.4 * angle.to_radians().sin(), 0.2, 0.0);
    let path = straight_line(&at(20.0), &at(-65.0)).unwrap();
    let (place, fault) = fault(&scara(), &path, Elbow::Left);
    let BranchFault::OtherBranch { joint, limit, elbow, same_elbow, .. } = fault else { panic!("{fault}") };
    assert_eq!((joint.as_str(), elbow, same_elbow), ("shoulder", Elbow::Right, false));
    assert!((limit + 85.0_f64.to_radians()).abs() < 1e-12 && place > 0.7 && place < 0.8, "{place}");
    // From the other elbow the same line can be followed.
    assert!(FollowedPath::new(&scara(), &path, &start_of(&scara(), &path, Elbow::Right)).is_ok());
}

/// The R-R-R with an elbow that can fold right over and a wrist that turns freely.
fn free_rrr() -> RobotModel {
    let mut robot = rrr();
    for joint in &mut robot.joints {
        joint.limits.position_min = -3.0 * PI;
        joint.limits.position_max = 3.0 * PI;
    }
    robot
}

/// A line of the wrist along x at height y, from x = -3 to 3.
fn wrist_line(y: f64) -> ToolPath {
    straight_line(&pose([-2.0, y, 0.0], [0.0; 3]), &pose([4.0, y, 0.0], [0.0; 3])).unwrap()
}

#[test]
fn passing_near_the_singular_circle_names_what_it_would_take() {
    let y = 1.002;
    let (at, fault) = fault(&free_rrr(), &wrist_line(y), Elbow::Left);
    let BranchFault::NearSingular { sine, demand, .. } = fault else { panic!("{fault}") };
    let cos = (y * y - 25.0) / 24.0;
    let expected = (1.0 - cos * cos).sqrt();
    assert!((sine - expected).abs() < 1e-9 && (at - 0.5).abs() < 1e-6, "{sine} at {at}");
    // At x = 0 the elbow has no slope but q2'' = -(1/12) / sin q2; the share of it that the angle between arm
    // and wrist takes is l2 (l2 + l1 cos q2) / r², and the last joint keeps the sum.
    let share = 3.0 * (3.0 + 4.0 * cos) / (y * y);
    let bend = (1.0 - share) / 12.0 / expected;
    assert!((demand.bend - bend).abs() < 1e-3 * bend, "{} is not {bend}", demand.bend);
    assert!((demand.slope - 1.0 / y).abs() < 1e-4, "the shoulder turns about the base: {}", demand.slope);
}

#[test]
fn outwards_along_a_ray_the_elbow_would_have_to_be_fast() {
    let path = straight_line(&pose([6.0, 0.0, 0.0], [0.0; 3]), &pose([7.998, 0.0, 0.0], [0.0; 3])).unwrap();
    let (at, fault) = fault(&free_rrr(), &path, Elbow::Left);
    let BranchFault::NearSingular { sine, demand, .. } = fault else { panic!("{fault}") };
    // cos q2 = (r² - 25)/24, so that q2' = -(r/12) / sin q2 at r = 6.998.
    let cos: f64 = (6.998 * 6.998 - 25.0) / 24.0;
    let expected = (1.0 - cos * cos).sqrt();
    assert!((at - 1.0).abs() < 1e-9 && (sine - expected).abs() < 1e-9);
    let slope = 6.998 / 12.0 / expected;
    assert_eq!(demand.fastest, "elbow");
    assert!((demand.slope - slope).abs() < 1e-6 * slope, "{} is not {slope}", demand.slope);
    assert!((demand.speed - 1.5 / slope).abs() < 1e-6, "{}", demand.speed);
}

#[test]
fn touching_the_singular_circle_is_a_branch_change_of_finite_speed() {
    for elbow in [Elbow::Left, Elbow::Right] {
        let (at, fault) = fault(&free_rrr(), &wrist_line(1.0), elbow);
        let BranchFault::BranchChange { slope } = fault else { panic!("{fault}") };
        assert!((slope - 1.0 / 12.0_f64.sqrt()).abs() < 1e-9, "{slope}");
        assert!((at - 0.5).abs() < 1e-7, "{at}");
    }
    // Touching the outer circle from inside, on an arc about (3.5, 0): r is 7 in its farthest point alone. With
    // θ the angle on it, r² = 24.5 + 24.5 cos θ and cos q2 = 1 - 49 θ²/96 + …, so that q2' = √(49/48) rad for
    // each rad, and by the way 3.5 m for each rad.
    let path = arc_about(
        &pose([4.5, -3.5, 0.0], [0.0; 3]),
        &Vector3::new(4.5, 0.0, 0.0),
        &Vector3::z_axis(),
        PI,
        ArcTurn::Fixed,
    )
    .unwrap();
    let (at, fault) = fault(&free_rrr(), &path, Elbow::Left);
    let BranchFault::BranchChange { slope } = fault else { panic!("{fault}") };
    assert!((slope - (49.0 / 48.0_f64).sqrt() / 3.5).abs() < 1e-7, "{slope}");
    assert!((at - 0.5).abs() < 1e-6);
}

#[test]
fn poses_that_the_arm_cannot_take_are_named() {
    let robot = scara();
    let from = down(0.32, 0.0, 0.2, 0.0);
    let tilted = from * pose([0.0; 3], [0.0, 0.2, 0.0]);
    let path = straight_line(&from, &tilted).unwrap();
    let (_, found) = fault(&robot, &path, Elbow::Left);
    assert!(matches!(found, BranchFault::OutOfReach { bound: Unreachable::Tilted { .. }, .. }), "{found}");
    let path = straight_line(&pose([5.0, 1.0, 0.0], [0.0; 3]), &pose([5.0, 2.0, 0.3], [0.0; 3])).unwrap();
    let (_, found) = fault(&rrr(), &path, Elbow::Left);
    assert!(
        matches!(found, BranchFault::OutOfReach { bound: Unreachable::OutOfPlane { .. }, .. }),
        "{found}"
    );
}

#[test]
fn where_a_path_begins_matters() {
    let robot = scara();
    let path = straight_line(&down(0.32, -0.05, 0.2, 0.3), &down(0.32, 0.05, 0.2, 0.3)).unwrap();
    let error = FollowedPath::new(&robot, &path, &[0.0, 1.0, 0.0, 0.0]).unwrap_err();
    assert!(matches!(error, FollowError::NotAtStart { .. }), "{error}");
    let error = FollowedPath::new(&robot, &path, &[f64::NAN; 4]).unwrap_err();
    assert!(matches!(error, FollowError::NotAtStart { .. }), "{error}");
    let error = FollowedPath::new(&robot, &path, &[0.0; 3]).unwrap_err();
    assert_eq!(error, FollowError::JointCount { count: 3, dof: 4 });
}

#[test]
fn bad_numbers_are_errors() {
    let [a, b] = [down(0.3, 0.0, 0.2, 0.0), down(0.3, 0.1, 0.2, 0.0)];
    let nan = down(f64::NAN, 0.0, 0.0, 0.0);
    for error in [straight_line(&a, &nan).unwrap_err(), screw_motion(&nan, &a).unwrap_err()] {
        assert!(matches!(error, PathError::NotFinite { .. }), "{error}");
    }
    for error in [straight_line(&a, &a).unwrap_err(), screw_motion(&a, &a).unwrap_err()] {
        assert!(matches!(error, PathError::NoLength { .. }), "{error}");
    }
    let [p, q] = [b.translation.vector, b.translation.vector + Vector3::new(0.0, 0.1, 0.0)];
    let error = arc_through(&a, &p, &q, ArcTurn::Fixed).unwrap_err();
    assert!(matches!(error, PathError::Collinear { .. }), "{error}");
    // The height that it says is enough, and a little less is not.
    let PathError::Collinear { needed, .. } = error else { unreachable!() };
    let off = |height: f64| arc_through(&a, &(p + Vector3::x() * height), &q, ArcTurn::Fixed);
    assert!(off(1.01 * needed).is_ok() && off(0.99 * needed).is_err());
    assert!(matches!(
        arc_through(&a, &a.translation.vector, &q, ArcTurn::Fixed),
        Err(PathError::Collinear { .. })
    ));
    let on_axis = arc_about(&a, &a.translation.vector, &Vector3::z_axis(), 1.0, ArcTurn::Fixed);
    assert!(matches!(on_axis, Err(PathError::BadNumber { .. })), "{on_axis:?}");
    let still = arc_about(&a, &Vector3::zeros(), &Vector3::z_axis(), 0.0, ArcTurn::Fixed);
    assert!(matches!(still, Err(PathError::NoLength { .. })), "{still:?}");
    let infinite = arc_about(&a, &Vector3::zeros(), &Vector3::z_axis(), f64::INFINITY, ArcTurn::Fixed);
    assert!(matches!(infinite, Err(PathError::NotFinite { .. })), "{infinite:?}");
    assert!(JointLine::new(&[0.0], &[f64::NAN]).is_err() && JointLine::new(&[0.0], &[]).is_err());

    let robot = scara();
    let path = straight_line(&a, &b).unwrap();
    let from = start_of(&robot, &path, Elbow::Left);
    for share in [0.0, -1.0, 1.1, f64::NAN] {
        let error = along(&robot, &path, &from, share, None, PATH_TOLERANCE).unwrap_err();
        assert!(matches!(error, AlongError::BadNumber { quantity: "share of the limits", .. }), "{error}");
    }
    for value in [0.0, -1e-6, f64::NAN, f64::INFINITY] {
        let tolerance = Deviation { position: value, angle: 1e-5 };
        let error = along(&robot, &path, &from, 1.0, None, tolerance).unwrap_err();
        assert!(matches!(error, AlongError::BadNumber { must: "finite and positive", .. }), "{error}");
    }
    for duration in [0.0, -1.0, f64::NAN] {
        assert!(along(&robot, &path, &from, 1.0, Some(duration), PATH_TOLERANCE).is_err());
    }
}

#[test]
fn a_line_of_a_nanometre_is_a_motion() {
    let robot = scara();
    let path = straight_line(&down(0.32, 0.0, 0.2, 0.3), &down(0.32, 1e-9, 0.2, 0.3)).unwrap();
    let from = start_of(&robot, &path, Elbow::Left);
    let found = along(&robot, &path, &from, 1.0, None, PATH_TOLERANCE).unwrap();
    let end = robot.world_from_tool(&found.motion.eval(found.motion.duration()).q);
    assert!((end.translation.vector - path.pose(1.0).translation.vector).norm() < 1e-13);
}

#[test]
fn a_screw_turns_and_slides_in_proportion() {
    let from = down(0.32, -0.1, 0.2, 0.3);
    let to = down(0.28, 0.12, 0.15, 1.4);
    let screw = screw_motion(&from, &to).unwrap();
    // exp(s ξ): the step from a to b is the same wherever it is made.
    let step = |a: f64, b: f64| screw.pose(b) * screw.pose(a).inverse();
    let (first, second) = (step(0.0, 0.25), step(0.6, 0.85));
    assert!((first.translation.vector - second.translation.vector).norm() < 1e-12);
    assert!(first.rotation.angle_to(&second.rotation) < 1e-7);
    assert!((screw.pose(1.0).translation.vector - to.translation.vector).norm() < 1e-12);
    let same = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 1.1);
    assert!((step(0.0, 1.0).rotation.angle_to(&same)) < 1e-7);
}
