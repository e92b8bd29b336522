//! Scenario and robot files: TOML to typed data, with every fault reported.
