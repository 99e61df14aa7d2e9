//! Brings the boundary closer to the surface where it strays most: along ridges and folds that an edge runs across.
//!
//! 1. Places: the middles of the boundary's edges and facets, farthest from the surface first.
//! 2. A 2-2 flip of an edge there, or else a vertex on the surface in its middle; the tets around are improved anew.
//! 3. Kept if the boundary there is closer to the surface by far, and no tet fell far below the floor.
//!
//! The count of vertices is made right afterwards.

use rayon::prelude::*;

use super::change::Change;
use super::complex::{Complex, Facet, Mark, NONE};
use super::endgame::WORSE;
use super::flips::remove_edge;
use super::floor::Worklist;
use super::ground::Ground;
use super::resize::split;

/// Places that stray by less than this share of the surface's diagonal are well.
const CLOSE: f64 = 2.2e-3;

/// The share of its distance that a place may keep.
const KEPT: f64 = 0.75;

/// At most this share of the vertices is added: a coarse mesh is coarse everywhere.
const MOST: f64 = 0.005;

/// What a tet may lack to the floor for the endgame to mend (radians).
const LACK: f64 = 0.035;

/// Tets treated after a flip or split before it is judged.
const TREATED: usize = 32;

/// Works off the places that stray most.
pub(super) fn run(complex: &mut Complex, ground: &Ground, work: &mut Worklist) {
    let close = CLOSE * ground.surface.diagonal();
    let most = complex.vertex_count() + (MOST * complex.vertex_count() as f64) as usize;
    for (before, [a, b]) in places(complex, ground, close) {
        if complex.vertex_count() >= most {
            return;
        }
        // What was done elsewhere may have changed this place.
        if complex.is_crease(a, b) || edge_facets(complex, [a, b]).len() != 2 {
            continue;
        }
        let before = before.min(strays_around(complex, ground, [a, b]));
        if before > close {
            draw_in(complex, ground, work, ([a, b], before));
        }
    }
}

/// The edges that stray, or whose facets do, the farthest first.
fn places(complex: &Complex, ground: &Ground, close: f64) -> Vec<(f64, [u32; 2])> {
    let mut found: Vec<(f64, [u32; 2])> = complex
        .facets
        .par_iter()
        .filter(|f| f.vertices[0] != NONE)
        .flat_map_iter(|f| {
            let [a, b, c] = f.vertices;
            let length2 = |e: [u32; 2]| complex.points[e[0] as usize].distance_squared(complex.points[e[1] as usize]);
            let edges = [[a, b], [b, c], [c, a]];
            let longest = edges.into_iter().max_by(|&d, &e| length2(d).total_cmp(&length2(e))).unwrap_or([a, b]);
            let inner = (f.stray > close).then_some((f.stray, longest));
            let along = edges.into_iter().filter(|e| e[0] < e[1]).map(|e| (edge_stray(complex, ground, e), e));
            inner.into_iter().chain(along.filter(|e| e.0 > close))
        })
        .map(|(stray, [a, b])| (stray, [a.min(b), a.max(b)]))
        .collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    found
}

/// How far the middle of an edge is from the surface.
fn edge_stray(complex: &Complex, ground: &Ground, [a, b]: [u32; 2]) -> f64 {
    let middle = (complex.points[a as usize] + complex.points[b as usize]) * 0.5;
    ground.surface.tree().closest(middle).distance2.sqrt()
}

/// The facets of the boundary at an edge.
fn edge_facets(complex: &Complex, [a, b]: [u32; 2]) -> Vec<u32> {
    let at_b = |&f: &u32| complex.facets[f as usize].vertices.contains(&b);
    complex.facets_of(a).iter().copied().filter(at_b).collect()
}

/// The most that an edge and its facets stray.
fn strays_around(complex: &Complex, ground: &Ground, edge: [u32; 2]) -> f64 {
    let facets = edge_facets(complex, edge);
    facets.iter().map(|&f| complex.facets[f as usize].stray).fold(edge_stray(complex, ground, edge), f64::max)
}

/// The most that facets changed since `mark` and their edges stray.
fn strays_since(complex: &Complex, ground: &Ground, mark: Mark) -> f64 {
    let mut most = 0.0_f64;
    for f in complex.facets_since(mark) {
        let Facet { vertices: [a, b, c], stray, .. } = complex.facets[f as usize];
        most = [[a, b], [b, c], [c, a]]
            .into_iter()
            .map(|e| edge_stray(complex, ground, e))
            .fold(most.max(stray), f64::max);
    }
    most
}

/// Steps 2 and 3 at an edge.
fn draw_in(complex: &mut Complex, ground: &Ground, work: &mut Worklist, (edge, before): ([u32; 2], f64)) {
    let mut change = Change::default();
    // Facets beside a ridge may stray more than they did, if the ridge comes closer.
    let wide = &ground.within(KEPT * before);
    let deficit = complex.deficit() + LACK * LACK * LACK;
    let around = edge.iter().flat_map(|&v| complex.star(v)).map(|&t| complex.quality[t as usize]);
    let least = around.fold(complex.floor() - LACK, f64::min) - 1e-9;
    let ways: &[bool] = if work.keeps_vertices { &[true] } else { &[true, false] };
    for &flip in ways {
        let mark = complex.mark();
        let done = if flip {
            let possible = remove_edge(complex, wide, edge, WORSE, &mut change);
            if possible {
                change.apply(complex);
            }
            possible
        } else {
            split(complex, wide, edge, &mut change).is_some()
        };
        if done
            && work.work_since(complex, ground, mark, (TREATED, least))
            && complex.deficit() <= deficit
            && strays_since(complex, ground, mark) <= KEPT * before
        {
            complex.commit();
            return;
        }
        complex.rollback(mark);
    }
}
