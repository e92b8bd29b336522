//! Random scenes of every arm, proved and judged: no claim of a proof is contradicted.
//!
//! `cargo run --release -p graspcheck-proof --example campaign -- --scenes 20000` runs as many as one likes.

use crate::trial::{
    arms::Arm,
    judge::{Tally, judge},
    random::Case,
};

fn campaign(arm: Arm, scenes: u64) -> Tally {
    let mut tally = Tally::default();
    for seed in 0..scenes {
        tally.add(judge(&format!("{} {seed}", arm.name()), &Case::random(arm, seed), seed % 4 == 0));
    }
    tally
}

fn assert_nothing_contradicts(arm: Arm, scenes: u64) {
    let tally = campaign(arm, scenes);
    let first = &tally.contradictions[..tally.contradictions.len().min(10)];
    assert!(first.is_empty(), "{} contradictions:\n{}", tally.contradictions.len(), first.join("\n"));
    assert_eq!((tally.unknown, tally.not_checked), (0, 0), "{tally:?}");
    assert_eq!(tally.vague, 0, "{tally:?}");
    // Both verdicts are met often, or the scenes try nothing.
    assert!(tally.free_scenes * 10 > scenes && tally.violated_scenes * 10 > scenes, "{tally:?}");
    assert!(tally.held * 10 > scenes && tally.leaves > 100 * scenes, "{tally:?}");
}

#[test]
fn nothing_contradicts_the_proofs_for_the_scara() {
    assert_nothing_contradicts(Arm::Scara, 25);
}

#[test]
fn nothing_contradicts_the_proofs_for_the_planar_arm() {
    assert_nothing_contradicts(Arm::Rrr, 25);
}

#[test]
fn nothing_contradicts_the_proofs_for_chains_with_skewed_axes() {
    assert_nothing_contradicts(Arm::Chain, 25);
}
