//! Exit codes of the command line. They are public interface: documented, and never given a new meaning.

use graspcheck_verify::{Outcome, Verdict};

/// Every verdict is as its scenario expects.
pub const AS_EXPECTED: u8 = 0;
/// A bug in graspcheck, or the output could not be written.
pub const BUG: u8 = 1;
/// The command line cannot be understood.
pub const USAGE: u8 = 2;
/// Nothing was selected: an empty suite is not a passing one.
pub const NOTHING_SELECTED: u8 = 3;
/// A verdict is not as expected.
pub const NOT_AS_EXPECTED: u8 = 10;
/// A check could not be decided.
pub const INCONCLUSIVE: u8 = 11;
/// A log says something else than is found in it: its verdict or its proofs were changed, or made otherwise.
pub const DIFFERS: u8 = 13;
/// A scenario, robot or other asset is invalid.
pub const INVALID_FILE: u8 = 20;
/// There is no plan for the task.
pub const NO_PLAN: u8 = 21;
/// A recording cannot be read.
pub const UNREADABLE_RECORDING: u8 = 30;

/// The order in which the code of a suite is chosen: the least recoverable comes first.
const WORST_FIRST: [u8; 7] =
    [BUG, INVALID_FILE, UNREADABLE_RECORDING, NO_PLAN, DIFFERS, NOT_AS_EXPECTED, INCONCLUSIVE];

/// The code of one verdict.
#[must_use]
pub fn of_verdict(verdict: &Verdict) -> u8 {
    match verdict.outcome {
        _ if verdict.as_expected => AS_EXPECTED,
        Outcome::Inconclusive | Outcome::NotRequested => INCONCLUSIVE,
        Outcome::Pass | Outcome::Fail => NOT_AS_EXPECTED,
    }
}

/// The code that speaks for all of `codes`: the least recoverable of them, [`AS_EXPECTED`] if there is none.
#[must_use]
pub fn worst(codes: &[u8]) -> u8 {
    WORST_FIRST.into_iter().find(|code| codes.contains(code)).unwrap_or(AS_EXPECTED)
}

/// One line for a code, as printed after a failure.
#[must_use]
pub fn meaning(code: u8) -> &'static str {
    match code {
        AS_EXPECTED => "as expected",
        USAGE => "command line not understood",
        NOTHING_SELECTED => "nothing was selected",
        NOT_AS_EXPECTED => "verdict not as expected",
        INCONCLUSIVE => "inconclusive",
        DIFFERS => "the log says something else than is found in it",
        INVALID_FILE => "scenario or asset invalid",
        NO_PLAN => "no plan",
        UNREADABLE_RECORDING => "recording unreadable",
        _ => "a bug, or output that could not be written",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_recoverable_code_wins() {
        assert_eq!(worst(&[]), AS_EXPECTED);
        assert_eq!(worst(&[AS_EXPECTED, INCONCLUSIVE, NOT_AS_EXPECTED]), NOT_AS_EXPECTED);
        assert_eq!(worst(&[NOT_AS_EXPECTED, DIFFERS, AS_EXPECTED]), DIFFERS);
        assert_eq!(worst(&[NOT_AS_EXPECTED, INVALID_FILE, NO_PLAN]), INVALID_FILE);
    }
}
