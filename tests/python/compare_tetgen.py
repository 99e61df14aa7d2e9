"""Compares a mesh with TetGen's of the same surface: volume and counts.

usage: compare_tetgen.py SURFACE.obj MESH REPORT.json
"""
import json
import sys

import numpy as np
import tetgen
import trimesh
from reading import check, read_tets, signed_volumes


def main(surface, mesh, report):
    solid = trimesh.load(surface, force="mesh", process=True)
    _, points, tets = read_tets(mesh)
    volume = signed_volumes(points, tets).sum()
    # Tets of about the same size as ours, at a quality that TetGen reaches everywhere.
    mesher = tetgen.TetGen(np.asarray(solid.vertices), np.asarray(solid.faces))
    size = 2 * volume / len(tets)
    nodes, elements = mesher.tetrahedralize(minratio=1.5, mindihedral=10, fixedvolume=True, maxvolume=size)[:2]
    theirs = np.abs(signed_volumes(nodes, elements)).sum()

    with open(report) as file:
        ours = json.load(file)
    check(abs(ours["input"]["volume"] / solid.volume - 1) < 1e-12,
          f"the solid's volume is {ours['input']['volume']}, says tetcvt, and {solid.volume}, says trimesh")
    # TetGen moves points of its boundary by about 1e-8.
    check(abs(solid.volume / theirs - 1) < 1e-6, f"TetGen's tets fill {theirs} of {solid.volume}")
    check(abs(volume / theirs - 1 - ours["mesh"]["volume_error"]) < 1e-6,
          f"volume_error is {ours['mesh']['volume_error']}, against TetGen {volume / theirs - 1}")
    check(abs(volume / theirs - 1) < 0.01, f"the tets fill {volume}, TetGen's {theirs}")
    # A tet mesh has 4.5 to 6.7 tets a vertex, fewer the more of its vertices are on the boundary.
    for name, n, t in [("ours", len(points), len(tets)), ("TetGen's", len(nodes), len(elements))]:
        check(3 < t / n < 6.8, f"{name} has {t} tets over {n} vertices")
    check(0.5 < len(tets) / len(elements) < 2, f"{len(tets)} tets, TetGen has {len(elements)}")
    print(f"ours: {len(points)} vertices, {len(tets)} tets, volume {volume:.9g}; "
          f"TetGen: {len(nodes)}, {len(elements)}, {theirs:.9g}")


if __name__ == "__main__":
    main(*sys.argv[1:])
