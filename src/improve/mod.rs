//! Takes the slivers out of a mesh.
//!
//! A centroidal Voronoi tessellation has near-regular tets and a few percent of slivers. Local operations that each raise the
//! worst of the tets they touch bring every dihedral angle over a floor, as in B. M. Klingner, J. R. Shewchuk, *Aggressive
//! tetrahedral mesh improvement*, Proceedings of the 16th International Meshing Roundtable, 2008,
//! doi 10.1007/978-3-540-75103-8_1:
//!
//! 1. Worst first (`floor.rs`): the best edge removal (`flips.rs`) or multi-face removal (`faces.rs`) around the tet, or else
//!    a move of its corners (`smooth.rs`).
//! 2. Polish: vertices move to where the sum of their tets' smallest angles is larger, the floor being a hard bound.
//! 3. Steps 1 and 2 again: the better average leaves fewer tets stuck.
//! 4. The boundary is brought closer to the surface where it strays most (`follow.rs`).
//! 5. For the few tets that are stuck (`endgame.rs`): splits and contractions of edges, each with its surroundings improved
//!    anew, kept if the sum of cubed deficits falls; then the count of vertices is made right elsewhere.
//!
//! Where vertices are known by their numbers, steps 4 and 5 have flips alone.
//!
//! Departures: boundary edges are flipped and boundary vertices moved too, within a tight bound on the distance to the
//! surface (`ground.rs`); creases stay, and which part of the surface a facet stands for. No operation of theirs that changes the
//! count is used before step 4, and the count is made right after it.
//!
//! Cost: that of the slivers, plus a constant number of passes over all vertices.

use crate::params::{Boundary, Params};
use crate::progress::{Flow, Observer};
use crate::seeds::Seeds;
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::tet_mesh::TetMesh;

mod bind;

mod change;

mod complex;

mod endgame;

mod faces;

mod flips;

mod floor;

mod follow;

mod ground;

mod measure;

mod outcome;

mod regions;

mod resize;

mod smooth;

mod stars;

use complex::Complex;
use floor::Worklist;
use ground::Ground;

/// Rounds of the polish before the endgame.
const POLISH_ROUNDS: usize = 2;

/// Tets that the endgame tries at most: a share of all, and not fewer than these.
const ENDGAME_SHARE: f64 = 0.004;
const ENDGAME_LEAST: usize = 200;

/// Times that the endgame is played, with a polish between.
const ENDGAMES: usize = 4;

/// Tets treated in all, over the mesh's: far more than are needed, but where walls are thinner than the spacing.
const TREATED: usize = 4;

/// The floor is raised by so much, so that rounding does not bring an angle below it (radians).
const MARGIN: f64 = 1e-6;

/// Raises the dihedral angles of `mesh`, made from `seeds`, to the floor of the parameters where that is possible; says
/// what became of it. `patch` has the patch of each of the surface's triangles.
///
/// The number of vertices stays, the boundary's topology, creases, and every invariant of the mesh; its smallest dihedral
/// angle does not fall. The observer may stop the work between its passes.
pub fn improve(
    mesh: &mut TetMesh,
    seeds: &Seeds,
    (surface, features, patch): (&Surface, &Features, &[u32]),
    params: &Params,
    observer: &mut dyn Observer,
) -> String {
    let ground = Ground::new(surface, features).keeping(&seeds.whole);
    let mut complex = bind::load(mesh, seeds, &ground);
    let creases = bind::crease_edges(&complex, &ground);
    complex.set_creases(creases.into_iter());
    if params.boundary == Boundary::Conform {
        bind::settle(&mut complex, &ground, &mesh.kinds);
    }
    complex.set_floor(params.min_dihedral.to_radians() + MARGIN);
    let mut work = Worklist::new(complex.tets.len() * TREATED);
    work.keeps_vertices = seeds.keep_places;
    passes(&mut complex, &ground, &mut work, mesh.points.len(), observer);
    let improved = outcome::store(mesh, &complex, &ground, patch);
    match improved.check() {
        Ok(()) => {
            *mesh = improved;
            outcome::describe(&complex, &ground, params.min_dihedral)
        }
        // In the model's coordinates, far from their origin, a tet may be flat that is not in the frame.
        Err(broken) => format!("left as it was: {broken}"),
    }
}

/// Steps 1 to 5, as far as the observer lets them go.
fn passes(complex: &mut Complex, ground: &Ground, work: &mut Worklist, count: usize, observer: &mut dyn Observer) {
    let mut goes_on = |complex: &Complex| observer.improving(endgame::left(complex).len()) == Flow::Continue;
    // 1.
    if !goes_on(complex) {
        return;
    }
    work.run(complex, ground);
    // 2.
    for _ in 0..POLISH_ROUNDS {
        if !goes_on(complex) {
            return;
        }
        work.polish(complex, ground);
    }
    // 3.
    let loose = &ground.loosened(&complex.facets);
    work.run(complex, loose);
    // 4.
    let before = complex.clone();
    follow::run(complex, ground, work);
    if !endgame::restore_count(complex, ground, work, count) {
        *complex = before;
    }
    // 5.
    let most = ((complex.tets.len() as f64 * ENDGAME_SHARE) as usize).max(ENDGAME_LEAST);
    for game in 0..ENDGAMES {
        if !goes_on(complex) {
            return;
        }
        if game > 0 && endgame::left(complex).is_empty() {
            break;
        }
        let before = complex.clone();
        endgame::run(complex, loose, work, most);
        if !endgame::restore_count(complex, ground, work, count) {
            *complex = before;
        }
        work.polish(complex, ground);
        // Only where the endgame could not help is a corner let off: the mesh loses a detail of the surface there.
        bind::release(complex, ground);
        work.run(complex, loose);
    }
    goes_on(complex);
}
