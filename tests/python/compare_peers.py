"""Meshes models with TetGen and fTetWild (pytetwild), and by tetcvt with exactly as many vertices as each; compares.

usage: compare_peers.py TETCVT TABLE.csv MODEL.obj...

Volumes and boundaries must agree within what the spacing allows, the dihedral angles and radius ratios of ours be at least
theirs, and a Poisson problem solved with linear elements have no larger error (within what ERROR leaves against fTetWild) and,
against TetGen, no larger condition number. The table is printed and written.
"""
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytetwild
import pyvista
import scipy.sparse.linalg
import skfem
import tetgen
from reading import check, outer_facets, read_tets, signed_volumes
from skfem.models.poisson import laplace

# What the meshes may differ by: the volume, and the distance between boundaries over the diagonal.
VOLUME, DISTANCE = 0.015, 0.015
# What ours may be over theirs. fTetWild's tets grow away from the surface, for which the condition number is rewarded, and its
# vertices move inside from the boundary: that number is told, not held against either.
ERROR = {"TetGen": 1.0, "fTetWild": 1.02}
CONDITION = {"TetGen": 1.0, "fTetWild": np.inf}
# How far fTetWild may stray, over the diagonal: as far as meshes of this size do.
ENVELOPE = 2e-3
# A denser surface is thinned out for all three: fTetWild takes minutes for it.
MOST_TRIANGLES = 2000
# Vertices that are aimed at.
VERTICES = 1000
COLUMNS = ("vertices", "tets", "volume", "min", "p1", "mean", "max", "radius_ratio", "error", "condition", "seconds")


def dihedrals(points, tets):
    """The six dihedral angles of each tet, in degrees."""
    angles = []
    for i, j, k, l in [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)]:
        edge = points[tets[:, j]] - points[tets[:, i]]
        u = np.cross(edge, points[tets[:, k]] - points[tets[:, i]])
        v = np.cross(edge, points[tets[:, l]] - points[tets[:, i]])
        angles.append(np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), (u * v).sum(axis=1)))
    return np.degrees(np.stack(angles, axis=1))


def radius_ratios(points, tets):
    """Three times the inscribed sphere's radius over the circumscribed one's."""
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    volume6 = np.abs(((b - a) * np.cross(c - a, d - a)).sum(axis=1))
    areas2 = sum(np.linalg.norm(np.cross(q - p, r - p), axis=1) for p, q, r in [(b, c, d), (a, c, d), (a, b, d), (a, b, c)])
    square = lambda u: (u * u).sum(axis=1)[:, None]
    center = (square(b - a) * np.cross(c - a, d - a) + square(c - a) * np.cross(d - a, b - a)
              + square(d - a) * np.cross(b - a, c - a)) / (2 * volume6[:, None])
    return 3 * (volume6 / areas2) / np.linalg.norm(center, axis=1)


def poisson(points, tets):
    """-laplace(u) = f with u a plane wave as long as the model: relative error in the energy norm, condition number."""
    low, high = points.min(axis=0), points.max(axis=0)
    # Across no side of a box: a wave that is still on some sides would favor meshes that are coarse there.
    wave = 2 * np.pi / (high - low).max() * np.array([2, 1, 2]) / 3
    phase = lambda x: np.tensordot(wave, x - low.reshape(3, 1, 1), axes=1)
    exact = lambda x: np.sin(phase(x))
    gradient = lambda x: wave.reshape(3, 1, 1) * np.cos(phase(x))

    basis = skfem.Basis(skfem.MeshTet(points.T.copy(), tets.T.copy()), skfem.ElementTetP1(), intorder=4)
    stiffness = laplace.assemble(basis)
    load = skfem.LinearForm(lambda v, w: wave @ wave * exact(w.x) * v).assemble(basis)
    boundary = basis.get_dofs()
    values = exact(basis.doflocs[:, None, :])[0]
    solution = skfem.solve(*skfem.condense(stiffness, load, x=values, D=boundary))
    squares = skfem.Functional(lambda w: ((w["u"].grad - gradient(w.x)) ** 2).sum(axis=0))
    whole = skfem.Functional(lambda w: (gradient(w.x) ** 2).sum(axis=0))
    error = np.sqrt(squares.assemble(basis, u=basis.interpolate(solution)) / whole.assemble(basis))
    inner = stiffness[basis.complement_dofs(boundary)][:, basis.complement_dofs(boundary)].tocsc()
    most = scipy.sparse.linalg.eigsh(inner, k=1, which="LA", return_eigenvectors=False, tol=1e-3, v0=np.ones(inner.shape[0]))[0]
    least = scipy.sparse.linalg.eigsh(inner, k=1, sigma=0, return_eigenvectors=False, tol=1e-3, v0=np.ones(inner.shape[0]))[0]
    return error, most / least


