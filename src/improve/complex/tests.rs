use super::*;
use crate::improve::bind;
use crate::improve::change::Change;
use crate::improve::endgame::restore_count;
use crate::improve::faces::remove_faces;
use crate::improve::flips::remove_edge;
use crate::improve::floor::Worklist;
use crate::improve::ground::Ground;
use crate::improve::measure::INVERTED;
use crate::improve::resize::{contract, split, split_facet};
use crate::rng::Rng;
use crate::surface::Surface;
use crate::surface::features::Features;
use crate::surface::walk::Walk;

/// The box of edge length 2, its sides cut into two triangles each.
fn cube() -> Surface {
    let at = |i: u32, k: u32| if i >> k & 1 == 1 { 1.0 } else { -1.0 };
    let points: Vec<DVec3> = (0..8).map(|i| DVec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let each: Vec<u32> = (0..12).collect();
    Surface::new(&points, &triangles, &each, &each).expect("a closed surface")
}

/// Six tets around a diagonal in each of n^3 small cubes (H. W. Kuhn, 1960), the vertices inside shaken.
fn grid(surface: &Surface, features: &Features, n: u32) -> Complex {
    let side = n + 1;
    let mut rng = Rng::new(1, 2);
    let id = |x: u32, y: u32, z: u32| (z * side + y) * side + x;
    let mut vertices = Vec::new();
    for i in 0..side * side * side {
        let place = [i % side, i / side % side, i / side / side];
        let [x, y, z] = place.map(|c| 2.0 * f64::from(c) / f64::from(n) - 1.0);
        let walls = place.iter().filter(|&&c| c == 0 || c == n).count();
        let p = surface.frame().to_frame(DVec3::new(x, y, z));
        let freedom = match walls {
            0 => Freedom::Inside,
            1 => Freedom::Surface(surface.tree().closest(p).triangle),
            2 => on_crease(surface, features, p),
            _ => Freedom::Fixed,
        };
        let shake = if walls == 0 { rng.in_cube() * (0.02 / f64::from(n)) } else { DVec3::ZERO };
        vertices.push(Vertex { point: p + shake, freedom, region: 0 });
    }
    let mut tets = Vec::new();
    for i in 0..n * n * n {
        let low = [i % n, i / n % n, i / n / n];
        for [a, b, c] in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]] {
            let mut at = low;
            let mut tet = [id(at[0], at[1], at[2]); 4];
            for (k, axis) in (1..).zip([a, b, c]) {
                at[axis] += 1;
                tet[k] = id(at[0], at[1], at[2]);
            }
            if measure::quality(tet.map(|v| vertices[v as usize].point)) == INVERTED {
                tet.swap(2, 3);
            }
            tets.push(tet);
        }
    }
    let mut complex = Complex::new(vertices, tets.clone(), Vec::new());
    let ground = Ground::new(Walk::new(surface), features, &features.face);
    for t in 0..tets.len() as u32 {
        for i in 0..4 {
            let facet = complex.facet_of(t, i);
            if complex.across(t, facet).is_none() {
                let face = features.face[surface.facing(complex.corners(facet)) as usize];
                let stray = ground.stray(complex.corners(facet));
                complex.add_facet(Facet { vertices: facet, face, stray });
            }
        }
    }
    let creases = bind::crease_edges(&complex, &ground);
    complex.set_creases(creases.into_iter());
    complex.commit();
    complex.set_floor(0.6);
    complex
}

/// The crease that a point is on.
fn on_crease(surface: &Surface, features: &Features, p: DVec3) -> Freedom {
    let found = (0..).zip(&features.curves).find_map(|(number, curve)| {
        let (at, distance2) = curve.closest(p, surface.points());
        (distance2 < 1e-24).then_some(Freedom::Curve(number, at))
    });
    found.expect("an edge of the cube is a crease")
}

/// All that a rollback must bring back, to the last bit; the order within a star may change.
fn state(complex: &Complex) -> impl PartialEq + use<> {
    let bits: Vec<[u64; 3]> = complex.points.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    let stars: Vec<[Vec<u32>; 2]> = (0..complex.points.len() as u32)
        .map(|v| {
            [complex.star(v), complex.facets_of(v)].map(|list| {
                let mut list = list.to_vec();
                list.sort_unstable();
                list
            })
        })
        .collect();
    let alive: Vec<u64> =
        (0..complex.tets.len()).filter(|&t| complex.is_alive(t as u32)).map(|t| complex.quality[t].to_bits()).collect();
    let free = (complex.free_tets.clone(), complex.free_facets.clone(), complex.free_vertices.clone());
    let facets: Vec<Option<Facet>> = complex.facets.iter().map(|f| (f.vertices[0] != NONE).then_some(*f)).collect();
    let rest = (complex.tets.clone(), facets, complex.freedom.clone(), complex.region.clone(), complex.creases.clone());
    (bits, stars, alive, free, rest, complex.deficit.to_bits())
}

