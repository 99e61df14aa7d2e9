//! Follows one recorded trajectory in every mode, the modes alternating within each iteration.

use glam::DVec3;
use tetcvt::delaunay::{Delaunay, Method, Relocation, Updater};

use super::Outcome;
use super::cgal::Cgal;
use super::clock::Clock;
use super::experiments::Sampling;
use super::frames::Frames;
use super::rows::{Mode, Row};

/// Iterations in which each mode is timed in both orders.
const BOTH_WAYS: usize = 20;

/// Follows the trajectory by each method, and by CGAL where it is there. All must come to the same triangulation: an error
/// says where they do not.
pub fn replay(
    frames: &mut Frames,
    methods: &[Method],
    mut cgal: Option<&mut Cgal>,
    sampling: Sampling,
    clock: Clock,
) -> Outcome<Vec<Row>> {
    let mut positions = Vec::new();
    frames.read(0, &mut positions)?;
    let first = Delaunay::build(&positions)?;
    let mut updaters: Vec<Updater> = methods.iter().map(|&m| Updater::new(first.clone(), m)).collect();
    drop(first);
    if let Some(cgal) = cgal.as_deref_mut() {
        cgal.open(frames)?;
    }
    let last = frames.count - 1;
    let mut rows = Vec::new();
    for k in 1..=last {
        frames.read(k, &mut positions)?;
        let begun = rows.len();
        // Each goes first in turn: what the one leaves in the caches is no constant favour to the next.
        let order = (0..updaters.len()).map(|place| (place + k) % updaters.len());
        let taken = order.filter(|&n| updaters[n].method() != Method::Rebuild || sampling.rebuilds(k));
        let taken: Vec<usize> = taken.collect();
        // What is built right after something as large was built finds its memory at hand: a seventh of the time. Where modes
        // build, each goes before the others and after them, and the mean counts.
        let mut before = vec![None; updaters.len()];
        for &turn in taken.iter().rev().filter(|_| k <= BOTH_WAYS) {
            let mut updater = updaters[turn].clone();
            let started = clock.seconds();
            updater.relocate(&positions)?;
            before[turn] = Some(clock.seconds() - started);
        }
        for turn in taken {
            let updater = &mut updaters[turn];
            let started = clock.seconds();
            let relocation = updater.relocate(&positions)?;
            let seconds = clock.seconds() - started;
            let seconds = before[turn].map_or(seconds, |before| 0.5 * (before + seconds));
            let mode = Mode::Ours(updater.method());
            rows.push(Row { iteration: k, mode, seconds, tets: updater.delaunay().vertices().len(), relocation });
        }
        if let Some(cgal) = cgal.as_deref_mut() {
            let mut add = |mode, (seconds, tets)| {
                rows.push(Row { iteration: k, mode, seconds, tets, relocation: Relocation::default() });
            };
            if sampling.rebuilds(k) {
                add(Mode::CgalRebuild, cgal.build(k)?);
            }
            if sampling.relocates(k) {
                add(Mode::CgalMove, cgal.relocate(k)?);
            }
        }
        same_count(&rows[begun..])?;
        if k == 1 || k == last.div_ceil(2) || k == last {
            same_tets(&updaters, &positions, k, sampling)?;
        }
    }
    Ok(rows)
}

/// That all modes have the same number of tets in an iteration.
fn same_count(rows: &[Row]) -> Outcome<()> {
    let differs = rows.iter().find(|r| r.tets != rows[0].tets);
    differs.map_or(Ok(()), |r| {
        let (first, k) = (&rows[0], r.iteration);
        let (one, other) = (first.mode.name(), r.mode.name());
        Err(format!("iteration {k}: {one} has {} tets, {other} {}", first.tets, r.tets).into())
    })
}

/// That all modes have the tets of a triangulation built anew.
fn same_tets(updaters: &[Updater], positions: &[DVec3], k: usize, sampling: Sampling) -> Outcome<()> {
    let expected = sorted(&Delaunay::build(positions)?);
    let followed = |u: &&Updater| u.method() != Method::Rebuild || sampling.rebuilds(k);
    for updater in updaters.iter().filter(followed) {
        if sorted(updater.delaunay()) != expected {
            return Err(format!("iteration {k}: {} has other tets than build", updater.method().name()).into());
        }
    }
    Ok(())
}

/// The finite tets, each with ascending vertices, in ascending order.
fn sorted(delaunay: &Delaunay) -> Vec<[u32; 4]> {
    let ascending = |mut tet: [u32; 4]| {
        tet.sort_unstable();
        tet
    };
    let mut tets: Vec<[u32; 4]> = delaunay.tets().map(ascending).collect();
    tets.sort_unstable();
    tets
}
