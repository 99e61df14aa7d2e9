//! Items by a number that each has.

/// Items in the order of their numbers, those with the same in the order in which they came.
#[derive(Default)]
pub(super) struct Groups<T> {
    /// Where those of each number begin.
    first: Vec<u32>,
    items: Vec<T>,
}

impl<T: Copy + Default> Groups<T> {
    /// Puts the items of all `lists`, each with its number below `count`, in the place of what was there.
    pub(super) fn set<I>(&mut self, count: usize, lists: impl DoubleEndedIterator<Item = I> + Clone)
    where
        I: DoubleEndedIterator<Item = (u32, T)> + ExactSizeIterator + Clone,
    {
        self.first.clear();
        self.first.resize(count + 1, 0);
        let mut len = 0;
        for list in lists.clone() {
            len += list.len();
            list.for_each(|(n, _)| self.first[n as usize] += 1);
        }
        // Where they end: filling from the back turns that into where they begin.
        let mut end = 0;
        for first in &mut self.first {
            end += *first;
            *first = end;
        }
        self.items.resize(len, T::default());
        for (n, item) in lists.rev().flat_map(|list| list.rev()) {
            let place = &mut self.first[n as usize];
            *place -= 1;
            self.items[*place as usize] = item;
        }
    }

    /// How many numbers there are; `None` before the first items.
    pub(super) fn count(&self) -> Option<usize> {
        self.first.len().checked_sub(1)
    }

    /// The items of one.
    pub(super) fn of(&self, n: u32) -> &[T] {
        &self.items[self.first[n as usize] as usize..self.first[n as usize + 1] as usize]
    }
}
