//! The command line as a user meets it: exit codes, messages, and nothing half-written.

#![expect(clippy::unwrap_used, reason = "a helper of a test fails like the test")]

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Runs the binary in the workspace with results into an empty folder of this test.
fn graspcheck(test: &str, arguments: &[&str]) -> (Output, PathBuf) {
    let out = folder(test).join("out");
    let output = Command::new(env!("CARGO_BIN_EXE_graspcheck"))
        .args(arguments)
        .current_dir(WORKSPACE)
        .env("GRASPCHECK_OUT", &out)
        .env_remove("CLICOLOR_FORCE")
        .output()
        .expect("the binary starts");
    (output, out)
}

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command_line").join(test);
    fs::create_dir_all(&folder).expect("the folder for temporary files can be written");
    folder
}

fn fresh_folder(test: &str) -> PathBuf {
    let _ = fs::remove_dir_all(folder(test));
    folder(test)
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A scenario file of this test that changes `scara/pick_cube.toml`, with a copy of its robot beside it.
fn changed_pick(test: &str, change: impl Fn(String) -> String) -> PathBuf {
    changed(test, "scara/pick_cube.toml", change)
}

/// The same for another scenario of the SCARA.
fn changed(test: &str, scenario: &str, change: impl Fn(String) -> String) -> PathBuf {
    let text = fs::read_to_string(Path::new(WORKSPACE).join("scenarios").join(scenario)).unwrap();
    let cells = Path::new(WORKSPACE).canonicalize().unwrap().join("scenarios/_cells");
    let text = text.replace("../_cells", &cells.display().to_string());
    let folder = fresh_folder(test);
    let robot = folder.join("assets/robots/scara");
    fs::create_dir_all(&robot).unwrap();
    for file in ["robot.toml", "scara.urdf"] {
        fs::copy(Path::new(WORKSPACE).join("assets/robots/scara").join(file), robot.join(file)).unwrap();
    }
    let path = folder.join("changed.toml");
    fs::write(&path, change(text)).unwrap();
    path
}

fn assert_fails(output: &Output, out: &Path, code: i32, sentences: &[&str]) {
    let text = stderr(output);
    assert_eq!(output.status.code(), Some(code), "{text}");
    for sentence in sentences {
        assert!(text.contains(sentence), "`{sentence}` is not in\n{text}");
    }
    assert!(!out.exists(), "something was written to {}", out.display());
}

#[test]
fn help_is_as_documented() {
    for (name, arguments) in [("help", vec!["--help"]), ("run_help", vec!["run", "--help"])] {
        let output = Command::new(env!("CARGO_BIN_EXE_graspcheck"))
            .args(arguments)
            .env_remove("GRASPCHECK_OUT")
            .output()
            .expect("the binary starts");
        assert!(output.status.success());
        insta::assert_snapshot!(name, String::from_utf8_lossy(&output.stdout));
    }
}

#[test]
fn list_names_scenarios_on_stdout() {
    let (output, _) = graspcheck("list", &["list"]);
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.lines().any(|line| line.starts_with("scara::pick_cube ")), "{text}");
}

