//! Every kind of fault: what is said, and which text it points to.

#![expect(clippy::unwrap_used, reason = "a helper of a test fails like the test")]

use std::{
    fmt::Write,
    fs,
    path::{Path, PathBuf},
};

use graspcheck_scenario::{Fault, LoadError, load};

/// A scenario without faults; cases change one piece of its text.
const SCENARIO: &str = r#"schema = 1
title = "pick a cube"
robot = "scara"
extends = "cell.toml"
seed = 7
expect = "pass"
gravity = "down"

[object.cube]
shape = { box_mm = [30, 30, 30] }
mass_kg = 0.10
friction = 0.6
at_mm = [280, -180, 15]
yaw_deg = 20

[[object.cube.handle]]
name = "side"
approach = "down"
turned_deg = 90
symmetry = "half_turn"

[task]
kind = "pick_and_place"
object = "cube"
start = { shoulder_deg = -60, elbow_deg = 100, quill_mm = -20, wrist_deg = 314 }
place = { at_mm = [330, 150, 15], yaw_deg = -70 }
departure_mm = [0, 0, 60]
arrival_mm = [0, 0, 60]

[motion]
speed_percent = 50

[phase.close]
force_n = 12

[phase.carry]
duration_s = 0.5

[controller]
bandwidth_hz = 30

[simulation]
dt_ms = 1

[check]
slip = { max_mm = 0.5 }
place = { max_mm = 1.0, max_deg = 1.0 }
"#;

const CELL: &str = r#"schema = 1

[[cell.body]]
name = "bench"
shape = { box_mm = [480, 700, 20] }
at_mm = [360, 0, -10]

[check.clearance]
required_mm = 5.0
pairs = [{ a = "gripper", b = "bench", required_mm = 2.0, reason = "they meet" }]
"#;

/// A folder of its own for one test, with the robots of the repository.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenario_faults").join(test);
    let _ = fs::remove_dir_all(&folder);
    for robot in ["scara", "rrr"] {
        let to = folder.join("assets/robots").join(robot);
        fs::create_dir_all(&to).unwrap();
        let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/robots").join(robot);
        for file in [format!("{robot}.urdf"), "robot.toml".to_owned()] {
            fs::copy(from.join(&file), to.join(&file)).unwrap();
        }
    }
    fs::write(folder.join("cell.toml"), CELL).unwrap();
    folder
}

/// The faults of a scenario text.
fn faults(test: &str, scenario: &str) -> LoadError {
    let folder = folder(test);
    let path = folder.join("pick.toml");
    fs::write(&path, scenario).unwrap();
    load(&path).expect_err("this scenario has a fault")
}

fn marked<'a>(fault: &Fault, error: &'a LoadError) -> &'a str {
    &error.sources[fault.source].text[fault.span.clone()]
}

/// What a terminal would show, without colours and source lines.
fn rendered(error: &LoadError) -> String {
    let mut out = String::new();
    for fault in &error.faults {
        let source = &error.sources[fault.source];
        let (line, column) = source.line_column(fault.span.start);
        let file = source.path.rsplit('/').next().unwrap();
        writeln!(out, "error[{}]: {}", fault.code, fault.title).unwrap();
        writeln!(out, "  {file}:{line}:{column}  `{}`  {}", marked(fault, error), fault.label).unwrap();
        if let Some(help) = &fault.help {
            write!(out, "  help: {}", help.text).unwrap();
            match &help.replacement {
                Some(text) => writeln!(out, "  -> `{text}`").unwrap(),
                None => writeln!(out).unwrap(),
            }
        }
        if let Some(second) = &fault.second {
            let other = &error.sources[second.source];
            let (line, column) = other.line_column(second.span.start);
            let file = other.path.rsplit('/').next().unwrap();
            writeln!(out, "  and {file}:{line}:{column}  {}", second.label).unwrap();
        }
    }
    out
}

