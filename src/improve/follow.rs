//! Brings the boundary closer to the surface where one strays most from the other: along ridges and folds that an edge runs
//! across, at tips that a facet cuts off.
//!
//! 1. Places: the middles of the boundary's edges and facets that are far from the surface, and the surface's vertices that are far
//!    from the boundary; the farthest first.
//! 2. A flip of an edge there, a vertex of the surface drawn to the place, or a new vertex there; the tets around are
//!    improved anew.
//! 3. Kept if the boundary there is closer to the surface by far, both ways, and no tet fell far below the floor. A vertex at a
//!    tip then stays where it is, unless a tet cannot do with it.
//!
//! The count of vertices is made right afterwards.

use glam::DVec3;

use super::change::Change;
use super::complex::{Complex, Facet, Freedom, Mark};
use super::endgame::{self, Budget, Game, WORSE};
use super::flips::remove_edge;
use super::floor::{Aim, Worklist};
use super::ground::Ground;
use super::places::{self, Place, edge_stray, edges_of};
use super::resize::{split, split_at};
use crate::geometry::frame::snap;
use crate::geometry::triangle;

/// Places that stray by less than this share of the surface's diagonal are well.
const CLOSE: f64 = 2.0e-3;

/// The share of its distance that a place may keep.
const KEPT: f64 = 0.75;

/// At most this share of the vertices is added: a coarse mesh is coarse everywhere.
const MOST: f64 = 0.005;

/// What a tet may lack to the floor for the endgame to mend (radians).
pub(super) const LACK: f64 = 0.035;

/// Tets treated after a flip or split before it is judged.
const TREATED: usize = 32;

/// Work ends when so many tets were treated, over the mesh's and beside: the farthest places come first, and in thin walls there
/// are thousands, of which few can be helped.
const TREATED_SHARE: f64 = 0.05;
const TREATED_LEAST: usize = 2000;

/// In the end so many places that stray by more than this share of the diagonal are tried once more, and so many tets treated
/// for each.
const LAST_PLACES: usize = 12;
const FAR: f64 = 2.4e-3;
const TREATED_LAST: usize = 400;
/// The share of its distance that a place may keep then.
const KEPT_LAST: f64 = 0.9;
/// What a tet may lack to the floor then before the endgame, tried in turn (radians).
const LACKS_LAST: [f64; 2] = [LACK, 0.2];

/// Rounds of looking for places: what mends one may leave another beside it.
const ROUNDS: usize = 3;

/// What a change at a place must come to.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    /// Places closer than this are well.
    close: f64,
    /// What tets may lack more to the floor.
    lack: f64,
    /// The share of its distance that the place may keep.
    kept: f64,
}

/// What is tried at a place.
#[derive(Clone, Copy, Debug)]
enum Way {
    Flip,
    Split,
    /// The vertex to the tip.
    Draw(u32),
    /// A new vertex there.
    SplitAtTip,
}

/// Works off the places that stray most; where tets are at the floor they may lack `lack` to it afterwards.
pub(super) fn run(complex: &mut Complex, ground: &Ground, work: &mut Worklist, lack: f64) {
    let close = CLOSE * ground.surface.diagonal();
    let most = complex.vertex_count() + (MOST * complex.vertex_count() as f64) as usize;
    let last = work.treated() + TREATED_LEAST + (TREATED_SHARE * complex.tets.len() as f64) as usize;
    let mut since = 0;
    for _ in 0..ROUNDS {
        let places = places::find(complex, ground, (close, since));
        since = complex.commits();
        let mut gained = false;
        for place in places {
            if complex.vertex_count() >= most || work.treated() > last {
                return;
            }
            gained |= draw_in(complex, ground, work, (place, Bounds { close, lack, kept: KEPT }));
        }
        if !gained {
            return;
        }
    }
}

