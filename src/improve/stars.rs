//! What lies around each vertex: lists in one array, which grow in place or move to its end.

/// For each vertex a short list of items.
#[derive(Clone, Debug, Default)]
pub(super) struct Stars {
    lists: Vec<List>,
    pool: Vec<u32>,
}

#[derive(Clone, Copy, Debug, Default)]
struct List {
    start: u32,
    length: u32,
    capacity: u32,
}

impl Stars {
    /// Lists for `vertices` vertices, with room for those of `items`: the vertices of item i.
    pub(super) fn new<const K: usize>(vertices: usize, items: &[[u32; K]]) -> Stars {
        let mut lists = vec![List::default(); vertices];
        items.iter().flatten().for_each(|&v| lists[v as usize].capacity += 1);
        let mut end = 0;
        for list in lists.iter_mut().filter(|l| l.capacity > 0) {
            list.capacity += list.capacity / 4 + 4;
            list.start = end;
            end += list.capacity;
        }
        let mut stars = Stars { lists, pool: vec![0; end as usize] };
        for (i, item) in (0..).zip(items) {
            item.iter().for_each(|&v| stars.add(v, i));
        }
        stars
    }

    /// The items of vertex `v`.
    pub(super) fn of(&self, v: u32) -> &[u32] {
        let List { start, length, .. } = self.lists[v as usize];
        &self.pool[start as usize..(start + length) as usize]
    }

    /// Appends an item to the list of `v`.
    pub(super) fn add(&mut self, v: u32, item: u32) {
        let list = &mut self.lists[v as usize];
        if list.length == list.capacity {
            let from = list.start as usize..(list.start + list.length) as usize;
            list.start = self.pool.len() as u32;
            list.capacity = 2 * list.capacity + 8;
            self.pool.extend_from_within(from);
            self.pool.resize((list.start + list.capacity) as usize, 0);
        }
        self.pool[(list.start + list.length) as usize] = item;
        list.length += 1;
    }

    /// Takes an item out of the list of `v`.
    pub(super) fn remove(&mut self, v: u32, item: u32) {
        let list = &mut self.lists[v as usize];
        let items = &mut self.pool[list.start as usize..(list.start + list.length) as usize];
        let at = items
            .iter()
            .position(|&x| x == item)
            .expect("an item is in the stars of its vertices: this is a bug in tetcvt");
        let last = items.len() - 1;
        items.swap(at, last);
        list.length -= 1;
    }

    /// Adds a vertex with an empty list.
    pub(super) fn push(&mut self) {
        self.lists.push(List::default());
    }

    /// Takes the last vertex away.
    pub(super) fn pop(&mut self) {
        self.lists.pop();
    }
}
