//! The command line: options, progress, messages. The only file that prints.

/// Runs the program; returns its exit status.
pub fn run() -> u8 {
    todo!()
}
