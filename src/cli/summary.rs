//! The summary at the end of a run.

use std::fmt::{self, Display, Formatter};

use crate::delaunay::Breakdown;
use crate::quality::BIN_DEGREES;
use crate::report::Report;
use crate::tet_mesh::SizeRatio;

/// Bins of the report that share a line.
const BINS_A_LINE: usize = 2;

/// Length of the longest bar.
const BAR: f64 = 50.0;

/// Regions that are told one by one.
const MOST_REGIONS: usize = 8;

/// Shows a report, for a human.
pub(super) struct Summary<'a>(pub &'a Report);

impl Display for Summary<'_> {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let Report { input, mesh, .. } = self.0;
        writeln!(
            f,
            "surface    {} vertices, {} triangles, {}, genus {}",
            input.vertices,
            input.triangles,
            counted(input.components, "component"),
            input.genus
        )?;
        writeln!(
            f,
            "mesh       {} vertices ({} interior, {} surface, {} curve, {} corner), {} tets, {} boundary triangles",
            mesh.vertices,
            mesh.interior_seeds,
            mesh.surface_seeds,
            mesh.curve_seeds,
            mesh.corner_seeds,
            mesh.tets,
            mesh.surface_triangles
        )?;
        writeln!(f, "volume     {:.6e}, {:+.4} % off the surface's", mesh.volume, 100.0 * mesh.volume_error)?;
        if mesh.regions.len() > 1 {
            let shown = mesh.regions.iter().take(MOST_REGIONS);
            let mut parts: Vec<String> =
                shown.map(|r| format!("region {}: {:.6e} in {} tets", r.region, r.volume, r.tets)).collect();
            if mesh.regions.len() > MOST_REGIONS {
                parts.push(format!("and {} more", mesh.regions.len() - MOST_REGIONS));
            }
            writeln!(f, "regions    {}", parts.join("; "))?;
        }
        writeln!(
            f,
            "distance   Hausdorff {:.4} %, rms {:.5} % of the diagonal {:.6}",
            100.0 * mesh.hausdorff,
            100.0 * mesh.rms_distance,
            input.diagonal
        )?;
        if let Some(SizeRatio { median, p5, p95 }) = mesh.size_ratio {
            writeln!(
                f,
                "sizes      edges have {median:.3} of the length asked for there in the median, {p5:.3} to {p95:.3} from the 5th to the 95th percentile"
            )?;
        }
        writeln!(
            f,
            "tets       the smallest angle of each: 1st percentile {:.2}, mean {:.2} degrees; mean radius ratio {:.4}",
            mesh.p1_min_dihedral, mesh.mean_min_dihedral, mesh.mean_radius_ratio
        )?;
        let [x, y, z] = mesh.worst_at;
        writeln!(
            f,
            "dihedral   {:.2} to {:.2} degrees, the smallest at ({x:.6}, {y:.6}, {z:.6})",
            mesh.min_dihedral, mesh.max_dihedral
        )?;
        histogram(f, &mesh.dihedral_histogram)?;
        if !self.0.improved.is_empty() {
            writeln!(f, "improved   {}", self.0.improved)?;
        }
        let iterations = counted(self.0.iterations.len(), "iteration");
        writeln!(f, "stopped    after {iterations}: {}", self.0.stopped)?;
        self.time(f)
    }
}

impl Summary<'_> {
    fn time(&self, f: &mut Formatter) -> fmt::Result {
        let time = &self.0.time;
        let stages: Vec<String> = time
            .stages()
            .iter()
            .filter(|(_, seconds)| *seconds >= 0.0005)
            .map(|(name, seconds)| format!("{name} {seconds:.3}"))
            .collect();
        write!(f, "time       {:.3} s: {}", time.total, stages.join(", "))?;
        match self.0.memory.peak_bytes {
            Some(bytes) => write!(f, "; {:.0} MB", bytes as f64 / 1e6),
            None => Ok(()),
        }
    }
}

/// Where the time of the updates went, in seconds and shares.
pub(super) fn breakdown(update: &Breakdown) -> String {
    let total: f64 = update.parts().iter().map(|(_, seconds)| seconds).sum();
    let share = |seconds: f64| if total > 0.0 { 100.0 * seconds / total } else { 0.0 };
    let parts = update.parts().map(|(name, seconds)| format!("{name} {seconds:.3} ({:.1} %)", share(seconds)));
    format!("update     {total:.3} s: {}", parts.join(", "))
}

/// All dihedral angles, a line for each 10 degrees, without the empty lines at either end.
fn histogram(f: &mut Formatter, bins: &[u64]) -> fmt::Result {
    let lines: Vec<u64> = bins.chunks(BINS_A_LINE).map(|c| c.iter().sum()).collect();
    let (Some(first), Some(last)) = (lines.iter().position(|&n| n > 0), lines.iter().rposition(|&n| n > 0)) else {
        return Ok(());
    };
    let total: u64 = lines.iter().sum();
    let most = lines.iter().copied().max().unwrap_or(1);
    let width = BIN_DEGREES as usize * BINS_A_LINE;
    for (k, &n) in lines.iter().enumerate().take(last + 1).skip(first) {
        let bar = "#".repeat((BAR * n as f64 / most as f64).ceil() as usize);
        let share = 100.0 * n as f64 / total as f64;
        let line = format!("  {:3} - {:3}  {share:7.3} %  {bar}", k * width, (k + 1) * width);
        writeln!(f, "{}", line.trim_end())?;
    }
    Ok(())
}

fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_histogram_shows_shares_and_leaves_empty_ends_out() {
        struct Lines(Vec<u64>);
        impl Display for Lines {
            fn fmt(&self, f: &mut Formatter) -> fmt::Result {
                histogram(f, &self.0)
            }
        }
        let mut bins = vec![0; 36];
        (bins[6], bins[7], bins[10]) = (1, 2, 1);
        let text = Lines(bins).to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[0], format!("   30 -  40   75.000 %  {}", "#".repeat(50)));
        assert_eq!(lines[1], "   40 -  50    0.000 %");
        assert_eq!(Lines(vec![0; 36]).to_string(), "");
    }
}
