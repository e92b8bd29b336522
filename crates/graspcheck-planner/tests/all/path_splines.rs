//! Paths through points and poses without a stop: splines of joints, of positions and of orientations.

use crate::robots::{cell, pace, pose, scara};
use graspcheck_model::{
    Pose,
    task::{PathSegment, PathShape, PathTask, Task},
    via::EndCondition,
};
use graspcheck_planner::{
    path::{
        JointSpline, Path, PathError,
        orientation_spline::OrientationSpline,
        spline::{through_points, through_poses},
    },
    plan,
    via::{
        ViaPoints,
        spline::{self, SplineEnd, SplineEnds},
    },
};
use nalgebra::{UnitQuaternion, Vector3};

/// Poses that turn about different axes from one to the next, at uneven distances.
fn tumbling() -> Vec<Pose> {
    vec![
        pose([0.3, 0.0, 0.1], [0.2, -0.1, 0.4]),
        pose([0.45, 0.1, 0.2], [1.1, 0.3, 0.1]),
        pose([0.5, 0.15, 0.15], [0.9, -0.8, 0.6]),
        pose([0.3, 0.4, 0.1], [-0.3, -0.2, 1.9]),
    ]
}

#[test]
fn a_spline_of_poses_meets_them_and_its_bend_is_continuous_and_that_of_the_curve() {
    let poses = tumbling();
    let path = through_poses(&poses).unwrap();
    let places: Vec<f64> =
        [path.start()].into_iter().chain(path.junctions().iter().map(|j| j.s)).chain([path.end()]).collect();
    assert!(path.junctions().iter().all(|junction| junction.class == 2), "{:?}", path.junctions());
    for (place, wanted) in places.iter().zip(&poses) {
        let found = path.pose(*place);
        assert!((found.translation.vector - wanted.translation.vector).norm() < 1e-14);
        assert!(found.rotation.angle_to(&wanted.rotation) < 1e-12);
    }
    // Natural: no acceleration at the ends, of the position and of the turn.
    for end in [0.0, 1.0] {
        assert!(path.eval(end).derivatives[1].norm() < 1e-11, "{}", path.eval(end).derivatives[1]);
    }
    // The derivatives are those of the poses.
    let step = 1e-5;
    for k in 1..40 {
        let s = f64::from(k) / 40.0;
        if places.iter().any(|place| (place - s).abs() < 2.0 * step) {
            continue;
        }
        let (before, here, after) = (path.eval(s - step), path.eval(s), path.eval(s + step));
        let turn = after.world_from_tool.rotation * before.world_from_tool.rotation.inverse();
        let angular = turn.scaled_axis() / (2.0 * step);
        assert!((here.derivatives[0].fixed_rows::<3>(3) - angular).norm() < 1e-7, "at {s}");
        for order in 0..2 {
            let difference = (after.derivatives[order] - before.derivatives[order]) / (2.0 * step);
            assert!((here.derivatives[order + 1] - difference).norm() < 1e-4, "order {order} at {s}");
        }
    }
}

#[test]
fn a_spline_of_poses_moves_with_them() {
    let poses = tumbling();
    let moved = pose([1.0, -2.0, 0.5], [0.7, 1.2, -0.4]);
    let path = through_poses(&poses).unwrap();
    let other = through_poses(&poses.iter().map(|pose| moved * pose).collect::<Vec<_>>()).unwrap();
    for k in 0..=20 {
        let s = f64::from(k) / 20.0;
        let (expected, found) = (moved * path.pose(s), other.pose(s));
        assert!((expected.translation.vector - found.translation.vector).norm() < 1e-13);
        assert!(expected.rotation.angle_to(&found.rotation) < 1e-12, "at {s}");
    }
}

#[test]
fn about_one_axis_a_spline_of_orientations_is_the_natural_spline_of_the_angle() {
    let axis = Vector3::new(1.0, -2.0, 0.5).normalize();
    let (places, angles) = ([0.0, 0.2, 0.5, 0.6, 1.0], [0.3, 1.2, 0.4, 0.7, -0.6]);
    let orientations = angles.map(|angle| UnitQuaternion::new(axis * angle));
    let curve = OrientationSpline::through(&places, &orientations).unwrap();
    let points = ViaPoints::new(places.to_vec(), angles.map(|angle| vec![angle]).to_vec()).unwrap();
    let scalar = spline::through(&points, &SplineEnds::both(SplineEnd::Natural)).unwrap();
    for piece in 0..4 {
        for k in 0..=8 {
            let length = (places[piece + 1] - places[piece]) * f64::from(k) / 8.0;
            let angle = scalar.piece(piece, 0).eval(length)[0];
            let wanted = UnitQuaternion::new(axis * angle);
            assert!(curve.curve(piece).at(length).angle_to(&wanted) < 1e-12, "piece {piece}, {length}");
        }
    }
}

