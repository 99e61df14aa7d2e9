//! Takes the slivers out of a mesh.
//!
//! A centroidal Voronoi tessellation has near-regular tets and a few percent of slivers. Local operations that each raise the
//! worst of the tets they touch bring every dihedral angle over a floor, as in B. M. Klingner, J. R. Shewchuk, *Aggressive
//! tetrahedral mesh improvement*, Proceedings of the 16th International Meshing Roundtable, 2008,
//! doi 10.1007/978-3-540-75103-8_1:
//!
//! 1. Worst first (`floor.rs`): the best edge removal (`flips.rs`) or multi-face removal (`faces.rs`) around the tet, or else
//!    a move of its corners (`smooth.rs`).
//! 2. Polish (`polish.rs`): vertices move to where the sum of their tets' smallest angles and shapes is larger, the floor being a hard
//!    bound.
//! 3. Step 1 again, the boundary being held less tightly: the better average leaves fewer tets stuck.
//! 4. The boundary is brought closer to the surface where it strays most (`places.rs`, `follow.rs`).
//! 5. Creases that are noise let their vertices go where these keep a tet low (`bind.rs`). For the tets that are stuck below
//!    the floor that was asked for (`endgame.rs`; steps 1 to 4 aim a little higher): flips, contractions and splits of edges,
//!    of creases too, and splits of facets, each with its surroundings improved anew, kept if the sum of cubed deficits falls;
//!    then the count of vertices is made right elsewhere.
//! 6. A last polish, and step 4 again, where no tet loses by it; the places that stray most by far once more, with what step 5
//!    does for the tets there.
//! 7. If so asked, the boundary's vertices leave the surface a little so that the volume is the surface's (`volume.rs`).
//!
//! Where much is left to do, steps 1 and 5 are taken in parts of the mesh at the same time (`parts.rs`), and then in what lies between.
//! Strides are long at first and shorten from game to game: small ones everywhere would be a crawl of tets that hold each
//! other down. Where many tets are stuck in walls thinner than the spacing, the boundary may stray more and is not brought closer.
//!
//! Where vertices are known by their numbers, steps 4 to 6 have flips alone. Work on tets that do not rise ends
//! where it would outweigh the rest: it is counted in tets treated, the same everywhere.
//!
//! Departures: boundary edges are flipped and boundary vertices moved too, within a tight bound on the distance to the
//! surface (`ground.rs`); creases stay, and which part of the surface a facet stands for. No operation of theirs that changes the
//! count is used before step 4, and the count is made right after each.
//!
//! Cost: that of the slivers, plus a constant number of passes over all vertices.

use crate::params::{Boundary, Params};
use crate::progress::{Flow, Observer};
use crate::seeds::Seeds;
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::surface::walk::Walk;
use crate::tet_mesh::TetMesh;

mod around;

mod bind;

mod change;

mod complex;

mod endgame;

mod faces;

mod flips;

mod floor;

mod follow;

mod ground;

mod hopeless;

mod measure;

mod outcome;

mod parts;

mod patches;

mod places;

mod polish;

mod regions;

mod resize;

mod smooth;

mod stars;

mod volume;

use complex::Complex;
use endgame::{Budget, Game};
use floor::Worklist;
use ground::Ground;

/// Rounds of the polish before the endgame.
const POLISH_ROUNDS: usize = 2;

/// The endgames, with a polish after each. The first is for urgent tets alone: where they are, others lack little, which
/// the polish and the larger strides after it mend for less.
const GAMES: [Game; 6] = [
    Game { strays: 0.1, share: 0.15, followed: 4, only_urgent: true, haste: 0.2 },
    Game { strays: 0.1, share: 0.15, followed: 40, only_urgent: false, haste: 0.25 },
    Game { strays: 0.15, share: 0.075, followed: 40, only_urgent: false, haste: 0.1 },
    Game { strays: 0.2, share: 0.075, followed: 100, only_urgent: false, haste: 0.05 },
    Game { strays: 0.3, share: 0.075, followed: 100, only_urgent: false, haste: 0.03 },
    Game { strays: 0.3, share: 0.075, followed: 160, only_urgent: false, haste: 0.01 },
];

/// The haste before them; see [`Worklist::haste`]. The last tets need small steps, many need few.
const HASTE: f64 = 0.3;

/// Where more than this share of the tets is left the haste of the endgames is at most so much: longer strides would leave to splits
/// what these could do, and more vertices would be made than can be taken out elsewhere.
const CROWDED: f64 = 0.25;
const CROWDED_HASTE: f64 = 0.03;

/// Where more than this share of the tets is left after step 3, and more than so many, most are in walls thinner than the
/// spacing. Facets may then stray by so much from the first game on, as there they would in the last, and the boundary is
/// not brought closer: thousands of places stray, of which few can be helped. A smaller mesh has the time for all that.
const THIN: f64 = 0.02;
const THIN_LEAST: f64 = 2000.0;
const THIN_STRAYS: f64 = 0.3;

/// How far facets of the boundary may stray, as a share of their size, for the tets left after the polish.
const STRAYS: f64 = 0.1;

/// Outside the endgames no list is worked on after so many tets treated in all, over the mesh's: far more than are needed, but where
/// walls are thinner than the spacing.
const TREATED: usize = 12;

/// The floor is raised by so much, where that stays below the angle after it (degrees) and no more than this share of the
/// tets is below it at the start: the last percent of the tets ends at what is aimed at, and up to there it costs little.
const RAISED: f64 = 1.5;
const EASY: f64 = 36.5;
const FEW_BELOW: f64 = 0.08;

