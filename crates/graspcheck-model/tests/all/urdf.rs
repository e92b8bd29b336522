//! Every fault that a URDF can have is found, at its place, and nothing else.

use graspcheck_model::{
    robot::JointKind,
    urdf::{UrdfFault, parse},
};

const GOOD: &str = include_str!("../arms/small.urdf");

/// One way to spoil the good text: what stands instead of what, and the fault that must come out as
/// title, the text it points at (its beginning), and label.
struct Spoiled {
    from: &'static str,
    to: &'static str,
    title: &'static str,
    at: &'static str,
    label: &'static str,
}

/// The text with the first `from` replaced.
fn spoiled(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "the good text has no {from}");
    text.replacen(from, to, 1)
}

fn faults(text: &str) -> Vec<UrdfFault> {
    parse(text).map(|_| ()).expect_err("the text has a fault")
}

/// Rows of `from => to: title / at / label`.
macro_rules! table {
    ($($from:literal => $to:literal : $title:literal / $at:literal / $label:literal;)*) => {
        &[$(Spoiled { from: $from, to: $to, title: $title, at: $at, label: $label }),*]
    };
}

const FORM: &[Spoiled] = table![
    "</robot>" => "</robt>": "not well-formed XML: expected 'robot' tag, not 'robt' at 71:1" / "<" / "here";
    "<limit lower=\"-2.9\"" => "<limits lower=\"-2.9\"":
        "joint elbow: unknown element <limits> in <joint>" / "limits" / "did you mean `limit`?";
    "<link name=\"flange\"/>" => "<link name=\"flange\"/><gazebo/>":
        "robot small: unknown element <gazebo> in <robot>" / "gazebo" / "not read by graspcheck";
    "<axis xyz=\"0 0 1\"/>" => "<axis xyz=\"0 0 1\"><speed/></axis>":
        "joint shoulder: unknown element <speed> in <axis>" / "speed" / "not read by graspcheck";
    "<robot name=\"small\">" => "<robot name=\"small\" xmlns:x=\"urn:x\"><x:link name=\"y\"/>":
        "robot small: unknown element <x:link> in <robot>" / "x:link" / "not read by graspcheck";
    "friction=\"0.25\"" => "frictoin=\"0.25\"":
        "joint shoulder: unknown attribute `frictoin` of <dynamics>" / "frictoin" / "did you mean `friction`?";
    "<mass value=\"2\"/>" => "<mass value=\"2\" unit=\"kg\"/>":
        "link upper_arm: unknown attribute `unit` of <mass>" / "unit" / "not read by graspcheck";
    "effort=\"100\"" => "effort=\"100\" acceleration=\"5\"":
        "joint elbow: limit of acceleration in a URDF" / "acceleration" / "belongs in robot.toml";
    "effort=\"100\"" => "effort=\"100\" jerk=\"50\"":
        "joint elbow: limit of jerk in a URDF" / "jerk" / "belongs in robot.toml";
    "effort=\"100\"" => "": "joint elbow: <limit> has no `effort`" / "<limit lower=\"-2.9\"" / "needs `effort`";
    "<limit lower=\"-2.9\" upper" => "<limit upper":
        "joint elbow: <limit> has no `lower`" / "<limit upper=" / "needs `lower`";
    "<mass value=\"2\"/>" => "": "link upper_arm: <inertial> has no <mass>" / "<inertial>" / "needs <mass>";
    "<child link=\"forearm\"/>" => "": "joint elbow: <joint> has no <child>" / "<joint name=\"elbow\"" / "needs <child>";
    "<mass value=\"2\"/>" => "<mass value=\"2\"/><mass value=\"3\"/>":
        "link upper_arm: second <mass>" / "<mass value=\"3\"/>" / "only one may stand in <inertial>";
    "<mass value=\"2\"/>" => "<mass value=\"2\"/> 2 kg":
        "link upper_arm: text in <inertial>" / " 2 kg" / "a URDF says everything in attributes";
    "<robot name=\"small\">" => "<robot name=\"small\" version=\"1.2\">":
        "robot small: URDF version 1.2" / "1.2" / "graspcheck reads version 1.0";
    "looks.dae" => "": "link base: filename is empty" / "" / "needs a value";
    "<box size=\"0.2 0.2 0.1\"/>" => "": "link base: <geometry> with 0 shapes" / "<geometry>" / "must hold exactly one";
    "<sphere radius=\"0.05\"/>" => "<sphere radius=\"0.05\"/><sphere radius=\"0.04\"/>":
        "link hand: second <sphere>" / "<sphere radius=\"0.04\"/>" / "only one may stand in <geometry>";
];

