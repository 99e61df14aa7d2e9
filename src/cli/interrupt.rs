//! Ctrl-C and its like: the first one asks for what there is, the second one ends the program.
//!
//! On Unix that is SIGINT, SIGTERM, which batch systems send before they kill, and SIGHUP unless whoever started the
//! program has it ignored, as `nohup` does; elsewhere Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use indicatif::ProgressBar;

use super::say;
use crate::io::atomic;

const NOTHING_TO_KEEP: u8 = 0;
const RUNNING: u8 = 1;
const FINISHING: u8 = 2;

/// The exit status after an interrupt.
const INTERRUPTED: i32 = 130;

/// Whether the user wants the run to end.
#[derive(Clone)]
pub(super) struct Interrupt {
    state: Arc<AtomicU8>,
}

impl Interrupt {
    /// Listens from now on; messages go above `bar`.
    pub(super) fn listen(bar: &ProgressBar) -> Interrupt {
        let state = Arc::new(AtomicU8::new(NOTHING_TO_KEEP));
        let (shared, bar) = (Arc::clone(&state), bar.clone());
        on_request_to_end(move || {
            match shared.compare_exchange(RUNNING, FINISHING, Ordering::SeqCst, Ordering::SeqCst) {
                Ok(_) => bar.suspend(|| say("finishing with the seeds as they are; Ctrl-C again stops at once")),
                Err(state) => {
                    let _no_more_files = atomic::discard_unfinished();
                    if state == NOTHING_TO_KEEP {
                        bar.finish_and_clear();
                        say("error: interrupted with nothing to keep");
                    }
                    std::process::exit(INTERRUPTED);
                }
            }
        });
        Interrupt { state }
    }

    /// From now on there is something to keep.
    pub(super) fn keep(&self) {
        // Where a handler came first, the program is ending.
        let _ = self.state.compare_exchange(NOTHING_TO_KEEP, RUNNING, Ordering::SeqCst, Ordering::SeqCst);
    }

    /// Whether Ctrl-C came.
    pub(super) fn came(&self) -> bool {
        self.state.load(Ordering::SeqCst) == FINISHING
    }
}

/// Calls `handler`, on a thread of its own, each time the program is asked to end. Without one such requests end the
/// program as they always do.
#[cfg(unix)]
fn on_request_to_end(handler: impl Fn() + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    let mut wanted = vec![SIGINT, SIGTERM];
    if !ignored(SIGHUP) {
        wanted.push(SIGHUP);
    }
    if let Ok(mut signals) = Signals::new(wanted) {
        std::thread::spawn(move || signals.forever().for_each(|_| handler()));
    }
}

#[cfg(not(unix))]
fn on_request_to_end(handler: impl Fn() + Send + 'static) {
    let _ = ctrlc::set_handler(handler);
}

/// Whether the program was started with a signal ignored; where that cannot be known it is left as it is.
#[cfg(unix)]
fn ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok()).is_none_or(|mask| mask >> (signal - 1) & 1 == 1)
}