/// Moves vertices inside a mesh at random, as far as no tet is inverted.
pub(in crate::improve) fn shake(complex: &mut Complex, reach: f64) {
    let mut rng = Rng::new(7, 8);
    for v in (0..complex.points.len() as u32).filter(|&v| !complex.on_boundary(v)).collect::<Vec<u32>>() {
        let (mark, to) = (complex.mark(), complex.points[v as usize] + rng.in_cube() * reach);
        complex.move_vertex(v, to, Freedom::Inside);
        if complex.star(v).iter().any(|&t| complex.quality[t as usize] == INVERTED) {
            complex.rollback(mark);
        }
    }
    complex.commit();
}

/// One random operation; whether it was possible.
fn change_something(complex: &mut Complex, ground: &Ground, rng: &mut Rng) -> bool {
    let mut change = Change::default();
    let t = (rng.bits() % complex.tets.len() as u64) as u32;
    if !complex.is_alive(t) {
        return false;
    }
    let tet = complex.tets[t as usize];
    let [i, j] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]][(rng.bits() % 6) as usize];
    match rng.bits() % 6 {
        0 => remove_edge(complex, ground, [tet[i], tet[j]], 0.0, &mut change).then(|| change.apply(complex)).is_some(),
        1 => remove_faces(complex, t, i, 0.0, &mut change).then(|| change.apply(complex)).is_some(),
        2 => split(complex, ground, [tet[i], tet[j]], &mut change).is_some(),
        3 => contract(complex, ground, [tet[i], tet[j]], 0.0, &mut change),
        4 => {
            let facet = complex.facet_of(t, i);
            split_facet(complex, (t, facet), &mut change)
        }
        _ if complex.on_seam(tet[i]) => false,
        _ => match ground.place(complex, tet[i], rng.in_cube() * 1e-3) {
            Some((to, freedom)) => {
                complex.move_vertex(tet[i], to, freedom);
                true
            }
            None => false,
        },
    }
}

fn volume(complex: &Complex) -> f64 {
    let tets = complex.tets.iter().filter(|t| t[0] != NONE);
    tets.map(|&t| {
        let [a, b, c, d] = complex.corners(t);
        crate::geometry::tetrahedron::volume(a, b, c, d)
    })
    .sum()
}

/// Calls `test` with the grid of 4^3 small cubes in the box, and with what holds it to its surface.
pub(in crate::improve) fn on_grid(test: impl FnOnce(Complex, &Ground)) {
    on_grid_of(4, test);
}

/// The same with the grid of n^3 small cubes.
fn on_grid_of(n: u32, test: impl FnOnce(Complex, &Ground)) {
    let surface = cube();
    let features = Features::find(&surface, 40.0);
    let ground = Ground::new(Walk::new(&surface), &features, &features.face);
    test(grid(&surface, &features, n), &ground);
}

#[test]
fn a_rollback_brings_everything_back_to_the_last_bit() {
    on_grid(|mut complex, ground| {
        let whole = volume(&complex);
        let mut rng = Rng::new(3, 4);
        let mut made = 0;
        for round in 0..60 {
            let (mark, before) = (complex.mark(), state(&complex));
            for _ in 0..30 {
                made += usize::from(change_something(&mut complex, ground, &mut rng));
            }
            // The sides are flat, and their vertices stay on them.
            assert!((volume(&complex) / whole - 1.0).abs() < 1e-12, "round {round}");
            if round % 3 == 0 {
                complex.commit();
            } else {
                complex.rollback(mark);
                assert!(state(&complex) == before, "round {round}");
            }
        }
        assert!(made > 300, "only {made} operations were possible");
    });
}

