//! What time is taken.

use std::sync::LazyLock;
use std::time::Instant;

/// A clock that only runs forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Time that this thread has spent computing: other work on the machine does not count.
    Thread,
    /// Time on the wall, for work on several threads.
    Wall,
}

impl Clock {
    /// The one for so many threads.
    pub fn for_threads(threads: usize) -> Clock {
        if threads == 1 { Clock::Thread } else { Clock::Wall }
    }

    /// Seconds from some start.
    pub fn seconds(self) -> f64 {
        match self {
            Clock::Thread => thread_seconds(),
            Clock::Wall => wall_seconds(),
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Clock::Thread => "time of the thread",
            Clock::Wall => "wall time",
        }
    }
}

fn wall_seconds() -> f64 {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed().as_secs_f64()
}

#[cfg(unix)]
fn thread_seconds() -> f64 {
    let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

/// Where the system's clock of the thread has no safe interface.
#[cfg(not(unix))]
fn thread_seconds() -> f64 {
    wall_seconds()
}
