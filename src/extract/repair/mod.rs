//! Labels under repair: what is wrong at each vertex, as a number that every accepted step lowers.

use rayon::prelude::*;

use super::complex::{Complex, FanBuffers};
use crate::disjoint_sets::DisjointSets;
use crate::seeds::SeedKind;

mod trials;

/// What geometry has to say about a tet.
pub struct Judge<'a> {
    /// How deep within the solid it lies; negative outside.
    pub depth: &'a (dyn Fn(u32) -> f64 + Sync),
    /// Whether it is too flat to keep.
    pub flat: &'a (dyn Fn(u32) -> bool + Sync),
    /// A label may be set against the sign of a tet's depth where that is no more than this.
    pub reach: f64,
}

/// Penalty of each further piece of a vertex's star.
const PIECE: u32 = 4;
/// Penalty of a seed in no tet.
const UNUSED: u32 = 3;
/// Penalty of a seed on the surface that is off the boundary, or the other way round.
const MISPLACED: u32 = 1;

/// Depths below this share of the reach say nothing on their own.
const NOISE: f64 = 0.05;

/// Tets that a search for the nearest tet inside may visit.
const SEARCH: usize = 64;

/// Vertices that one thread looks at in a row, at least.
const BLOCK: usize = 2048;

/// Labels, and what is wrong with them.
pub struct Repair<'a> {
    complex: &'a Complex<'a>,
    kinds: &'a [SeedKind],
    judge: Judge<'a>,
    inside: Vec<bool>,
    // For each seed what is wrong at it, and the sum.
    penalty: Vec<u32>,
    hard: u64,
    soft: u64,
    // Whether each seed is on the boundary; how many are, and the facets of the boundary.
    bounds: Vec<bool>,
    vertices: i64,
    facets: i64,
    // Every tet that was toggled, in order.
    toggled: Vec<u32>,
    // Vertices with a penalty whose stars have changed since they were last looked at.
    pending: Vec<u32>,
    // Depths asked for so far, otherwise NaN.
    depths: Vec<f64>,
    // Whether there are seeds on the surface at all.
    conforming: bool,
    buffers: FanBuffers,
    touched: Vec<u32>,
}