/// And by so much, so that rounding does not bring an angle below it (radians).
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
    let walk = Walk::new(surface);
    let face = patches::joined(walk, features, mesh.boundary.len());
    let ground = Ground::new(walk, features, &face).keeping(&seeds.whole);
    let mut complex = bind::load(mesh, seeds, &ground);
    let creases = bind::crease_edges(&complex, &ground);
    complex.set_creases(creases.into_iter());
    if params.boundary == Boundary::Conform {
        bind::settle(&mut complex, &ground, &mesh.kinds);
    }
    complex.set_floor(aim(&complex, params.min_dihedral).to_radians() + MARGIN);
    let mut work = Worklist::new(complex.tets.len() * TREATED);
    work.keeps_vertices = seeds.keep_places;
    work.haste = HASTE;
    work.follows = params.boundary == Boundary::Conform;
    let asked = params.min_dihedral.to_radians() + MARGIN;
    passes(&mut complex, &ground, &mut work, (mesh.points.len(), asked), observer);
    let kept = params.preserve_volume.then(|| volume::preserve(&mut complex, &ground));
    let improved = outcome::store(mesh, &complex, &ground, patch);
    match improved.check() {
        Ok(()) => {
            *mesh = improved;
            let reached = outcome::describe(&complex, &ground, params.min_dihedral);
            kept.map_or(reached.clone(), |k| format!("{reached}; {}", outcome::describe_volume(&k, &ground)))
        }
        // In the model's coordinates, far from their origin, a tet may be flat that is not in the frame.
        Err(broken) => format!("left as it was: {broken}"),
    }
}

/// What is aimed at where the floor is that asked for, in degrees.
fn aim(complex: &Complex, floor: f64) -> f64 {
    let raised = (floor + RAISED).min(EASY).max(floor);
    let below = complex.quality.iter().filter(|&&q| q < raised.to_radians()).count();
    if below as f64 <= FEW_BELOW * complex.quality.len() as f64 { raised } else { floor }
}

/// Steps 1 to 6, as far as the observer lets them go; `asked` is the floor of the parameters, which may be below that aimed at.
fn passes(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    (count, asked): (usize, f64),
    observer: &mut dyn Observer,
) {
    let mut goes_on = |complex: &Complex| observer.improving(complex.low().count()) == Flow::Continue;
    // 1.
    if !goes_on(complex) {
        return;
    }
    work.run(complex, ground, usize::MAX);
    // 2.
    for _ in 0..POLISH_ROUNDS {
        if !goes_on(complex) {
            return;
        }
        polish::run(complex, ground, 0);
    }
    // 3.
    work.forget();
    work.run(complex, &ground.loosened(&complex.facets, STRAYS), usize::MAX);
    // 4.
    let is_thin = complex.low().count() as f64 > (THIN * complex.tets.len() as f64).max(THIN_LEAST);
    if !is_thin {
        draw_closer(complex, ground, work, (count, follow::LACK));
    }
    bind::release(complex, ground);
    work.run(complex, &ground.loosened(&complex.facets, STRAYS), usize::MAX);
    // 5. What is aimed at beyond the floor that was asked for is not worth an endgame.
    complex.set_floor(asked);
    let mut budget = Budget::default();
    let mut bound = STRAYS;
    for (number, game) in GAMES.iter().enumerate() {
        let strays = if is_thin { game.strays.max(THIN_STRAYS) } else { game.strays };
        let loose = &ground.loosened(&complex.facets, strays);
        let is_crowded = complex.low().count() as f64 > CROWDED * complex.tets.len() as f64;
        let haste = if is_crowded { game.haste.min(CROWDED_HASTE) } else { game.haste };
        if strays > bound || haste < work.haste {
            work.forget();
        }
        (bound, work.haste) = (strays, haste);
        if !goes_on(complex) {
            return;
        }
        if number > 0 && complex.low().next().is_none() {
            break;
        }
        let (before, begun) = (complex.clone(), complex.commits());
        budget.extend((complex.tets.len() as f64 * game.share) as usize);
        endgame::run(complex, loose, work, (game, &mut budget));
        if !endgame::restore_count(complex, ground, work, count) {
            *complex = before;
            work.forget();
        }
        polish::run(complex, ground, begun);
        // Only where the endgame could not help is a corner let off: the mesh loses a detail of the surface there.
        bind::release(complex, ground);
        work.run(complex, loose, work.treated() + budget.urgent);
    }
    // 6.
    polish::run(complex, ground, 0);
    if !is_thin {
        draw_closer(complex, ground, work, (count, 0.0));
        let loose = &ground.loosened(&complex.facets, bound);
        let last = |complex: &mut Complex, work: &mut Worklist| {
            follow::run_last(complex, ground, work, (loose, &GAMES[1]));
        };
        closer(complex, ground, work, count, last);
    }
    goes_on(complex);
}

/// Brings the boundary closer to the surface; tets may lack `lack` more to the floor afterwards.
fn draw_closer(complex: &mut Complex, ground: &Ground, work: &mut Worklist, (count, lack): (usize, f64)) {
    closer(complex, ground, work, count, |complex, work| follow::run(complex, ground, work, lack));
}

/// Lets the boundary be brought closer to the surface without a change of the count.
fn closer(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    count: usize,
    draw: impl FnOnce(&mut Complex, &mut Worklist),
) {
    // Free seeds keep their distance from the surface.
    if !work.follows {
        return;
    }
    let before = complex.clone();
    draw(complex, work);
    if !endgame::restore_count(complex, ground, work, count) {
        *complex = before;
        work.forget();
    }
}
