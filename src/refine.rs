//! Adds seeds where the sampling is too coarse for a valid mesh, and takes them from elsewhere.
//!
//! After each round of insertions a few iterations smooth the change; later rounds leave them out, so that what was
//! inserted stays where it is needed. The number of seeds never changes, and seed i stays seed i.

use glam::DVec3;
use rayon::prelude::*;

use crate::clipped_voronoi::Crossing;
use crate::error::Error;
use crate::extract::{self, Defect, DefectKind, Proposal, Sampling};
use crate::fidelity;
use crate::geometry::frame::snap;
use crate::geometry::places::Places;
use crate::geometry::tetrahedron;
use crate::params::{Boundary, Params};
use crate::progress::Observer;
use crate::relax::{Relaxation, Stopped};
use crate::seeds::{self, Anchor, SeedKind, Seeds};
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::tet_mesh::TetMesh;

/// Rounds of insertion before the run gives up.
const ROUNDS: usize = 40;

/// Rounds in a row that may bring nothing before the run gives up.
const STUCK_ROUNDS: usize = 10;

/// Rounds that also mend what is only unsightly, such as an interior seed on the boundary.
const POLISHED_ROUNDS: usize = 3;

/// Rounds that also mend pits: seeds deep inside on the boundary, where two parts of the surface nearly touch.
const PIT_ROUNDS: usize = 20;

/// Rounds of insertion for the sake of the volume and of the distance, and iterations after each.
const FIDELITY_ROUNDS: usize = 3;
const FIDELITY_SMOOTHING: usize = 2;

/// A place with a seed of the surface within this share of the spacing gains nothing by another: at an acute tip the corner
/// itself may be in no tet yet.
const OCCUPIED: f64 = 0.1;

/// Rounds that also split the edges of creases that the mesh lacks.
const CREASE_ROUNDS: usize = 10;

/// Edges of creases are split while they are at most one for so many seeds, and a few.
const MOST_SPLITS: usize = 100;

/// The same for creases that are noise.
const MOST_SPLITS_OF_NOISE: usize = 250;

/// Creases that are noise are not split within this share of the spacing of another crease's seed.
const BESIDE: f64 = 0.4;

/// A seed of the surface nearer to the middle of a stretch of a crease than this share of its half becomes a seed of the crease.
const INTRUDES: f64 = 0.5;

/// The few.
const FEW_SPLITS: usize = 8;

/// Rounds after which a seed that is still in no tet goes elsewhere, and tets without volume are left to the improvement.
const PATIENT_ROUNDS: usize = 3;

/// Rounds after which seeds are put everywhere around what is wrong; how far apart then, over the spacing, by how much closer
/// in each further round, and at the closest.
const DENSE_ROUNDS: usize = 6;
const DENSE: f64 = 0.5;
const DENSER: f64 = 0.7;
const DENSEST: f64 = 0.1;

/// How far around, over the spacing, and the power of the gap that this falls with where there would be too many.
const AROUND: f64 = 1.5;
const AROUND_FINER: f64 = 0.75;

/// Around two seeds of creases that are closer than this share of the spacing, others are no farther apart than that.
const PAIR: f64 = 0.3;
const AROUND_PAIRS: f64 = 0.5;

/// At most one seed in so many goes there at once.
const FEW_DENSE: usize = 64;

/// A solid with fewer than one seed in so many within is thin.
const THIN: usize = 8;

/// Iterations after round r: enough to smooth at first, none in the end.
fn smoothing(round: usize) -> usize {
    [5, 5, 4, 3, 2, 2, 1, 1].get(round).copied().unwrap_or(0)
}