/// Works off the few places that stray most by far, where nothing else went: one at a time, the tets that lack something to
/// the floor afterwards being left to the endgame; none of it is kept unless that brings them back.
pub(super) fn run_last(complex: &mut Complex, ground: &Ground, work: &mut Worklist, (loose, game): (&Ground, &Game)) {
    let close = CLOSE * ground.surface.diagonal();
    let far = FAR * ground.surface.diagonal();
    let places = places::find(complex, ground, (close, 0));
    let mut before = complex.clone();
    for place in places.into_iter().take_while(|p| p.distance > far).take(LAST_PLACES) {
        let deficit = complex.deficit() * (1.0 + 1e-9) + 1e-15;
        for (kept, lack) in [KEPT, KEPT_LAST].into_iter().flat_map(|k| LACKS_LAST.map(|l| (k, l))) {
            if !draw_in(complex, ground, work, (place, Bounds { close, lack, kept })) {
                continue;
            }
            endgame::run(complex, loose, work, (game, &mut Budget::even(TREATED_LAST)));
            // What the endgame did may stray itself.
            let worst = || places::find(complex, ground, (close, before.commits())).first().map_or(0.0, |p| p.distance);
            if complex.deficit() <= deficit && worst() <= kept * place.distance {
                before = complex.clone();
                break;
            }
            *complex = before.clone();
            work.forget();
        }
    }
}

/// The most that an edge and its facets stray.
fn strays_around(complex: &Complex, ground: &Ground, edge: [u32; 2]) -> f64 {
    let facets = complex.edge_facets(edge);
    facets.iter().map(|&f| complex.facets[f as usize].stray.distance).fold(edge_stray(complex, ground, edge), f64::max)
}

/// The most that facets changed since `mark` and their edges stray.
fn strays_since(complex: &Complex, ground: &Ground, mark: Mark) -> f64 {
    let mut most = 0.0_f64;
    for f in complex.facets_since(mark) {
        let Facet { vertices, stray, .. } = complex.facets[f as usize];
        most = edges_of(vertices)
            .into_iter()
            .map(|e| edge_stray(complex, ground, e))
            .fold(most.max(stray.distance), f64::max);
    }
    most
}

/// The vertices of the surface around an edge, as far as the edges at its ends reach.
fn samples_around(complex: &Complex, ground: &Ground, edge: [u32; 2]) -> Vec<DVec3> {
    let [a, b] = complex.corners(edge);
    let middle = (a + b) * 0.5;
    let facets = complex.edge_facets(edge);
    let corners = facets.iter().flat_map(|&f| complex.corners(complex.facets[f as usize].vertices));
    let reach = DVec3::splat(corners.map(|p| p.distance(middle)).fold(0.0, f64::max));
    let mut near: Vec<u32> = Vec::new();
    ground.surface.tree().near_box(middle - reach, middle + reach, |t| {
        near.extend(ground.surface.triangles()[t as usize]);
    });
    near.sort_unstable();
    near.dedup();
    let points = near.into_iter().map(|v| ground.surface.points()[v as usize]);
    points.filter(|p| p.distance(middle) <= reach.x).collect()
}

/// The most that any of `samples` is away from the boundary two facets around `vertices`.
fn farthest(complex: &Complex, samples: &[DVec3], vertices: &[u32]) -> f64 {
    let ring = |vertices: &[u32]| {
        let mut around: Vec<u32> = vertices.iter().flat_map(|&v| complex.facets_of(v)).copied().collect();
        around.sort_unstable();
        around.dedup();
        around
    };
    let vertices: Vec<u32> = ring(vertices).iter().flat_map(|&f| complex.facets[f as usize].vertices).collect();
    let facets: Vec<[DVec3; 3]> =
        ring(&vertices).iter().map(|&f| complex.corners(complex.facets[f as usize].vertices)).collect();
    let away2 = |&p: &DVec3| {
        facets.iter().map(|&f| triangle::closest_point(f, p).distance_squared(p)).fold(f64::INFINITY, f64::min)
    };
    samples.iter().map(away2).fold(0.0, f64::max).sqrt()
}

