//! Removal of triangles without area from a closed, oriented surface, without opening it and without moving a vertex.
//!
//! A triangle abc without area has its middle corner b on the edge ac. The neighbour across ac gets b as a corner of
//! its own:
//!
//! ```text
//!        d                  d
//!       / \                /|\
//!      /   \      -->     / | \
//!     a-----c            a--b--c
//!      `-b-'
//! ```
//!
//! The surface stays where it was. Where a triangle beside abc lies on the new one (its apex is d as well), the two
//! cancel. Along a line of many such triangles the neighbour may itself be without area; it is then taken first if
//! its longest edge is another one, which ends because that edge is longer. Triangles that are exactly flat get
//! shorter by every change, others must get higher, so that the whole ends too.

use std::collections::BTreeMap;

use glam::DVec3;

use super::defects::{Defect, Flaw, Marks};
use super::soup::{Soup, note_count};
use crate::geometry::bounding_box::BoundingBox;
use crate::geometry::predicates::collinear;

/// Triangles lower than this are without area: 4 grid units of the frame, which rounding to the grid can do to one.
const HEIGHT: f64 = 4.0 / (1u64 << 52) as f64;

/// Removes triangles without area from an oriented, closed, manifold soup. Returns whether anything changed.
pub(super) fn remove(soup: &mut Soup, notes: &mut Vec<String>, marks: &mut Marks) -> Result<bool, Defect> {
    let needles: Vec<u32> = (0..soup.triangles.len() as u32).filter(|&t| is_needle(soup.corners(t as usize))).collect();
    if needles.is_empty() {
        return Ok(false);
    }
    let mut repair = Repair::new(soup);
    // Each is tried again as long as others go: one may stand in another's way.
    let mut pending = needles.clone();
    let mut budget = 1000 + 100 * needles.len();
    loop {
        let mut next = vec![];
        let mut progress = false;
        for t in pending {
            match repair.remove(t, &mut budget) {
                Step::Done(mut more) => {
                    progress = true;
                    next.append(&mut more);
                }
                Step::Stuck => next.push(t),
                Step::Gone => progress = true,
            }
        }
        pending = next;
        if pending.is_empty() || !progress {
            break;
        }
    }
    let alive = repair.alive;
    let stuck: Vec<u32> =
        pending.into_iter().filter(|&t| alive[t as usize] && is_flat(soup.corners(t as usize))).collect();
    if let Some(&t) = stuck.iter().min() {
        stuck.iter().for_each(|&t| soup.mark_triangle(marks, Flaw::Degenerate, t));
        return Err(Defect::Degenerate { count: stuck.len(), place: soup.corner_place(t, 0) });
    }
    let left = (0..alive.len()).filter(|&t| alive[t] && is_needle(soup.corners(t))).count();
    let gone = needles.len().saturating_sub(left);
    soup.retain(&alive);
    soup.drop_unused();
    note_count(
        notes,
        gone,
        "degenerate triangle (no area) was removed; the surface stays where it was",
        "degenerate triangles (no area) were removed; the surface stays where it was",
    );
    note_count(
        notes,
        left,
        "triangle is flat to 2^-50 of the model's size and was kept",
        "triangles are flat to 2^-50 of the model's size and were kept",
    );
    Ok(true)
}

/// Longest spike that may go, over the diagonal.
const SPIKE: f64 = 1e-4;

/// The soup without the spikes of its flat triangles: such a triangle abc, b between a and c, with bc short, folds the
/// surface along bc, or widens it by a hair; c becomes b. `None` where there is nothing of the kind.
pub(super) fn without_spikes(mut soup: Soup, notes: &mut Vec<String>) -> Option<Soup> {
    let longest = SPIKE * BoundingBox::of(&soup.points).diagonal();
    let mut becomes: Vec<u32> = (0..soup.points.len() as u32).collect();
    let mut touched = vec![false; soup.points.len()];
    let (mut moved, mut farthest) = (0, 0.0f64);
    for t in 0..soup.triangles.len() {
        let triangle = soup.triangles[t];
        if !is_needle(soup.corners(t)) {
            continue;
        }
        let length = |i: usize| {
            let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(|v| soup.points[v as usize]);
            a.distance(b)
        };
        let by_length = |i: &usize, j: &usize| length(*i).total_cmp(&length(*j));
        let (short, long) = ((0..3).min_by(by_length)?, (0..3).max_by(by_length)?);
        let middle = triangle[(long + 2) % 3];
        let tip = [triangle[short], triangle[(short + 1) % 3]].into_iter().find(|&v| v != middle)?;
        // Each vertex takes part once.
        if length(short) <= longest && !touched[middle as usize] && !touched[tip as usize] {
            (touched[middle as usize], touched[tip as usize]) = (true, true);
            becomes[tip as usize] = middle;
            moved += 1;
            farthest = farthest.max(length(short));
        }
    }
    if moved == 0 {
        return None;
    }
    for v in soup.triangles.as_flattened_mut() {
        *v = becomes[*v as usize];
    }
    let keep: Vec<bool> = soup.triangles.iter().map(|&[a, b, c]| a != b && b != c && c != a).collect();
    soup.retain(&keep);
    soup.drop_unused();
    let share = farthest / longest * SPIKE;
    note_count(
        notes,
        moved,
        &format!("spike of a degenerate triangle was cut off, at most {share:.1e} of the diagonal long"),
        &format!("spikes of degenerate triangles were cut off, at most {share:.1e} of the diagonal long"),
    );
    Some(soup)
}