/// Adds seeds to the surface where flat facets are far from it or cut off too much of the solid, and lets them settle.
pub fn follow_surface(
    relaxation: &mut Relaxation,
    surface: &Surface,
    iterations: usize,
    params: &Params,
    observer: &mut dyn Observer,
) -> Result<Stopped, Error> {
    for round in 0..FIDELITY_ROUNDS {
        if relaxation.iterations() + 2 * (1 + FIDELITY_SMOOTHING) > iterations {
            break;
        }
        let kinds = relaxation.seeds().kinds();
        let sampling = Sampling::new(relaxation.delaunay(), &kinds, surface, relaxation.seeds().spacings());
        let labels = extract::label(&sampling, relaxation.clipped());
        let mut proposals = fidelity::proposals(&sampling, &labels, round);
        let taken = taken_places(relaxation, &kinds);
        proposals.retain(|p| !taken.any_within(p.place, OCCUPIED * relaxation.seeds().spacing_at(p.place)));
        let mut donors = donors(relaxation, &sampling, &proposals);
        // The surface of a thin solid, which has all the seeds already, gains nothing by robbing itself.
        donors.retain(|&(donor, _)| kinds[donor as usize] == SeedKind::Interior);
        if donors.is_empty() {
            break;
        }
        observer.note(&format!(
            "round {}: {} seeds moved to where flat facets follow the surface least",
            round + 1,
            donors.len()
        ));
        insert(relaxation, params, donors, observer)?;
        let stopped = relaxation.run(FIDELITY_SMOOTHING, observer)?;
        if stopped.is_interruption() {
            return Ok(stopped);
        }
    }
    Ok(Stopped::Iterations)
}

/// The places of the seeds that are bound to the surface.
fn taken_places(relaxation: &Relaxation, kinds: &[SeedKind]) -> Places {
    let seeds = relaxation.seeds();
    let mut places = Places::new(seeds.spacing);
    let bound = seeds.positions.iter().zip(kinds).filter(|(_, k)| **k != SeedKind::Interior);
    bound.for_each(|(&p, _)| places.insert(p));
    places
}

/// Labels the tets of the mesh; inserts seeds until they form one. After an interruption only what must be is mended.
pub fn until_valid(
    relaxation: &mut Relaxation,
    (surface, features): (&Surface, &Features),
    params: &Params,
    observer: &mut dyn Observer,
    mut interrupted: bool,
) -> Result<Vec<bool>, Error> {
    let mut progress = Progress::default();
    let mut crowded = Crowded::default();
    for round in 0.. {
        let kinds = relaxation.seeds().kinds();
        let sampling = Sampling::new(relaxation.delaunay(), &kinds, surface, relaxation.seeds().spacings());
        let labels = extract::label(&sampling, relaxation.clipped());
        let labels = extract::mend(&sampling, labels);
        let mut defects = extract::defects(&sampling, &labels, &relaxation.clipped().crossings);
        // Seeds known by their places are not sent away for what is only unsightly.
        let keeps_places = relaxation.seeds().keep_places;
        if round >= POLISHED_ROUNDS || keeps_places {
            let pits = round < PIT_ROUNDS;
            defects.retain(|d| d.kind.is_fatal() || (pits && extract::is_pit(&sampling, d)));
        }
        // Seeds of a crease in one plane can have a tet that no seed near by takes from them: flips will.
        if round >= PATIENT_ROUNDS && params.improve && !interrupted {
            defects.retain(|d| d.kind != DefectKind::FlatTet);
        }
        let fatal: Vec<&Defect> = defects.iter().filter(|d| d.kind.is_fatal()).collect();
        let mut proposals = proposals(relaxation, &sampling, &defects, round);
        let splits = match round < CREASE_ROUNDS && !keeps_places {
            true => splits(relaxation, &sampling, &labels, &mut crowded),
            false => Vec::new(),
        };
        proposals.extend_from_slice(&splits);
        if round == 0 && !keeps_places && !interrupted {
            let close =
                extract::dense_proposals(&sampling, &close_pairs(relaxation, &sampling), (AROUND_PAIRS, AROUND));
            if close.len() <= sampling.kinds.len() / FEW_DENSE {
                proposals.extend(close);
            }
        }
        if fatal.is_empty() && (proposals.is_empty() || interrupted) {
            return Ok(labels);
        }
        let donors = donors(relaxation, &sampling, &proposals);
        let hopeless = round == ROUNDS || progress.is_stuck(&fatal, round);
        if let Some(first) = fatal.first()
            && (proposals.is_empty() || hopeless || donors.is_empty())
        {
            return Err(too_few((surface, features), params, relaxation.seeds(), (first, proposals.len())));
        }
        if donors.is_empty() {
            return Ok(labels);
        }
        observer.note(&note(round, &defects, splits.len(), donors.len()));
        insert(relaxation, params, donors, observer)?;
        if !interrupted {
            let left = params.iterations.saturating_sub(relaxation.iterations());
            interrupted = relaxation.run(smoothing(round).min(left), observer)?.is_interruption();
        }
    }
    unreachable!("the last round returns: this is a bug in tetcvt")
}

