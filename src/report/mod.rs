//! Everything that a run knows of itself: what `--json` writes and the summary shows.
//!
//! Lengths, areas and volumes are in model units, angles in degrees, times in seconds; `volume_error` is relative, and
//! distances are over the diagonal of the surface's bounding box. A number that is not finite becomes `null`.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;

use crate::delaunay::Breakdown;
use crate::geometry::tetrahedron;
use crate::progress::Step;
use crate::quality::TetQuality;
use crate::seeds::SeedKind;
use crate::surface::Surface;
use crate::tet_mesh::{SizeRatio, StageTimes, TetMesh};

mod distance;

pub use distance::{Distance, SAMPLES};

/// The report of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of the program.
    pub tetcvt: &'static str,
    /// The command line.
    pub command: Vec<String>,
    /// The surface.
    pub input: InputReport,
    /// The mesh.
    pub mesh: MeshReport,
    /// Where the time went.
    pub time: TimeReport,
    /// Where that of the updates of the triangulation went.
    pub update: Breakdown,
    /// What it took.
    pub memory: MemoryReport,
    /// Why the iterations ended.
    pub stopped: String,
    /// What became of the floor for dihedral angles; empty where none was aimed at.
    pub improved: String,
    /// What a user should know: repairs, fall-backs, doubts.
    pub notes: Vec<String>,
    /// What each iteration did.
    pub iterations: Vec<Step>,
}

/// The surface, once checked and mended.
#[derive(Clone, Debug, Serialize)]
pub struct InputReport {
    /// Its file.
    pub file: String,
    /// Vertices.
    pub vertices: usize,
    /// Triangles.
    pub triangles: usize,
    /// Connected components.
    pub components: usize,
    /// Handles, over all components.
    pub genus: usize,
    /// Volume of the solid.
    pub volume: f64,
    /// Area.
    pub area: f64,
    /// Diagonal of the bounding box.
    pub diagonal: f64,
}

/// The mesh.
#[derive(Clone, Debug, Serialize)]
pub struct MeshReport {
    /// Vertices.
    pub vertices: usize,
    /// Tets.
    pub tets: usize,
    /// Triangles of the boundary.
    pub surface_triangles: usize,
    /// Vertices inside.
    pub interior_seeds: usize,
    /// Vertices on the surface.
    pub surface_seeds: usize,
    /// Vertices on creases.
    pub curve_seeds: usize,
    /// Vertices on corners.
    pub corner_seeds: usize,
    /// Sum of the tets' volumes.
    pub volume: f64,
    /// Its excess over the solid's volume, over that volume.
    pub volume_error: f64,
    /// Largest distance between the boundary and the surface, from either side, over the diagonal.
    pub hausdorff: f64,
    /// Root of the mean squared distance, over both sides, over the diagonal.
    pub rms_distance: f64,
    /// Length over the size asked for, of all edges; nothing where one size was asked for.
    pub size_ratio: Option<SizeRatio>,
    /// Smallest dihedral angle of all tets.
    pub min_dihedral: f64,
    /// Largest dihedral angle of all tets.
    pub max_dihedral: f64,
    /// The 1st percentile of the tets' smallest dihedral angles.
    pub p1_min_dihedral: f64,
    /// Mean over the tets of their smallest dihedral angle.
    pub mean_min_dihedral: f64,
    /// Mean over the tets of three times the inscribed sphere's radius over the circumscribed one's.
    pub mean_radius_ratio: f64,
    /// The solids, or the regions between shells.
    pub regions: Vec<RegionReport>,
    /// The centre of the tet with the smallest dihedral angle.
    pub worst_at: [f64; 3],
    /// All dihedral angles, six of each tet, counted in bins of 5 degrees from 0 to 180.
    pub dihedral_histogram: Vec<u64>,
}

/// One region of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RegionReport {
    /// Its number, as the files have it.
    pub region: u32,
    /// Its tets.
    pub tets: usize,
    /// Sum of their volumes.
    pub volume: f64,
}

/// Where the time went, in seconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TimeReport {
    /// From the start of the program until this report was made.
    pub total: f64,
    /// Reading and parsing the surface.
    pub read: f64,
    /// Checking it and building its box tree.
    pub check: f64,
    /// Placing seeds.
    pub seeds: f64,
    /// The first triangulation.
    pub build: f64,
    /// Keeping it while the seeds move.
    pub update: f64,
    /// Clipped cells and their moments.
    pub centroids: f64,
    /// Taking the mesh out.
    pub extract: f64,
    /// Improving its tets.
    pub improve: f64,
    /// Measuring it for this report.
    pub measure: f64,
    /// Writing files.
    pub write: f64,
}

impl TimeReport {
    /// The stages that the library timed.
    pub fn of(times: &StageTimes) -> TimeReport {
        let StageTimes { seeds, build, update, centroids, extract, improve, .. } = *times;
        TimeReport { seeds, build, update, centroids, extract, improve, ..TimeReport::default() }
    }

