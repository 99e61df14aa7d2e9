//! Divides a mesh into parts that are worked on at the same time.
//!
//! Planes cut the tets that there is work on into halves, quarters and so on (J. L. Bentley, *Multidimensional binary search trees
//! used for associative searching*, Communications of the ACM 18(9), 1975, doi 10.1145/361002.361007), each where the way between
//! two of them is widest. What lies between the same planes is a part, and put back in the order of the parts; their
//! number is that of the work alone. So the result is the same on any number of threads.

use glam::DVec3;
use rayon::prelude::*;

use super::complex::{Complex, NONE, Part};

/// At most 2 to the power of so many parts.
const DEEPEST: u32 = 6;

/// So many tets make a part that is more than its seam.
const TETS_EACH: usize = 4000;

/// What was done in the parts.
pub(super) struct Done<T> {
    pub of_parts: Vec<T>,
    /// The tets away from the seams that nothing helped.
    pub hopeless: Vec<u32>,
}

/// Does `work` in parts of the whole, each with about `each` of the tets `low` or more and so with a share of them; it says
/// what nothing helped of the part's tets. Nothing where there would be but one part.
pub(super) fn work<T: Send>(
    complex: &mut Complex,
    (low, each): (&[u32], usize),
    work: impl Fn(&mut Part, &Complex, f64) -> (T, Vec<u32>) + Sync,
) -> Option<Done<T>> {
    let parts = (low.len() / each).min(complex.tets.len() / TETS_EACH);
    let depth = parts.max(1).ilog2().min(DEEPEST);
    if depth == 0 || complex.is_part() {
        return None;
    }
    let planes = Planes::new(low.iter().map(|&t| center(complex, t)).collect(), depth);
    let divided = Divided::new(complex, &planes);
    let mut shares = vec![0.0; planes.parts()];
    low.iter().for_each(|&t| shares[divided.part[t as usize] as usize] += 1.0 / low.len() as f64);
    let whole = &*complex;
    let parts: Vec<(Part, T, Vec<u32>)> = (0..planes.parts())
        .into_par_iter()
        .with_max_len(1)
        .map(|number| {
            let mut part = whole.part(divided.tets(number as u32), &divided.seam);
            let (done, hopeless) = work(&mut part, whole, shares[number]);
            let hopeless = hopeless.into_iter().filter_map(|t| part.tet_within(whole, t)).collect();
            (part, done, hopeless)
        })
        .collect();
    let mut done = Done { of_parts: Vec::new(), hopeless: Vec::new() };
    for (part, of_part, hopeless) in parts {
        complex.put_back(&part);
        done.of_parts.push(of_part);
        done.hopeless.extend(hopeless);
    }
    Some(done)
}

/// The middle of a tet.
fn center(complex: &Complex, t: u32) -> DVec3 {
    let [a, b, c, d] = complex.corners(complex.tets[t as usize]);
    (a + b + c + d) * 0.25
}

/// Which part each tet is of, and which vertices belong to several.
struct Divided {
    /// [`NONE`] for empty slots.
    part: Vec<u32>,
    seam: Vec<bool>,
}

impl Divided {
    fn new(complex: &Complex, planes: &Planes) -> Divided {
        let part_of = |t: u32| if complex.is_alive(t) { planes.part_of(center(complex, t)) } else { NONE };
        let part: Vec<u32> = (0..complex.tets.len() as u32).into_par_iter().map(part_of).collect();
        let is_shared = |v: u32| complex.star(v).windows(2).any(|w| part[w[0] as usize] != part[w[1] as usize]);
        let seam = (0..complex.points.len() as u32).into_par_iter().map(is_shared).collect();
        Divided { part, seam }
    }

    /// The tets of a part, ascending.
    fn tets(&self, number: u32) -> Vec<u32> {
        (0..).zip(&self.part).filter(|p| *p.1 == number).map(|p| p.0).collect()
    }
}

/// Planes across the axes, each of which parts what those before it left: plane i is followed by planes 2 i + 1 and 2 i + 2.
struct Planes {
    planes: Vec<(usize, f64)>,
}

impl Planes {
    /// Planes that part some points, so many one after the other.
    fn new(mut points: Vec<DVec3>, depth: u32) -> Planes {
        let mut planes = Planes { planes: vec![(0, 0.0); (1 << depth) - 1] };
        planes.cut(&mut points, 0);
        planes
    }

    fn parts(&self) -> usize {
        self.planes.len() + 1
    }

    /// Sets a plane and those that follow it.
    fn cut(&mut self, points: &mut [DVec3], number: usize) {
        if number >= self.planes.len() {
            return;
        }
        let mut widest = (0, f64::NEG_INFINITY);
        for axis in 0..3 {
            points.sort_unstable_by(|p, q| p[axis].total_cmp(&q[axis]));
            let way = widest_way(points, axis).1;
            if way > widest.1 {
                widest = (axis, way);
            }
        }
        let axis = widest.0;
        points.sort_unstable_by(|p, q| p[axis].total_cmp(&q[axis]));
        let (first, _) = widest_way(points, axis);
        self.planes[number] = (axis, 0.5 * (points[first][axis] + points[first + 1][axis]));
        let (below, above) = points.split_at_mut(first + 1);
        self.cut(below, 2 * number + 1);
        self.cut(above, 2 * number + 2);
    }

    fn part_of(&self, p: DVec3) -> u32 {
        let mut number = 0;
        while let Some(&(axis, place)) = self.planes.get(number) {
            number = 2 * number + 1 + usize::from(p[axis] > place);
        }
        (number - self.planes.len()) as u32
    }
}

/// The point that the widest way along an axis follows, of those not far from the middle one in order, and how wide it is.
fn widest_way(points: &[DVec3], axis: usize) -> (usize, f64) {
    let near = points.len() * 2 / 5..points.len() * 3 / 5;
    let way = |i: usize| points[i + 1][axis] - points[i][axis];
    near.fold(
        (points.len() / 2 - 1, f64::NEG_INFINITY),
        |widest, i| {
            if way(i) > widest.1 { (i, way(i)) } else { widest }
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn planes_part_points_about_evenly() {
        let mut rng = Rng::new(4, 1);
        let points: Vec<DVec3> = (0..2000).map(|_| rng.in_cube() * DVec3::new(1.0, 3.0, 0.1)).collect();
        let planes = Planes::new(points.clone(), 3);
        let mut counts = vec![0; planes.parts()];
        points.iter().for_each(|&p| counts[planes.part_of(p) as usize] += 1);
        // Each plane leaves two fifths on either side, or more.
        assert_eq!(counts.len(), 8);
        assert!(counts.iter().all(|&c| (2000 * 8 / 125..=2000 * 27 / 125).contains(&c)), "{counts:?}");
    }

    #[test]
    fn a_plane_runs_where_the_way_is_widest() {
        let points = (0..100).map(|i| DVec3::new(f64::from(i), f64::from(i % 7), f64::from(i / 45) * 90.0)).collect();
        let planes = Planes::new(points, 1);
        assert_eq!(planes.planes, [(2, 45.0)]);
    }
}