#[test]
fn what_is_no_spline_is_an_error_that_names_the_point() {
    let mut poses = tumbling();
    poses[2] = poses[1];
    assert!(matches!(through_poses(&poses), Err(PathError::SamePoint { point: 3, .. })));
    assert!(matches!(through_poses(&poses[..1]), Err(PathError::Points(_))));
    poses[2].translation.x = f64::NAN;
    assert!(matches!(through_poses(&poses), Err(PathError::NotFinite { .. })));
    // Nearly half a turn about one axis and then another, five times: no curve of one piece a pose does that.
    let wild: Vec<_> = (0..6)
        .map(|k| {
            let axis = [Vector3::x(), Vector3::y(), Vector3::z()][k % 3];
            UnitQuaternion::new(axis * 3.1 * f64::from(u8::try_from(k % 2).unwrap()))
        })
        .collect();
    let places = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
    if let Ok(curve) = OrientationSpline::through(&places, &wild) {
        for (k, wanted) in wild.iter().enumerate().take(5) {
            assert!(curve.curve(k).at(0.0).angle_to(wanted) < 1e-12);
        }
    }
    let angle = Vector3::z_axis();
    let points = [Vector3::zeros(), Vector3::x()];
    let natural = SplineEnds::both(SplineEnd::Natural);
    let error = through_points(&points, &[0.0], &UnitQuaternion::identity(), &angle, &natural).unwrap_err();
    assert_eq!(error.to_string(), "spline: 1 angles for 2 points; give one for each point");
    assert!(JointSpline::new(&[vec![0.0], vec![0.0], vec![1.0]], &natural).is_err());
}

#[test]
fn a_spline_of_the_joints_meets_its_points_at_shares_of_the_way() {
    let points = [vec![0.0, 0.0], vec![3.0, 4.0], vec![3.0, 9.0], vec![-7.0, 9.0]];
    let path = JointSpline::new(&points, &SplineEnds::both(SplineEnd::NotAKnot)).unwrap();
    // The ways are 5, 5 and 10.
    for (s, point) in [0.0, 0.25, 0.5, 1.0].into_iter().zip(&points) {
        for (found, wanted) in path.eval(s).q.iter().zip(point) {
            assert!((found - wanted).abs() < 1e-13);
        }
    }
    let (step, s) = (1e-6, 0.6);
    let (before, here, after) = (path.eval(s - step), path.eval(s), path.eval(s + step));
    for joint in 0..2 {
        assert!((here.q_s[joint] - (after.q[joint] - before.q[joint]) / (2.0 * step)).abs() < 1e-6);
        assert!((here.q_ss[joint] - (after.q_s[joint] - before.q_s[joint]) / (2.0 * step)).abs() < 1e-6);
        assert!((here.q_sss[joint] - (after.q_ss[joint] - before.q_ss[joint]) / (2.0 * step)).abs() < 1e-6);
    }
}

#[test]
fn a_path_task_leads_the_tool_through_a_spline_without_a_stop() {
    let robot = scara();
    let start = vec![-0.9, 1.4, -0.12, 6.2];
    let shape = PathShape::Spline {
        points: [[-0.04, 0.06, 0.0], [0.04, 0.12, 0.02], [-0.02, 0.18, 0.0]].map(Vector3::from).to_vec(),
        turns: vec![1.5, 4.7, 7.0],
        ends: EndCondition::Natural,
    };
    let segments = vec![PathSegment { name: "slalom".into(), from_start: true, shape }];
    let task = Task::Path(PathTask { start: start.clone(), tolerance: 1e-5, segments });
    let plan = plan(&robot, &cell(0.0, &[]), None, &task, &pace(0.5)).unwrap();
    let planned = &plan.paths[0];
    for (junction, wanted) in planned.path.junctions().iter().zip([[-0.04, 0.06, 0.0], [0.04, 0.12, 0.02]]) {
        // When the law is there: the tool is at the point, and moves.
        let law = &planned.law;
        let (mut early, mut late) = (0.0, law.duration());
        for _ in 0..60 {
            let middle = 0.5 * (early + late);
            if law.eval(middle).q[0] < junction.s { early = middle } else { late = middle }
        }
        let state = plan.trajectory.eval(early);
        let moved = robot.world_from_tool(&state.q).translation.vector
            - robot.world_from_tool(&start).translation.vector;
        assert!((moved - Vector3::from(wanted)).norm() < 1e-5, "{moved}");
        assert!(state.qd[0].abs() > 0.05, "{state:?}");
    }
    let end = plan.trajectory.eval(plan.duration()).q;
    let psi = |q: &[f64]| q[0] + q[1] + q[3];
    assert!((psi(&end) - psi(&start) - 7.0).abs() < 1e-9);
}
