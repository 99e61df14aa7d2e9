//! Small repairs of labels, without further seeds.
//!
//! A boundary is a manifold where, at every vertex, the tets inside are connected through facets and so are those
//! outside ([`super::complex::Fans`]). What is wrong at a vertex is a number, the penalty, that only its star decides;
//! a toggled tet changes four penalties. Toggling a tet of a manifold so that no penalty rises keeps the topology: the
//! tet then meets the boundary in a disk, unless it is alone with its new label, which no step may leave it. Tets that
//! join seeds of two solids pass through the outside and are never inside. The steps:
//!
//! 1. Peel slim tets off the boundary that are mere folds of it: 2-2 flips of the boundary, and caps over a seed.
//! 2. Around vertices with a penalty, label by [`Sampling::depth`] wherever a cluster of such changes gains; once before
//!    step 3 around the grave ones, once after it around all that are left.
//! 3. Descend: at each vertex with a penalty take, of all toggles of a tet, of a pair, of a piece of the star or of an
//!    edge's ring, or of a way from an unused seed to the nearest tet inside, the one that obeys the depths best among
//!    those that lower the sum of penalties.
//! 4. Take over from the depths where tets beside the boundary lie clearly on the other side of it than their labels say,
//!    as where it runs across a crease that has seeds near by, and it stays a manifold.
//! 5. Where the topology is wrong, first fill tunnels, take bridges away and link what has fallen apart, one by one: by tets
//!    between the vertices of triangles that stand across the surface, by clusters of tets whose labels contradict their
//!    depths, by ways from small regions to others. What each does to the penalties and to the Euler characteristic is
//!    known from around it, so that all can be tried.
//! 6. Then try all such clusters at once, the large ones, and regions that stand for no shell, each followed by steps 1 to
//!    4; keep what lowers the penalties or else the mismatch.
//!
//! Every accepted step lowers an integer, so it ends; all orders are by index, so that it is deterministic. No tet is
//! toggled against its depth by more than a fraction of the spacing.

use std::sync::atomic::{AtomicU8, Ordering};

use super::Sampling;
use super::boundary::{Boundary, OUTSIDE, regions};
use super::complex::Complex;
use super::repair::{Judge, Repair};
use super::topology::Topology;
use super::tunnels;
use crate::geometry::tetrahedron::{self, FACETS};
use crate::geometry::triangle::normal2;

/// A label may go against a tet's depth by this share of the spacing.
const REACH: f64 = 0.25;
/// A tet whose smallest dihedral angle is below this, in degrees, is thin.
const THIN: f64 = 5.0;
/// Below this it may be a fold of the boundary, where its facets lie as one.
const SLIM: f64 = 20.0;
/// Facets whose normals differ by less than the angle of this cosine lie on one sheet.
const SHEET: f64 = 0.94;
/// Changes tried for the sake of topology.
const TRIALS: usize = 32;
/// Times that tunnels and bridges are looked for.
const TUNNEL_PASSES: usize = 4;
/// Rounds over all vertices.
const ROUNDS: usize = 12;
/// A region of more tets than this is no mistake of labelling.
const SMALL_REGION: usize = 1000;

/// Repairs the labels `inside`.
pub fn mend(sampling: &Sampling, inside: Vec<bool>) -> Vec<bool> {
    let complex = &sampling.complex;
    // Where the spacing varies, in terms of its largest.
    let depth = |t: u32| {
        let [a, b, c, d] = complex.corners(t);
        sampling.depth(t) / sampling.spacing.relative(tetrahedron::centroid(a, b, c, d))
    };
    let [flats, thins, slims] = [0; 3].map(|_| Known::of(inside.len()));
    let flat = |t: u32| flats.get(t, || sampling.is_flat(t));
    let thin = |t: u32| thins.get(t, || min_dihedral(complex, t) < THIN);
    let slim = |t: u32| slims.get(t, || min_dihedral(complex, t) < SLIM);
    let shape = Shape { thin: &thin, slim: &slim };
    let judge = Judge { depth: &depth, flat: &flat, reach: REACH * sampling.spacing.largest };
    let mut repair = Repair::new(complex, sampling.kinds, judge, inside);
    settle(complex, &mut repair, shape);
    mend_topology(sampling, &mut repair, shape);
    repair.into_labels()
}

