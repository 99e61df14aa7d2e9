//! The last tets below the floor, by flips, contractions and splits of edges and splits of facets; and the count of
//! vertices, made right again.

use std::collections::HashMap;

use super::change::Change;
use super::complex::{Complex, NONE, Part};
use super::flips::remove_edge;
use super::floor::{Aim, Worklist};
use super::ground::Ground;
use super::hopeless::Hopeless;
use super::parts;
use super::resize::{contract, split, split_facet};
use crate::geometry::tetrahedron::EDGES;

/// Tets treated after an operation for the sake of the count before it is judged.
const TREATED: usize = 16;

/// The quality that a contraction for the sake of the count may leave for these to mend (radians).
const LEAST: f64 = 0.3;

/// What a contraction may add to the deficit, as a share of that of a flat tet: more is hardly ever made good.
const ADDED: f64 = 0.8;

/// The quality that a flip, split or contraction may leave for the operations after it to mend (radians).
pub(super) const WORSE: f64 = 0.05;

/// So many tets that are left are worth a part of the mesh of their own.
const LEFT_EACH: usize = 64;

/// One of the endgames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Game {
    /// How far facets of the boundary may stray, as a share of their size.
    pub strays: f64,
    /// Tets treated at most, over the mesh's, beside what the games before left over; urgent ones [`URGENT_SHARE`] times as many.
    pub share: f64,
    /// Tets treated after an operation before it is judged.
    pub followed: usize,
    /// Whether tets that are not urgent are left to later games.
    pub only_urgent: bool,
    /// See [`Worklist::haste`].
    pub haste: f64,
}

/// Tets are urgent below this share of the floor.
const URGENT: f64 = 6.0 / 7.0;

/// For urgent tets so many times more may be treated.
const URGENT_SHARE: usize = 4;

/// How many tets may still be treated: while the tet at hand is urgent, and for others, from whom urgent ones take nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Budget {
    pub urgent: usize,
    pub usual: usize,
}

impl Budget {
    /// The same for urgent tets and for others.
    pub(super) fn even(treated: usize) -> Budget {
        Budget { urgent: treated, usual: treated }
    }

    /// Allows so many more for usual tets, and a multiple of that for urgent ones.
    pub(super) fn extend(&mut self, usual: usize) {
        self.usual += usual;
        self.urgent += URGENT_SHARE * usual;
    }

    /// A share of it.
    fn share(&self, share: f64) -> Budget {
        let of = |treated: usize| (share * treated as f64) as usize;
        Budget { urgent: of(self.urgent), usual: of(self.usual) }
    }
}

/// Tries flips, contractions and splits around the tets that are left, until none helps or as many tets were treated as the budget
/// allows: first in parts of the mesh, then in what lies between them.
pub(super) fn run(complex: &mut Complex, ground: &Ground, work: &mut Worklist, (game, budget): (&Game, &mut Budget)) {
    let hopeless = run_parts(complex, ground, work, (game, budget));
    run_whole(complex, ground, work, (game, budget), hopeless);
}

/// The game in parts of the mesh; the tets between which nothing helped.
fn run_parts(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    (game, budget): (&Game, &mut Budget),
) -> Hopeless {
    let low: Vec<u32> = complex.low().collect();
    let whole = *budget;
    let listed = &*work;
    let play = |Part { complex, .. }: &mut Part, _: &Complex, share: f64| {
        let (mut work, mut budget) = (listed.of_part(usize::MAX), whole.share(share));
        let hopeless = run_whole(complex, ground, &mut work, (game, &mut budget), Hopeless::default());
        ((work.treated(), budget), complex.low().filter(|&t| hopeless.has(complex, t)).collect())
    };
    let mut hopeless = Hopeless::default();
    let Some(done) = parts::work(complex, (&low, LEFT_EACH), play) else { return hopeless };
    done.hopeless.into_iter().for_each(|t| hopeless.add(complex, t));
    *budget = Budget::default();
    for (treated, left) in done.of_parts {
        work.add_treated(treated);
        budget.urgent += left.urgent;
        budget.usual += left.usual;
    }
    hopeless
}