impl<'a> Repair<'a> {
    /// Looks at all vertices under the labels `inside`.
    pub fn new(complex: &'a Complex<'a>, kinds: &'a [SeedKind], judge: Judge<'a>, inside: Vec<bool>) -> Repair<'a> {
        let conforming = kinds.iter().any(|&k| k != SeedKind::Interior);
        let depths = vec![f64::NAN; inside.len()];
        let buffers = complex.fan_buffers();
        let mut repair = Repair {
            complex,
            kinds,
            judge,
            inside,
            penalty: vec![0; complex.seeds],
            hard: 0,
            soft: 0,
            bounds: vec![false; complex.seeds],
            vertices: 0,
            facets: 0,
            toggled: Vec::new(),
            pending: Vec::new(),
            depths,
            conforming,
            buffers,
            touched: Vec::new(),
        };
        let buffers = || complex.fan_buffers();
        let state = |buffers: &mut FanBuffers, v: u32| repair.state_with(v, buffers);
        let seeds = 0..complex.seeds as u32;
        let states: Vec<(u32, bool)> = seeds.into_par_iter().with_min_len(BLOCK).map_init(buffers, state).collect();
        (0..).zip(states).for_each(|(v, state)| repair.set_state(v, state));
        let tets = (0..repair.inside.len() as u32).filter(|&t| repair.inside[t as usize]);
        repair.facets = tets.map(|t| complex.exposed(&repair.inside, t) as i64).sum();
        repair
    }

    /// The labels.
    pub fn inside(&self) -> &[bool] {
        &self.inside
    }

    /// The labels, taken out.
    pub fn into_labels(self) -> Vec<bool> {
        self.inside
    }

    /// The sum of the penalties that a mesh must not have: 0 = a manifold in which every seed is in use.
    pub fn hard(&self) -> u64 {
        self.hard
    }

    /// Number of misplaced seeds.
    pub fn soft(&self) -> u64 {
        self.soft
    }

    /// Whether there are seeds on the surface at all.
    pub fn is_conforming(&self) -> bool {
        self.conforming
    }

    /// Twice the Euler characteristic of the boundary, where it is a manifold: each facet has three edges, each edge two
    /// facets.
    pub fn twice_euler(&self) -> i64 {
        2 * self.vertices - self.facets
    }

    fn total(&self) -> u64 {
        self.hard + self.soft
    }

    /// Looks at vertex `v` again.
    fn renew(&mut self, v: u32) {
        let new = self.state_of(v);
        self.set_state(v, new);
    }

    fn set_state(&mut self, v: u32, (new, bounds): (u32, bool)) {
        let bounded = std::mem::replace(&mut self.bounds[v as usize], bounds);
        self.vertices += i64::from(bounds) - i64::from(bounded);
        let old = std::mem::replace(&mut self.penalty[v as usize], new);
        let (soft_old, soft_new) = (old % PIECE == MISPLACED, new % PIECE == MISPLACED);
        self.soft = self.soft + u64::from(soft_new) - u64::from(soft_old);
        self.hard = self.hard + u64::from(new - u32::from(soft_new)) - u64::from(old - u32::from(soft_old));
        if new > 0 {
            self.pending.push(v);
        }
    }

    /// The vertices at which the boundary is no manifold, and the seeds in no tet; with misplaced seeds if so asked;
    /// ascending.
    pub fn wrong(&self, misplaced: bool) -> Vec<u32> {
        let least = if misplaced { MISPLACED } else { MISPLACED + 1 };
        (0..self.penalty.len() as u32).filter(|&v| self.penalty[v as usize] >= least).collect()
    }

    /// The penalty of vertex `v`, and whether it is on the boundary.
    fn state_of(&mut self, v: u32) -> (u32, bool) {
        let mut buffers = std::mem::take(&mut self.buffers);
        let state = self.state_with(v, &mut buffers);
        self.buffers = buffers;
        state
    }

    fn state_with(&self, v: u32, buffers: &mut FanBuffers) -> (u32, bool) {
        let fans = self.complex.fans(&self.inside, v, buffers);
        let pieces = fans.inside.saturating_sub(1) + fans.outside.saturating_sub(1);
        let misplaced = self.conforming && fans.on_boundary() == (self.kinds[v as usize] == SeedKind::Interior);
        let penalty = match self.complex.is_unused(v, fans) {
            true => UNUSED,
            false => PIECE * pieces + if misplaced { MISPLACED } else { 0 },
        };
        (penalty, fans.on_boundary())
    }

    /// How deep tet `t` lies.
    fn depth(&mut self, t: u32) -> f64 {
        if self.depths[t as usize].is_nan() {
            self.depths[t as usize] = (self.judge.depth)(t);
        }
        self.depths[t as usize]
    }

    /// Asks for the depths of `tets`, in parallel.
    fn prefetch(&mut self, tets: &[u32]) {
        let missing: Vec<u32> = tets.iter().copied().filter(|&t| self.depths[t as usize].is_nan()).collect();
        let depths: Vec<f64> = missing.par_iter().map(|&t| (self.judge.depth)(t)).collect();
        for (t, depth) in missing.into_iter().zip(depths) {
            self.depths[t as usize] = depth;
        }
    }

    /// How much toggling `tets` goes against geometry, negative where it obeys it; none where that is out of the
    /// question.
    fn cost(&mut self, tets: &[u32]) -> Option<f64> {
        if self.is_island(tets) {
            return None;
        }
        tets.iter().map(|&t| self.against(t)).sum()
    }

    /// The same for tet `t` alone.
    fn against(&mut self, t: u32) -> Option<f64> {
        if !self.complex.usable(t) || (!self.inside[t as usize] && (self.judge.flat)(t)) {
            return None;
        }
        let against = if self.inside[t as usize] { self.depth(t) } else { -self.depth(t) };
        (against <= self.judge.reach).then_some(against)
    }

    /// Whether `tets` would be alone with their new label: a component of the boundary out of nothing, which no vertex
    /// needs to notice.
    fn is_island(&self, tets: &[u32]) -> bool {
        tets.iter().all(|&t| {
            let label = self.inside[t as usize];
            self.complex.around(t).iter().all(|n| self.inside[*n as usize] == label || tets.contains(n))
        })
    }

    fn flip(&mut self, tets: &[u32]) {
        for &t in tets {
            self.inside[t as usize] ^= true;
        }
    }

    /// The seeds of `tets`, ascending, into `touched`.
    fn touch(&mut self, tets: &[u32]) {
        self.touched.clear();
        let seeds = self.complex.seeds as u32;
        self.touched.extend(tets.iter().flat_map(|&t| self.complex.tets[t as usize]).filter(|&v| v < seeds));
        self.touched.sort_unstable();
        self.touched.dedup();
    }

    /// What toggling `tets` would add to the total.
    fn change(&mut self, tets: &[u32]) -> i64 {
        self.touch(tets);
        let touched = std::mem::take(&mut self.touched);
        self.flip(tets);
        let change = touched.iter().map(|&v| i64::from(self.state_of(v).0) - i64::from(self.penalty[v as usize])).sum();
        self.flip(tets);
        self.touched = touched;
        change
    }

    /// Toggles `tets`.
    pub fn toggle(&mut self, tets: &[u32]) {
        for &t in tets {
            self.facets += 4 - 2 * self.complex.exposed(&self.inside, t) as i64;
            self.inside[t as usize] ^= true;
        }
        self.toggled.extend(tets);
        self.touch(tets);
        let touched = std::mem::take(&mut self.touched);
        for &v in &touched {
            self.renew(v);
        }
        self.touched = touched;
    }

    /// Usable tets in the stars of `vertices` whose labels contradict their depths, ascending; flat ones count as
    /// outside.
    pub fn contradictions(&mut self, vertices: &[u32]) -> Vec<u32> {
        let complex = self.complex;
        let mut tets: Vec<u32> = vertices.iter().flat_map(|&v| complex.star(v)).copied().collect();
        tets.sort_unstable();
        tets.dedup();
        tets.retain(|&t| complex.usable(t));
        self.prefetch(&tets);
        tets.retain(|&t| (self.depths[t as usize] > 0.0 && !(self.judge.flat)(t)) != self.inside[t as usize]);
        tets
    }

    /// Lets geometry decide around the [`Repair::wrong`] vertices, in every cluster that gains by it.
    ///
    /// Tets that share no vertex do not affect each other's penalties: each cluster of toggled tets is accepted or
    /// refused on its own.
    pub fn relabel(&mut self, misplaced: bool, rounds: usize) {
        for _ in 0..rounds {
            let wrong = self.wrong(misplaced);
            let tets = self.contradictions(&wrong);
            let before = self.total();
            for cluster in self.clusters(&tets) {
                if self.change(&cluster) < 0 && !self.is_island(&cluster) {
                    self.toggle(&cluster);
                }
            }
            if self.total() == before {
                return;
            }
        }
    }

    /// Groups `tets`: those that share a vertex share a cluster.
    pub fn clusters(&self, tets: &[u32]) -> Vec<Vec<u32>> {
        let mut corners: Vec<(u32, u32)> =
            tets.iter().enumerate().flat_map(|(i, &t)| self.complex.tets[t as usize].map(|v| (v, i as u32))).collect();
        corners.sort_unstable();
        let mut sets = DisjointSets::new(tets.len());
        for pair in corners.windows(2).filter(|p| p[0].0 == p[1].0) {
            sets.join(pair[0].1, pair[1].1);
        }
        sets.group(tets)
    }

    /// Takes the best step at each vertex where something is wrong and whose star has changed since it was last looked
    /// at, again and again, while any step lowers the total.
    pub fn descend(&mut self) {
        while !self.pending.is_empty() {
            let mut vertices = std::mem::take(&mut self.pending);
            vertices.sort_unstable();
            vertices.dedup();
            for v in vertices {
                while self.penalty[v as usize] > 0 && self.step(v) {}
            }
        }
    }

    /// Takes the step at `v` that obeys geometry best among those that lower the total.
    fn step(&mut self, v: u32) -> bool {
        if self.penalty[v as usize] == MISPLACED {
            let moves = self.gentle_moves(v);
            return self.best(&moves, 0);
        }
        let moves = self.moves(v);
        if self.best(&moves, 0) {
            return true;
        }
        let pairs = self.pairs(v);
        // A step that only obeys geometry better may open the way; those come to an end too.
        self.best(&pairs, 0) || self.best(&moves, 1)
    }

    /// Sets of tets whose toggling may put a misplaced seed right: all tets outside at a seed of the interior, or one of
    /// the tets between a seed of the surface and the boundary.
    fn gentle_moves(&self, v: u32) -> Vec<Vec<u32>> {
        const MOST: usize = 4;
        let star = self.complex.star(v);
        if self.kinds[v as usize] == SeedKind::Interior {
            let outside: Vec<u32> = star.iter().copied().filter(|&t| !self.inside[t as usize]).collect();
            return if outside.len() <= MOST { vec![outside] } else { Vec::new() };
        }
        let exposed = star.iter().filter(|&&t| self.complex.exposed(&self.inside, t) > 0);
        exposed.map(|&t| vec![t]).collect()
    }

    /// Takes the one of `moves` that obeys geometry best among those that change the total by less than `bound`; one
    /// that does not lower it must obey geometry better than the labels do.
    fn best(&mut self, moves: &[Vec<u32>], bound: i64) -> bool {
        let mut best: Option<(f64, usize)> = None;
        for (i, tets) in moves.iter().enumerate() {
            let change = self.change(tets);
            if change >= bound {
                continue;
            }
            if let Some(cost) = self.cost(tets)
                && (change < 0 || cost < -NOISE * self.judge.reach)
                && best.is_none_or(|(least, _)| cost < least)
            {
                best = Some((cost, i));
            }
        }
        if let Some((_, i)) = best {
            self.toggle(&moves[i]);
        }
        best.is_some()
    }

    /// Sets of tets at `v` worth toggling: single ones, pieces of the star, pieces of the rings of irregular edges, and
    /// ways from an unused seed to the nearest tet inside.
    fn moves(&mut self, v: u32) -> Vec<Vec<u32>> {
        let complex = self.complex;
        let star = complex.star(v);
        let mut moves: Vec<Vec<u32>> = star.iter().map(|&t| vec![t]).collect();
        let pieces = self.pieces(star, v);
        if pieces.len() > 2 {
            moves.extend(self.bridges(v, &pieces));
            moves.extend(pieces);
        } else if pieces.len() == 1 && !self.inside[star[0] as usize] {
            moves.extend(star.iter().filter_map(|&t| self.way(t)));
        }
        // The tets around each edge vw, by w.
        let mut spokes: Vec<(u32, u32)> = star
            .iter()
            .flat_map(|&t| complex.tets[t as usize].map(|w| (w, t)))
            .filter(|&(w, _)| w != v && (w as usize) < complex.points.len())
            .collect();
        spokes.sort_unstable();
        for ring in spokes.chunk_by(|a, b| a.0 == b.0) {
            let ring: Vec<u32> = ring.iter().map(|&(_, t)| t).collect();
            let pieces = self.pieces(&ring, v);
            if pieces.len() > 2 {
                moves.extend(pieces);
            }
        }
        moves.sort_unstable();
        moves.dedup();
        moves
    }

    /// The shortest ways within the star of `v` from each of its pieces to another one of the same label.
    fn bridges(&self, v: u32, pieces: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let complex = self.complex;
        let piece_of = |t: u32| {
            pieces.iter().position(|p| p.contains(&t)).expect("a star is made of its pieces: this is a bug in tetcvt")
        };
        let mut bridges = Vec::new();
        for (home, piece) in pieces.iter().enumerate() {
            let label = self.inside[piece[0] as usize];
            // Tets reached, each with the position of the one it was reached from.
            let mut reached: Vec<(u32, usize)> = piece.iter().map(|&t| (t, usize::MAX)).collect();
            let mut next = 0;
            'search: while next < reached.len() {
                let (t, _) = reached[next];
                for k in (0..4).filter(|&k| complex.tets[t as usize][k] != v) {
                    let n = complex.neighbors[t as usize][k].tet();
                    if reached.iter().any(|&(r, _)| r == n) {
                        continue;
                    }
                    if self.inside[n as usize] != label {
                        reached.push((n, next));
                    } else if piece_of(n) != home {
                        let mut way = Vec::new();
                        let mut at = next;
                        while reached[at].1 != usize::MAX {
                            way.push(reached[at].0);
                            at = reached[at].1;
                        }
                        way.sort_unstable();
                        bridges.push(way);
                        break 'search;
                    }
                }
                next += 1;
            }
        }
        bridges
    }

    /// The pieces of equal label of `tets`, all around `v`.
    fn pieces(&mut self, tets: &[u32], v: u32) -> Vec<Vec<u32>> {
        self.complex.pieces(tets, v, &self.inside, &mut self.buffers).group(tets)
    }

    /// Pairs of tets of equal label that share a facet, one of them at `v`.
    fn pairs(&self, v: u32) -> Vec<Vec<u32>> {
        let mut pairs: Vec<Vec<u32>> = Vec::new();
        for &t in self.complex.star(v) {
            for n in self.complex.around(t) {
                if self.inside[t as usize] == self.inside[n as usize] {
                    pairs.push(vec![t.min(n), t.max(n)]);
                }
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    /// The shortest way through usable tets from tet `start`, outside, to one beside a tet inside.
    fn way(&self, start: u32) -> Option<Vec<u32>> {
        if !self.complex.usable(start) {
            return None;
        }
        // Tets reached, each with the position of the one it was reached from.
        let mut reached = vec![(start, 0usize)];
        let mut next = 0;
        while next < reached.len() && reached.len() < SEARCH {
            let (t, _) = reached[next];
            let neighbors = self.complex.around(t);
            if neighbors.iter().any(|&n| self.inside[n as usize]) {
                let mut way = vec![t];
                let mut at = next;
                while at != 0 {
                    at = reached[at].1;
                    way.push(reached[at].0);
                }
                way.sort_unstable();
                return (way.len() > 1).then_some(way);
            }
            for n in neighbors {
                if self.complex.usable(n) && !reached.iter().any(|&(r, _)| r == n) {
                    reached.push((n, next));
                }
            }
            next += 1;
        }
        None
    }

    /// Takes tets off the boundary that `thin` says are nothing but a fold of it, flat ones first of all; never at the
    /// price of a penalty.
    pub fn peel(&mut self, thin: &dyn Fn(u32, &[bool]) -> bool) {
        let mut queue: Vec<u32> = (0..self.inside.len() as u32)
            .filter(|&t| self.inside[t as usize] && self.complex.exposed(&self.inside, t) > 0)
            .collect();
        // Taking a tet off brings others to the boundary; each tet goes at most once.
        let mut next = 0;
        while next < queue.len() {
            let t = queue[next];
            next += 1;
            let peelable = self.inside[t as usize] && ((self.judge.flat)(t) || thin(t, &self.inside));
            if peelable && self.change(&[t]) <= 0 {
                self.toggle(&[t]);
                queue.extend(self.complex.around(t).into_iter().filter(|&n| self.inside[n as usize]));
            }
        }
    }

    /// Toggles each of `tets` that lies clearly on the other side of the surface than its label says, where that does no
    /// harm at its vertices.
    pub fn straighten(&mut self, tets: &[u32]) {
        self.prefetch(tets);
        for &t in tets {
            let depth = self.depth(t);
            let contradicts = if self.inside[t as usize] { depth < 0.0 } else { depth > 0.0 && !(self.judge.flat)(t) };
            if contradicts && depth.abs() > NOISE * self.judge.reach && !self.is_island(&[t]) && self.change(&[t]) <= 0
            {
                self.toggle(&[t]);
            }
        }
    }
}