/// Text to replace, its replacement, code of the fault, text that it marks, a part of its title.
type Case = (&'static str, &'static str, &'static str, &'static str, &'static str);

const CASES: &[Case] = &[
    ("mass_kg", "weight_kg", "unknown-key", "weight_kg", "unknown key `weight_kg` in [object.cube]"),
    ("at_mm = [280", "at_cm = [280", "unknown-key", "at_cm", "unknown key `at_cm` in [object.cube]"),
    ("mass_kg", "mas_kg", "unknown-key", "mas_kg", "unknown key `mas_kg` in [object.cube]"),
    ("friction = 0.6\n", "", "missing-key", "[object.cube]", "missing key `friction` in [object.cube]"),
    (
        "quill_mm = -20",
        "quill_deg = -20",
        "unit-of-kind",
        "quill_deg",
        "joint quill is prismatic: `quill_deg`",
    ),
    ("elbow_deg = 100", "elbow_mm = 100", "unit-of-kind", "elbow_mm", "joint elbow is revolute: `elbow_mm`"),
    (
        ", wrist_deg = 314",
        "",
        "missing-key",
        "{ shoulder_deg = -60, elbow_deg = 100, quill_mm = -20 }",
        "missing key `wrist_deg`",
    ),
    (
        "shoulder_deg = -60",
        "shoulder_deg = -91",
        "outside-limit",
        "-91",
        "joint shoulder: start -91.0° is below -85.0° by 6.0°",
    ),
    (
        "quill_mm = -20",
        "quill_mm = 6",
        "outside-limit",
        "6",
        "joint quill: start 6.0 mm is above 5.0 mm by 1.0 mm",
    ),
    (
        "yaw_deg = -70",
        "yaw_deg = \"-70 deg\"",
        "type",
        "\"-70 deg\"",
        "yaw_deg takes a number; the unit is in the key",
    ),
    (
        "yaw_deg = -70",
        "yaw_deg = -70, yaw_rad = 1",
        "two-units",
        "yaw_rad",
        "has both `yaw_deg` and `yaw_rad`",
    ),
    (
        "duration_s = 0.5",
        "duration_deg = 0.5",
        "unit",
        "duration_deg",
        "has the unit of an angle, it takes a time",
    ),
    ("duration_s = 0.5", "duration = 0.5", "unit", "duration", "`duration` lacks its unit: it takes a time"),
    ("duration_s = 0.5", "duration_s = -0.5", "range", "-0.5", "duration_s is -0.5"),
    ("duration_s = 0.5", "duration_s = nan", "range", "nan", "duration_s is NaN"),
    ("mass_kg = 0.10", "mass_kg = inf", "range", "inf", "mass_kg is inf"),
    ("mass_kg = 0.10", "mass_kg = 0", "range", "0", "mass_kg is 0"),
    ("speed_percent = 50", "speed_percent = 101", "range", "101", "speed_percent is 101"),
    ("[280, -180, 15]", "[280, -180]", "type", "[280, -180]", "at_mm has 2 numbers, it takes 3"),
    ("[280, -180, 15]", "[280, true, 15]", "type", "true", "at_mm takes a number"),
    ("robot = \"scara\"", "robot = \"scarra\"", "unknown-robot", "\"scarra\"", "unknown robot `scarra`"),
    (
        "robot = \"scara\"",
        "robot = \"../scara\"",
        "unknown-robot",
        "\"../scara\"",
        "unknown robot `../scara`",
    ),
    ("\"cell.toml\"", "\"cel.toml\"", "unreadable-file", "\"cel.toml\"", "cel.toml: no such file"),
    ("\"cell.toml\"", "\"pick.toml\"", "extends", "\"pick.toml\"", "extends goes in a circle"),
    ("[phase.carry]", "[phase.cary]", "unknown-phase", "cary", "unknown phase `cary`"),
    (
        "[phase.carry]",
        "[phase.lift]\nlaw = \"quintic\"\n[phase.carry]",
        "no-joint-move",
        "lift",
        "phase `lift` is no joint move: it has no law of time to choose",
    ),
    (
        "[phase.carry]",
        "[phase.approach]\nlaw = \"quintc\"\n[phase.carry]",
        "unknown-word",
        "\"quintc\"",
        "law is one of \"s_curve\", \"quintic\", \"cubic\" or \"trapezoid\", not \"quintc\"",
    ),
    ("force_n = 12", "force_n = 21", "outside-limit", "21", "grip force 21 N exceeds 20 N"),
    ("force_n = 12\n", "", "missing-key", "[task]", "missing key `force_n` in [phase.close]"),
    ("object = \"cube\"", "object = \"cup\"", "unknown-object", "\"cup\"", "unknown object `cup`"),
    ("slip =", "slipp =", "unknown-check", "slipp", "unknown check `slipp`"),
    (
        "place = { max_mm",
        "via_miss = { max_mm = 1 }\nplace = { max_mm",
        "check-of-task",
        "via_miss",
        "needs via points",
    ),
    (
        "expect = \"pass\"",
        "expect_fail = [\"velocty\"]",
        "unknown-check",
        "\"velocty\"",
        "unknown check `velocty`",
    ),
    ("expect = \"pass\"", "expect_fail = []", "range", "[]", "expect_fail names no check"),
    (
        "expect = \"pass\"",
        "expect = \"fail\"",
        "unknown-word",
        "\"fail\"",
        "expect is one of \"pass\", not \"fail\"",
    ),
    ("schema = 1", "schema = 2", "schema", "2", "this program reads schema 1"),
    (
        "box_mm = [30, 30, 30]",
        "box_mm = [30, 0, 30]",
        "range",
        "{ box_mm = [30, 0, 30] }",
        "a box has three lengths",
    ),
    ("{ box_mm = [30, 30, 30] }", "{ cube_mm = 30 }", "unknown-key", "cube_mm", "unknown key `cube_mm`"),
    ("turned_deg = 90", "turned_deg = 30", "handle", "[[object.cube.handle]]", "close on edges"),
    ("[30, 30, 30]", "[30, 70, 30]", "outside-limit", "[[object.cube.handle]]", "width 70.0 mm does not fit"),
    ("dt_ms = 1", "dt_ms = 0.3", "range", "0.3", "does not divide one second"),
    ("seed = 7", "seed = -7", "range", "-7", "seed is -7, below 0"),
    ("gravity = \"down\"", "gravity = \"up\"", "unknown-word", "\"up\"", "gravity is one of"),
    ("kind = \"pick_and_place\"", "kind = \"pick\"", "unknown-word", "\"pick\"", "kind is one of"),
    ("seed = 7", "seed = 1979-05-27", "type", "1979-05-27", "seed takes a whole number"),
];

#[test]
fn each_fault_is_named_and_located() {
    for (index, &(from, to, code, text, title)) in CASES.iter().enumerate() {
        assert_eq!(
            SCENARIO.matches(from).count(),
            usize::from(SCENARIO.contains(from)).max(1),
            "`{from}` is not unique"
        );
        let error = faults(&format!("case_{index}"), &SCENARIO.replacen(from, to, 1));
        let fault = error
            .faults
            .iter()
            .find(|fault| fault.code == code && fault.title.contains(title))
            .unwrap_or_else(|| panic!("{from} -> {to} gives\n{}", rendered(&error)));
        assert_eq!(marked(fault, &error), text, "{from} -> {to}");
    }
}

#[test]
fn a_misspelt_phase_is_found_beside_a_value_that_cannot_be_read() {
    let scenario = SCENARIO
        .replace("duration_s = 0.5", "duration_s = -0.5")
        .replace("force_n = 12", "force_n = -12")
        .replace("[phase.carry]", "[phase.lfit]\nspeed_percent = 50\n\n[phase.carry]");
    let error = faults("phases", &scenario);
    let titles: Vec<&str> = error.faults.iter().map(|fault| fault.title.as_str()).collect();
    assert_eq!(titles.len(), 3, "{titles:?}");
    assert!(
        titles[0].starts_with("force_n is -12") && titles[2].starts_with("duration_s is -0.5"),
        "{titles:?}"
    );
    assert_eq!(titles[1], "unknown phase `lfit`");
}

#[test]
fn closing_faster_than_the_fingers_can_is_a_fault_that_tells_the_least_duration() {
    let with =
        |duration: &str| SCENARIO.replace("force_n = 12", &format!("force_n = 12\nduration_s = {duration}"));
    let error = faults("fast_fingers", &with("0.05"));
    assert_eq!(error.faults.len(), 1, "{}", rendered(&error));
    let fault = &error.faults[0];
    assert_eq!(marked(fault, &error), "0.05");
    assert!(
        fault.title.starts_with("phase close: 0.050 s is too short, the fingers need"),
        "{}",
        fault.title
    );
    let least: f64 = fault.help.as_ref().unwrap().replacement.as_ref().unwrap().parse().unwrap();
    assert_eq!(faults("fast_fingers", &with(&format!("{:.3}", least - 0.001))).faults.len(), 1);
    let folder = folder("fast_fingers");
    fs::write(folder.join("pick.toml"), with(&format!("{least}"))).unwrap();
    load(&folder.join("pick.toml")).unwrap();
}

#[test]
fn an_object_that_floats_or_is_inside_a_body_is_a_fault_with_its_line() {
    let at = |z: &str| {
        faults(&format!("support_{z}"), &SCENARIO.replace("[280, -180, 15]", &format!("[280, -180, {z}]")))
    };
    let error = at("27");
    assert_eq!(error.faults.len(), 1, "{}", rendered(&error));
    assert_eq!(error.faults[0].title, "nothing supports cube: its lowest point is 12.00 mm above bench");
    assert_eq!(marked(&error.faults[0], &error), "[280, -180, 27]");
    assert!(rendered(&error).contains("it stands on bench at_mm = [280, -180, 15]"), "{}", rendered(&error));
    let error = at("10");
    assert_eq!(error.faults[0].title, "cube is 5.00 mm inside bench at the start");
    assert_eq!(marked(&error.faults[0], &error), "[280, -180, 10]");
    let error = faults("support_beside", &SCENARIO.replace("[280, -180, 15]", "[280, 450, 15]"));
    assert_eq!(error.faults[0].title, "nothing supports cube: there is no body below it");

    let folder = folder("support_none");
    let scenario =
        SCENARIO.replace("gravity = \"down\"", "gravity = \"none\"").replace("-180, 15]", "-180, 40]");
    fs::write(folder.join("pick.toml"), scenario).unwrap();
    load(&folder.join("pick.toml")).unwrap();
}

#[test]
fn the_scenario_of_these_tests_has_no_fault() {
    let folder = folder("clean");
    fs::write(folder.join("pick.toml"), SCENARIO).unwrap();
    load(&folder.join("pick.toml")).unwrap();
}

#[test]
fn all_faults_of_a_file_come_at_once() {
    let scenario = SCENARIO
        .replace("mass_kg = 0.10", "weight_kg = 0.10")
        .replace("shoulder_deg = -60", "shoulder_deg = -91.0")
        .replace("quill_mm", "quill_deg")
        .replace("yaw_deg = -70", "yaw_deg = \"-70 deg\"")
        .replace("[check]", "[check.clearence]\nrequired_mm = 3\n\n[check]");
    insta::assert_snapshot!(rendered(&faults("at_once", &scenario)));
}

#[test]
fn units_are_explained() {
    let scenario = SCENARIO
        .replace("duration_s = 0.5", "duration = 0.5")
        .replace("force_n", "force_kg")
        .replace("departure_mm", "departure_deg")
        .replace("yaw_deg = 20", "yaw_deg = 20\nyaw_rad = 0.3")
        .replace("mass_kg = 0.10", "mass_kg = \"0.10 kg\"");
    insta::assert_snapshot!(rendered(&faults("units", &scenario)));
}

#[test]
fn a_broken_line_does_not_hide_the_rest() {
    let scenario = SCENARIO
        .replace("friction = 0.6", "friction = 0.6.1")
        .replace("[phase.carry]", "[phase.cary]")
        .replace("seed = 7", "seed = 7\nseed = 8");
    insta::assert_snapshot!(rendered(&faults("syntax", &scenario)));
}

#[test]
fn an_unclosed_bracket_is_one_fault() {
    let scenario = SCENARIO.replace("at_mm = [280, -180, 15]", "at_mm = [280, -180, 15");
    insta::assert_snapshot!(rendered(&faults("bracket", &scenario)));
}

#[test]
fn names_in_clearance_pairs_must_exist() {
    let folder = folder("pairs");
    fs::write(folder.join("cell.toml"), CELL.replace("b = \"bench\"", "b = \"bank\"")).unwrap();
    fs::write(folder.join("pick.toml"), SCENARIO).unwrap();
    insta::assert_snapshot!(rendered(&load(&folder.join("pick.toml")).unwrap_err()));
}

#[test]
fn names_are_unique_in_a_scene() {
    let scenario =
        SCENARIO.replace("object.cube", "object.hand").replace("object = \"cube\"", "object = \"hand\"");
    let error = faults("names", &scenario);
    assert_eq!(error.faults.len(), 1, "{}", rendered(&error));
    assert_eq!(error.faults[0].code, "name");
    assert_eq!(marked(&error.faults[0], &error), "hand");
}

#[test]
fn a_missing_scenario_is_one_fault() {
    let error = load(&folder("missing").join("absent.toml")).unwrap_err();
    assert_eq!(error.faults.len(), 1);
    assert_eq!(error.faults[0].code, "unreadable-file");
    assert!(error.faults[0].title.ends_with("absent.toml: no such file"), "{}", error.faults[0].title);
}

#[test]
fn a_chain_of_cells_may_be_three_long() {
    let folder = folder("deep");
    fs::write(folder.join("pick.toml"), SCENARIO).unwrap();
    let chain = |length: usize| {
        for level in 1..=length {
            let text = match level < length {
                true => format!("extends = \"cell{}.toml\"\nschema = 1\n", level + 1),
                false => CELL.to_owned(),
            };
            let name = if level == 1 { "cell.toml".to_owned() } else { format!("cell{level}.toml") };
            fs::write(folder.join(name), text).unwrap();
        }
        load(&folder.join("pick.toml"))
    };
    chain(3).unwrap();
    let error = chain(4).unwrap_err();
    assert_eq!(error.faults.len(), 1);
    assert!(error.faults[0].title.starts_with("extends is more than 3 deep: "), "{}", error.faults[0].title);
}

/// The faults of the repository's SCARA with one file changed.
fn robot_faults(test: &str, file: &str, from: &str, to: &str) -> LoadError {
    let folder = folder(test);
    let path = folder.join("assets/robots/scara").join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} does not contain `{from}`");
    fs::write(&path, text.replacen(from, to, 1)).unwrap();
    fs::write(folder.join("pick.toml"), SCENARIO).unwrap();
    load(&folder.join("pick.toml")).expect_err("this robot has a fault")
}