/// The game in a mesh or a part of one, but for tets that are known to be hopeless; those that turned out to be, too.
fn run_whole(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    (game, budget): (&Game, &mut Budget),
    mut hopeless: Hopeless,
) -> Hopeless {
    let mut vain = Vain::new();
    loop {
        let mut gained = false;
        for t in left(complex) {
            let is_low = complex.is_alive(t) && complex.quality[t as usize] < complex.floor();
            if !is_low || hopeless.has(complex, t) {
                continue;
            }
            let is_urgent = complex.quality[t as usize] < URGENT * complex.floor();
            if game.only_urgent && !is_urgent {
                continue;
            }
            let allowed = if is_urgent { &mut budget.urgent } else { &mut budget.usual };
            if *allowed == 0 {
                continue;
            }
            let before = work.treated();
            if resolve(complex, ground, work, (t, game), &mut vain) {
                gained = true;
            } else {
                hopeless.add(complex, t);
            }
            *allowed = allowed.saturating_sub(work.treated() - before);
        }
        if !gained {
            return hopeless;
        }
    }
}

/// The tets below the floor, worst first.
pub(super) fn left(complex: &Complex) -> Vec<u32> {
    let mut left: Vec<u32> = complex.low().collect();
    left.sort_by(|&t, &u| complex.quality[t as usize].total_cmp(&complex.quality[u as usize]).then(t.cmp(&u)));
    left
}

/// Tries an operation on each of a tet's edges, in the end splits of its facets if all its vertices are on the boundary; keeps the first
/// that helps. Whether one did.
fn resolve(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    (t, game): (u32, &Game),
    vain: &mut Vain,
) -> bool {
    let mut change = Change::default();
    let tet = complex.tets[t as usize];
    let operations: &[Operation] = if work.keeps_vertices {
        &[Operation::Flip]
    } else {
        &[Operation::Flip, Operation::Contraction, Operation::Split]
    };
    for &operation in operations {
        for [i, j] in EDGES {
            for ends in [[tet[i], tet[j]], [tet[j], tet[i]]] {
                let tried = vain.get(&(operation, ends)).copied();
                if tried.is_some_and(|since| !ends.iter().any(|&v| complex.changed_at(v, since))) {
                    continue;
                }
                let make = |complex: &mut Complex| operation.make(complex, ground, ends, &mut change);
                if attempt(complex, ground, work, (&ends, game), make) {
                    return true;
                }
                vain.insert((operation, ends), complex.commits());
            }
        }
    }
    !work.keeps_vertices
        && tet.iter().all(|&v| complex.on_boundary(v))
        && (0..4).any(|i| {
            let facet = complex.facet_of(t, i);
            let make = |complex: &mut Complex| split_facet(complex, (t, facet), &mut change);
            attempt(complex, ground, work, (&tet, game), make)
        })
}

/// Makes a change around some vertices and improves what it touched; takes it back unless that helped. Whether it did.
fn attempt(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    (around, game): (&[u32], &Game),
    make: impl FnOnce(&mut Complex) -> bool,
) -> bool {
    // None may be worse than the worst there was.
    let star = around.iter().flat_map(|&v| complex.star(v));
    let least = star.map(|&t| complex.quality[t as usize]).fold(f64::INFINITY, f64::min) - 1e-9;
    let deficit = complex.deficit() * (1.0 - 1e-9) - 1e-12;
    let mark = complex.mark();
    let helped =
        make(complex) && work.work_since(complex, ground, mark, Aim { treated: game.followed, least, deficit });
    if helped {
        complex.commit();
    } else {
        complex.rollback(mark);
    }
    helped
}