#[test]
fn a_prefix_of_names_selects_many() {
    let (output, _) = graspcheck("prefix", &["run", "scara::pick", "--no-simulate"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("2 scenarios"));
}

#[test]
fn a_refuted_plan_is_not_called_proved() {
    let (output, _) = graspcheck("refuted", &["run", "negative::planned_collision"]);
    let text = stderr(&output);
    assert!(text.contains("Refuted") && !text.contains("Proved"), "{text}");
}

#[test]
fn a_run_prints_its_verdict_on_stdout_and_writes_its_log() {
    let _ = fresh_folder("run");
    let (output, out) = graspcheck("run", &["run", "scara::pick_cube"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.lines().any(|line| line.starts_with("PASS  ")), "{text}");
    assert!(!text.contains('\u{1b}'), "no colours into a pipe");
    assert!(out.join("scara/pick_cube/run.mcap").is_file());
    let files = fs::read_dir(out.join("scara/pick_cube")).unwrap();
    assert!(files.flatten().all(|file| !file.file_name().to_string_lossy().ends_with(".tmp")));
}

#[test]
fn a_run_without_execution_says_so_and_has_files_of_its_own() {
    let _ = fresh_folder("no_simulate");
    let (output, out) = graspcheck("no_simulate", &["run", "scara::pick_cube", "--no-simulate"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("plan only   not executed"), "{text}");
    assert!(text.contains(" checks of the plan; tightest") && text.ends_with("; not executed\n"), "{text}");
    let executed = text.split("executed\n").nth(1).unwrap_or_default();
    assert!(!executed.contains("not requested"), "{text}");
    assert!(out.join("scara/pick_cube/plan.mcap").is_file());
    assert!(!out.join("scara/pick_cube/run.mcap").exists());
}

#[test]
fn without_execution_its_expected_failures_do_not_count() {
    let (output, _) =
        graspcheck("no_simulate_fail", &["run", "negative::planned_collision", "--no-simulate"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("as expected: planned.clearance; not executed, so failures"), "{text}");
    assert!(text.contains("slip"), "{text}");

    let (output, _) = graspcheck("no_simulate_none", &["run", "negative::weak_grip", "--no-simulate"]);
    assert_eq!(output.status.code(), Some(11), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("NOT JUDGED  ") && text.contains(" checks of the plan pass"), "{text}");
    assert!(!text.contains("PASS"), "{text}");

    let (output, _) = graspcheck("no_simulate_suite", &["run", "negative", "--no-simulate"]);
    assert_eq!(output.status.code(), Some(11), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("nothing was executed") && text.contains("not judged"), "{text}");
}

#[test]
fn the_choice_of_the_grasp_is_shown_and_kept_in_the_log() {
    let (output, out) = graspcheck("choice", &["run", "scara::pick_cube", "--no-simulate"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("grasp   side x, elbow left, wrist turn 1; best of 144: 143 not faster\n"),
        "{text}"
    );
    assert!(!text.contains("as fast as the chosen one"), "{text}");
    let log = fs::read(out.join("scara/pick_cube/plan.mcap")).unwrap();
    let recording = graspcheck_recording::from_bytes(&log).unwrap();
    let kept = recording.attachments.iter().find(|document| document.name == "candidates.json").unwrap();
    let kept: serde_json::Value = serde_json::from_slice(&kept.data).unwrap();
    let ways = kept["candidates"].as_array().unwrap();
    assert_eq!(ways.len(), 144);
    assert_eq!((&ways[0]["outcome"], &ways[0]["handle"]), (&"chosen".into(), &"side x".into()));

    let (output, _) = graspcheck("choice", &["run", "scara::pick_cube", "--no-simulate", "-v"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(
        text.lines().filter(|line| line.contains(" elbow ") && line.contains("complete")).count(),
        144
    );

    let (output, _) = graspcheck("choice", &["run", "negative::planned_collision", "--no-simulate"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("none is proved clear, the fastest of 144: 143 refuted"), "{text}");
}

#[test]
fn a_failure_shows_where_it_began_and_where_it_is_worst() {
    let (output, _) = graspcheck("began", &["run", "negative::weak_grip"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let slip = text.split("\nexecuted.slip").nth(1).unwrap().lines().nth(1).unwrap().to_owned();
    assert!(slip.starts_with("  first  at t = 2.1") && slip.contains(" s, lift; last at t = "), "{slip}");
    assert!(slip.contains("; worst at t = 3."), "{slip}");
    let column = |line: &str, mark: &str| line.find(mark).map(|at| line[..at].chars().count());
    let find = |mark: &str| text.lines().find_map(|line| column(line, mark)).unwrap();
    assert!((find("├lift")..find("├carry")).contains(&find("▲ slip")), "{text}");
    let last = text.lines().last().unwrap();
    assert!(last.contains("; first at t = 2.1") && last.ends_with("executed.slip, lift"), "{last}");
}

#[test]
fn the_least_duration_that_is_told_is_the_least() {
    let changed = |duration: &str| {
        changed("least", "negative/velocity_limit.toml", |text| {
            text.replacen("duration_s = 0.507", &format!("duration_s = {duration}"), 1)
        })
    };
    let run = |path: &Path| graspcheck("least", &["run", &path.display().to_string(), "--no-simulate"]).0;
    let text = String::from_utf8_lossy(&run(&changed("0.4")).stdout).into_owned();
    let told = text.split("try    [phase.swing] duration_s = ").nth(1).unwrap().split(':').next().unwrap();
    let planned = |text: &str| text.lines().last().unwrap().starts_with("PASS");
    let with = |duration: f64| {
        let output = run(&changed(&format!("{duration:.3}")));
        planned(&String::from_utf8_lossy(&output.stdout))
    };
    let told: f64 = told.parse().unwrap();
    assert!(with(told) && !with(told - 0.001), "{told}: {text}");
}

#[test]
fn quiet_leaves_one_line_of_a_pass_and_nothing_when_asked_twice() {
    let (output, _) = graspcheck("quiet", &["run", "scara::pick_cube", "-q"]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(text.lines().count(), 1, "{text}");
    assert!(text.starts_with("scara::pick_cube  PASS  "), "{text}");
    let (output, _) = graspcheck("quiet", &["run", "scara::pick_cube", "-qq"]);
    assert!(output.stdout.is_empty() && output.stderr.is_empty(), "{}", stderr(&output));
}

/// Up to the simulation, whose last digits may differ between processors.
#[test]
fn the_readme_shows_what_its_first_command_prints() {
    let readme = fs::read_to_string(Path::new(WORKSPACE).join("README.md")).unwrap();
    let shown = readme.split("```text\n").nth(1).expect("the README shows the output");
    let (output, _) = graspcheck("readme", &["run", "scenarios/scara/pick_cube.toml"]);
    let printed = String::from_utf8_lossy(&output.stdout);
    let planned = |text: &str| text.split("executed").next().map(str::to_owned);
    assert_eq!(planned(shown), planned(&printed), "paste the output of the first command into the README");
    let shown = shown.split("```").next().unwrap_or_default();
    assert_eq!(shown.lines().last(), printed.lines().last(), "the last line is about the plan");
}

#[test]
fn a_scenario_that_fails_on_purpose_is_as_expected() {
    let (output, _) = graspcheck("negative", &["run", "negative::velocity_limit"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
}

#[test]
fn a_verdict_that_is_not_as_expected_has_a_code_of_its_own() {
    let path = changed_pick("unexpected", |text| format!("expect_fail = [\"slip\"]\n{text}"));
    let (output, _) = graspcheck("unexpected", &["run", &path.display().to_string()]);
    assert_eq!(output.status.code(), Some(10), "{}", stderr(&output));
}

#[test]
fn the_command_line_is_checked() {
    let (output, out) = graspcheck("usage", &["run"]);
    assert_fails(&output, &out, 2, &["SCENARIO"]);
    let (output, out) = graspcheck("usage", &["list", "--nothing"]);
    assert_fails(&output, &out, 2, &["--nothing"]);
}

#[test]
fn what_names_nothing_is_told_in_the_same_words_everywhere() {
    for arguments in [
        ["run", "no::such_scenario"],
        ["run", "nope.toml"],
        ["run", "scenarios/nope"],
        ["run", "scenarios/scara/absent.toml"],
        ["list", "nope"],
        ["list", "scenarios/scara/absent.toml"],
    ] {
        let (output, out) = graspcheck("nothing", &arguments);
        let sentence =
            format!("error: {}: no such file, folder or scenario; see graspcheck list", arguments[1]);
        assert_fails(&output, &out, 3, &[&sentence]);
    }
}

#[test]
fn folders_without_scenarios_say_so() {
    let empty = fresh_folder("empty").display().to_string();
    let robot = "assets/robots/scara/robot.toml";
    for command in ["run", "list"] {
        for folder in ["assets", &empty] {
            let (output, out) = graspcheck("no_scenario", &[command, folder]);
            assert_fails(&output, &out, 3, &[&format!("error: {folder}: there is no scenario here\n")]);
        }
        for path in ["scenarios/_cells", "scenarios/_cells/bench.toml"] {
            let (output, out) = graspcheck("no_scenario", &[command, path]);
            let sentence = format!(
                "{path}: there is no scenario here; a folder whose name begins with `_` holds files to extend"
            );
            assert_fails(&output, &out, 3, &[&sentence]);
        }
    }
    // A file that is named is read, and says itself why it is none.
    let (output, out) = graspcheck("no_scenario", &["run", robot]);
    assert_fails(&output, &out, 20, &["unknown key `urdf`"]);
}

#[test]
fn all_faults_of_a_file_come_with_their_lines() {
    let path = changed_pick("faults", |text| {
        text.replace("mass_kg", "weight_kg").replace("quill_mm", "quill_deg").replace("title", "titel")
    });
    let (output, out) = graspcheck("faults", &["run", &path.display().to_string()]);
    let sentences = [
        "unknown key `weight_kg`",
        "did you mean `mass_kg`?",
        "joint quill is prismatic: `quill_deg` has the unit of an angle",
        "unknown key `titel`",
        "changed.toml:",
        "nothing was run",
    ];
    assert_fails(&output, &out, 20, &sentences);
}

/// The pick with the object somewhere else, or its place.
fn pick_moved(test: &str, from: &str, to: &str) -> PathBuf {
    changed_pick(test, |text| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

#[test]
fn an_object_out_of_reach_is_explained_with_its_candidates() {
    let path = pick_moved("unreachable", "[280, -180, 15]", "[190, -60, 15]");
    let (output, out) = graspcheck("unreachable", &["run", &path.display().to_string()]);
    let sentences =
        ["UNREACHABLE  cube at (190.0, -60.0, 15.0) mm", "reachable", "elbow left", "try  at_mm = ["];
    assert_fails(&output, &out, 21, &sentences);
    // 24 ways that differ in turns of the wrist and in handles: one row for each elbow.
    let rows = |text: &str| text.lines().filter(|line| line.contains("elbow 8.9°")).count();
    assert_eq!(rows(&stderr(&output)), 2, "{}", stderr(&output));
    let (output, _) = graspcheck("unreachable", &["run", "-v", &path.display().to_string()]);
    assert_eq!(rows(&stderr(&output)), 24, "{}", stderr(&output));
}

#[test]
fn what_is_suggested_instead_of_an_unreachable_place_can_be_run() {
    const OBJECT: &str = "[280, -180, 15]";
    const PLACE: &str = "[330, 150, 15]";
    for (case, from, to) in [
        ("too_near", OBJECT, "[190, -60, 15]"),
        ("too_far", OBJECT, "[470, -180, 15]"),
        ("straight_on", OBJECT, "[452, 0, 15]"),
        ("place_too_far", PLACE, "[450, 150, 15]"),
        ("place_too_near", PLACE, "[180, 40, 15]"),
    ] {
        let path = pick_moved(case, from, to);
        let arguments = ["run", &path.display().to_string(), "--no-simulate"];
        let (output, _) = graspcheck(case, &arguments);
        let text = stderr(&output);
        assert_eq!(output.status.code(), Some(21), "{case}: {text}");
        let line = text.lines().find(|line| line.starts_with("  try  ")).unwrap_or_default();
        let numbers = line.find("at_mm = [").map(|at| &line[at + "at_mm = ".len()..]);
        let numbers = &numbers.expect("a place is suggested")[..=numbers.unwrap().find(']').unwrap()];
        let scenario = fs::read_to_string(&path).unwrap();
        fs::write(&path, scenario.replacen(to, numbers, 1)).unwrap();
        let (output, _) = graspcheck(case, &arguments);
        assert_eq!(output.status.code(), Some(0), "{case}: {line}\n{}", stderr(&output));
    }
}

/// A scenario with another URDF of the SCARA.
fn changed_robot(test: &str, change: impl Fn(String) -> String) -> PathBuf {
    let path = changed_pick(test, |text| text);
    let urdf = folder(test).join("assets/robots/scara/scara.urdf");
    let text = fs::read_to_string(&urdf).unwrap();
    fs::write(&urdf, change(text)).unwrap();
    path
}

#[test]
fn faults_of_a_urdf_are_shown_in_it() {
    let path = changed_robot("urdf", |urdf| {
        urdf.replacen("<mass value=\"4.5\"/>", "<mass value=\"oops\"/>", 1).replacen(
            "velocity=\"7.5\"",
            "velocity=\"7.5\" jerk=\"3000\"",
            1,
        )
    });
    let (output, out) = graspcheck("urdf", &["run", &path.display().to_string()]);
    assert_fails(&output, &out, 20, &["scara.urdf:", "oops", "jerk", "robot.toml"]);
}

#[test]
fn an_unreadable_mesh_is_a_fault_of_the_urdf() {
    let path = changed_robot("mesh", |urdf| {
        let collision = urdf.find("<collision").expect("the URDF has a collision shape");
        let at = collision + urdf[collision..].find("<box size").expect("which is a box");
        let end = at + urdf[at..].find("/>").expect("which ends") + 2;
        format!("{}<mesh filename=\"lost.stl\"/>{}", &urdf[..at], &urdf[end..])
    });
    let (output, out) = graspcheck("mesh", &["run", &path.display().to_string()]);
    assert_fails(&output, &out, 20, &["scara.urdf:", "lost.stl"]);
}

/// The log of the pick, run once for all tests that review it.
fn log_of_the_pick() -> PathBuf {
    static RUN: std::sync::Once = std::sync::Once::new();
    let log = folder("review_run").join("out/scara/pick_cube/run.mcap");
    RUN.call_once(|| {
        let (output, _) = graspcheck("review_run", &["run", "scara::pick_cube", "-q"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    });
    log
}

/// The pick's log with something in it changed, as a file of its own.
fn edited_log(name: &str, change: impl FnOnce(&mut graspcheck_recording::Recording)) -> PathBuf {
    let mut recording = graspcheck_recording::load(&log_of_the_pick()).unwrap();
    change(&mut recording);
    let log = folder("review_edited").join(format!("{name}.mcap"));
    graspcheck_recording::save(&recording, &log).unwrap();
    log
}

fn edit_document(
    recording: &mut graspcheck_recording::Recording,
    name: &str,
    change: impl FnOnce(&mut serde_json::Value),
) {
    let document = recording.attachments.iter_mut().find(|document| document.name == name).unwrap();
    let mut content = serde_json::from_slice(&document.data).unwrap();
    change(&mut content);
    document.data = serde_json::to_vec(&content).unwrap();
}

fn scale(number: &mut serde_json::Value, factor: f64) {
    *number = (number.as_f64().unwrap() * factor).into();
}

fn review(logs: &[&Path], flags: &[&str]) -> (Option<i32>, String) {
    let logs = logs.iter().map(|log| log.to_str().unwrap());
    let arguments: Vec<&str> = ["review"].into_iter().chain(logs).chain(flags.iter().copied()).collect();
    let (output, _) = graspcheck("review", &arguments);
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned() + &stderr(&output))
}

#[test]
fn a_log_is_judged_again_from_its_file_alone() {
    let (code, text) = review(&[&log_of_the_pick()], &[]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("scara::pick_cube") && text.lines().any(|line| line.starts_with("PASS  ")),
        "{text}"
    );
    assert!(text.contains("the verdict in the log is this one"), "{text}");
    assert!(text.contains(" limit proofs re-validated independently"), "{text}");

    let (code, text) = review(&[&log_of_the_pick(), &log_of_the_pick()], &[]);
    assert_eq!(code, Some(0), "{text}");
    assert_eq!(text.lines().filter(|line| line.starts_with("   ok  ")).count(), 2, "{text}");
}

#[test]
fn an_edited_log_is_told_by_what_was_edited() {
    for (name, change, sentences) in [
        (
            "sample",
            (|log| log.measured.position[100 * log.measured.names.len()] += 1e-3)
                as fn(&mut graspcheck_recording::Recording),
            ["executed.consistency: value is ", "log    says something else in "],
        ),
        (
            "effort",
            |log| {
                edit_document(log, "limits.json", |proofs| {
                    let limits = proofs["limits"].as_array_mut().unwrap();
                    let effort = limits.iter_mut().find(|proof| proof["quantity"] == "effort").unwrap();
                    scale(&mut effort["bound"], 0.5);
                });
            },
            ["proof: effort of joint shoulder: bound is ", "log    says something else in "],
        ),
        (
            "limit",
            |log| {
                edit_document(log, "resolved.json", |resolved| {
                    scale(&mut resolved["robot"]["joints"][0]["limits"]["velocity"], 2.0);
                });
            },
            ["planned.velocity: limit is 7.5", "proof: velocity of shoulder, t = 0 … 4"],
        ),
        (
            "certificate",
            |log| {
                edit_document(log, "certificate.json", |certificate| {
                    scale(&mut certificate["pairs"][3]["leaves"][0]["gap"], 1.001);
                });
            },
            ["planned.certificate: outcome is pass in the log, found to be fail", ": gap is 0."],
        ),
        (
            "verdict",
            |log| {
                let mut verdict = serde_json::from_str(log.verdict.as_ref().unwrap()).unwrap();
                let check = |verdict: &mut serde_json::Value| scale(&mut verdict["checks"][1]["margin"], 2.0);
                check(&mut verdict);
                log.verdict = Some(verdict.to_string());
            },
            ["planned.position: margin is 0.01", "says something else in 1 places"],
        ),
    ] {
        let (code, text) = review(&[&edited_log(name, change)], &[]);
        assert_eq!(code, Some(13), "{name}: {text}");
        for sentence in sentences {
            assert!(text.contains(sentence), "{name}: `{sentence}` is not in\n{text}");
        }
    }
}

#[test]
fn what_is_no_log_cannot_be_reviewed() {
    let folder = fresh_folder("review_unreadable");
    let [noise, cut, bare, gone] =
        ["noise", "cut", "bare", "gone"].map(|name| folder.join(format!("{name}.mcap")));
    fs::write(&noise, "this is no log").unwrap();
    let whole = fs::read(log_of_the_pick()).unwrap();
    fs::write(&cut, &whole[..whole.len() / 2]).unwrap();
    graspcheck_recording::save(&graspcheck_recording::Recording::default(), &bare).unwrap();
    for log in [&noise, &cut, &bare, &gone] {
        let (code, text) = review(&[log], &[]);
        assert_eq!(code, Some(30), "{text}");
        assert!(text.contains(&format!("error: {}: ", log.display())), "{text}");
    }
    let edited = edited_log("one_of_many", |log| log.verdict = None);
    let (code, text) = review(&[&log_of_the_pick(), &edited, &noise], &[]);
    assert_eq!(code, Some(30), "{text}");
    assert!(text.contains(" DIFF  ") && text.contains("verdict: is missing in the log"), "{text}");
}

#[test]
fn a_review_for_programs_is_one_json_document() {
    let edited = edited_log("for_programs", |log| log.verdict = None);
    let (output, _) = graspcheck(
        "review",
        &["review", "--json", log_of_the_pick().to_str().unwrap(), edited.to_str().unwrap(), "gone.mcap"],
    );
    assert_eq!(output.status.code(), Some(30), "{}", stderr(&output));
    let logs: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let [good, changed, gone] = logs.as_array().unwrap().as_slice() else { panic!("three logs: {logs}") };
    assert_eq!((&good["code"], &changed["code"], &gone["code"]), (&0.into(), &13.into(), &30.into()));
    assert_eq!((&good["verdict"]["outcome"], &good["proofs"]["confirmed"]), (&"pass".into(), &true.into()));
    assert_eq!(
        (good["differences"].as_array().unwrap().len(), changed["differences"].as_array().unwrap().len()),
        (0, 1)
    );
    assert!(good["proofs"]["limits"].as_u64().unwrap() == 20 && gone["error"].is_string());
}