/// Steps 2 and 3 at a place; whether that went.
fn draw_in(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    (place, Bounds { close, lack, kept }): (Place, Bounds),
) -> bool {
    let edge = place.edge;
    // What was done elsewhere may have changed this place.
    if complex.is_crease(edge[0], edge[1]) || complex.edge_facets(edge).len() != 2 {
        return false;
    }
    let mut around: Vec<u32> =
        complex.edge_facets(edge).iter().flat_map(|&f| complex.facets[f as usize].vertices).collect();
    let samples = samples_around(complex, ground, edge);
    let before = match place.tip {
        Some((p, _)) => farthest(complex, &[p], &around),
        None => strays_around(complex, ground, edge),
    };
    if before <= close {
        return false;
    }
    let before = farthest(complex, &samples, &around).max(before);
    // Facets beside a ridge may stray more than they did, if the ridge comes closer.
    let wide = &ground.within(kept * before);
    let qualities = edge.iter().flat_map(|&v| complex.star(v)).map(|&t| complex.quality[t as usize]);
    let least = qualities.fold(complex.floor() - lack, f64::min) - 1e-9;
    let known = around.len();
    let aim = Aim { treated: TREATED, least, deficit: complex.deficit() * (1.0 + 1e-9) + lack * lack * lack + 1e-15 };
    for way in ways(complex, place, work.keeps_vertices) {
        let mark = complex.mark();
        around.truncate(known);
        let made = make(complex, wide, (place, way));
        around.extend(made);
        if made.is_some()
            && work.work_since(complex, ground, mark, aim)
            && strays_since(complex, ground, mark) <= kept * before
            && farthest(complex, &samples, &around) <= kept * before
        {
            complex.commit();
            return true;
        }
        complex.rollback(mark);
    }
    false
}

/// What may help at a place, the cheapest first.
fn ways(complex: &Complex, place: Place, keeps_vertices: bool) -> Vec<Way> {
    let mut ways = vec![Way::Flip];
    if let (Some((p, _)), false) = (place.tip, keeps_vertices) {
        let mut near: Vec<u32> =
            complex.edge_facets(place.edge).iter().flat_map(|&f| complex.facets[f as usize].vertices).collect();
        near.retain(|&v| matches!(complex.freedom[v as usize], Freedom::Surface(_) | Freedom::Held(_)));
        let away = |v: u32| complex.points[v as usize].distance_squared(p);
        near.sort_by(|&v, &w| away(v).total_cmp(&away(w)).then(v.cmp(&w)));
        near.dedup();
        ways.extend(near.into_iter().take(2).map(Way::Draw));
    }
    if !keeps_vertices {
        ways.extend(place.tip.map(|_| Way::SplitAtTip));
        ways.push(Way::Split);
    }
    ways
}

/// Goes one way; a vertex there, if that is possible.
fn make(complex: &mut Complex, ground: &Ground, (place, way): (Place, Way)) -> Option<u32> {
    let mut change = Change::default();
    match way {
        Way::Flip => {
            let possible = remove_edge(complex, ground, place.edge, WORSE, &mut change);
            possible.then(|| change.apply(complex)).map(|()| place.edge[0])
        }
        Way::Split => split(complex, ground, place.edge, &mut change),
        Way::SplitAtTip => {
            let (p, triangle) = place.tip?;
            split_at(complex, ground, place.edge, (snap(p), Freedom::Held(triangle)), &mut change)
        }
        Way::Draw(v) => {
            let (p, triangle) = place.tip?;
            let face = ground.face[triangle as usize];
            let facets: Vec<u32> = complex.facets_of(v).to_vec();
            let to = snap(p);
            let mut strays = Vec::with_capacity(facets.len());
            for &f in &facets {
                let old = complex.facets[f as usize];
                let moved = old.vertices.map(|u| if u == v { to } else { complex.points[u as usize] });
                let turned = {
                    let [a, b, c] = complex.corners(old.vertices);
                    let [x, y, z] = moved;
                    let (before, after) = (triangle::normal2(a, b, c), triangle::normal2(x, y, z));
                    after.dot(before) <= 0.5 * after.length() * before.length()
                };
                let stray = ground.stray_near(moved, old.stray.triangle);
                if old.face != face || turned || !ground.allows(moved, stray, old.stray.distance) {
                    return None;
                }
                strays.push(stray);
            }
            complex.move_vertex(v, to, Freedom::Held(triangle));
            facets.iter().zip(strays).for_each(|(&f, stray)| complex.set_stray(f, stray));
            let worst = complex.star(v).iter().map(|&t| complex.quality[t as usize]).fold(f64::INFINITY, f64::min);
            (worst > WORSE).then_some(v)
        }
    }
}
