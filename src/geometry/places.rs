//! Places, and whether any of them is near another: a grid of cubes that grows with them.

use std::collections::HashMap;

use glam::DVec3;

/// Places by the cube that holds them, each with what there is to say of it.
pub struct Places<T = ()> {
    cell: f64,
    cubes: HashMap<[i64; 3], Vec<(DVec3, T)>>,
}

impl Places {
    /// Adds a place.
    pub fn insert(&mut self, p: DVec3) {
        self.insert_with(p, ());
    }
}

impl<T> Places<T> {
    /// None yet; `cell` is about the distance that will be asked for.
    pub fn new(cell: f64) -> Places<T> {
        Places { cell: cell.max(1e-9), cubes: HashMap::new() }
    }

    /// Adds a place, with what there is to say of it.
    pub fn insert_with(&mut self, p: DVec3, what: T) {
        self.cubes.entry(self.cube(p)).or_default().push((p, what));
    }

    /// Whether any is within `distance` of `p`.
    pub fn any_within(&self, p: DVec3, distance: f64) -> bool {
        self.any_within_that(p, distance, |_| true)
    }

    /// Whether any of which `counts` says so is within `distance` of `p`.
    pub fn any_within_that(&self, p: DVec3, distance: f64, counts: impl Fn(&T) -> bool) -> bool {
        let (low, high) = (self.cube(p - distance), self.cube(p + distance));
        let near = |(q, what): &(DVec3, T)| q.distance(p) <= distance && counts(what);
        let cubes: f64 = (0..3).map(|k| (high[k] - low[k] + 1) as f64).product();
        if cubes > self.cubes.len() as f64 {
            return self.cubes.values().flatten().any(near);
        }
        (low[0]..=high[0]).any(|x| {
            (low[1]..=high[1])
                .any(|y| (low[2]..=high[2]).any(|z| self.cubes.get(&[x, y, z]).is_some_and(|c| c.iter().any(near))))
        })
    }

    fn cube(&self, p: DVec3) -> [i64; 3] {
        (p / self.cell).floor().to_array().map(|x| x as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn near_places_are_found_at_every_distance() {
        let mut rng = Rng::new(3, 3);
        let all: Vec<DVec3> = (0..300).map(|_| rng.in_cube()).collect();
        let mut places = Places::new(0.1);
        all.iter().for_each(|&p| places.insert(p));
        let mut found = 0;
        for _ in 0..200 {
            let (p, distance) = (rng.in_cube(), 0.3 * rng.unit());
            let near = all.iter().any(|q| q.distance(p) <= distance);
            assert_eq!(places.any_within(p, distance), near);
            found += usize::from(near);
        }
        assert!(found > 20 && found < 180, "{found}");
    }
}
