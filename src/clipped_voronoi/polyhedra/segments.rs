//! The parts of Voronoi edges inside the solid, as segments of the three facets around each.

use rayon::prelude::*;

use super::{Key, Segment};
use crate::clipped_voronoi::crossings::{Crossings, FACET, Finder};
use crate::clipped_voronoi::{ClippedVoronoi, Crossing, outer_crossings};
use crate::delaunay::{Delaunay, INFINITE};
use crate::surface::Surface;

/// The segments of all Voronoi edges, by tet.
pub(super) fn of_edges(delaunay: &Delaunay, surface: &Surface, clipped: &ClippedVoronoi) -> Vec<Segment<Key>> {
    let (vertices, neighbors) = (delaunay.vertices(), delaunay.neighbors());
    let outer = outer_crossings(surface, &clipped.crossings);
    let crossings = Crossings::new(&outer, delaunay.points().len());
    let finder = Finder::new(crossings.facets(), 0..crossings.facets().len() as u32);
    let of_tet = |t: usize| {
        let (crossings, finder) = (&crossings, &finder);
        (0..4).flat_map(move |f| {
            let n = neighbors[t][f].tet() as usize;
            let facet = FACET[f].map(|v| vertices[t][v]);
            let mut found = Vec::new();
            // Each edge once, from the neighbour to t.
            if t < n && !facet.contains(&INFINITE) {
                let found_at = finder.find(facet).map(|n| crossings.facets()[n as usize].first);
                let (own, even) = found_at.map_or((&[][..], true), |first| crossings.from(first, facet));
                let ends = [n, t].map(|t| clipped.inside[t].then_some(Key::Center(t as u32)));
                for [from, to] in intervals(delaunay, facet, ends, own, even) {
                    found.extend([0, 1, 2].map(|side| segment(facet[side], facet[(side + 1) % 3], from, to)));
                }
            }
            found
        })
    };
    (0..vertices.len()).into_par_iter().flat_map_iter(of_tet).collect()
}

/// The interval from `from` to `to` as the facet between seeds `i` and `j` has it, which lies to its left seen from `j`.
fn segment(i: u32, j: u32, from: Key, to: Key) -> Segment<Key> {
    if i < j { Segment { facet: [i, j], from, to } } else { Segment { facet: [j, i], from: to, to: from } }
}

/// The intervals inside the solid of the Voronoi edge dual to facet (p, q, r), along (q - p) x (r - p). The `ends` that are
/// inside have names.
///
/// Where it begins inside, and where it enters, a stretch begins; sorted along the edge, the k-th of these belongs to the
/// k-th place where it leaves or ends. Rounding may swap neighbours, but every place is used once.
fn intervals(
    delaunay: &Delaunay,
    facet: [u32; 3],
    ends: [Option<Key>; 2],
    crossings: &[Crossing],
    even: bool,
) -> Vec<[Key; 2]> {
    let [first, last] = ends;
    if crossings.is_empty() {
        return first.zip(last).map(|(a, b)| [a, b]).into_iter().collect();
    }
    let [p, q, r] = facet.map(|i| delaunay.points()[i as usize]);
    let along = (q - p).cross(r - p);
    let mut sorted: Vec<(f64, &Crossing)> = crossings.iter().map(|c| ((c.point - p).dot(along), c)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let named = |leaves: bool| {
        let wanted = move |c: &&(f64, &Crossing)| (c.1.leaves == even) == leaves;
        sorted.iter().filter(wanted).map(|(_, c)| Key::Within(c.triangle, c.facet))
    };
    let begins = first.into_iter().chain(named(false));
    let stops = named(true).chain(last);
    begins.zip(stops).map(|(a, b)| [a, b]).collect()
}
