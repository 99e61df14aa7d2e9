"""Reads a file of defects with VTK: check_defects.py FILE KIND DEFECT COUNT, KIND being verts, lines or polys."""
import sys

from reading import check, read
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

path, kind, defect, count = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
marks = read(path, {"vtp": vtkXMLPolyDataReader})
counts = {"verts": marks.GetNumberOfVerts(), "lines": marks.GetNumberOfLines(), "polys": marks.GetNumberOfPolys()}
check(counts[kind] == count, f"{path} has {counts}")
values = vtk_to_numpy(marks.GetCellData().GetArray("defect"))
check(len(values) == sum(counts.values()), f"{path}: {len(values)} numbers of defects")
check((values == defect).sum() == count, f"{path}: defects {sorted(set(values))}")
check(marks.GetCellData().GetArray("face").GetNumberOfTuples() == len(values), f"{path}: face")
