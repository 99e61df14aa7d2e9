//! The `tetcvt` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(tetcvt::cli::run())
}
