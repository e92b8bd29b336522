//! Via points of the wrist and of the joints: what is read under each method, and what is at fault.

#![expect(clippy::panic, reason = "helpers of tests fail as tests do")]
#![expect(clippy::float_cmp, reason = "these values must be met to the last digit")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use graspcheck_model::{
    plan::NoMotion,
    task::{CartesianVia, JointVia, PathShape, Task},
    via::{Blend, BlendEnds, EndCondition, ViaLaw},
};
use graspcheck_scenario::{LoadError, Scenario, load};
use graspcheck_verify::Expectation;

/// A folder of its own for one test, with the planar arm of the repository.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenario_via").join(test);
    let robot = folder.join("assets/robots/rrr");
    fs::create_dir_all(&robot).expect("a folder for tests");
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots/rrr");
    for file in ["rrr.urdf", "robot.toml"] {
        fs::copy(from.join(file), robot.join(file)).expect("the arm is in the repository");
    }
    folder
}

fn read(test: &str, task: &str) -> Result<Scenario, LoadError> {
    let path = folder(test).join("via.toml");
    let scenario = format!("schema = 1\ntitle = \"via\"\nrobot = \"rrr\"\n\n[task]\n{task}");
    fs::write(&path, scenario).expect("the folder is there");
    load(&path)
}

/// Three points of the joints under a method, with more keys for the middle one.
fn joints(method: &str, middle: &str) -> String {
    let point = |t: f64, shoulder: f64, more: &str| {
        format!(
            "[[task.via]]\nt_s = {t}\nat = {{ shoulder_deg = {shoulder}, elbow_deg = 90, wrist_deg = 0 }}\n{more}\n"
        )
    };
    let points = [point(0.5, 0.0, ""), point(2.0, 45.0, middle), point(4.0, 22.5, "")].concat();
    format!("kind = \"joint_via\"\n{method}\n\n{points}")
}

/// Three points of the wrist.
fn wrist(method: &str, middle: &str) -> String {
    let point = |t: f64, x: f64, more: &str| {
        format!("[[task.via]]\nt_s = {t}\nwrist_m = [{x}, 3]\ntheta_deg = 45\n{more}\n")
    };
    let points = [point(0.5, -1.0, ""), point(2.0, 0.0, middle), point(4.0, 1.0, "")].concat();
    format!("kind = \"via\"\nelbow = \"left\"\n{method}\n\n{points}")
}

fn joint_task(test: &str, method: &str, middle: &str) -> JointVia {
    match read(test, &joints(method, middle)).unwrap_or_else(|error| panic!("{error}")).resolved.task {
        Task::JointVia(task) => task,
        other => panic!("{other:?}"),
    }
}

