//! Finds where flat facets cut too much off a curved surface.
//!
//! A facet with its vertices on the surface lies below a convex part of it and above a concave one, by an amount that
//! falls with the square of the spacing. Where an even spacing loses more volume in all than is tolerable, the facets
//! that lose most get a seed; and so do the few tips and folds of the surface that are farthest from the facets.

use glam::DVec3;
use rayon::prelude::*;

use crate::extract::boundary::Boundary;
use crate::extract::{Proposal, Sampling};
use crate::geometry::places::Places;
use crate::geometry::tetrahedron::FACETS;
use crate::geometry::triangle::{centroid, closest_point, normal2};
use crate::seeds::Anchor;
use crate::surface::box_tree::BoxTree;

/// The share of the volume that may be lost or gained.
const TOLERATED: f64 = 0.0027;
/// The share of a facet's error that a seed at its middle removes: the error falls with the square of the edges, and some
/// of what is inserted is smoothed away again.
const GAIN: f64 = 0.6;
/// The spacing asked for around a new seed, over the facet's.
const FINER: f64 = 0.7;
/// At most this share of the seeds moves in one round: a coarse mesh is coarse everywhere.
const MOST: f64 = 0.0285;
/// Where more than so many times that would have to move yet, after a first round, the tolerance is out of reach: only this
/// share of it does, and tets stay better.
const OUT_OF_REACH: usize = 5;
const OUT_OF_REACH_MOST: f64 = 0.5;

/// Vertices of the surface farther from the facets than this share of the spacing get a seed, and none within [`APART`]
/// spacings of it.
const FAR: f64 = 0.11;
const APART: f64 = 1.0;
/// At most this share of the seeds goes there in one round.
const MOST_FAR: f64 = 0.006;

/// A facet of the boundary and the volume between it and the surface: positive where the tets behind it lack it.
struct Loss {
    proposal: Proposal,
    volume: f64,
    account: usize,
}

/// Seeds that bring the boundary of the tets `inside` closer to the surface in this round, from 0; none where it is close
/// enough.
pub fn proposals(sampling: &Sampling, inside: &[bool], round: usize) -> Vec<Proposal> {
    let mut chosen = far_spots(sampling, inside);
    let mut places = Places::new(sampling.spacing.largest);
    chosen.iter().for_each(|p| places.insert(p.place));
    chosen.extend(volumes(sampling, inside, round).into_iter().filter(|p| !places.any_within(p.place, p.size)));
    chosen
}

/// The vertices of the surface that lie farthest from the boundary of the tets `inside`.
fn far_spots(sampling: &Sampling, inside: &[bool]) -> Vec<Proposal> {
    let surface = sampling.surface;
    let most = (MOST_FAR * sampling.kinds.len() as f64) as usize;
    let facets = Boundary::of(&sampling.complex, inside).triangles;
    // Where no tet is inside all is far, which a seed more does not mend.
    if most == 0 || facets.is_empty() {
        return Vec::new();
    }
    let boundary = BoxTree::build(sampling.complex.points, &facets);
    let mut far: Vec<(f64, u32)> = (surface.points().par_iter().enumerate())
        .filter_map(|(v, &p)| {
            let spacing = sampling.spacing.at(p);
            // Nearly all are close to the first facet that is met.
            let (reach, square) = (DVec3::splat(FAR * spacing), (FAR * spacing).powi(2));
            let is_close = |f: u32| {
                let corners = facets[f as usize].map(|v| sampling.complex.points[v as usize]);
                closest_point(corners, p).distance_squared(p) <= square
            };
            if boundary.any_near_box(p - reach, p + reach, is_close) {
                return None;
            }
            Some((boundary.closest(p).distance2.sqrt() / spacing, v as u32))
        })
        .collect();
    far.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Proposal> = Vec::new();
    let mut places = Places::new(sampling.spacing.largest);
    for (_, v) in far {
        if chosen.len() >= most {
            break;
        }
        let place = surface.points()[v as usize];
        let spacing = sampling.spacing.at(place);
        if !places.any_within(place, APART * spacing) {
            places.insert(place);
            let anchor = Anchor::Surface { triangle: surface.tree().closest(place).triangle };
            chosen.push(Proposal { place, anchor, size: FINER * spacing, replaces: None });
        }
    }
    chosen
}

/// Seeds that bring the volume of the tets `inside` closer to the solid's; none where it is close enough. What each interface
/// shuts in has an account of its own.
fn volumes(sampling: &Sampling, inside: &[bool], round: usize) -> Vec<Proposal> {
    let surface = sampling.surface;
    let mut losses: Vec<Loss> =
        (0..inside.len() as u32).into_par_iter().flat_map_iter(|t| losses_of(sampling, inside, t)).collect();
    let mut total = vec![0.0; 1 + surface.shell_count()];
    losses.iter().for_each(|l| total[l.account] += l.volume);
    let volumes = (0..surface.shell_count() as u32).map(|s| surface.volume_of_shell(s));
    let volumes = std::iter::once(surface.volume()).chain(volumes);
    let mut excess: Vec<f64> = total.iter().zip(volumes).map(|(t, v)| t.abs() - TOLERATED * v).collect();
    losses.retain(|l| l.volume * total[l.account] > 0.0);
    losses.sort_by(|a, b| b.volume.abs().total_cmp(&a.volume.abs()));
    let mut most = (MOST * sampling.kinds.len() as f64) as usize;
    if round > 0 && needed(&losses, excess.clone()) > OUT_OF_REACH * most {
        most = (most as f64 * OUT_OF_REACH_MOST) as usize;
    }
    let mut chosen: Vec<Proposal> = Vec::new();
    let mut places = Places::new(losses.get(losses.len() / 2).map_or(1.0, |l| l.proposal.size));
    for loss in losses {
        let Loss { proposal, volume, account } = loss;
        if chosen.len() >= most {
            break;
        }
        if excess[account] > 0.0 && !places.any_within(proposal.place, proposal.size) {
            places.insert(proposal.place);
            chosen.push(proposal);
            excess[account] -= GAIN * volume.abs();
        }
    }
    chosen
}

