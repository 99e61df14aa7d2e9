//! Which way is out: consistent orientation, shells, and how they nest.
//!
//! Steps: 1. flood each connected shell over its edges so that neighbours agree; 2. count, for a vertex of each shell,
//! the other shells that hold it, by exact crossings of a ray; 3. an even count makes a shell the outside of a solid,
//! an odd one a cavity of the solid right around it; 4. turn the shells whose signed volume has the wrong sign.

use super::Regions;
use super::box_tree::BoxTree;
use super::defects::{Defect, Flaw, Marks};
use super::edges::{self, EdgeId};
use super::measures;
use super::soup::{Soup, note_count};

/// The shells of an oriented soup.
pub(super) struct Shells {
    /// For each triangle, its shell; numbered by the first triangle of each.
    pub of_triangle: Vec<u32>,
    /// For each shell, its solid.
    pub solid: Vec<u32>,
    /// For each shell, how many others it lies inside.
    pub depth: Vec<u32>,
    /// For each shell, the one right around it.
    pub around: Vec<Option<u32>>,
}

/// Orients neighbours alike (step 1); returns the shell of each triangle.
pub(super) fn agree(
    soup: &mut Soup,
    twin: &[EdgeId],
    notes: &mut Vec<String>,
    marks: &mut Marks,
) -> Result<Vec<u32>, Defect> {
    let count = soup.triangles.len();
    let mut shell = vec![u32::MAX; count];
    let mut turned = vec![false; count];
    let (mut shells, mut mended) = (0, 0);
    let mut queue = vec![];
    for start in 0..count {
        if shell[start] != u32::MAX {
            continue;
        }
        shell[start] = shells;
        queue.clear();
        queue.push(start as u32);
        let mut next = 0;
        while next < queue.len() {
            let t = queue[next];
            next += 1;
            for i in 0..3 {
                let e = 3 * t + i;
                let f = twin[e as usize];
                // Neighbours agree when they run along their common edge in opposite directions.
                let differ = edges::ends(&soup.triangles, e) == edges::ends(&soup.triangles, f);
                let want = turned[t as usize] ^ differ;
                let neighbor = edges::triangle_of(f) as usize;
                if shell[neighbor] == u32::MAX {
                    shell[neighbor] = shells;
                    turned[neighbor] = want;
                    queue.push(neighbor as u32);
                } else if turned[neighbor] != want {
                    soup.mark_edge(marks, Flaw::NonOrientable, t, i as usize);
                    return Err(Defect::NonOrientable { place: soup.edge_place(t, i as usize) });
                }
            }
        }
        // Which of the two choices is outward comes later; until then the majority keeps its orientation.
        let against = queue.iter().filter(|&&t| turned[t as usize]).count();
        if 2 * against > queue.len() {
            queue.iter().for_each(|&t| turned[t as usize] ^= true);
        }
        mended += against.min(queue.len() - against);
        shells += 1;
    }
    for (triangle, _) in soup.triangles.iter_mut().zip(&turned).filter(|(_, turn)| **turn) {
        triangle.swap(1, 2);
    }
    note_count(
        notes,
        mended,
        "face was turned to agree with its neighbours",
        "faces were turned to agree with their neighbours",
    );
    Ok(shell)
}

/// Turns each shell the way its nesting asks for (steps 2 to 4).
pub(super) fn outward(
    soup: &mut Soup,
    of_triangle: Vec<u32>,
    regions: Regions,
    notes: &mut Vec<String>,
    marks: &mut Marks,
) -> Result<Shells, Defect> {
    let around = enclosing(soup, &of_triangle);
    let count = around.len();
    let volume = measures::shell_volumes(&soup.points, &soup.triangles, &of_triangle, count);
    let flat: Vec<usize> = (0..count).filter(|&s| volume[s].is_nothing()).collect();
    if let Some(&s) = flat.first() {
        for t in (0..of_triangle.len()).filter(|&t| volume[of_triangle[t] as usize].is_nothing()) {
            soup.mark_triangle(marks, Flaw::NoVolume, t as u32);
        }
        let t = first_triangle(&of_triangle, s as u32);
        return Err(Defect::NoVolume { count: flat.len(), place: soup.corner_place(t, 0) });
    }
    let is_cavity = |s: usize| around[s].len() % 2 == 1;
    let wrong: Vec<bool> = (0..count).map(|s| (volume[s].signed > 0.0) == is_cavity(s)).collect();
    for (triangle, _) in soup.triangles.iter_mut().zip(&of_triangle).filter(|(_, s)| wrong[**s as usize]) {
        triangle.swap(1, 2);
    }
    let turned = |cavity: bool| (0..count).filter(|&s| wrong[s] && is_cavity(s) == cavity).count();
    note_count(notes, turned(false), "shell was inside out and was turned", "shells were inside out and were turned");
    // An interface may face either way.
    if regions == Regions::Parity {
        note_count(
            notes,
            turned(true),
            "shell lies inside another and faced outward; it was turned and is a cavity (nesting parity)",
            "shells lie inside others and faced outward; they were turned and are cavities (nesting parity)",
        );
    }
    let right_around: Vec<Option<u32>> = (0..count).map(|s| right_around(&around, s)).collect();
    let depth: Vec<u32> = around.iter().map(|a| a.len() as u32).collect();
    Ok(Shells { of_triangle, solid: solids(&depth, &right_around), depth, around: right_around })
}

/// The shell right around shell `s`: the one of those around it that is deepest itself.
fn right_around(around: &[Vec<u32>], s: usize) -> Option<u32> {
    around[s].iter().copied().max_by_key(|&o| (around[o as usize].len(), std::cmp::Reverse(o)))
}

/// For each shell, the others that hold its first vertex, in order.
fn enclosing(soup: &Soup, of_triangle: &[u32]) -> Vec<Vec<u32>> {
    let count = of_triangle.iter().max().map_or(0, |&s| s as usize + 1);
    if count == 1 {
        return vec![vec![]];
    }
    let tree = BoxTree::build(&soup.points, &soup.triangles);
    let mut known = vec![false; count];
    let mut around = vec![vec![]; count];
    for (t, &s) in of_triangle.iter().enumerate() {
        if std::mem::replace(&mut known[s as usize], true) {
            continue;
        }
        let mut crossed = vec![];
        tree.crossed_upward(soup.points[soup.triangles[t][0] as usize], |u| crossed.push(of_triangle[u as usize]));
        crossed.sort_unstable();
        around[s as usize] =
            crossed.chunk_by(|a, b| a == b).filter(|g| g.len() % 2 == 1 && g[0] != s).map(|g| g[0]).collect();
    }
    around
}

/// For each shell, its solid: that of the shell right around it for a cavity, a new one otherwise.
fn solids(depth: &[u32], around: &[Option<u32>]) -> Vec<u32> {
    let mut number = vec![u32::MAX; depth.len()];
    let mut solids = 0;
    for s in 0..depth.len() {
        let root = around[s].filter(|_| depth[s] % 2 == 1).map_or(s, |o| o as usize);
        if number[root] == u32::MAX {
            number[root] = solids;
            solids += 1;
        }
        number[s] = number[root];
    }
    number
}

fn first_triangle(of_triangle: &[u32], shell: u32) -> u32 {
    of_triangle.iter().position(|&s| s == shell).expect("each shell has triangles: this is a bug in tetcvt") as u32
}