fn wrist_task(test: &str, method: &str, middle: &str) -> CartesianVia {
    match read(test, &wrist(method, middle)).unwrap_or_else(|error| panic!("{error}")).resolved.task {
        Task::CartesianVia(task) => task,
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_method_is_read_with_its_keys_in_si_units() {
    let task = joint_task("computed", "method = \"computed_velocities\"", "");
    assert_eq!(task.law, ViaLaw::ComputedVelocities);
    assert_eq!((task.points.len(), task.points[1].t), (3, 2.0));
    assert_eq!(task.points[1].q[0], 45_f64.to_radians());

    let velocity = "velocity = { shoulder_deg_s = 10, elbow_deg_s = -5, wrist_rad_s = 0.5 }";
    let task = joint_task("imposed", "method = \"imposed_velocities\"", velocity);
    let middle = vec![10_f64.to_radians(), -5_f64.to_radians(), 0.5];
    assert_eq!(task.law, ViaLaw::ImposedVelocities(vec![vec![0.0; 3], middle, vec![0.0; 3]]));

    for (word, condition) in [
        ("at_rest", EndCondition::AtRest),
        ("natural", EndCondition::Natural),
        ("not_a_knot", EndCondition::NotAKnot),
    ] {
        let method = format!("method = \"spline\"\nspline_ends = \"{word}\"");
        assert_eq!(joint_task(word, &method, "").law, ViaLaw::Spline(condition));
    }
    let task = joint_task("virtual", "method = \"virtual_points\"\nvirtual_s = [1.0, 3.0]", "");
    assert_eq!(task.law, ViaLaw::VirtualPoints([1.0, 3.0]));

    let velocity = "wrist_velocity_mm_s = [500, -250]\ntheta_velocity_deg_s = 10";
    let task = wrist_task("wrist_imposed", "method = \"imposed_velocities\"", velocity);
    let ViaLaw::ImposedVelocities(velocities) = task.law else { panic!("{:?}", task.law) };
    assert_eq!(velocities[1], [0.5, -0.25, 10_f64.to_radians()]);
}

#[test]
fn blends_come_from_the_task_from_the_point_or_from_accelerations() {
    let blends = |law: ViaLaw| match law {
        ViaLaw::ParabolicBlends(blends) => blends,
        other => panic!("{other:?}"),
    };
    let found = blends(wrist_task("default", "blend_s = 0.4", "").law);
    assert_eq!(ViaLaw::ParabolicBlends(found), ViaLaw::blends_of(0.4, 3, 3));

    let found = blends(
        wrist_task("point", "blend_s = 0.4\nends = \"centred\"", "blend_s = 0.3\nmet_within_s = 0.2").law,
    );
    assert_eq!(found.ends, BlendEnds::Centred);
    assert_eq!(
        (&found.points[1].blends[..], found.points[1].met),
        (&[Blend::Duration(0.3); 3][..], Some(0.2))
    );

    let met = |velocity: &str| format!("met_within_s = 0.2\n{velocity}");
    let velocity = met("wrist_velocity_mm_s = [300, -200]\ntheta_velocity_rad_s = 0.1");
    let found = blends(wrist_task("met", "blend_s = 0.4", &velocity).law);
    assert_eq!(found.points[1].velocity, Some(vec![0.3, -0.2, 0.1]));
    let velocity = met("velocity = { shoulder_rad_s = 0.5, elbow_rad_s = 0, wrist_rad_s = -1 }");
    let found = blends(joint_task("joint_met", "method = \"lfpb\"\nblend_s = 0.4", &velocity).law);
    assert_eq!(found.points[1].velocity, Some(vec![0.5, 0.0, -1.0]));
    assert_eq!(found.points[0].velocity, None);

    let accelerations = "wrist_acceleration_m_s2 = [2, 3]\ntheta_acceleration_rad_s2 = 1.5";
    let found = blends(wrist_task("accelerations", "blend_s = 0.4", accelerations).law);
    assert_eq!(found.points[1].blends, [2.0, 3.0, 1.5].map(Blend::Acceleration));

    let acceleration = "acceleration = { shoulder_rad_s2 = 2, elbow_rad_s2 = 3, wrist_rad_s2 = 4 }";
    let found = blends(joint_task("joint_blends", "method = \"lfpb\"\nblend_s = 0.4", acceleration).law);
    assert_eq!(found.points[1].blends, [2.0, 3.0, 4.0].map(Blend::Acceleration));
    assert_eq!(found.points[2].blends, [Blend::Duration(0.4); 3]);
}

#[test]
fn each_fault_is_named_and_located() {
    let periodic = "method = \"spline\"\nspline_ends = \"periodic\"";
    let virtual_late = "method = \"virtual_points\"\nvirtual_s = [2.0, 3.0]";
    for (index, (task, code, text, title)) in [
        (joints("", ""), "missing-key", "[task]", "missing key `method`"),
        (joints("method = \"splin\"", ""), "unknown-word", "\"splin\"", "method is one of"),
        (joints("method = \"spline\"", ""), "missing-key", "[task]", "missing key `spline_ends`"),
        (joints(periodic, ""), "range", "[[task.via]]", "a periodic motion ends where it begins"),
        (
            joints(virtual_late, ""),
            "range",
            "[2.0, 3.0]",
            "the first virtual point is due at 2 s, not between 0.5 s and 2 s",
        ),
        (
            joints("method = \"imposed_velocities\"", ""),
            "missing-key",
            "[[task.via]]",
            "missing key `velocity`",
        ),
        (joints("method = \"lfpb\"", ""), "missing-key", "[[task.via]]", "missing key `blend_s`"),
        (joints("method = \"lfpb\"\nblend_s = 0.0", ""), "range", "0.0", "blend_s is 0, out of its range"),
        (
            joints("method = \"computed_velocities\"\nblend_s = 0.4", ""),
            "unknown-key",
            "blend_s",
            "unknown key `blend_s`",
        ),
        (
            joints("method = \"computed_velocities\"", "").replace("t_s = 4", "t_s = 2"),
            "range",
            "[[task.via]]",
            "via point 3: t = 2 s is not after 2 s",
        ),
        (
            joints("method = \"computed_velocities\"", "").replace("elbow_deg = 90", "elbow_mm = 90"),
            "unit-of-kind",
            "elbow_mm",
            "joint elbow is revolute",
        ),
        (
            wrist("blend_s = 0.4", "").replacen("theta_deg = 45", "theta_deg = 45\nmet_within_s = 0.1", 1),
            "met-end",
            "0.1",
            "cannot lie between pseudo via points",
        ),
        (
            wrist(
                "blend_s = 0.4",
                "blend_s = 0.2\nwrist_acceleration_m_s2 = [1, 1]\ntheta_acceleration_deg_s2 = 9",
            ),
            "two-blends",
            "[[task.via]]",
            "either a blend time or accelerations",
        ),
        (
            wrist("blend_s = 0.4", "wrist_velocity_mm_s = [300, -200]\ntheta_velocity_rad_s = 0.1"),
            "not-met",
            "[[task.via]]",
            "a velocity belongs to a via point that is met",
        ),
        (
            wrist("blend_s = 0.4", "met_within_s = -0.1"),
            "range",
            "-0.1",
            "met_within_s is -0.1, out of its range",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        let error = read(&format!("fault_{index}"), &task).expect_err("this scenario has a fault");
        let fault = error
            .faults
            .iter()
            .find(|fault| fault.code == code && fault.title.contains(title))
            .unwrap_or_else(|| panic!("{task} gives\n{error}"));
        assert_eq!(&error.sources[fault.source].text[fault.span.clone()], text, "{title}");
    }
}

/// A spline of the tool with these keys.
fn spline(keys: &str) -> String {
    let start = "start = { shoulder_deg = 20, elbow_deg = 70, wrist_deg = -40 }";
    format!("kind = \"path\"\n{start}\n[[task.segment]]\nname = \"bend\"\nkind = \"spline\"\n{keys}\n")
}

#[test]
fn a_path_can_be_a_spline() {
    let shape = |test: &str, keys: &str| match read(test, &spline(keys)).expect("no fault").resolved.task {
        Task::Path(task) => task.segments[0].shape.clone(),
        other => panic!("{other:?}"),
    };
    let found = shape("spline", "at_mm = [[1000, 0, 0], [2000, 500, 0]]\nturn_rad = [0.5, 1]");
    let PathShape::Spline { points, turns, ends } = found else { panic!("{found:?}") };
    assert_eq!((points[1].x, points[1].y, turns, ends), (2.0, 0.5, vec![0.5, 1.0], EndCondition::Natural));
    let found = shape("spline_ends", "at_m = [[1, 0, 0]]\nspline_ends = \"not_a_knot\"");
    let PathShape::Spline { turns, ends, .. } = found else { panic!("{found:?}") };
    assert_eq!((turns, ends), (vec![0.0], EndCondition::NotAKnot));
    let error =
        read("spline_turns", &spline("at_mm = [[1000, 0, 0]]\nturn_deg = [1, 2]")).expect_err("a fault");
    assert!(error.to_string().contains("turn_deg has 2 angles for 1 points"), "{error}");
}

#[test]
fn a_limit_of_the_angle_may_be_left_out_and_the_deviation_needs_a_path() {
    let with =
        |test: &str, check: &str| read(test, &format!("{}\n[check]\n{check}", wrist("blend_s = 0.4", "")));
    let limits = |test: &str, check: &str| with(test, check).expect("no fault").resolved.checks;
    let found = limits("via_mm", "via_miss = { max_mm = 3 }");
    assert_eq!((found.via_miss, found.via_miss_angle), (Some(0.003), None));
    let found = limits("via_deg", "via_miss = { max_mm = 3, max_rad = 0.1 }\ndeviation = { max_mm = 0.002 }");
    assert_eq!((found.via_miss_angle, found.deviation), (Some(0.1), Some(2e-6)));
    let joints = joints("method = \"lfpb\"\nblend_s = 0.4", "");
    let judged = |check: &str| format!("{joints}\n[check]\n{check}");
    assert!(read("joint_via_miss", &judged("via_miss = { max_mm = 3 }")).is_ok());
    let error = read("joint_deviation", &judged("deviation = { max_mm = 3 }")).expect_err("a fault");
    assert!(error.to_string().contains("check `deviation` needs paths of the tool"), "{error}");
}

#[test]
fn the_phase_of_via_points_has_a_duration_and_no_share() {
    let with =
        |test: &str, key: &str| read(test, &format!("{}\n[phase.via]\n{key}", wrist("blend_s = 0.4", "")));
    let pace = with("via_duration", "duration_s = 9").expect("no fault").resolved.pace;
    assert_eq!((pace.phases[0].phase.as_str(), pace.phases[0].duration), ("via", Some(9.0)));
    let error = with("via_share", "speed_percent = 50").expect_err("a fault");
    assert_eq!(error.faults[0].code, "timed-phase", "{error}");
}

#[test]
fn that_there_is_no_plan_is_expected_alone() {
    let expecting = |test: &str, names: &str| {
        let path = folder(test).join("via.toml");
        let task = wrist("blend_s = 0.4", "");
        let head = format!("schema = 1\ntitle = \"via\"\nrobot = \"rrr\"\nexpect_fail = [{names}]\n");
        fs::write(&path, format!("{head}\n[task]\n{task}")).expect("the folder is there");
        load(&path)
    };
    for reason in NoMotion::ALL {
        let name = reason.name();
        let found = expecting(name, &format!("\"{name}\"")).expect("no fault").resolved.expect;
        assert_eq!(found, Expectation::Fail(vec![name.to_owned()]));
    }
    let error = expecting("both", "\"plan.branch\", \"planned.velocity\"").expect_err("a fault");
    assert_eq!(error.faults[0].code, "no-plan", "{error}");
    let error = expecting("misspelt", "\"plan.unreachabel\"").expect_err("a fault");
    assert!(error.faults[0].code == "unknown-check", "{error}");
}

#[test]
fn an_unknown_method_hides_no_fault_and_makes_none() {
    let task = joints("method = \"splin\"\nspline_ends = \"natural\"", "velocity = { shoulder_deg_s = 1 }");
    let error = read("unknown_method", &task).expect_err("this scenario has a fault");
    assert_eq!(error.faults.len(), 1, "{error}");
}
