"""Checks meshes of the second order: nodes, Jacobians, closeness to the sphere of radius 1 that they fill.

usage: check_second_order.py MESH.vtu FILE...
"""
import sys

import meshio
import numpy as np
from check_formats import gmsh, in_order
from reading import check, signed_volumes
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import VTK_QUADRATIC_TETRA
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]


def determinants(nodes, at):
    """Of the Jacobian of each tet's map, at barycentric coordinates `at`."""
    slopes = np.array([[-1.0, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    corner = [(4 * at[i] - 1) * slopes[i] for i in range(4)]
    middle = [4 * (at[i] * slopes[j] + at[j] * slopes[i]) for i, j in EDGES]
    return np.linalg.det(np.einsum("tnx,nk->txk", nodes, np.array(corner + middle)))


def main(path, *files):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    check({grid.GetCellType(i) for i in range(grid.GetNumberOfCells())} == {VTK_QUADRATIC_TETRA}, f"{path}: cells")
    points = vtk_to_numpy(grid.GetPoints().GetData())
    tets = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 10).astype(np.int64)
    data = {name: vtk_to_numpy(grid.GetPointData().GetArray(name)) for name in ("kind", "seed")}
    middles = np.unique(tets[:, 4:])
    check(np.array_equal(np.unique(tets), np.arange(len(points))), f"{path}: a node is not used")
    check((data["seed"][middles] == -1).all() and (data["seed"] == -1).sum() == len(middles), f"{path}: seeds")

    nodes = points[tets]
    straight = 6 * signed_volumes(points, tets[:, :4])
    grid_points = [np.array([i, j, k, 4 - i - j - k]) / 4
                   for i in range(5) for j in range(5 - i) for k in range(5 - i - j)]
    least = np.min([determinants(nodes, at) for at in grid_points], axis=0)
    check((least > 0.05 * straight).all(), f"{path}: a Jacobian determinant is {(least / straight).min()}")

    chords = np.array([(nodes[:, i] + nodes[:, j]) / 2 for i, j in EDGES]).transpose(1, 0, 2)
    inside = data["kind"][tets[:, 4:]] == 0
    size = np.abs(points).max()
    check(np.abs(nodes[:, 4:] - chords)[inside].max() < 1e-15 * size, f"{path}: an inner node is not in its middle")
    # As far out as the surface, which is a polyhedron with edges of 0.035.
    boundary = middles[data["kind"][middles] > 0]
    radii = np.linalg.norm(points[boundary], axis=1)
    check((radii < 1 + 1e-9).all(), f"{path}: a node at radius {radii.max()}")
    short = (radii < 1 - 3e-4).mean()
    check(short < 0.03, f"{path}: {100 * short} % of the nodes are short of the surface")
    flat = np.linalg.norm(chords[~inside], axis=1)
    check(flat.min() < 0.98, f"{path}: the mesh is too fine to tell")

    for other in files:
        mesh = meshio.read(other)
        if other.endswith(".msh"):
            mesh = in_order(mesh, points)
        (block,) = [c for c in mesh.cells if c.type == "tetra10"]
        check(np.array_equal(mesh.points, points) and np.array_equal(block.data, tets), f"{other}: other nodes or tets")
        if other.endswith(".msh"):
            triangles = np.concatenate([c.data for c in mesh.cells if c.type == "triangle6"])
            check(np.isin(triangles[:, 3:], boundary).all() and len(np.unique(triangles[:, 3:])) == len(boundary),
                  f"{other}: nodes of triangles")
            turns = [(0, 1), (1, 2), (2, 0)]
            lengths = [np.linalg.norm(points[triangles[:, i]] - points[triangles[:, j]], axis=1) for i, j in turns]
            for k, (i, j) in enumerate(turns):
                way = points[triangles[:, 3 + k]] - (points[triangles[:, i]] + points[triangles[:, j]]) / 2
                check((np.linalg.norm(way, axis=1) < 0.2 * lengths[k]).all(), f"{other}: order of a triangle's nodes")
            if gmsh:
                gmsh.initialize()
                gmsh.option.setNumber("General.Terminal", 0)
                gmsh.open(other)
                elements = gmsh.model.mesh.getElementsByType(11)[0]
                theirs = gmsh.model.mesh.getElementQualities(elements, "minDetJac")
                check(len(theirs) == len(tets) and theirs.min() > 0, f"{other}: Gmsh finds folds")
                gmsh.finalize()


if __name__ == "__main__":
    main(*sys.argv[1:])
