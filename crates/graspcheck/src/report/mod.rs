//! Renderings of findings for people. Everything here returns text; only the binary prints it.
//!
//! There is one structure of a finding, [`graspcheck_verify::CheckResult`]; the terminal's table, the
//! sentence in an event and the message of a failing test are renderings of it. Colours are written as
//! ANSI styles and stripped by the printer where they are not wanted.

mod candidates;
mod cure;
mod fault;
mod quantity;
mod sentence;
mod table;
mod unreachable;
mod verdict;

pub use fault::faults;
pub use quantity::{Rounding, against, instant, margin, quantity};
pub use sentence::{is_lower_limit, motion, note, sentence, subject, word};
pub use table::{DIM, FAILED, NAME, PASSED, UNDECIDED, Words, checks, strip, words};
pub use unreachable::{exit_code, is_expected, no_motion_line, no_run};
pub use verdict::{failure, last_line, page, plain};
