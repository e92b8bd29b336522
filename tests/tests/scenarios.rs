//! Every scenario under `scenarios/` is one test.

fn main() -> std::process::ExitCode {
    graspcheck::harness::run(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
}