/// What was found out about each tet so far, for questions that are asked in every round.
struct Known(Vec<AtomicU8>);

impl Known {
    const YES: u8 = 1;
    const NO: u8 = 2;

    fn of(tets: usize) -> Known {
        Known((0..tets).map(|_| AtomicU8::new(0)).collect())
    }

    fn get(&self, t: u32, find: impl Fn() -> bool) -> bool {
        // The answer is the same whoever finds it.
        match self.0[t as usize].load(Ordering::Relaxed) {
            0 => {
                let is_so = find();
                self.0[t as usize].store(if is_so { Known::YES } else { Known::NO }, Ordering::Relaxed);
                is_so
            }
            known => known == Known::YES,
        }
    }
}

/// What there is to say of a tet by its smallest dihedral angle.
#[derive(Clone, Copy)]
pub struct Shape<'a> {
    /// Too thin for the boundary to be straightened by it.
    pub thin: &'a dyn Fn(u32) -> bool,
    /// Slim enough for a fold of the boundary.
    pub slim: &'a dyn Fn(u32) -> bool,
}

/// Steps 1 to 4.
pub fn settle(complex: &Complex, repair: &mut Repair, shape: Shape) {
    let fold = |t: u32, inside: &[bool]| (shape.slim)(t) && is_fold(complex, inside, t);
    repair.peel(&fold);
    if repair.hard() > 0 {
        repair.relabel(false, ROUNDS);
    }
    repair.descend();
    repair.relabel(true, ROUNDS);
    repair.descend();
    if repair.is_conforming() {
        let corners_cut = cut_corners(complex, repair.inside(), shape.thin);
        repair.straighten(&corners_cut);
    }
    repair.peel(&fold);
    repair.descend();
}

/// The usable tets, not thin, that meet tets of the other label in two facets or more: where the boundary may run across
/// a crease rather than along it.
fn cut_corners(complex: &Complex, inside: &[bool], thin: &dyn Fn(u32) -> bool) -> Vec<u32> {
    (0..inside.len() as u32).filter(|&t| complex.usable(t) && complex.exposed(inside, t) >= 2 && !thin(t)).collect()
}

/// The smallest dihedral angle of a tet, in degrees.
fn min_dihedral(complex: &Complex, t: u32) -> f64 {
    let [a, b, c, d] = complex.corners(t);
    tetrahedron::min_dihedral(a, b, c, d)
}

/// Whether the facets of tet `t`, which is slim, on the boundary lie on one sheet with those within, so that taking it off hardly
/// moves the boundary.
fn is_fold(complex: &Complex, inside: &[bool], t: u32) -> bool {
    let p = complex.corners(t);
    let normals = FACETS.map(|[i, j, k]| normal2(p[i], p[j], p[k]).normalize_or_zero());
    let around = complex.around(t);
    let outward = |i: usize| !inside[around[i] as usize];
    (0..4).filter(|&i| outward(i)).all(|i| (0..4).filter(|&j| !outward(j)).all(|j| normals[i].dot(-normals[j]) > SHEET))
}

/// What has to fall: what makes the mesh invalid at vertices, then the mismatch with the surface's topology, then what is
/// merely not as it should be.
fn score(sampling: &Sampling, repair: &Repair) -> (u64, u64, u64) {
    let boundary = Boundary::of(&sampling.complex, repair.inside());
    (repair.hard(), Topology::of(sampling, repair.inside(), &boundary).mismatch(), repair.soft())
}

/// Steps 5 and 6.
fn mend_topology(sampling: &Sampling, repair: &mut Repair, shape: Shape) {
    let mut best = score(sampling, repair);
    if best.1 > 0 {
        best = close_tunnels(sampling, repair, best);
    }
    let mut trials = 0;
    while best.1 > 0 {
        let mut improved = false;
        for change in candidates(sampling, repair) {
            if trials == TRIALS {
                return;
            }
            trials += 1;
            let labels = repair.inside().to_vec();
            repair.toggle(&change);
            settle(&sampling.complex, repair, shape);
            let new = score(sampling, repair);
            if new < best {
                let clusters = repair.clusters(&change);
                best = narrow(sampling, (repair, shape), (&labels, new), clusters);
                improved = true;
                break;
            }
            repair.restore(&labels);
        }
        if !improved {
            return;
        }
    }
}