/// What is tried on an edge, though it may gain nothing by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Operation {
    Flip,
    Contraction,
    Split,
}

impl Operation {
    /// Makes it on an edge; whether that was possible.
    fn make(self, complex: &mut Complex, ground: &Ground, ends: [u32; 2], change: &mut Change) -> bool {
        match self {
            Operation::Contraction => {
                let most = complex.deficit() + ADDED * complex.deficit_of(0.0);
                contract(complex, ground, ends, WORSE, change) && complex.deficit() < most
            }
            _ if ends[0] > ends[1] => false,
            Operation::Flip => {
                let possible = remove_edge(complex, ground, ends, WORSE, change);
                if possible {
                    change.apply(complex);
                }
                possible
            }
            Operation::Split => split(complex, ground, ends, change).is_some(),
        }
    }
}

/// Operations on edges that did not help, which neighbouring tets share, each with the commit then.
type Vain = HashMap<(Operation, [u32; 2]), u32>;

/// Where edges that may be split or contracted begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    Inside,
    /// On the boundary, where they end too.
    Boundary,
}

impl Origin {
    /// How many edges are tried for each vertex too many or too few: most of the boundary's hold on to creases and bends.
    fn edges_tried(self) -> usize {
        match self {
            Origin::Inside => 400,
            Origin::Boundary => 8000,
        }
    }
}

/// More than there are tets around nearly any edge.
const TETS_AROUND: usize = 10;

/// Splits or contracts edges until there are `count` vertices, without taking any tet below the floor, or below what
/// there is: edges from inside and, where these do not suffice as in thin solids, those between vertices of the boundary. Whether
/// that went.
pub(super) fn restore_count(complex: &mut Complex, ground: &Ground, work: &mut Worklist, count: usize) -> bool {
    while complex.vertex_count() != count {
        let origins = [Origin::Inside, Origin::Boundary];
        if !origins.into_iter().any(|origin| approach_count(complex, ground, work, (count, origin))) {
            return false;
        }
    }
    true
}

/// Splits or contracts some of the edges of one origin, as long as there are too few or too many vertices; whether one was.
fn approach_count(
    complex: &mut Complex,
    ground: &Ground,
    work: &mut Worklist,
    (count, origin): (usize, Origin),
) -> bool {
    let mut change = Change::default();
    let before = complex.vertex_count();
    let shrink = before > count;
    for [a, b] in edges_from(complex, origin, shrink, origin.edges_tried() * before.abs_diff(count)) {
        if complex.vertex_count() == count {
            break;
        }
        if complex.star(a).is_empty() || complex.star(b).is_empty() || !complex.has_edge(a, b) {
            continue;
        }
        let mark = complex.mark();
        // Nothing may fall below the floor; what is below it already may stay there.
        let aim = Aim { treated: TREATED, least: 0.0, deficit: complex.deficit() * (1.0 + 1e-9) + 1e-15 };
        let done = if shrink {
            contract(complex, ground, [a, b], LEAST, &mut change)
        } else {
            split(complex, ground, [a, b], &mut change).is_some()
        };
        if done && work.work_since(complex, ground, mark, aim) {
            complex.commit();
        } else {
            complex.rollback(mark);
        }
    }
    complex.vertex_count() != before
}

/// The first of the edges of one origin: the shortest first, or the longest.
fn edges_from(
    complex: &Complex,
    origin: Origin,
    shortest: bool,
    count: usize,
) -> impl Iterator<Item = [u32; 2]> + use<> {
    // Each is there once for every tet around it.
    let mut first = First::new(TETS_AROUND * count);
    let sign = if shortest { 1.0 } else { -1.0 };
    for tet in complex.tets.iter().filter(|t| t[0] != NONE) {
        let bound = tet.map(|v| complex.on_boundary(v));
        let points = tet.map(|v| complex.points[v as usize]);
        for [i, j] in EDGES {
            let length2 = sign * points[i].distance_squared(points[j]);
            for [i, j] in [[i, j], [j, i]] {
                let fits = match origin {
                    Origin::Inside => !bound[i] && (bound[j] || tet[i] < tet[j]),
                    Origin::Boundary => bound[i] && bound[j],
                };
                if fits {
                    first.add((length2, [tet[i], tet[j]]));
                }
            }
        }
    }
    let mut last = None;
    first.sorted().map(|e| e.1).filter(move |&edge| last.replace(edge) != Some(edge)).take(count)
}