/// Whether tets and facets fit together, with nothing between them, and are known where they are.
fn assert_sound(complex: &Complex) {
    for t in (0..complex.tets.len() as u32).filter(|&t| complex.is_alive(t)) {
        let quality = measure::quality(complex.corners(complex.tets[t as usize]));
        assert_eq!(complex.quality[t as usize], quality);
        for facet in (0..4).map(|i| complex.facet_of(t, i)) {
            assert!(complex.across(t, facet).is_some() != complex.facet(facet).is_some(), "{facet:?}");
        }
    }
    assert!(complex.creases.iter().all(|&edge| complex.edge_facets(edge).len() == 2));
    let in_use = (0..complex.points.len() as u32).filter(|&v| !complex.star(v).is_empty());
    assert_eq!(in_use.count(), complex.vertex_count());
}

/// The parts above and below the middle of the box along an axis.
fn halves(complex: &Complex, ground: &Ground, axis: usize) -> [Part; 2] {
    let middle = ground.surface.frame().to_frame(DVec3::ZERO)[axis];
    let is_above = |&t: &u32| {
        let corners = complex.corners(complex.tets[t as usize]);
        corners.iter().map(|p| p[axis] - middle).sum::<f64>() > 0.0
    };
    let alive = (0..complex.tets.len() as u32).filter(|&t| complex.is_alive(t));
    let (above, below): (Vec<u32>, Vec<u32>) = alive.partition(is_above);
    let is_shared = |v| complex.star(v).windows(2).any(|w| is_above(&w[0]) != is_above(&w[1]));
    let seam: Vec<bool> = (0..complex.points.len() as u32).map(is_shared).collect();
    [above, below].map(|tets| complex.part(tets, &seam))
}

#[test]
fn changes_made_in_parts_fit_together() {
    on_grid(|mut complex, ground| {
        let whole = volume(&complex);
        let mut rng = Rng::new(5, 6);
        let mut made = 0;
        for round in 0..12 {
            let mut parts = halves(&complex, ground, round % 3);
            for part in &mut parts {
                made += (0..60).filter(|_| change_something(&mut part.complex, ground, &mut rng)).count();
                complex.put_back(part);
            }
            assert!((volume(&complex) / whole - 1.0).abs() < 1e-12, "round {round}");
            assert_sound(&complex);
        }
        assert!(made > 300, "only {made} operations were possible");
    });
}