/// The same, for `robot.toml`.
const ROBOT_CASES: &[Case] = &[
    (
        "acceleration_max_m_s2",
        "acceleration_max_rad_s2",
        "unit-of-kind",
        "acceleration_max_rad_s2",
        "joint quill is prismatic",
    ),
    (
        "jerk_max_rad_s3 = 3000",
        "jerk_max_m_s3 = 3000",
        "unit-of-kind",
        "jerk_max_m_s3",
        "joint shoulder is revolute",
    ),
    ("jerk_max_rad_s3 = 3000", "jerk_max_rad_s3 = -3000", "range", "-3000", "jerk_max_rad_s3 is -3000"),
    ("jerk_max_rad_s3 = 3000\n", "", "missing-key", "[joint.shoulder]", "missing key `jerk_max_deg_s3`"),
    (
        "urdf = \"scara.urdf\"",
        "urdf = \"scar.urdf\"",
        "unreadable-file",
        "\"scar.urdf\"",
        "scar.urdf: no such file",
    ),
    ("closes = \"+x\"", "closes = \"+z\"", "tool-axes", "[tool]", "two different axes"),
    ("closes = \"+x\"", "closes = \"x\"", "unknown-word", "\"x\"", "closes is one of"),
    ("[joint.elbow]", "[joint.elbo]", "robot", "elbo", "joint elbo: no such joint"),
    ("link = \"hand\"", "link = \"palm\"", "robot", "link", "palm"),
    ("force_max_n = 20", "force_max_mm = 20", "unit", "force_max_mm", "has the unit of a length"),
    ("a = \"quill\"", "aa = \"quill\"", "unknown-key", "aa", "unknown key `aa` in [[allowed_contact]]"),
];