/// Edges, each with a number that they are ordered by.
type Ordered = (f64, [u32; 2]);

/// So many are put in order at a time: mostly few are needed.
const SORTED_AT_ONCE: usize = 2048;

/// The first so many of a stream of them.
struct First {
    kept: Vec<Ordered>,
    count: usize,
    /// What comes after this is not among the first.
    bound: f64,
}

impl First {
    fn new(count: usize) -> First {
        First { kept: Vec::new(), count: count.max(1), bound: f64::INFINITY }
    }

    fn order(x: &Ordered, y: &Ordered) -> std::cmp::Ordering {
        x.0.total_cmp(&y.0).then(x.1.cmp(&y.1))
    }

    #[inline]
    fn add(&mut self, item: Ordered) {
        if item.0 > self.bound {
            return;
        }
        self.kept.push(item);
        if self.kept.len() == 2 * self.count {
            let (_, last, _) = self.kept.select_nth_unstable_by(self.count - 1, First::order);
            self.bound = last.0;
            self.kept.truncate(self.count);
        }
    }

    /// They in their order, sorted as far as they are asked for.
    fn sorted(self) -> impl Iterator<Item = Ordered> {
        let First { mut kept, count, .. } = self;
        let mut sorted = 0;
        (0..count.min(kept.len())).map(move |i| {
            if i == sorted {
                let rest = &mut kept[i..];
                let some = rest.len().min(SORTED_AT_ONCE);
                if some < rest.len() {
                    rest.select_nth_unstable_by(some, First::order);
                }
                rest[..some].sort_unstable_by(First::order);
                sorted += some;
            }
            kept[i]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::complex::tests::{edges_both_ways, on_grid, shake};
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn contractions_that_add_too_much_to_the_deficit_are_none() {
        on_grid(|mut complex, ground| {
            shake(&mut complex, 0.05);
            complex.set_floor(0.9);
            let (mut change, before) = (Change::default(), complex.deficit());
            let most = before + ADDED * complex.deficit_of(0.0);
            let (mut made, mut possible) = (0, 0);
            for edge in edges_both_ways(&complex) {
                let mark = complex.mark();
                if Operation::Contraction.make(&mut complex, ground, edge, &mut change) {
                    made += 1;
                    assert!(complex.deficit() < most, "{edge:?} adds {}", complex.deficit() - before);
                }
                complex.rollback(mark);
                possible += usize::from(contract(&mut complex, ground, edge, WORSE, &mut change));
                complex.rollback(mark);
            }
            assert!(made > 20 && possible > made + 20, "{made} of {possible} were made");
        });
    }

    #[test]
    fn the_first_of_a_stream_are_those_of_its_sorted_list() {
        let mut rng = Rng::new(2, 0);
        for (count, total) in [(1, 1), (3, 2), (5, 1000), (40, 79), (40, 80), (40, 81), (7, 0)] {
            let mut below = |n: f64| (rng.unit() * n).floor();
            let all: Vec<Ordered> = (0..total).map(|_| (below(20.0), [below(9.0) as u32, below(9.0) as u32])).collect();
            let mut first = First::new(count);
            all.iter().for_each(|&item| first.add(item));
            let mut expected = all;
            expected.sort_by(First::order);
            expected.truncate(count);
            assert_eq!(first.sorted().collect::<Vec<Ordered>>(), expected);
        }
    }
}
