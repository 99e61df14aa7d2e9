//! Disjoint sets of small integers.
//!
//! R. E. Tarjan, *Efficiency of a good but not linear set union algorithm*, Journal of the ACM 22(2), 1975,
//! doi 10.1145/321879.321884. Departures: paths are halved (Tarjan, van Leeuwen 1984) and the least member is the root,
//! whatever the sets' sizes, so that roots depend on the sets alone.

/// A partition of 0..n that grows coarser; the least member stands for its set.
#[derive(Clone, Debug, Default)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// The partition of 0..n into single members.
    pub fn new(n: usize) -> DisjointSets {
        let mut sets = DisjointSets::default();
        sets.reset(n);
        sets
    }

    /// Starts again with n single members.
    pub fn reset(&mut self, n: usize) {
        self.parent.clear();
        self.parent.extend(0..n as u32);
    }

    /// The least member of the set that holds `i`.
    pub fn find(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let up = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = up;
            i = up;
        }
        i
    }

    /// Joins the sets that hold `i` and `j`.
    pub fn join(&mut self, i: u32, j: u32) {
        let (a, b) = (self.find(i), self.find(j));
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// For each member the number of its set, sets being numbered by their least members; and how many there are.
    pub fn number(&mut self) -> (Vec<u32>, usize) {
        let mut numbers = vec![0; self.parent.len()];
        let mut count = 0;
        for i in 0..self.parent.len() {
            let root = self.find(i as u32) as usize;
            if root == i {
                numbers[i] = count;
                count += 1;
            } else {
                numbers[i] = numbers[root];
            }
        }
        (numbers, count as usize)
    }

    /// Sorts items, one for each element, by their sets, which come in the order of [`DisjointSets::number`].
    pub fn group<T: Copy>(&mut self, items: &[T]) -> Vec<Vec<T>> {
        let (numbers, count) = self.number();
        let mut groups = vec![Vec::new(); count];
        for (&item, number) in items.iter().zip(numbers) {
            groups[number as usize].push(item);
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_are_numbered_by_their_least_members() {
        let mut sets = DisjointSets::new(6);
        sets.join(5, 1);
        sets.join(4, 3);
        sets.join(3, 5);
        assert_eq!(sets.number(), (vec![0, 1, 2, 1, 1, 1], 3));
        assert_eq!(sets.group(&['a', 'b', 'c', 'd', 'e', 'f']), [vec!['a'], vec!['b', 'd', 'e', 'f'], vec!['c']]);
        assert_eq!(sets.find(4), 1);
        sets.reset(2);
        assert_eq!(sets.number(), (vec![0, 1], 2));
    }
}