/// The least height, squared.
fn height2([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    (b - a).cross(c - a).length_squared() / longest
}

fn is_needle(corners: [DVec3; 3]) -> bool {
    height2(corners) <= HEIGHT * HEIGHT
}

fn is_flat([a, b, c]: [DVec3; 3]) -> bool {
    collinear(a, b, c)
}

/// What came of one triangle.
enum Step {
    /// Changed; these may now be without area.
    Done(Vec<u32>),
    /// It cannot be changed now.
    Stuck,
    /// It is not there, or not without area, any more.
    Gone,
}

/// The soup while it changes.
struct Repair<'a> {
    soup: &'a mut Soup,
    alive: Vec<bool>,
    /// The triangle that runs along an edge in this direction.
    along: BTreeMap<[u32; 2], u32>,
}

impl<'a> Repair<'a> {
    fn new(soup: &'a mut Soup) -> Repair<'a> {
        let alive = vec![true; soup.triangles.len()];
        let mut repair = Repair { soup, alive, along: BTreeMap::new() };
        (0..repair.alive.len() as u32).for_each(|t| repair.link(t));
        repair
    }

    fn link(&mut self, t: u32) {
        let [a, b, c] = self.soup.triangles[t as usize];
        for edge in [[a, b], [b, c], [c, a]] {
            self.along.insert(edge, t);
        }
    }

    fn unlink(&mut self, t: u32) {
        let [a, b, c] = self.soup.triangles[t as usize];
        for edge in [[a, b], [b, c], [c, a]] {
            self.along.remove(&edge);
        }
    }

    /// The corners of `t`, the longest edge from the third to the first.
    fn longest_last(&self, t: u32) -> [u32; 3] {
        let [a, b, c] = self.soup.triangles[t as usize];
        let length2 = |u: u32, v: u32| self.soup.points[u as usize].distance_squared(self.soup.points[v as usize]);
        let turns = [[a, b, c], [b, c, a], [c, a, b]];
        turns
            .into_iter()
            .reduce(|x, y| if length2(y[2], y[0]) > length2(x[2], x[0]) { y } else { x })
            .unwrap_or(turns[0])
    }

    fn apex(&self, edge: [u32; 2]) -> u32 {
        let triangle = self.soup.triangles[self.along[&edge] as usize];
        triangle.into_iter().find(|v| !edge.contains(v)).expect("corners are distinct: this is a bug in tetcvt")
    }

    fn corners_of(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.soup.points[v as usize])
    }

    /// Takes away triangle `t`, or one that must go before it.
    fn remove(&mut self, mut t: u32, budget: &mut usize) -> Step {
        if !self.alive[t as usize] || !is_needle(self.soup.corners(t as usize)) {
            return Step::Gone;
        }
        let first = t;
        loop {
            if *budget == 0 {
                return Step::Stuck;
            }
            *budget -= 1;
            let [a, b, c] = self.longest_last(t);
            let n = self.along[&[a, c]];
            let d = self.apex([a, c]);
            let last = self.longest_last(n);
            if is_needle(self.soup.corners(n as usize)) && [last[2], last[0]] != [a, c] {
                t = n;
                continue;
            }
            return match self.split(t, [a, b, c], n, d) {
                Some(mut more) => {
                    more.extend([first, t]);
                    more.sort_unstable();
                    more.dedup();
                    Step::Done(more)
                }
                None => Step::Stuck,
            };
        }
    }

    /// Gives b to the neighbour `n` = (a, c, d) of `t` = (a, b, c), and cancels what then lies on each other.
    fn split(&mut self, t: u32, [a, b, c]: [u32; 3], n: u32, d: u32) -> Option<Vec<u32>> {
        let beside = [self.along[&[b, a]], self.along[&[c, b]]];
        let covers = [self.apex([b, a]) == d, self.apex([c, b]) == d];
        let (left, right) = ([a, b, d], [b, c, d]);
        let kept: Vec<[u32; 3]> = match covers {
            // A closed tet without volume: its shell encloses nothing, which is said later.
            [true, true] => return None,
            [true, false] => vec![right],
            [false, true] => vec![left],
            [false, false] => {
                let taken = self.along.contains_key(&[b, d]) || self.along.contains_key(&[d, b]);
                let old = height2(self.soup.corners(t as usize)).min(height2(self.soup.corners(n as usize)));
                let new = height2(self.corners_of(left)).min(height2(self.corners_of(right)));
                if taken || (new <= old && !is_flat(self.soup.corners(t as usize))) {
                    return None;
                }
                vec![left, right]
            }
        };
        // What lay on n comes from n; slot t takes the second triangle, if there is one.
        let gone: Vec<u32> = [t, n].into_iter().chain((0..2).filter(|&i| covers[i]).map(|i| beside[i])).collect();
        for &g in &gone {
            self.unlink(g);
            self.alive[g as usize] = false;
        }
        let slots = [n, t];
        for (&slot, &triangle) in slots.iter().zip(&kept) {
            self.soup.triangles[slot as usize] = triangle;
            self.soup.source[slot as usize] = self.soup.source[n as usize];
            self.soup.patch[slot as usize] = self.soup.patch[n as usize];
            self.alive[slot as usize] = true;
            self.link(slot);
        }
        Some(slots[..kept.len()].to_vec())
    }
}
