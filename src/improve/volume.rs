//! Gives the boundary the surface's volume back.
//!
//! Facets with their corners on the surface cut convex parts off it and fill concave ones. Corners that leave it by a share of
//! what the facets around them stray leave the rest to these facets' middles: the volume comes out right, and boundary and
//! surface are no farther apart than before.
//!
//! 1. The way of each vertex on a smooth part of the surface: along the mean normal of its facets, the mean of what these
//!    stray there; only those towards the volume that lacks, none away from the surface where that is farthest, and none by which
//!    a facet that strays the other way would stray nearly as far. On flat sides and along creases there is none.
//! 2. All go the share of their way that makes up for the volume, 1 at most; those that would take a tet below the floor, or
//!    below the worst around them, half of it, or none.
//! 3. Again, until the volume is right or nothing is left to go.
//!
//! The volume is linear in each vertex: it grows by a sixth of the way times the sum of the facets' normals, twice their areas long.

use std::collections::HashMap;

use glam::DVec3;

use super::complex::{Complex, Freedom, NONE};
use super::ground::Ground;
use super::places::{self, Place};
use crate::geometry::frame::snap;
use crate::geometry::{tetrahedron, triangle};

/// Share of the volume that may lack in the end.
const TOLERANCE: f64 = 1e-6;

/// What facets may come to stray that strayed the other way, as a share of what the farthest of all does: elsewhere than in their middles
/// they stray farther.
const MOST_OTHER_WAY: f64 = 0.5;

/// Rounds of steps 2 and 3.
const ROUNDS: usize = 12;

/// Where boundary and surface are apart by more than this share of the most that they are anywhere, no vertex goes away from the surface.
const FAR: f64 = 0.8;

/// A vertex on its way.
struct Traveler {
    vertex: u32,
    /// All of its way.
    way: DVec3,
    /// The volume that all of it gains.
    gain: f64,
    /// The share that it has gone.
    gone: f64,
    /// Whether it may go on.
    free: bool,
}

/// What has been done.
pub(super) struct Outcome {
    /// Volume of the mesh over the surface's, less 1.
    pub error: f64,
    /// The farthest that a vertex went, in the frame.
    pub farthest: f64,
}

/// Moves the vertices of the boundary so that the tets have the surface's volume, as far as that is possible.
pub(super) fn preserve(complex: &mut Complex, ground: &Ground) -> Outcome {
    let wanted = ground.surface.volume();
    let mut lack = wanted - volume(complex);
    let mut travelers = travelers(complex, ground, lack.signum());
    for _ in 0..ROUNDS {
        if lack.abs() <= TOLERANCE * wanted {
            break;
        }
        let gain: f64 = travelers.iter().filter(|t| t.free).map(|t| t.gain).sum();
        if gain == 0.0 {
            break;
        }
        let share = lack / gain;
        for traveler in travelers.iter_mut().filter(|t| t.free) {
            advance(complex, traveler, share);
        }
        complex.commit();
        lack = wanted - volume(complex);
    }
    let farthest = travelers.iter().map(|t| t.way.length() * t.gone).fold(0.0, f64::max);
    Outcome { error: -lack / wanted, farthest }
}

/// Step 1: those whose way gains volume of the sign `sign`.
fn travelers(complex: &Complex, ground: &Ground, sign: f64) -> Vec<Traveler> {
    let sagitta: Vec<f64> = complex
        .facets
        .iter()
        .map(|f| if f.vertices[0] == NONE { 0.0 } else { sagitta(ground, complex.corners(f.vertices)) })
        .collect();
    let farthest = sagitta.iter().fold(0.0, |most: f64, s| most.max(s.abs()));
    let far_beside = far_beside(complex, ground);
    let traveler = |vertex: u32| {
        let Freedom::Surface(_) = complex.freedom[vertex as usize] else { return None };
        let facets = complex.facets_of(vertex);
        // What one region gains at an interface the other loses.
        if complex.has_interfaces && facets.iter().any(|&f| is_interface(complex, complex.facets[f as usize].vertices))
        {
            return None;
        }
        let normal2: DVec3 = facets
            .iter()
            .map(|&f| {
                let [a, b, c] = complex.corners(complex.facets[f as usize].vertices);
                triangle::normal2(a, b, c)
            })
            .sum();
        let mean = facets.iter().map(|&f| sagitta[f as usize]).sum::<f64>() / facets.len() as f64;
        // Facets that stray the other way stray farther then.
        let other_way = facets.iter().map(|&f| -mean.signum() * sagitta[f as usize]).fold(0.0, f64::max);
        if other_way > 0.0 && other_way + mean.abs() > MOST_OTHER_WAY * farthest {
            return None;
        }
        let way = normal2.try_normalize()? * mean;
        if far_beside.get(&vertex).is_some_and(|ways| ways.iter().any(|w| w.dot(way) < 0.0)) {
            return None;
        }
        let gain = way.dot(normal2) / 6.0;
        (gain * sign > 0.0).then_some(Traveler { vertex, way, gain, gone: 0.0, free: true })
    };
    (0..complex.points.len() as u32).filter(|&v| complex.on_boundary(v)).filter_map(traveler).collect()
}

