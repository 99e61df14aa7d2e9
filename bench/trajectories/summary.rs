//! What the rows of one experiment say of each mode.

use tetcvt::delaunay::Method;

use super::rows::{Mode, Row};

/// Rebuilding is expected up to this iteration, while the points move far.
const SETTLED: usize = 20;

/// One mode in one experiment.
pub struct ModeSummary {
    /// The mode.
    pub mode: Mode,
    /// Iterations measured.
    pub measured: usize,
    /// Seconds of each iteration, between those measured on a straight line.
    pub seconds: Vec<f64>,
    /// Bi-cells that failed the filter, or vertices for a filter of vertices, in percent, where it decided; none for
    /// rebuilding.
    pub failed_percent: Option<f64>,
    /// Mean count of flips, of reversed tets and of predicates in an iteration.
    pub flips: f64,
    /// See `flips`.
    pub reversed: f64,
    /// See `flips`.
    pub predicates: f64,
    /// Triangulations built anew.
    pub rebuilt: usize,
    /// Those after iteration 20.
    pub rebuilt_settled: usize,
    /// Seconds of an iteration by part, and what is not in any, in the mean.
    pub parts: Vec<(&'static str, f64)>,
}

impl ModeSummary {
    /// Of all iterations.
    pub fn total(&self) -> f64 {
        self.seconds.iter().sum()
    }

    /// Of an iteration.
    pub fn mean(&self) -> f64 {
        self.total() / self.seconds.len() as f64
    }

    /// Median over the last quarter of the iterations.
    pub fn late(&self) -> f64 {
        let mut late = self.seconds[self.seconds.len() * 3 / 4..].to_vec();
        late.sort_unstable_by(f64::total_cmp);
        late[late.len() / 2]
    }

    /// The worst iteration against `other`, and which it is.
    pub fn worst_against(&self, other: &ModeSummary) -> (f64, usize) {
        let ratios = self.seconds.iter().zip(&other.seconds).map(|(a, b)| a / b).zip(1..);
        ratios.max_by(|a, b| a.0.total_cmp(&b.0)).expect("an experiment has iterations")
    }
}

/// One experiment.
pub struct Summary {
    /// Its name.
    pub name: String,
    /// Count of seeds.
    pub seeds: usize,
    /// Iterations.
    pub iterations: usize,
    /// Modes that were run.
    pub modes: Vec<ModeSummary>,
}

impl Summary {
    /// Of the rows of an experiment; none where there are no rows.
    pub fn new(name: &str, seeds: usize, rows: &[Row]) -> Option<Summary> {
        let iterations = rows.iter().map(|r| r.iteration).max()?;
        let modes = Mode::all().filter_map(|mode| summarise(mode, seeds, iterations, rows)).collect();
        Some(Summary { name: name.to_owned(), seeds, iterations, modes })
    }

    /// One of its modes, where that was run.
    pub fn mode(&self, mode: Mode) -> Option<&ModeSummary> {
        self.modes.iter().find(|m| m.mode == mode)
    }

    /// What speed is compared with: CGAL's construction, or ours where CGAL was not there.
    pub fn yardstick(&self) -> Option<&ModeSummary> {
        self.mode(Mode::CgalRebuild).or_else(|| self.mode(Mode::Ours(Method::Rebuild)))
    }
}

fn summarise(mode: Mode, seeds: usize, iterations: usize, rows: &[Row]) -> Option<ModeSummary> {
    let rows: Vec<&Row> = rows.iter().filter(|r| r.mode == mode).collect();
    if rows.is_empty() {
        return None;
    }
    let mean = |f: &dyn Fn(&Row) -> f64| rows.iter().map(|r| f(r)).sum::<f64>() / rows.len() as f64;
    let failed: Vec<f64> = rows.iter().filter_map(|r| failed_share(r, seeds)).collect();
    let percent = 100.0 * failed.iter().sum::<f64>() / failed.len() as f64;
    let rebuilt = |from: usize| rows.iter().filter(|r| r.iteration > from && r.relocation.rebuilt).count();
    let part = |i: usize| mean(&|r| r.relocation.seconds.parts()[i].1);
    let mut parts: Vec<(&'static str, f64)> =
        rows[0].relocation.seconds.parts().iter().enumerate().map(|(i, p)| (p.0, part(i))).collect();
    let named: f64 = parts.iter().map(|p| p.1).sum();
    // Parts are on the wall's clock: work of others may make them longer than the whole.
    parts.push(("rest", (mean(&|r| r.seconds) - named).max(0.0)));
    Some(ModeSummary {
        mode,
        measured: rows.len(),
        seconds: filled(&rows, iterations),
        failed_percent: (!failed.is_empty()).then_some(percent),
        flips: mean(&|r| r.relocation.flips as f64),
        reversed: mean(&|r| r.relocation.reversed as f64),
        predicates: mean(&|r| r.relocation.predicates as f64),
        rebuilt: rebuilt(0),
        rebuilt_settled: rebuilt(SETTLED),
        parts,
    })
}

/// Share of the bi-cells, or vertices, that failed the filter of a mode that has one. Where all was built anew without a
/// failure, it was so before the filter was asked.
pub fn failed_share(row: &Row, seeds: usize) -> Option<f64> {
    let r = &row.relocation;
    let (failed, of) = match row.mode {
        Mode::Ours(Method::Rebuild) | Mode::CgalRebuild | Mode::CgalMove => return None,
        Mode::Ours(Method::Vertex) => (r.vertices_failed, seeds),
        Mode::Ours(_) => (r.bicells_failed, 2 * row.tets),
    };
    (failed > 0 || !r.rebuilt).then(|| failed as f64 / of as f64)
}

/// The seconds of every iteration: on a straight line between two that were measured, constant beyond the last.
fn filled(rows: &[&Row], iterations: usize) -> Vec<f64> {
    let mut next = 0;
    (1..=iterations)
        .map(|k| {
            while next < rows.len() && rows[next].iteration < k {
                next += 1;
            }
            match (next.checked_sub(1).map(|i| rows[i]), rows.get(next)) {
                (_, Some(at)) if at.iteration == k => at.seconds,
                (Some(before), Some(after)) => {
                    let share = (k - before.iteration) as f64 / (after.iteration - before.iteration) as f64;
                    before.seconds + share * (after.seconds - before.seconds)
                }
                (Some(only), None) => only.seconds,
                (None, Some(only)) => only.seconds,
                (None, None) => unreachable!("a mode that was run has rows"),
            }
        })
        .collect()
}
