//! Changes of labels that are tried for the sake of topology: which ones first, what they come to with what they break mended, and
//! the way back from those that are not worth it.

use super::Repair;

impl Repair<'_> {
    /// What of each of `sets` may be toggled; the sets that go least against geometry first.
    pub fn by_obedience(&mut self, sets: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
        self.prefetch(&sets.concat());
        let mut ranked: Vec<(f64, Vec<u32>)> = Vec::new();
        for mut set in sets {
            set.retain(|&t| self.against(t).is_some());
            let sum: f64 = set.iter().filter_map(|&t| self.against(t)).sum();
            if !set.is_empty() {
                ranked.push((sum / set.len() as f64, set));
            }
        }
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
        ranked.dedup();
        ranked.into_iter().map(|(_, set)| set).collect()
    }

    /// Toggles `tets` and mends what that breaks around them. Where that makes more of what makes the mesh invalid, or as much
    /// with a boundary of the same Euler characteristic, all stays as it was. Whether it does not.
    pub fn attempt(&mut self, tets: &[u32]) -> bool {
        if self.is_island(tets) {
            return false;
        }
        let (mark, hard, euler) = (self.mark(), self.hard, self.twice_euler());
        self.toggle(tets);
        self.descend();
        let matters = self.hard < hard || (self.hard == hard && self.twice_euler() != euler);
        if !matters {
            self.undo(mark);
        }
        matters
    }

    /// How many toggles there have been, to go back to.
    pub fn mark(&self) -> usize {
        self.toggled.len()
    }

    /// Takes back all toggles since there were `mark` of them.
    pub fn undo(&mut self, mark: usize) {
        let mut undone = self.toggled.split_off(mark);
        undone.sort_unstable();
        let odd: Vec<u32> = undone.chunk_by(|a, b| a == b).filter(|same| same.len() % 2 == 1).map(|s| s[0]).collect();
        self.toggle(&odd);
        self.toggled.truncate(mark);
    }

    /// Goes back to `labels`.
    pub fn restore(&mut self, labels: &[bool]) {
        let changed: Vec<u32> =
            (0..labels.len() as u32).filter(|&t| labels[t as usize] != self.inside[t as usize]).collect();
        self.toggle(&changed);
    }
}