/// For vertices beside which boundary and surface are farthest apart, the ways there from the boundary to the surface.
fn far_beside(complex: &Complex, ground: &Ground) -> HashMap<u32, Vec<DVec3>> {
    let strays = complex.facets.iter().filter(|f| f.vertices[0] != NONE).map(|f| f.stray.distance);
    let places = places::find(complex, ground, (FAR * strays.fold(0.0, f64::max), 0));
    let far = FAR * places.first().map_or(0.0, |p| p.distance);
    let mut beside: HashMap<u32, Vec<DVec3>> = HashMap::new();
    for place in places.iter().take_while(|p| p.distance > far) {
        let facets = complex.edge_facets(place.edge).into_iter().map(|f| complex.facets[f as usize].vertices);
        let facets: Vec<[u32; 3]> = facets.collect();
        let way = way_to_surface(complex, ground, place, &facets);
        facets.iter().flatten().for_each(|&v| beside.entry(v).or_default().push(way));
    }
    beside
}

/// From the boundary to the surface at a place, beside which there are these facets.
fn way_to_surface(complex: &Complex, ground: &Ground, place: &Place, facets: &[[u32; 3]]) -> DVec3 {
    let corners = facets.iter().map(|&f| complex.corners(f));
    let longest = |ways: &mut dyn Iterator<Item = DVec3>| {
        ways.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or_default()
    };
    if let Some((tip, _)) = place.tip {
        return -longest(&mut corners.map(|c| triangle::closest_point(c, tip) - tip));
    }
    let [a, b] = complex.corners(place.edge);
    let samples = corners.map(|[a, b, c]| triangle::centroid(a, b, c)).chain([(a + b) * 0.5]);
    longest(&mut samples.map(|p| ground.surface.tree().closest(p).point - p))
}

/// Whether there are tets on both sides of a facet.
fn is_interface(complex: &Complex, [a, b, c]: [u32; 3]) -> bool {
    let has = |&&t: &&u32| complex.tets[t as usize].contains(&b) && complex.tets[t as usize].contains(&c);
    complex.star(a).iter().filter(has).count() == 2
}

/// How far the surface is above the middle of a facet.
fn sagitta(ground: &Ground, [a, b, c]: [DVec3; 3]) -> f64 {
    let middle = triangle::centroid(a, b, c);
    let offset = ground.surface.tree().closest(middle).point - middle;
    triangle::normal2(a, b, c).try_normalize().map_or(0.0, |n| n.dot(offset))
}

/// Takes a vertex a share of its way further, or half of it, if its tets allow that.
fn advance(complex: &mut Complex, traveler: &mut Traveler, share: f64) {
    let (v, from) = (traveler.vertex, complex.points[traveler.vertex as usize]);
    let freedom = complex.freedom[v as usize];
    let worst =
        |complex: &Complex| complex.star(v).iter().map(|&t| complex.quality[t as usize]).fold(f64::INFINITY, f64::min);
    let bound = worst(complex).min(complex.floor());
    // Back, where the others went too far; but not beyond the start.
    let step = (traveler.gone + share).clamp(0.0, 1.0) - traveler.gone;
    for step in [step, 0.5 * step] {
        let mark = complex.mark();
        complex.move_vertex(v, snap(from + traveler.way * step), freedom);
        if worst(complex) >= bound {
            traveler.gone += step;
            traveler.free = traveler.gone < 1.0;
            return;
        }
        complex.rollback(mark);
    }
    traveler.free = false;
}

/// The volume of all tets, in the frame.
fn volume(complex: &Complex) -> f64 {
    let tets = complex.tets.iter().filter(|t| t[0] != NONE);
    tets.map(|&t| {
        let [a, b, c, d] = complex.corners(t);
        tetrahedron::volume(a, b, c, d)
    })
    .sum()
}
