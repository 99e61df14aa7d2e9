"""Checks the files of two nested boxes, with edges of 2 and 1, meshed with `--regions nested`.

usage: check_regions.py MESH.vtu SURFACE.vtp CELLS.vtu REPORT.json
"""
import json
import sys

import meshio
import numpy as np
from reading import check, read_tets, read_triangles, signed_volumes
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkDataObject
from vtkmodules.vtkFiltersCore import vtkThreshold
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

WANTED = [7.0, 1.0]


def main(mesh, surface, cells, report):
    grid, points, tets = read_tets(mesh)
    region = vtk_to_numpy(grid.GetCellData().GetArray("region"))
    check(list(np.unique(region)) == [0, 1], f"regions {np.unique(region)}")
    volumes = signed_volumes(points, tets)
    for r, wanted in enumerate(WANTED):
        check(abs(volumes[region == r].sum() - wanted) < 1e-12, f"region {r} has {volumes[region == r].sum()}")
        # As ParaView does it: a threshold, then the sizes of cells.
        part = vtkThreshold()
        part.SetInputData(grid)
        part.SetInputArrayToProcess(0, 0, 0, vtkDataObject.FIELD_ASSOCIATION_CELLS, "region")
        part.SetLowerThreshold(r)
        part.SetUpperThreshold(r)
        size = vtkCellSizeFilter()
        size.SetInputConnection(part.GetOutputPort())
        size.Update()
        found = np.abs(vtk_to_numpy(size.GetOutput().GetCellData().GetArray("Volume"))).sum()
        check(abs(found - wanted) < 1e-12, f"VTK finds {found} in region {r}")
    read = meshio.read(mesh)
    check(np.array_equal(np.ravel(read.cell_data["region"]), region), "meshio has other regions")

    poly, own, triangles = read_triangles(surface)
    inside, outside = (vtk_to_numpy(poly.GetCellData().GetArray(n)) for n in ("region_inside", "region_outside"))
    sides = set(zip(inside.tolist(), outside.tolist()))
    check(sides == {(0, -1), (1, 0)}, f"the sides of triangles are {sides}")
    check(len(np.unique(np.sort(triangles, axis=1), axis=0)) == len(triangles), "a triangle is there twice")
    corners = own[triangles]
    flux = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    check(abs(flux[outside == -1].sum() - 8) < 1e-12, "the outer triangles enclose another volume")
    check(abs(flux[outside == 0].sum() - 1) < 1e-12, "the interface does not face away from the region within")

    # Cells are of the solid as a whole.
    cells = vtk_to_numpy(read_cells(cells).GetCellData().GetArray("volume"))
    check(abs(cells.sum() - 8) < 1e-9, f"the cells have {cells.sum()}")
    report = json.load(open(report))
    check(abs(report["mesh"]["volume_error"]) < 1e-12, f"volume_error {report['mesh']['volume_error']}")
    check(abs(report["input"]["volume"] - 8) < 1e-12, f"volume {report['input']['volume']}")


def read_cells(path):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


if __name__ == "__main__":
    main(*sys.argv[1:])
