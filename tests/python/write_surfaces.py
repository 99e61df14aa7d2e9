"""Writes one surface in every format that VTK, meshio and trimesh have, into a folder; run as write_surfaces.py FOLDER.

Files whose name begins with `refused` are of kinds that tetcvt does not read.
"""
import sys
from pathlib import Path

import meshio
import numpy as np
import pyvista as pv
import trimesh
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

folder = Path(sys.argv[1])
ball = trimesh.creation.icosphere(subdivisions=3, radius=1.7)
ball.vertices = np.asarray(ball.vertices).astype(np.float32).astype(np.float64) + [0.25, -0.5, 4.0]
points, faces = np.asarray(ball.vertices), np.asarray(ball.faces)
patch = (points[faces].mean(axis=1)[:, 2] > 4).astype(np.int32) * 5 + 2

surface = pv.PolyData(points, np.hstack([np.full((len(faces), 1), 3), faces]))
surface.cell_data["area"] = np.ones(len(faces), dtype=np.float32)
surface.cell_data["patch"] = patch
surface.point_data["height"] = points[:, 2]


def xml(name, mode, compressor, encode=True, header=64, big=False):
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(surface)
    writer.SetFileName(str(folder / name))
    writer.SetDataMode(mode)
    writer.SetCompressorType(compressor)
    writer.SetEncodeAppendedData(encode)
    writer.SetHeaderType(header)
    writer.SetByteOrder(0 if big else 1)
    writer.Write()


TEXT, BINARY, APPENDED = 0, 1, 2
NONE, ZLIB, LZ4 = 0, 1, 2
xml("text.vtp", TEXT, NONE)
xml("binary.vtp", BINARY, NONE)
xml("binary_zlib.vtp", BINARY, ZLIB)
xml("binary_zlib_32.vtp", BINARY, ZLIB, header=32)
xml("appended.vtp", APPENDED, NONE)
xml("appended_zlib.vtp", APPENDED, ZLIB)
xml("raw.vtp", APPENDED, NONE, encode=False)
xml("raw_zlib.vtp", APPENDED, ZLIB, encode=False)
xml("raw_big.vtp", APPENDED, ZLIB, encode=False, big=True)
xml("refused_lz4.vtp", APPENDED, LZ4)
for version in (42, 51):
    for kind in (1, 2):
        writer = vtkPolyDataWriter()
        writer.SetInputData(surface)
        writer.SetFileName(str(folder / f"legacy_{version}_{kind}.vtk"))
        writer.SetFileVersion(version)
        writer.SetFileType(kind)
        writer.Write()
surface.save(folder / "pyvista.ply")
surface.save(folder / "pyvista_text.ply", binary=False)
surface.save(folder / "pyvista.stl")
surface.save(folder / "pyvista_text.stl", binary=False)
surface.cast_to_unstructured_grid().save(folder / "pyvista.vtu")
surface.strip().save(folder / "strips.vtp")
surface.strip().save(folder / "strips.vtk")

for name in ("trimesh.ply", "trimesh.stl", "trimesh.off", "trimesh.obj", "trimesh.glb"):
    ball.export(folder / name)
ball.export(folder / "trimesh_text.ply", encoding="ascii")
ball.export(folder / "trimesh_text.stl", file_type="stl_ascii")
for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(ball)).items():
    (folder / name.replace("model", "trimesh")).write_bytes(data)

mesh = meshio.Mesh(points, [("triangle", faces)], cell_data={"patch": [patch]})
bare = meshio.Mesh(points, [("triangle", faces)])
mesh.write(folder / "meshio.vtk", file_format="vtk")
mesh.write(folder / "meshio42.vtk", file_format="vtk42")
mesh.write(folder / "meshio_text.vtk", file_format="vtk42", binary=False)
mesh.write(folder / "meshio.vtu")
mesh.write(folder / "meshio_text.vtu", binary=False)
mesh.write(folder / "meshio_raw.vtu", compression=None)
bare.write(folder / "meshio.off")
bare.write(folder / "meshio.stl")
bare.write(folder / "meshio_binary.stl", binary=True)
bare.write(folder / "meshio.ply")
bare.write(folder / "meshio_text.ply", binary=False)
bare.write(folder / "meshio.obj")