/// What the rounds have brought so far. Holes and handles are looked at only where the boundary is a manifold: the two states
/// count for themselves.
#[derive(Default)]
struct Progress {
    /// The fewest defects of a boundary that is no manifold, and of one that is.
    fewest: [Option<usize>; 2],
    last: usize,
}

impl Progress {
    /// Takes note of the defects of a round; whether the last rounds brought nothing.
    fn is_stuck(&mut self, fatal: &[&Defect], round: usize) -> bool {
        let is_manifold = !fatal.iter().any(|d| d.kind < DefectKind::UnusedSeed);
        let fewest = &mut self.fewest[usize::from(is_manifold)];
        if fewest.is_none_or(|f| fatal.len() < f) {
            *fewest = Some(fatal.len());
            self.last = round;
        }
        round > self.last + STUCK_ROUNDS
    }
}

/// Amid seeds of designed creases that are forced much closer together than the spacing.
fn close_pairs(relaxation: &Relaxation, sampling: &Sampling) -> Vec<DVec3> {
    let (complex, seeds) = (&sampling.complex, relaxation.seeds());
    if !seeds.whole.contains(&true) {
        return Vec::new();
    }
    let is_whole = |v: u32| seeds.anchors[v as usize].curve().is_none_or(|c| seeds.whole[c as usize]);
    let is_bound =
        |v: u32| (v as usize) < complex.seeds && sampling.kinds[v as usize] > SeedKind::Surface && is_whole(v);
    let mut found = Vec::new();
    for v in (0..complex.seeds as u32).filter(|&v| is_bound(v)) {
        let p = complex.points[v as usize];
        let near = PAIR * sampling.spacing.at(p);
        let others = complex.star(v).iter().flat_map(|&t| complex.tets[t as usize]).filter(|&w| w > v && is_bound(w));
        let nearest = others.map(|w| complex.points[w as usize]).find(|q| q.distance(p) < near);
        found.extend(nearest.map(|q| 0.5 * (p + q)));
    }
    found
}

/// Where to put seeds to mend `defects`.
fn proposals(relaxation: &Relaxation, sampling: &Sampling, defects: &[Defect], round: usize) -> Vec<Proposal> {
    if round < PATIENT_ROUNDS {
        return extract::proposals(sampling, defects);
    }
    let (unused, others): (Vec<Defect>, Vec<Defect>) =
        defects.iter().cloned().partition(|d| d.kind == DefectKind::UnusedSeed);
    let mut found = extract::proposals(sampling, &others);
    if round >= DENSE_ROUNDS {
        let is_torn = |d: &&Defect| d.kind.is_fatal() && d.kind != DefectKind::FlatTet;
        let fatal: Vec<DVec3> = others.iter().filter(is_torn).map(|d| d.place).collect();
        let most = sampling.kinds.len() / FEW_DENSE;
        let dense = dense_within(sampling, &fatal, round - DENSE_ROUNDS, most);
        if !dense.is_empty() {
            found = dense;
        }
    }
    found.extend(moved_away(relaxation, &unused));
    found
}

/// Seeds all around what is wrong, closer from round to round, at most so many, for walls elsewhere need theirs. Where that is too
/// many, in every other round, those closest around the first places; none in the rounds between.
fn dense_within(sampling: &Sampling, fatal: &[DVec3], round: usize, most: usize) -> Vec<Proposal> {
    let gap = (DENSE * DENSER.powi(round as i32)).max(DENSEST);
    let all = extract::dense_proposals(sampling, fatal, (gap, AROUND));
    if all.len() <= most {
        return all;
    }
    let closest = AROUND * (gap / DENSE).powf(AROUND_FINER);
    let mut places = if round.is_multiple_of(2) { &[] } else { fatal };
    while !places.is_empty() {
        let dense = extract::dense_proposals(sampling, places, (gap, closest));
        if dense.len() <= most {
            return dense;
        }
        places = &places[..places.len() / 2];
    }
    Vec::new()
}