def measure(points, tets, seconds):
    used, tets = np.unique(tets, return_inverse=True)
    points, tets = np.asarray(points, float)[used], tets.reshape(-1, 4)
    volumes = signed_volumes(points, tets)
    tets = np.where((volumes < 0)[:, None], tets[:, [1, 0, 2, 3]], tets)
    angles = dihedrals(points, tets)
    smallest = angles.min(axis=1)
    error, condition = poisson(points, tets)
    row = (len(points), len(tets), np.abs(volumes).sum(), smallest.min(), np.percentile(smallest, 1), smallest.mean(),
           angles.max(), radius_ratios(points, tets).mean(), error, condition, seconds)
    return dict(zip(COLUMNS, row)), (points, outer_facets(tets)[0])


def apart(one, other):
    """The largest distance of a vertex or facet middle of either boundary to the other."""
    farthest = 0.0
    for (points, facets), (target, target_facets) in [(one, other), (other, one)]:
        samples = np.concatenate([points[np.unique(facets)], points[facets].mean(axis=1)])
        surface = pyvista.PolyData.from_regular_faces(target, target_facets)
        closest = surface.find_closest_cell(samples, return_closest_point=True)[1]
        farthest = max(farthest, np.linalg.norm(samples - closest, axis=1).max())
    return farthest


def thinned(model, folder):
    """The surface, with fewer triangles if it has too many: file, points, triangles."""
    surface = pyvista.read(model).triangulate().clean()
    if surface.n_cells > MOST_TRIANGLES:
        surface = surface.decimate(1 - MOST_TRIANGLES / surface.n_cells).clean()
    points, triangles = np.asarray(surface.points, float), surface.regular_faces
    path = folder / f"{Path(model).stem}.obj"
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(rows) + "\n")
    return path, points, triangles


def by_tetgen(points, triangles, volume):
    # At even spacing there are five to six tets a vertex.
    size = volume / (5 * VERTICES)
    mesher = tetgen.TetGen(points, triangles)
    for body in pyvista.PolyData.from_regular_faces(points, triangles).split_bodies():
        shell = body.extract_surface(algorithm="dataset_surface")
        a, b, c = (np.asarray(shell.points)[shell.regular_faces[:, k]] for k in range(3))
        if (a * np.cross(b, c)).sum() < 0:
            # A cavity, convex here.
            mesher.add_hole(shell.points.mean(axis=0))
    return mesher.tetrahedralize(minratio=1.4, mindihedral=10, fixedvolume=True, maxvolume=size)[:2]


def by_tetwild(points, triangles, volume):
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    # Edges of tets of that size, as a share of the diagonal.
    edge = (volume / (5 * VERTICES) * 6 * np.sqrt(2)) ** (1 / 3) / diagonal
    return pytetwild.tetrahedralize(points, triangles, edge_length_fac=edge, epsilon=ENVELOPE, quiet=True)[:2]


def compare(exe, model, name, surface, mesher, folder):
    path, points, triangles = surface
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = (a * np.cross(b, c)).sum() / 6
    begun = time.perf_counter()
    nodes, elements = mesher(points, triangles, volume)
    theirs, their_boundary = measure(nodes, elements, time.perf_counter() - begun)
    mesh = folder / "ours.vtu"
    begun = time.perf_counter()
    subprocess.run([exe, "-q", path, "--seeds", str(theirs["vertices"]), "--threads", "1", "-o", mesh,
                    "--surface", folder / "ours.vtp"], check=True)
    ours, our_boundary = measure(*read_tets(str(mesh))[1:], time.perf_counter() - begun)
    case = f"{Path(model).stem} against {name}: ours {ours}, theirs {theirs}"
    check(ours["vertices"] == theirs["vertices"], f"{case}: counts differ")
    for row in (ours, theirs):
        check(abs(row["volume"] / volume - 1) < VOLUME, f"{case}: volume of the surface {volume}")
    distance = apart(our_boundary, their_boundary) / np.linalg.norm(np.ptp(points, axis=0))
    check(distance < DISTANCE, f"{case}: boundaries {distance} of the diagonal apart")
    for column in ("min", "p1", "mean", "radius_ratio"):
        check(ours[column] >= theirs[column], f"{case}: {column}")
    check(ours["error"] <= theirs["error"] * ERROR[name], f"{case}: error")
    check(ours["condition"] <= theirs["condition"] * CONDITION[name], f"{case}: condition number")
    return [(Path(model).stem, mesher_name, distance, row) for mesher_name, row in ((name, theirs), ("tetcvt", ours))]


def main(exe, table, *models):
    lines = [",".join(("model", "mesher", "apart", *COLUMNS))]
    exe, table, *models = (Path(path).resolve() for path in (exe, table, *models))
    with tempfile.TemporaryDirectory() as folder:
        # fTetWild leaves a file where it runs.
        os.chdir(folder)
        for model in models:
            surface = thinned(model, Path(folder))
            for name, mesher in (("TetGen", by_tetgen), ("fTetWild", by_tetwild)):
                for stem, who, distance, row in compare(exe, model, name, surface, mesher, Path(folder)):
                    numbers = [f"{distance:.5f}", *(f"{x:.5g}" if isinstance(x, float) else str(x) for x in row.values())]
                    lines.append(",".join((stem, who, *numbers)))
                    print(lines[-1], flush=True)
    Path(table).write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
