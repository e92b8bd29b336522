//! Scenario suites and tests that span crates; everything is under `tests/`.