/// Which creases are let be, because they are so many and so close that splitting one takes the edges of the next.
#[derive(Default)]
struct Crowded {
    noise: bool,
    all: bool,
}

/// Where to put seeds on creases that the boundary of the tets `inside` does not contain. Where creases crowd they are let be
/// from then on.
fn splits(relaxation: &Relaxation, sampling: &Sampling, inside: &[bool], crowded: &mut Crowded) -> Vec<Proposal> {
    let boundary = extract::boundary::Boundary::of(&sampling.complex, inside);
    let mut edges: Vec<[u32; 2]> = boundary
        .triangles
        .iter()
        .flat_map(|t| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let mut splits = relaxation.crease_splits(|a, b| edges.binary_search(&[a.min(b), a.max(b)]).is_ok());
    let whole = &relaxation.seeds().whole;
    let is_whole = |anchor: &Anchor| anchor.curve().is_some_and(|c| whole.get(c as usize) == Some(&true));
    let (count, noise) = (sampling.kinds.len(), splits.iter().filter(|s| !is_whole(&s.1)).count());
    crowded.noise |= noise > count / MOST_SPLITS_OF_NOISE + FEW_SPLITS;
    crowded.all |= splits.len() - noise > count / MOST_SPLITS + FEW_SPLITS;
    let seeds = relaxation.seeds();
    let on_curves = seeds.positions.iter().zip(&seeds.anchors).filter_map(|(&p, a)| Some((p, a.curve()?)));
    let on_curves: Vec<(DVec3, u32)> = on_curves.collect();
    let is_crowded = |(place, anchor, _): &(DVec3, Anchor, f64)| {
        crowded.noise || is_beside_another(&on_curves, *place, anchor.curve(), BESIDE * seeds.spacing_at(*place))
    };
    splits.retain(|s| !crowded.all && (is_whole(&s.1) || !is_crowded(s)));
    let mut moved = Vec::new();
    let proposal = |(place, anchor, size): (DVec3, Anchor, f64)| {
        // A seed of the surface that keeps the crease's seeds apart is on the wrong side of it, and goes there itself.
        let nearest = sampling.complex.nearest(place, moved.last().copied().unwrap_or(0));
        let is_free = sampling.kinds[nearest as usize] == SeedKind::Surface && !moved.contains(&nearest);
        let intrudes = is_free && seeds.positions[nearest as usize].distance(place) < INTRUDES * size;
        if intrudes {
            moved.push(nearest);
        }
        Proposal { place, anchor, size, replaces: intrudes.then_some(nearest) }
    };
    splits.into_iter().map(proposal).collect()
}

/// Whether a place on a crease that is noise has a seed of another crease so near that the two would have to be split in turn, on
/// and on.
fn is_beside_another(on_curves: &[(DVec3, u32)], place: DVec3, own: Option<u32>, reach: f64) -> bool {
    on_curves.iter().any(|&(p, curve)| Some(curve) != own && p.distance(place) < reach)
}

/// For each seed in no tet, which more seeds around it did not help: the surface's coarsest places, where there is room.
fn moved_away(relaxation: &Relaxation, unused: &[Defect]) -> Vec<Proposal> {
    let seeds = relaxation.seeds();
    let gap = |c: &Crossing| c.point.distance(seeds.positions[c.facet[0] as usize]) / seeds.spacing_at(c.point);
    let mut coarsest: Vec<&Crossing> = relaxation.clipped().crossings.iter().collect();
    coarsest.sort_by_cached_key(|c| std::cmp::Reverse(gap(c).to_bits()));
    let mut found: Vec<Proposal> = Vec::new();
    for crossing in coarsest {
        let Some(defect) = unused.get(found.len()) else { break };
        let spacing = seeds.spacing_at(crossing.point);
        let far = |p: DVec3| p.distance(crossing.point) > 2.0 * spacing;
        if unused.iter().all(|d| far(d.place)) && found.iter().all(|p| far(p.place)) {
            let (place, anchor) = (crossing.point, Anchor::Surface { triangle: crossing.triangle });
            found.push(Proposal { place, anchor, size: spacing, replaces: Some(defect.seeds[0]) });
        }
    }
    found
}

/// Moves each donor to its proposal's place, and asks for a finer spacing there.
fn insert(
    relaxation: &mut Relaxation,
    params: &Params,
    donors: Vec<(u32, Proposal)>,
    observer: &mut dyn Observer,
) -> Result<(), Error> {
    relaxation.refine_density(&donors.iter().map(|(_, p)| (p.place, p.size)).collect::<Vec<_>>());
    let seeds = relaxation.seeds();
    let mut targets: Vec<(DVec3, Anchor)> =
        seeds.positions.iter().copied().zip(seeds.anchors.iter().copied()).collect();
    for (donor, proposal) in donors {
        let anchor = match params.boundary {
            Boundary::Conform => proposal.anchor,
            Boundary::Free => Anchor::Interior,
        };
        targets[donor as usize] = (snap(proposal.place), anchor);
    }
    relaxation.insert(targets, observer)?;
    Ok(())
}

/// For each proposal a seed that can be spared: the least cells of the interior first, then of the surface, no two of
/// them neighbours and none near a place where seeds are wanted.
fn donors(relaxation: &Relaxation, sampling: &Sampling, proposals: &[Proposal]) -> Vec<(u32, Proposal)> {
    let cells = &relaxation.clipped().cells;
    let seeds = relaxation.seeds();
    let adjacency = &relaxation.clipped().adjacency;
    let relative = |i: u32| sampling.spacing.relative(seeds.positions[i as usize]);
    // Over what a seed should have where it is.
    let size = |i: u32| match sampling.kinds[i as usize] {
        SeedKind::Interior => cells[i as usize].volume / relative(i).powi(3),
        _ => cells[i as usize].area_mass * relative(i).powi(2),
    };
    let mut spare: Vec<u32> = (0..seeds.positions.len() as u32)
        .filter(|&i| match sampling.kinds[i as usize] {
            SeedKind::Interior => cells[i as usize].area == 0.0,
            kind => kind == SeedKind::Surface,
        })
        .collect();
    spare.sort_by(|&a, &b| {
        let kind = |i: u32| sampling.kinds[i as usize];
        (kind(a), size(a)).partial_cmp(&(kind(b), size(b))).expect("moments are finite: this is a bug in tetcvt")
    });
    let inner = spare.partition_point(|&i| sampling.kinds[i as usize] == SeedKind::Interior);
    if THIN * inner < spare.len() {
        // Thin solids have few seeds within, and need them: both kinds give alike.
        let outer = spare.len() - inner;
        let share = |k: usize| if k < inner { k as f64 / inner as f64 } else { (k - inner) as f64 / outer as f64 };
        let mut order: Vec<usize> = (0..spare.len()).collect();
        order.sort_by(|&a, &b| share(a).total_cmp(&share(b)));
        spare = order.into_iter().map(|k| spare[k]).collect();
    }
    let mut taken = vec![false; seeds.positions.len()];
    for proposal in proposals {
        if let Some(own) = proposal.replaces {
            taken[own as usize] = true;
        }
    }
    let mut places = Places::new(seeds.spacing);
    proposals.iter().for_each(|q| places.insert(q.place));
    let wanted = |p: DVec3| places.any_within(p, 2.0 * seeds.spacing_at(p));
    let mut spare = spare.into_iter();
    let mut found = Vec::new();
    for &proposal in proposals {
        if let Some(own) = proposal.replaces {
            found.push((own, proposal));
            continue;
        }
        let free = |&i: &u32| {
            let apart = adjacency.of(i as usize).iter().all(|&j| !taken[j as usize]);
            apart && !taken[i as usize] && !wanted(seeds.positions[i as usize])
        };
        match spare.find(free) {
            Some(donor) => {
                taken[donor as usize] = true;
                found.push((donor, proposal));
            }
            None => break,
        }
    }
    found
}

fn note(round: usize, defects: &[Defect], splits: usize, moved: usize) -> String {
    let mut kinds: Vec<(&str, usize)> = Vec::new();
    if splits > 0 {
        kinds.push(("a crease without its edge", splits));
    }
    for defect in defects {
        match kinds.iter_mut().find(|k| k.0 == defect.kind.describe()) {
            Some(kind) => kind.1 += 1,
            None => kinds.push((defect.kind.describe(), 1)),
        }
    }
    let list: Vec<String> = kinds.iter().map(|(what, count)| format!("{what} ({count})")).collect();
    format!("round {}: {}; {moved} seeds moved there from elsewhere", round + 1, list.join(", "))
}

/// That the improvement left no tet without volume; it was handed some if [`until_valid`] could not help it.
pub fn check_volumes(
    mesh: &TetMesh,
    (surface, features): (&Surface, &Features),
    params: &Params,
    seeds: &Seeds,
) -> Result<(), Error> {
    let frame = surface.frame();
    let corners = |t: usize| mesh.corners(t).map(|p| frame.to_frame(p));
    let is_flat = |&t: &usize| extract::is_flat(corners(t)) || extract::model_volume6(frame, mesh.corners(t)) <= 0.0;
    let Some(t) = (0..mesh.tets.len()).into_par_iter().find_first(is_flat) else { return Ok(()) };
    let [a, b, c, d] = corners(t);
    let (kind, place) = (DefectKind::FlatTet, tetrahedron::centroid(a, b, c, d));
    let defect = Defect { kind, place, seeds: Vec::new(), crossing: None, shell: None };
    Err(too_few((surface, features), params, seeds, (&defect, 0)))
}

/// The error for a sampling that cannot be mended: the first defect, and how many places there are at which more seeds would be wanted.
fn too_few(
    (surface, features): (&Surface, &Features),
    params: &Params,
    seeds: &Seeds,
    (defect, places): (&Defect, usize),
) -> Error {
    let count = seeds.positions.len();
    // A place that is still too coarse takes a few seeds more than were moved to it.
    let for_places = (count + count / 2).max(count + 4 * places);
    // Walls that were too thin for the first seeds to see to may be too thin for that many too.
    let for_walls = match params.boundary {
        Boundary::Conform => {
            seeds::enough_for_walls(surface, features, seeds.sizing.as_deref(), (count, params.random_seed))
        }
        Boundary::Free => 0,
    };
    Error::TooFewSeeds {
        count,
        needed: for_places.max(for_walls),
        reason: defect.kind.describe().to_string(),
        place: surface.frame().to_model(defect.place).to_array(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Target;

    /// A plate of 1 by 1, as thin as it says.
    fn plate(thickness: f64) -> Surface {
        let size = DVec3::new(1.0, 1.0, thickness);
        let corner = |i: u32| size * DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let each: Vec<u32> = (0..12).collect();
        let points: Vec<DVec3> = (0..8).map(corner).collect();
        Surface::new(&points, &triangles, &each, &each).expect("a closed surface")
    }

    /// A count that the first seeds do with, because walls have fewer than they should, may be too few all the same.
    #[test]
    fn a_refusal_names_no_fewer_seeds_than_thin_walls_need() {
        let surface = plate(0.01);
        let params = |count| Params { target: Target::Count(count), ..Params::default() };
        let features = Features::find(&surface, params(4).feature_angle);
        let needed = |error| match error {
            Error::TooFewSeeds { needed, .. } => needed,
            other => panic!("{other}"),
        };
        let walls = needed(seeds::sample(&surface, &features, &params(1000)).expect_err("too few for the walls"));
        let stretched = seeds::sample(&surface, &features, &params(2500)).expect("just enough for the walls");
        let (kind, place, seeds) = (DefectKind::UnusedSeed, stretched.positions[0], vec![0]);
        let defect = Defect { kind, place, seeds, crossing: None, shell: None };
        let named = needed(too_few((&surface, &features), &params(2500), &stretched, (&defect, 1)));
        assert!(named >= walls, "{named} seeds are said to do, thin walls need {walls}");
        // Where nothing is thin the places of the defects tell.
        let seeds = Seeds { positions: vec![DVec3::ZERO; 100_000], ..stretched };
        assert_eq!(needed(too_few((&surface, &features), &params(100_000), &seeds, (&defect, 1))), 150_000);
    }
}