const NUMBERS: &[Spoiled] = table![
    "xyz=\"0.5 0.1 0\"" => "xyz=\"0.5 oops 0.1 0\"":
        "link upper_arm: xyz \"0.5 oops 0.1 0\"" / "0.5 oops" / "`oops` is not a number";
    "xyz=\"0.5 0.1 0\"" => "xyz=\"0.5 0.1\"":
        "link upper_arm: xyz \"0.5 0.1\"" / "0.5 0.1" / "takes 3 numbers, has 2";
    "xyz=\"0.5 0.1 0\"" => "xyz=\"0.5 0.1 0 0\"":
        "link upper_arm: xyz \"0.5 0.1 0 0\"" / "0.5 0.1 0 0" / "takes 3 numbers, has 4";
    "<mass value=\"2\"/>" => "<mass value=\"nan\"/>":
        "link upper_arm: value \"nan\"" / "nan" / "`nan` is not finite";
    "upper=\"2.9\"" => "upper=\"inf\"": "joint elbow: upper \"inf\"" / "inf" / "`inf` is not finite";
    "upper=\"2.9\"" => "upper=\"2,9\"": "joint elbow: upper \"2,9\"" / "2,9" / "`2,9` is not a number";
    "<mass value=\"2\"/>" => "<mass value=\"0\"/>":
        "link upper_arm: value \"0\" must be positive" / "0" / "must be positive";
    "effort=\"100\"" => "effort=\"-100\"":
        "joint elbow: effort \"-100\" must be positive" / "-100" / "must be positive";
    "effort=\"100\"" => "effort=\"0\"": "joint elbow: effort \"0\" must be positive" / "0" / "must be positive";
    "damping=\"0.5\"" => "damping=\"-0.5\"":
        "joint shoulder: damping \"-0.5\" must not be negative" / "-0.5" / "must not be negative";
    "radius=\"0.05\" length" => "radius=\"0\" length":
        "link upper_arm: radius \"0\" must be positive" / "0" / "must be positive";
    "upper=\"2.9\"" => "upper=\"-2.95\"":
        "joint elbow: lower -2.9 is not below upper -2.95" / "<limit lower" / "leaves no room to move";
    "iyy=\"0.2\"" => "iyy=\"-0.2\"":
        "link upper_arm: inertia tensor: principal moment -2.003e-1 kg·m² must be positive"
        / "<inertia ixx" / "no rigid body has this inertia";
    "izz=\"0.25\"" => "izz=\"0.5\"":
        "link upper_arm: inertia tensor: principal moment 5.000e-1 kg·m² exceeds the sum 3.000e-1 kg·m² of the two others"
        / "<inertia ixx" / "no rigid body has this inertia";
    "<axis xyz=\"0 0 1\"/>" => "": "joint shoulder: no <axis>" / "<joint name=\"shoulder\"" / "other readers take x";
    "<axis xyz=\"0 0 1\"/>" => "<axis xyz=\"0 0 2\"/>":
        "joint shoulder: axis has length 2, must be 1" / "0 0 2" / "not a unit vector";
    "<axis xyz=\"0 0 1\"/>" => "<axis xyz=\"0 0 0\"/>":
        "joint shoulder: axis has length 0, must be 1" / "0 0 0" / "not a unit vector";
    "<limit lower=\"-4.7\" upper=\"4.7\" velocity=\"1.5\" effort=\"300\"/>" => "":
        "joint shoulder: no <limit>" / "<joint name=\"shoulder\"" / "needs lower, upper, effort and velocity";
    "name=\"elbow\" type=\"revolute\"" => "name=\"elbow\" type=\"floating\"":
        "joint elbow: type floating is not supported" / "floating" / "an arm has joints of one degree of freedom";
    "name=\"elbow\" type=\"revolute\"" => "name=\"elbow\" type=\"continuous\"":
        "joint elbow: type continuous is not supported" / "continuous" / "write revolute, with limits";
    "name=\"elbow\" type=\"revolute\"" => "name=\"elbow\" type=\"revolut\"":
        "joint elbow: type revolut is not supported" / "revolut" / "did you mean `revolute`?";
    "forearm.stl" => "forearm.dae":
        "link forearm: mesh forearm.dae is not an STL file" / "forearm.dae" / "only .stl is read";
    "<mimic joint=\"finger_left_slide\"/>" => "<mimic joint=\"finger_left_slide\" multiplier=\"-1\"/>":
        "joint finger_right_slide: mimic multiplier -1 must be 1" / "-1" / "both fingers move by the same amount";
    "<mimic joint=\"finger_left_slide\"/>" => "<mimic joint=\"finger_left_slide\" offset=\"0.1\"/>":
        "joint finger_right_slide: mimic offset 0.1 must be 0" / "0.1" / "both fingers move by the same amount";
];

