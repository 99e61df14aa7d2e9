"""Reads tetcvt's files with VTK's own readers, and fails on anything that they complain of."""
import sys

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_DOUBLE, VTK_INT, VTK_UNSIGNED_CHAR
from vtkmodules.vtkCommonDataModel import VTK_TETRA, VTK_TRIANGLE
from vtkmodules.vtkIOLegacy import vtkPolyDataReader, vtkUnstructuredGridReader
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLUnstructuredGridReader

MESH_POINT_DATA = {"kind": VTK_UNSIGNED_CHAR, "seed": VTK_INT}
MESH_CELL_DATA = {"region": VTK_INT, "volume": VTK_DOUBLE, "min_dihedral": VTK_DOUBLE, "radius_ratio": VTK_DOUBLE}
SURFACE_POINT_DATA = {"vertex": VTK_INT}
SURFACE_CELL_DATA = {name: VTK_INT for name in ("region_inside", "region_outside", "patch", "source_triangle")}


def check(condition, message):
    if not condition:
        sys.exit(f"check failed: {message}")


def read(path, readers):
    """The data set in `path`, by the reader for its extension."""
    reader = readers[path.rsplit(".", 1)[1].lower()]()
    complaints = []
    for event in ("ErrorEvent", "WarningEvent"):
        reader.AddObserver(event, lambda *_: complaints.append(event))
    reader.SetFileName(path)
    reader.Update()
    check(not complaints, f"VTK's reader complains of {path}")
    return reader.GetOutput()


def arrays(data, expected, tuples, path):
    """The arrays of point or cell data; they must be the expected ones, in their order, one number a tuple."""
    found = [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]
    check(found == list(expected), f"{path} has arrays {found}, not {list(expected)}")
    for name, kind in expected.items():
        array = data.GetArray(name)
        check(array.GetDataType() == kind, f"{path}: {name} is of type {array.GetDataTypeAsString()}")
        check(array.GetNumberOfComponents() == 1, f"{path}: {name} has {array.GetNumberOfComponents()} components")
        check(array.GetNumberOfTuples() == tuples, f"{path}: {name} has {array.GetNumberOfTuples()} tuples")
    return {name: vtk_to_numpy(data.GetArray(name)) for name in expected}


def cells_of(cell_array, corners, path):
    check(cell_array.IsHomogeneous() == corners, f"{path}: some cell has not {corners} points")
    return vtk_to_numpy(cell_array.GetConnectivityArray()).reshape(-1, corners).astype(np.int64)


def read_tets(path):
    """Grid, points and tets of a `.vtu` or `.vtk`."""
    grid = read(path, {"vtu": vtkXMLUnstructuredGridReader, "vtk": vtkUnstructuredGridReader})
    check(grid.GetNumberOfCells() > 0, f"{path} has no cells")
    kinds = {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}
    check(kinds == {VTK_TETRA}, f"{path} has cells of types {kinds}")
    check(grid.GetPoints().GetDataType() == VTK_DOUBLE, f"{path}: points are not of double precision")
    return grid, vtk_to_numpy(grid.GetPoints().GetData()), cells_of(grid.GetCells(), 4, path)


def read_triangles(path):
    """Poly data, points and triangles of a `.vtp` or `.vtk`."""
    surface = read(path, {"vtp": vtkXMLPolyDataReader, "vtk": vtkPolyDataReader})
    others = [surface.GetNumberOfVerts(), surface.GetNumberOfLines(), surface.GetNumberOfStrips()]
    check(others == [0, 0, 0], f"{path} has verts, lines or strips: {others}")
    check(surface.GetNumberOfPolys() > 0, f"{path} has no polygons")
    kinds = {surface.GetCellType(i) for i in range(surface.GetNumberOfCells())}
    check(kinds == {VTK_TRIANGLE}, f"{path} has cells of types {kinds}")
    return surface, vtk_to_numpy(surface.GetPoints().GetData()), cells_of(surface.GetPolys(), 3, path)


def signed_volumes(points, tets):
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def outer_facets(tets):
    """Facets of one tet only, outward, and the tet behind each."""
    facets = np.concatenate([tets[:, [1, 2, 3]], tets[:, [0, 3, 2]], tets[:, [0, 1, 3]], tets[:, [0, 2, 1]]])
    _, first, count = np.unique(np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True)
    check(count.max() <= 2, f"a facet belongs to {count.max()} tets")
    first = first[count == 1]
    return facets[first], first % len(tets)


def turned(triangles):
    """Each triangle from its least vertex on, sorted: equal for equal sets of oriented triangles."""
    least = triangles.argmin(axis=1)
    rows = np.arange(len(triangles))
    triangles = np.stack([triangles[rows, (least + k) % 3] for k in range(3)], axis=1)
    return triangles[np.lexsort(triangles.T[::-1])]