/// Step 5, while the score falls from `best`. What is reached in the end.
fn close_tunnels(sampling: &Sampling, repair: &mut Repair, mut best: (u64, u64, u64)) -> (u64, u64, u64) {
    for _ in 0..TUNNEL_PASSES {
        let before = best;
        let mut suspects = tunnels::fillings(sampling, repair.inside());
        let contradictions = contradictions(sampling, repair);
        suspects.extend(repair.clusters(&contradictions));
        let regions = small_regions(&sampling.complex, repair.inside());
        suspects.extend(regions.iter().filter_map(|r| tunnels::link(&sampling.complex, repair.inside(), r)));
        for change in repair.by_obedience(suspects) {
            let mark = repair.mark();
            if !repair.attempt(&change) {
                continue;
            }
            // From around it a tunnel closed is no different from a component made up.
            match score(sampling, repair) {
                new if new < best => best = new,
                _ => repair.undo(mark),
            }
            if best.1 == 0 {
                return best;
            }
        }
        if best == before {
            break;
        }
    }
    best
}

/// Of clusters that were toggled all at once, and mended to what `repair` has and `reached` says, looks for the few that it took:
/// the others lay as they did for a reason. What is reached in the end.
fn narrow(
    sampling: &Sampling,
    (repair, shape): (&mut Repair, Shape),
    (before, mut reached): (&[bool], (u64, u64, u64)),
    mut clusters: Vec<Vec<u32>>,
) -> (u64, u64, u64) {
    while clusters.len() > 1 {
        let wide = repair.inside().to_vec();
        let rest = clusters.split_off(clusters.len() / 2);
        let mut found = false;
        for half in [rest, std::mem::take(&mut clusters)] {
            repair.restore(before);
            repair.toggle(&half.concat());
            settle(&sampling.complex, repair, shape);
            let new = score(sampling, repair);
            if (new.0, new.1) <= (reached.0, reached.1) {
                (reached, clusters, found) = (new, half, true);
                break;
            }
        }
        if !found {
            repair.restore(&wide);
        }
    }
    reached
}

/// Sets of tets whose labels may be what makes the topology wrong, the most promising first.
fn candidates(sampling: &Sampling, repair: &mut Repair) -> Vec<Vec<u32>> {
    let contradictions = contradictions(sampling, repair);
    let mut clusters = repair.clusters(&contradictions);
    clusters.sort_by_key(|c| std::cmp::Reverse(c.len()));
    let mut all = small_regions(&sampling.complex, repair.inside());
    if clusters.len() > 1 {
        all.push(contradictions);
    }
    all.extend(clusters);
    all
}

/// The tets at the boundary whose labels contradict their depths.
fn contradictions(sampling: &Sampling, repair: &mut Repair) -> Vec<u32> {
    let boundary = Boundary::of(&sampling.complex, repair.inside());
    let mut vertices: Vec<u32> = boundary.triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    repair.contradictions(&vertices)
}

/// Small regions of tets inside, and small cavities, that are surrounded by the other label.
fn small_regions(complex: &Complex, inside: &[bool]) -> Vec<Vec<u32>> {
    let outside: Vec<bool> = inside.iter().map(|x| !x).collect();
    let mut all = Vec::new();
    for labels in [inside, &outside] {
        let (region, count) = regions(complex, labels);
        let mut members = vec![Vec::new(); count];
        for (t, &r) in region.iter().enumerate().filter(|&(_, &r)| r != OUTSIDE) {
            if members[r as usize].len() <= SMALL_REGION {
                members[r as usize].push(t as u32);
            }
        }
        if count > 1 {
            all.extend(members.into_iter().filter(|m| m.len() <= SMALL_REGION && m.iter().all(|&t| complex.usable(t))));
        }
    }
    all
}