const STRUCTURE: &[Spoiled] = table![
    "<link name=\"palm\">" => "<link name=\"hand\">": "two links are called hand" / "hand" / "already taken";
    "<joint name=\"elbow\"" => "<joint name=\"wrist\"": "two joints are called wrist" / "wrist" / "already taken";
    "<parent link=\"upper_arm\"/>" => "<parent link=\"upper_arn\"/>":
        "joint elbow: no link upper_arn" / "upper_arn" / "did you mean `upper_arm`?";
    "<child link=\"forearm\"/>" => "<child link=\"leg\"/>": "joint elbow: no link leg" / "leg" / "no link has this name";
    "<mimic joint=\"finger_left_slide\"/>" => "<mimic joint=\"finger_left\"/>":
        "joint finger_right_slide: no joint finger_left" / "finger_left" / "no joint has this name";
    "<child link=\"palm\"/>" => "<child link=\"forearm\"/>":
        "link forearm: moved by joint elbow and by joint hand_palm" / "forearm" / "already the child of another joint";
    "<link name=\"flange\"/>" => "<link name=\"flange\"/><link name=\"lost\"/>":
        "link lost: does not hang on base" / "<link name=\"lost\"/>" / "no joint moves it";
    "<inertial><mass value=\"1\"/><inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial>" => "":
        "link forearm: no <inertial>" / "<link name=\"forearm\">" / "moves, so it needs mass and inertia";
    "<inertial><origin xyz=\"0.1 0 0\"/><mass value=\"1\"/><inertia ixx=\"0.1\" ixy=\"0\" ixz=\"0\" iyy=\"0.1\" iyz=\"0\" izz=\"0.1\"/></inertial>" => "":
        "link palm: no <inertial>" / "<link name=\"palm\">" / "is solid, so it needs mass";
    "<mimic joint=\"finger_left_slide\"/>" => "":
        "robot small: no joint mimics another" / "<robot name=\"small\">" / "has no gripper";
    "<axis xyz=\"0 1 0\"/>" => "<axis xyz=\"0 1 0\"/><mimic joint=\"finger_right_slide\"/>":
        "joint finger_right_slide: a second joint that mimics" / "<joint name=\"finger_right_slide\"" / "only one finger follows";
    "<mimic joint=\"finger_left_slide\"/>" => "<mimic joint=\"finger_right_slide\"/>":
        "joint finger_right_slide: mimics itself" / "<joint name=\"finger_right_slide\"" / "must name the other finger";
    "name=\"finger_left_slide\" type=\"prismatic\"" => "name=\"finger_left_slide\" type=\"revolute\"":
        "joint finger_left_slide: a finger that is not prismatic" / "<joint name=\"finger_left_slide\"" / "must be prismatic";
    "<parent link=\"flange\"/><child link=\"finger_left\"/>" => "<parent link=\"forearm\"/><child link=\"finger_left\"/>":
        "joint finger_left_slide: finger on link forearm, not on hand" / "forearm" / "must stand on the last link of the arm, hand";
    "<parent link=\"forearm\"/>" => "<parent link=\"base\"/>":
        "joint wrist: the arm branches at link base" / "<joint name=\"wrist\"" / "joint shoulder moves on from there already";
];

/// The faults of a spoiled text are exactly the one of the row; faults of structure may follow from it.
fn check(rows: &[Spoiled]) {
    for row in rows {
        let text = spoiled(GOOD, row.from, row.to);
        let found = faults(&text);
        let hit = found.iter().any(|fault| {
            fault.title == row.title
                && text[fault.span.clone()].starts_with(row.at)
                && fault.label == row.label
                && (row.at.is_empty() || !fault.span.is_empty())
        });
        assert!(hit, "{} -> {}:\n{found:#?}", row.from, row.to);
    }
}

#[test]
fn the_good_text_is_good() {
    let document = parse(GOOD).unwrap();
    assert_eq!(document.chain.root, "base");
    assert_eq!(document.chain.arm, ["shoulder", "elbow", "wrist"]);
    assert_eq!(document.chain.fingers, ["finger_left_slide", "finger_right_slide"]);
    assert_eq!(document.robot.links.len(), 8);
    assert_eq!(&GOOD[document.joint_span("elbow")], "<joint name=\"elbow\" type=\"revolute\">");
    assert_eq!(&GOOD[document.link_span("flange")], "<link name=\"flange\"/>");
    assert_eq!(&GOOD[document.mesh_span("forearm.stl")], "forearm.stl");
    assert_eq!(document.mesh_span("no.stl"), 0..0);
    assert_eq!(document.joint_kind("elbow"), Some(JointKind::Revolute));
    assert_eq!(document.joint_kind("finger_left_slide"), Some(JointKind::Prismatic));
    assert_eq!(document.joint_kind("hand_palm"), None);
    assert_eq!(document.joint_kind("knee"), None);
}

