//! How much memory a run will take, and how much there is.

use crate::params::{MOST_SEEDS, Params, Target};
use crate::surface::Surface;

/// Bytes that any run takes.
const BASE: f64 = 1e7;

/// Bytes to a vertex of the mesh, and to a triangle of the surface, at the peak of a run: measured with 5,000 to 100,000
/// vertices over surfaces of 446 and 69,664 triangles; with these the estimate was from 1 % below to 15 % above.
const PER_VERTEX: f64 = 3900.0;
const PER_TRIANGLE: f64 = 600.0;

/// Vertices over the volume of a regular tet's edge cubed, and over the area of that edge squared: what `--edge` leads to,
/// roughly.
const PER_VOLUME: f64 = 1.57;
const PER_AREA: f64 = 0.8;

/// The memory that a run is about to take, in bytes.
pub(super) fn estimate(params: &Params, surface: &Surface) -> f64 {
    let by_edge = |l: f64| surface.volume() * PER_VOLUME / l.powi(3) + surface.area() * PER_AREA / (l * l);
    let vertices = match params.target {
        Target::Count(n) => n as f64,
        Target::Edge(l) => by_edge(l * surface.frame().scale),
        Target::RelativeEdge(share) => by_edge(share * surface.diagonal()),
        // Not before these are known.
        Target::Sizes => 0.0,
    };
    // More is refused.
    let vertices = vertices.min(MOST_SEEDS as f64);
    BASE + PER_VERTEX * vertices + PER_TRIANGLE * surface.triangles().len() as f64
}

/// The memory that is free, in bytes, where the system tells.
pub(super) fn free() -> Option<f64> {
    available(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

/// The line of Linux's table that says what a program can have without swapping.
fn available(table: &str) -> Option<f64> {
    let line = table.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    Some(kibibytes * 1024.0)
}

/// What to tell the user before a run that takes more than half of what is free.
pub(super) fn warning(needed: f64, free: f64) -> Option<String> {
    let size =
        |bytes: f64| if bytes < 1e9 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.1} GB", bytes / 1e9) };
    (needed > free / 2.0).then(|| format!("this will take about {} of memory; {} are free", size(needed), size(free)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_linux_is_understood() {
        let table = "MemTotal:       24684084 kB\nMemFree:        18981596 kB\nMemAvailable:   22261596 kB\n";
        assert_eq!(available(table), Some(22_261_596.0 * 1024.0));
        assert_eq!(available("MemTotal: 1 kB\n"), None);
        assert_eq!(available("MemAvailable: many\n"), None);
    }

    #[test]
    fn only_more_than_half_is_worth_a_word() {
        assert_eq!(warning(4e9, 8e9), None);
        let text = warning(4.1e9, 8e9).expect("a warning");
        assert_eq!(text, "this will take about 4.1 GB of memory; 8.0 GB are free");
        assert!(warning(6e8, 1e9).expect("a warning").contains("600 MB"));
    }
}
