"""Checks clipped Voronoi cells: closed, conforming, as large as they say, around their seeds.

usage: check_voronoi.py CELLS.vtu MESH.vtu VOLUME

VTK's vtkCellSizeFilter takes every polyhedron for convex; vtkMassProperties, over a cell's own faces, does not.
"""
import sys
from collections import Counter

import numpy as np
from reading import check, read
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdList
from vtkmodules.vtkCommonDataModel import VTK_POLYHEDRON
from vtkmodules.vtkFiltersCore import vtkMassProperties, vtkTriangleFilter
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader


def faces_of(grid, c):
    stream = vtkIdList()
    grid.GetFaceStream(c, stream)
    ids = [stream.GetId(i) for i in range(stream.GetNumberOfIds())]
    faces, k = [], 1
    for _ in range(ids[0]):
        faces.append(ids[k + 1:k + 1 + ids[k]])
        k += 1 + ids[k]
    return faces


def volume_by_vtk(grid, c):
    triangles = vtkTriangleFilter()
    triangles.SetInputData(grid.GetCell(c).GetPolyData())
    mass = vtkMassProperties()
    mass.SetInputConnection(triangles.GetOutputPort())
    return mass.GetVolume()


def volume_of(points, faces):
    """By the divergence theorem, each face as a fan."""
    origin, volume = points[faces[0][0]], 0.0
    for face in faces:
        p = points[face] - origin
        volume += sum(p[0] @ np.cross(p[i], p[i + 1]) for i in range(1, len(p) - 1)) / 6
    return volume


def main(path, mesh_path, total):
    grid = read(path, {"vtu": vtkXMLUnstructuredGridReader})
    count = grid.GetNumberOfCells()
    check({grid.GetCellType(c) for c in range(count)} == {VTK_POLYHEDRON}, f"{path}: cells that are no polyhedra")
    points = vtk_to_numpy(grid.GetPoints().GetData())
    data = {name: vtk_to_numpy(grid.GetCellData().GetArray(name)) for name in ("seed", "volume", "neighbors")}
    check((np.diff(data["seed"]) > 0).all(), f"{path}: seeds are not ascending")
    check((data["volume"] > 0).all(), f"{path}: a volume is not positive")
    check(abs(data["volume"].sum() / float(total) - 1) < 1e-12, f"{path}: volumes sum to {data['volume'].sum()}")

    shared, convex = Counter(), []
    own_edges = []
    for c in range(count):
        faces = faces_of(grid, c)
        edges = Counter(e for face in faces for e in zip(face, face[1:] + face[:1]))
        check(all(edges[b, a] == n for (a, b), n in edges.items()), f"{path}: cell {c} is not closed")
        shared.update(tuple(np.roll(face, -int(np.argmin(face)))) for face in faces)
        own_edges.append(faces)
        # Heights above each face, against its size.
        corners = points[np.unique(np.concatenate(faces))]
        hull = True
        for face in faces:
            a, b, d = points[face[0]], points[face[1]], points[face[2]]
            normal = np.cross(b - a, d - a)
            length = np.linalg.norm(normal)
            hull &= length > 0 and ((corners - a) @ normal).max() < 1e-9 * length
        convex.append(hull)
    # A face has one cell, or two that see it from either side.
    once = {face for face, n in shared.items() if n == 1}
    check(set(shared.values()) == {1}, f"{path}: two cells see a face from the same side")

    def back(face):
        turned = face[::-1]
        return tuple(np.roll(turned, -int(np.argmin(turned))))

    seen = Counter({c: 0 for c in range(count)})
    of_face = {tuple(np.roll(f, -int(np.argmin(f)))): c for c in range(count) for f in own_edges[c]}
    beyond = [set() for _ in range(count)]
    for face, c in of_face.items():
        if back(face) in once:
            beyond[c].add(of_face[back(face)])
    listed = np.split(vtk_to_numpy(grid.GetFieldData().GetArray("neighbor")), np.cumsum(data["neighbors"])[:-1])
    for c in range(count):
        seeds = sorted(data["seed"][list(beyond[c])])
        check(list(listed[c]) == seeds, f"{path}: cell {c} has neighbours {seeds}, not {listed[c]}")

    by_faces = np.array([volume_of(points, faces) for faces in own_edges])
    check(np.allclose(by_faces, data["volume"], rtol=1e-9, atol=0),
          f"{path}: volumes differ from those of the faces by {np.abs(by_faces / data['volume'] - 1).max()}")
    theirs = np.array([volume_by_vtk(grid, c) for c in range(count)])
    apart = np.abs(theirs / data["volume"] - 1)
    # Cutting a face in triangles VTK may lose a sliver of it, and the cell on the other side with it.
    check((apart > 1e-9).sum() <= max(2, count // 100) and apart.max() < 1e-6,
          f"{path}: {(apart > 1e-9).sum()} volumes differ from VTK's, by up to {apart.max()}")
    sizes = vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    theirs = vtk_to_numpy(sizes.GetOutput().GetCellData().GetArray("Volume"))
    convex = np.array(convex)
    check(convex.sum() > count / 4, f"{path}: only {convex.sum()} convex cells")
    # It cuts a cell into tets by a triangulation of its own, which may lose a sliver.
    agree = np.isclose(theirs[convex], data["volume"][convex], rtol=1e-9, atol=0)
    check(agree.mean() > 0.95, f"{path}: {(~agree).sum()} convex cells differ from vtkCellSizeFilter")

    # Every corner of a cell has no seed closer than the cell's.
    mesh = read(mesh_path, {"vtu": vtkXMLUnstructuredGridReader})
    seed = vtk_to_numpy(mesh.GetPointData().GetArray("seed"))
    position = np.empty((seed.max() + 1, 3))
    position[seed] = vtk_to_numpy(mesh.GetPoints().GetData())
    size = np.ptp(points, axis=0).max()
    for c in range(count):
        corners = points[np.unique(np.concatenate(own_edges[c]))]
        to_all = np.linalg.norm(corners[:, None] - position[None], axis=2).min(axis=1)
        to_own = np.linalg.norm(corners - position[data["seed"][c]], axis=1)
        check((to_own < to_all + 1e-12 * size).all(), f"{path}: a corner of cell {c} is closer to another seed")
    print(f"{path}: {count} cells, {convex.sum()} convex, {len(shared)} faces")


if __name__ == "__main__":
    main(*sys.argv[1:])
