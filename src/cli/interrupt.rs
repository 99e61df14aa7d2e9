//! Ctrl-C: the first one asks for what there is, the second one ends the program.

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
        // Without a handler Ctrl-C ends the program as it always does.
        let _ = ctrlc::set_handler(move || {
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