    /// The stages by name, in their order, without the total.
    pub fn stages(&self) -> [(&'static str, f64); 10] {
        [
            ("read", self.read),
            ("check", self.check),
            ("seeds", self.seeds),
            ("build", self.build),
            ("update", self.update),
            ("centroids", self.centroids),
            ("extract", self.extract),
            ("improve", self.improve),
            ("measure", self.measure),
            ("write", self.write),
        ]
    }
}

/// Memory of the process.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct MemoryReport {
    /// Largest resident size so far; unknown where the system does not tell.
    pub peak_bytes: Option<u64>,
}

impl MemoryReport {
    /// The memory of this process until now.
    pub fn now() -> MemoryReport {
        // Linux: "VmHWM:     12345 kB".
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|l| l.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
        MemoryReport { peak_bytes: kilobytes.map(|k| k * 1024) }
    }
}

impl InputReport {
    /// Of `surface`, read from `file`.
    pub fn of(surface: &Surface, file: String) -> InputReport {
        let length = |l: f64| surface.frame().length_to_model(l);
        InputReport {
            file,
            vertices: surface.points().len(),
            triangles: surface.triangles().len(),
            components: surface.shell_count(),
            genus: surface.genus(),
            volume: length(length(length(surface.volume()))),
            area: length(length(surface.area())),
            diagonal: length(surface.diagonal()),
        }
    }
}

impl MeshReport {
    /// Of `mesh`, made from `surface`.
    pub fn of(mesh: &TetMesh, quality: &TetQuality, surface: &Surface) -> MeshReport {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let distance = Distance::between(mesh, surface);
        let angles = &quality.min_dihedral;
        let worst = (0..angles.len()).min_by(|&t, &u| angles[t].total_cmp(&angles[u]));
        MeshReport {
            vertices: mesh.points.len(),
            tets: mesh.tets.len(),
            surface_triangles: mesh.boundary.len(),
            interior_seeds: mesh.count(SeedKind::Interior),
            surface_seeds: mesh.count(SeedKind::Surface),
            curve_seeds: mesh.count(SeedKind::Curve),
            corner_seeds: mesh.count(SeedKind::Corner),
            volume: quality.volume.iter().sum(),
            // In the frame: in units of the model a volume may be out of range.
            volume_error: volume_at_scale(mesh, surface.frame().scale) / surface.volume() - 1.0,
            hausdorff: distance.hausdorff / surface.diagonal(),
            rms_distance: distance.rms / surface.diagonal(),
            size_ratio: mesh.size_ratio,
            min_dihedral: worst.map_or(180.0, |t| quality.min_dihedral[t]),
            max_dihedral: quality.max_dihedral.iter().copied().fold(0.0, f64::max),
            p1_min_dihedral: percentile(&quality.min_dihedral, 0.01),
            mean_min_dihedral: mean(&quality.min_dihedral),
            mean_radius_ratio: mean(&quality.radius_ratio),
            regions: regions(mesh, quality),
            worst_at: worst.map_or([f64::NAN; 3], |t| tet_center(mesh, t).to_array()),
            dihedral_histogram: quality.histogram.to_vec(),
        }
    }
}

/// The regions that have tets, by number.
fn regions(mesh: &TetMesh, quality: &TetQuality) -> Vec<RegionReport> {
    let mut regions: BTreeMap<u32, RegionReport> = BTreeMap::new();
    for (&region, &volume) in mesh.regions.iter().zip(&quality.volume) {
        let found = regions.entry(region).or_insert(RegionReport { region, tets: 0, volume: 0.0 });
        found.tets += 1;
        found.volume += volume;
    }
    regions.into_values().collect()
}

/// The value that a share of all are below, linear between two; not a number where there are none.
fn percentile(values: &[f64], share: f64) -> f64 {
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let mut values = values.to_vec();
    let at = share * last as f64;
    let (_, &mut lower, above) = values.select_nth_unstable_by(at as usize, f64::total_cmp);
    let upper = above.iter().copied().min_by(f64::total_cmp).unwrap_or(lower);
    lower + (upper - lower) * at.fract()
}

/// The mean of the corners of a tet.
fn tet_center(mesh: &TetMesh, t: usize) -> DVec3 {
    // Halves first: the sum of four may be out of range.
    mesh.corners(t).into_iter().map(|p| p * 0.25).sum()
}

/// Sum of the volumes of the tets, with lengths multiplied by `scale`.
fn volume_at_scale(mesh: &TetMesh, scale: f64) -> f64 {
    let volume = |tet: &[u32; 4]| {
        let [a, b, c, d] = tet.map(|v| (mesh.points[v as usize] - mesh.points[tet[0] as usize]) * scale);
        tetrahedron::volume(a, b, c, d)
    };
    mesh.tets.iter().map(volume).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_peak_of_memory_covers_what_was_just_used() {
        let block = std::hint::black_box(vec![1u8; 64 << 20]);
        let peak = MemoryReport::now().peak_bytes.expect("Linux tells");
        assert!(peak >= block.len() as u64, "{peak}");
    }
}