/// All edges of a mesh, both ways.
pub(in crate::improve) fn edges_both_ways(complex: &Complex) -> Vec<[u32; 2]> {
    let tets = complex.tets.iter().filter(|t| t[0] != NONE);
    let mut edges: Vec<[u32; 2]> = tets.flat_map(|t| t.iter().flat_map(|&a| t.map(|b| [a, b]))).collect();
    edges.retain(|[a, b]| a != b);
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// What is around a vertex of the seam is known in none of the parts: it stays, and no vertex of the boundary comes to it.
#[test]
fn contractions_leave_the_seam_alone() {
    on_grid(|complex, ground| {
        for Part { mut complex, .. } in halves(&complex, ground, 0) {
            let mut change = Change::default();
            let mut possible = 0;
            for [a, b] in edges_both_ways(&complex) {
                let mark = complex.mark();
                let made = contract(&mut complex, ground, [a, b], 0.0, &mut change);
                let (from_seam, to_seam) = (complex.on_seam(a), complex.on_seam(b));
                complex.rollback(mark);
                assert!(!made || !from_seam, "a vertex of the seam is gone");
                assert!(!made || !to_seam || !complex.on_boundary(a), "a vertex of the boundary came to the seam");
                possible += usize::from(made);
            }
            assert!(possible > 20, "only {possible} contractions were possible");
        }
    });
}

#[test]
fn a_crease_that_is_split_stays_a_crease() {
    on_grid(|mut complex, ground| {
        let creases: Vec<[u32; 2]> = complex.creases.iter().copied().filter(|[a, b]| a < b).collect();
        assert_eq!(creases.len(), 12 * 4);
        let (whole, mut change) = (volume(&complex), Change::default());
        for [a, b] in creases {
            let (tets, facets) = (complex.star(a).len(), complex.edge_facets([a, b]).len());
            assert!(tets > 0 && facets == 2);
            let m = split(&mut complex, ground, [a, b], &mut change).expect("nothing is in the way");
            assert!(complex.is_crease(a, m) && complex.is_crease(m, b) && !complex.is_crease(a, b));
            let [p, q, middle] = complex.corners([a, b, m]);
            assert!(middle.distance((p + q) / 2.0) < 1e-15, "{middle} between {p} and {q}");
            assert!(matches!(complex.freedom[m as usize], Freedom::Curve(..)));
            assert_eq!(complex.edge_facets([a, m]).len(), 2);
        }
        assert_eq!(complex.creases.len(), 2 * 12 * 8);
        assert!((volume(&complex) / whole - 1.0).abs() < 1e-12);
        assert!((0..complex.tets.len() as u32).all(|t| !complex.is_alive(t) || complex.quality[t as usize] > 0.0));
    });
}

/// Two vertices of the boundary that all but coincide become one, whichever way the needles between them face.
#[test]
fn vertices_of_the_boundary_that_all_but_coincide_are_contracted() {
    on_grid(|mut complex, ground| {
        let mut change = Change::default();
        let (whole, count) = (volume(&complex), complex.vertex_count());
        let on_surface = |complex: &Complex, v: u32| matches!(complex.freedom[v as usize], Freedom::Surface(_));
        let all = (0..complex.tets.len()).flat_map(|t| complex.tets[t].map(|a| complex.tets[t].map(|b| [a, b])));
        let inner = |&[a, b]: &[u32; 2]| {
            a != b && on_surface(&complex, a) && on_surface(&complex, b) && complex.edge_facets([a, b]).len() == 2
        };
        let [a, b] = all.flatten().find(inner).expect("an edge amid a face");
        let m = split(&mut complex, ground, [a, b], &mut change).expect("nothing is in the way");
        // Outward, and hardly along the face: 80 degrees.
        let [p, q] = complex.corners([a, b]);
        let out = ground.surface.normal2(ground.surface.tree().closest(p).triangle).normalize();
        let to = p + ((q - p) * 0.17 + out * q.distance(p)) * 1e-3;
        let freedom = complex.freedom[m as usize];
        complex.points[m as usize] = to;
        let qualities: Vec<f64> =
            complex.star(m).iter().map(|&t| measure::quality(complex.corners(complex.tets[t as usize]))).collect();
        assert!(qualities.iter().all(|&q| q > 0.0) && qualities.iter().any(|&q| q < 0.01), "{qualities:?}");
        complex.move_judged(m, to, freedom, &qualities);
        complex.commit();
        assert!(contract(&mut complex, ground, [m, a], 0.0, &mut change), "a vertex beside another stays");
        assert_eq!(complex.vertex_count(), count);
        assert!((volume(&complex) / whole - 1.0).abs() < 1e-12);
    });
}

/// A coarse grid has one vertex inside, or none: that is not enough to make the count right.
#[test]
fn the_count_is_made_right_on_the_boundary_where_little_is_inside() {
    for (n, count) in [(2, 27 - 5), (1, 8 + 3)] {
        on_grid_of(n, |mut complex, ground| {
            let whole = volume(&complex);
            complex.set_floor(0.1);
            let mut work = Worklist::new(1000);
            assert!(restore_count(&mut complex, ground, &mut work, count), "not to {count}");
            assert_eq!(complex.vertex_count(), count);
            assert!((volume(&complex) / whole - 1.0).abs() < 1e-12);
            // Creases keep their corners, and are edges of two facets each.
            let corners = (0..complex.points.len() as u32).filter(|&v| complex.freedom[v as usize] == Freedom::Fixed);
            assert!(corners.filter(|&v| complex.along_creases(v).count() == 3).count() == 8);
            assert!(complex.creases.iter().all(|&edge| complex.edge_facets(edge).len() == 2));
        });
    }
}

#[test]
fn a_facet_inside_is_split_into_three_and_one_of_the_boundary_is_not() {
    on_grid(|mut complex, _| {
        let whole = volume(&complex);
        for t in 0..200 {
            let mark = complex.mark();
            for i in 0..4 {
                let facet = complex.facet_of(t, i);
                let (count, tets) = (complex.vertex_count(), complex.tets.len() - complex.free_tets.len());
                let inside = complex.facet(facet).is_none();
                assert_eq!(split_facet(&mut complex, (t, facet), &mut Change::default()), inside);
                assert_eq!(complex.vertex_count(), count + usize::from(inside));
                assert_eq!(complex.tets.len() - complex.free_tets.len(), tets + if inside { 4 } else { 0 });
                assert!((volume(&complex) / whole - 1.0).abs() < 1e-12);
                complex.rollback(mark);
            }
        }
    });
}