/// How many of the largest `losses` it takes to be within tolerance, if none stood in the way of another.
fn needed(losses: &[Loss], mut excess: Vec<f64>) -> usize {
    let helps = |loss: &&Loss| -> bool {
        let left = &mut excess[loss.account];
        let was_over = *left > 0.0;
        *left -= GAIN * loss.volume.abs();
        was_over
    };
    losses.iter().filter(helps).count()
}

/// What the facets of tet `t` on the boundary lose.
fn losses_of<'a>(sampling: &'a Sampling, inside: &'a [bool], t: u32) -> impl Iterator<Item = Loss> + 'a {
    let around = sampling.complex.around(t);
    (0..4).filter(move |&f| inside[t as usize] && !inside[around[f] as usize]).map(move |f| {
        let corners = sampling.complex.corners(t);
        let [a, b, c] = FACETS[f].map(|k| corners[k]);
        let middle = centroid(a, b, c);
        let closest = sampling.surface.tree().closest(middle);
        let edge = (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0;
        Loss {
            proposal: Proposal {
                place: closest.point,
                anchor: Anchor::Surface { triangle: closest.triangle },
                size: FINER * edge,
                replaces: None,
            },
            volume: volume_between(normal2(a, b, c), closest.point - middle),
            account: account(sampling, closest.triangle),
        }
    })
}

/// The volume between a facet and the surface `offset` from its middle: 3/4 of the prism's, as if a paraboloid stood on
/// the facet's corners.
fn volume_between(normal2: DVec3, offset: DVec3) -> f64 {
    0.75 * normal2.dot(offset) / 2.0
}

/// Where the volume between a facet and a triangle counts: the number of its shell plus 1 for an interface, else 0.
fn account(sampling: &Sampling, triangle: u32) -> usize {
    match sampling.surface.is_interface(triangle) {
        true => 1 + sampling.surface.shell()[triangle as usize] as usize,
        false => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::Delaunay;
    use crate::seeds::SeedKind;
    use crate::surface::Surface;

    /// A cube of side 1 with a seed at each corner.
    fn cube() -> (Surface, Delaunay) {
        let points: Vec<DVec3> =
            (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1))).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let each: Vec<u32> = (0..12).collect();
        let surface = Surface::new(&points, &triangles, &each, &each).expect("a closed surface");
        let half = surface.points()[7].max_element();
        // As many seeds as it takes for one to go to a far place.
        let inner =
            (0..512).map(|i| DVec3::new(f64::from(i % 8), f64::from(i / 8 % 8), f64::from(i / 64)) / 8.0 - 0.4375);
        let seeds: Vec<DVec3> = surface.points().iter().copied().chain(inner.map(|p| p * half)).collect();
        (surface, Delaunay::build(&seeds).expect("seeds have tets"))
    }

    #[test]
    fn a_boundary_that_cuts_off_a_corner_is_drawn_to_it_and_none_asks_for_nothing() {
        let (surface, delaunay) = cube();
        let kinds: Vec<SeedKind> =
            (0..520).map(|i| if i < 8 { SeedKind::Corner } else { SeedKind::Interior }).collect();
        let sampling = Sampling::new(&delaunay, &kinds, &surface, 0.05);
        let count = delaunay.vertices().len();
        assert!(proposals(&sampling, &vec![false; count], 0).is_empty());

        let has = |t: usize, v: u32| delaunay.vertices()[t].contains(&v);
        let all: Vec<bool> = delaunay.vertices().iter().map(|t| t[3] != crate::delaunay::INFINITE).collect();
        assert!(far_spots(&sampling, &all).is_empty());
        let without: Vec<bool> = (0..count).map(|t| all[t] && !has(t, 3)).collect();
        let found = far_spots(&sampling, &without);
        assert_eq!(found.iter().map(|p| p.place).collect::<Vec<_>>(), [surface.points()[3]]);
    }

    #[test]
    fn the_largest_losses_count_until_the_rest_is_tolerable() {
        let loss = |volume: f64| Loss {
            proposal: Proposal { place: DVec3::ZERO, anchor: Anchor::Interior, size: 1.0, replaces: None },
            volume,
            account: 0,
        };
        let losses = [loss(5.0), loss(3.0), loss(1.0), loss(1.0)];
        for (excess, expected) in [(-1.0, 0), (1.0, 1), (5.0 * GAIN + 0.1, 2), (8.5 * GAIN, 3), (100.0, 4)] {
            assert_eq!(needed(&losses, vec![excess]), expected, "{excess}");
        }
    }
}
