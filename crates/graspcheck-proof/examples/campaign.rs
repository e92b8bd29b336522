//! Long trials of the proofs against samples and distances that are not theirs.
//!
//! ```text
//! cargo run --release -p graspcheck-proof --example campaign -- --arm scara --scenes 20000 --first 0
//! ```
//!
//! Without `--arm` all three follow each other. It prints what was counted, and every claim that is not true; then it
//! ends with an error.

#![expect(clippy::print_stdout, reason = "an example prints")]

use std::process::ExitCode;

#[path = "../tests/trial/mod.rs"]
mod trial;

use trial::{
    arms::Arm,
    judge::{Tally, judge},
    random::Case,
};

const USAGE: &str = "campaign [--arm scara|rrr|chain] [--scenes NUMBER] [--first SEED]";

struct Arguments {
    arms: Vec<Arm>,
    scenes: u64,
    first: u64,
}

fn arguments() -> Result<Arguments, String> {
    let mut found = Arguments { arms: Arm::ALL.to_vec(), scenes: 1000, first: 0 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let value = words.next().ok_or_else(|| format!("{word} needs a value; {USAGE}"))?;
        let number = || value.parse::<u64>().map_err(|fault| format!("{word} {value}: {fault}; {USAGE}"));
        match word.as_str() {
            "--scenes" => found.scenes = number()?,
            "--first" => found.first = number()?,
            "--arm" => {
                let arm = Arm::ALL.into_iter().find(|arm| arm.name() == value);
                found.arms = vec![arm.ok_or_else(|| format!("there is no arm {value}; {USAGE}"))?];
            }
            _ => return Err(format!("there is no {word}; {USAGE}")),
        }
    }
    Ok(found)
}

fn print(arm: Arm, tally: &Tally) {
    let Tally { scenes, held, free_scenes, violated_scenes, unknown_scenes, .. } = tally;
    println!("{}: {scenes} scenes, {held} with a held object", arm.name());
    println!(
        "  scenes: {free_scenes} free, {violated_scenes} with a hit, {unknown_scenes} with an unknown pair"
    );
    let Tally { free, violated, unknown, not_checked, leaves, sweeps, .. } = tally;
    println!(
        "  pairs: {free} free, {violated} hit, {unknown} unknown, {not_checked} not checked; {leaves} leaves, {sweeps} sweeps"
    );
    let Tally { looked_at, excluded, vague, bracketed, loose, .. } = tally;
    println!(
        "  10 kHz samples: {looked_at} looked at, {excluded} excluded by the speed bound, {vague} vague"
    );
    println!("  least margins: {bracketed} bracketed, {loose} of overlaps with an open depth");
    println!("  contradictions: {}", tally.contradictions.len());
    for contradiction in &tally.contradictions {
        println!("    {contradiction}");
    }
}

fn main() -> ExitCode {
    let arguments = match arguments() {
        Ok(arguments) => arguments,
        Err(fault) => {
            println!("{fault}");
            return ExitCode::FAILURE;
        }
    };
    let mut all_true = true;
    for arm in arguments.arms {
        let mut tally = Tally::default();
        for seed in arguments.first..arguments.first + arguments.scenes {
            tally.add(judge(&format!("{} {seed}", arm.name()), &Case::random(arm, seed), seed % 4 == 0));
        }
        print(arm, &tally);
        all_true &= tally.contradictions.is_empty();
    }
    if all_true { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