#[test]
fn each_fault_of_a_robot_is_named_and_located() {
    for (index, &(from, to, code, text, title)) in ROBOT_CASES.iter().enumerate() {
        let error = robot_faults(&format!("robot_{index}"), "robot.toml", from, to);
        let fault = error
            .faults
            .iter()
            .find(|fault| fault.code == code && fault.title.contains(title))
            .unwrap_or_else(|| panic!("{from} -> {to} gives\n{}", rendered(&error)));
        assert_eq!(marked(fault, &error), text, "{from} -> {to}");
        assert!(error.sources[fault.source].path.ends_with("robot.toml"));
    }
}

#[test]
fn faults_of_the_urdf_point_into_it() {
    let error = robot_faults("urdf", "scara.urdf", "lower=\"-0.33\"", "lower=\"-0.33 m\"");
    assert!(error.sources[error.faults[0].source].path.ends_with("scara.urdf"));
    assert!(marked(&error.faults[0], &error).contains("-0.33 m"), "{}", rendered(&error));
}

#[test]
fn a_planar_arm_cannot_approach_from_above() {
    let scenario = SCENARIO
        .replace("robot = \"scara\"", "robot = \"rrr\"")
        .replace(", quill_mm = -20, wrist_deg = 314", ", wrist_deg = 10")
        // The fingers of this arm are slower.
        .replace("force_n = 12", "force_n = 12\nduration_s = 0.6\n\n[phase.open]\nduration_s = 0.6");
    let error = faults("planar", &scenario);
    assert_eq!(error.faults.len(), 1, "{}", rendered(&error));
    assert!(error.faults[0].title.contains("a planar arm cannot approach across its plane"));
}