#[test]
fn faults_of_form() {
    check(FORM);
}

#[test]
fn faults_of_numbers_and_words() {
    check(NUMBERS);
}

#[test]
fn faults_of_structure() {
    check(STRUCTURE);
}

#[test]
fn a_spoiled_text_has_one_fault_unless_others_follow_from_it() {
    for row in FORM.iter().chain(NUMBERS).chain(STRUCTURE) {
        let found = faults(&spoiled(GOOD, row.from, row.to));
        // A missing or renamed part can break the structure too; it must not set off an avalanche.
        assert!(found.len() <= 3, "{} -> {}:\n{found:#?}", row.from, row.to);
    }
}

#[test]
fn a_document_of_another_kind_is_named() {
    let found = faults("<sdf version=\"1.9\"><model/></sdf>");
    assert_eq!(found[0].title, "the document is <sdf>, not <robot>");
    assert_eq!(found[0].span, 1..4);
}

#[test]
fn an_empty_robot_and_a_loop_have_no_base() {
    let found = faults("<robot name=\"r\"/>");
    assert_eq!((found.len(), found[0].label.as_str()), (1, "has no links"));
    let ring = "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/>\
        <joint name=\"x\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\
        <joint name=\"y\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint></robot>";
    let found = faults(ring);
    assert_eq!((found.len(), found[0].label.as_str()), (1, "its links form a loop"));
}

#[test]
fn a_loop_beside_the_tree_is_loose() {
    let ring = GOOD.replace(
        "<link name=\"flange\"/>",
        "<link name=\"flange\"/><link name=\"a\"/><link name=\"b\"/>\
         <joint name=\"x\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>\
         <joint name=\"y\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint>",
    );
    let found = faults(&ring);
    assert_eq!(found.len(), 2, "{found:#?}");
    assert!(found.iter().all(|fault| fault.label == "hangs on a link that is loose itself"));
}

#[test]
fn all_faults_come_at_once_in_the_order_of_the_text() {
    let mut text = GOOD.to_owned();
    for (from, to) in [
        ("<mass value=\"2\"/>", "<mass value=\"nan\"/>"),
        ("upper=\"2.9\"", "uper=\"2.9\""),
        ("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 3 4\"/>"),
        ("effort=\"20\"", "effort=\"20\" jerk=\"9\""),
    ] {
        text = spoiled(&text, from, to);
    }
    let titles: Vec<String> = faults(&text).into_iter().map(|fault| fault.title).collect();
    assert_eq!(
        titles,
        [
            "link upper_arm: value \"nan\"",
            "joint elbow: <limit> has no `upper`",
            "joint elbow: unknown attribute `uper` of <limit>",
            "joint wrist: limit of jerk in a URDF",
            "joint finger_left_slide: axis has length 5, must be 1",
        ]
    );
    assert_eq!(faults(&text)[4].help.as_deref(), Some("<axis xyz=\"0 0.6 0.8\"/>"));
}

#[test]
fn a_place_behind_letters_of_several_bytes_is_still_right() {
    let text = format!(
        "<!-- größer als ±5° — ✓ -->\n{}",
        spoiled(GOOD.trim_start_matches("<?xml version=\"1.0\"?>\n"), "</robot>", "ä")
    );
    let found = faults(&text);
    assert_eq!(found.len(), 1);
    assert!(text.is_char_boundary(found[0].span.start) && text.is_char_boundary(found[0].span.end));
}

#[test]
fn the_arms_of_the_assets_have_no_fault() {
    for (text, arm) in [
        (
            include_str!("../../../../assets/robots/scara/scara.urdf"),
            &["shoulder", "elbow", "quill", "wrist"][..],
        ),
        (include_str!("../../../../assets/robots/rrr/rrr.urdf"), &["shoulder", "elbow", "wrist"][..]),
    ] {
        let document = parse(text).unwrap_or_else(|faults| panic!("{faults:#?}"));
        assert_eq!(document.chain.arm, arm);
        assert_eq!(document.chain.fingers, ["finger_left_slide", "finger_right_slide"]);
    }
}
