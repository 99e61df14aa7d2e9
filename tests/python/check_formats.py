"""Checks mesh and surface files of all formats against a mesh and its surface in VTK's formats.

usage: check_formats.py MESH.vtu SURFACE.vtp FILE...

Readers: meshio for all meshes; Gmsh itself for .msh where its library can be loaded (its wheel needs a desktop's
libraries); TetGen itself where the program is installed; VTK and trimesh for surfaces.
"""
import shutil
import subprocess
import sys

import meshio
import numpy as np
import trimesh
from reading import check, read_tets, read_triangles, signed_volumes, turned
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOGeometry import vtkOBJReader, vtkSTLReader
from vtkmodules.vtkIOPLY import vtkPLYReader

try:
    import gmsh
except OSError as reason:
    gmsh = None
    print(f"no Gmsh here: {reason}", file=sys.stderr)

# Abaqus: nodes of the faces of an element, 0-based.
ABAQUS_FACES = {"S1": [0, 1, 2], "S2": [0, 3, 1], "S3": [1, 3, 2], "S4": [2, 3, 0]}


def rows(array):
    """The rows, sorted: equal for equal sets of rows."""
    array = np.asarray(array)
    return array[np.lexsort(array.T[::-1])]


class Reference:
    def __init__(self, mesh, surface):
        grid, self.points, self.tets = read_tets(mesh)
        self.region = vtk_to_numpy(grid.GetCellData().GetArray("region"))
        self.kind = vtk_to_numpy(grid.GetPointData().GetArray("kind"))
        poly, self.own, own_triangles = read_triangles(surface)
        self.vertex = vtk_to_numpy(poly.GetPointData().GetArray("vertex")).astype(np.int64)
        self.own_triangles = own_triangles
        self.triangles = self.vertex[own_triangles]
        self.data = {name: vtk_to_numpy(poly.GetCellData().GetArray(name))
                     for name in ("region_inside", "region_outside", "patch", "source_triangle")}
        self.patch = self.data["patch"]

    def tets_with_region(self):
        return np.column_stack([self.tets, self.region])

    def triangles_with_patch(self):
        return np.column_stack([self.triangles, self.patch])


def check_mesh(path, ref, mesh, region, patch):
    """A mesh as meshio read it; region and patch are its numbers minus what the format adds."""
    check(np.array_equal(mesh.points, ref.points), f"{path}: other points")
    tets = np.concatenate([c.data for c in mesh.cells if c.type == "tetra"])
    check(np.array_equal(rows(np.column_stack([tets, region])), rows(ref.tets_with_region())), f"{path}: other tets")
    if patch is not None:
        triangles = np.concatenate([c.data for c in mesh.cells if c.type == "triangle"])
        check(np.array_equal(rows(np.column_stack([triangles, patch])), rows(ref.triangles_with_patch())),
              f"{path}: other triangles")


def of_type(mesh, name, kind):
    return np.concatenate([np.ravel(d) for c, d in zip(mesh.cells, mesh.cell_data[name]) if c.type == kind])


def in_order(mesh, points):
    """A mesh whose nodes are in the order of their numbers, which is that of `points`: meshio leaves Gmsh's, by entity."""
    number = np.empty(len(points), dtype=np.int64)
    number[np.lexsort(mesh.points.T)] = np.lexsort(points.T)
    cells = [(c.type, number[c.data]) for c in mesh.cells]
    ordered = np.empty_like(mesh.points)
    ordered[number] = mesh.points
    return meshio.Mesh(ordered, cells, cell_data=mesh.cell_data, field_data=mesh.field_data)


def check_msh(path, ref):
    mesh = in_order(meshio.read(path), ref.points)
    for name in ("gmsh:physical", "gmsh:geometrical"):
        check_mesh(path, ref, mesh, of_type(mesh, name, "tetra") - 1, of_type(mesh, name, "triangle") - 1)
    names = {**{f"patch_{p}": [p + 1, 2] for p in np.unique(ref.patch)},
             **{f"region_{r}": [r + 1, 3] for r in np.unique(ref.region)}}
    check({k: list(v) for k, v in mesh.field_data.items()} == names, f"{path}: groups {mesh.field_data}")
    if gmsh:
        check_msh_by_gmsh(path, ref, names)


def check_msh_by_gmsh(path, ref, names):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.logger.start()
    gmsh.open(path)
    complaints = [line for line in gmsh.logger.get() if not line.startswith("Info")]
    gmsh.logger.stop()
    check(not complaints, f"{path}: Gmsh says {complaints}")
    tags, points, _ = gmsh.model.mesh.getNodes()
    check(np.array_equal(points.reshape(-1, 3)[np.argsort(tags)], ref.points), f"{path}: Gmsh has other points")
    found = {gmsh.model.getPhysicalName(d, t): [t, d] for d, t in gmsh.model.getPhysicalGroups()}
    check(found == names, f"{path}: Gmsh has groups {found}")
    for dimension, numbers, kind in [(2, ref.patch, 2), (3, ref.region, 4)]:
        for number in np.unique(numbers):
            (entity,) = gmsh.model.getEntitiesForPhysicalGroup(dimension, number + 1)
            kinds, elements, nodes = gmsh.model.mesh.getElements(dimension, entity)
            check(list(kinds) == [kind] and len(elements[0]) == (numbers == number).sum(), f"{path}: group {number}")
            wanted = (ref.triangles if dimension == 2 else ref.tets)[numbers == number]
            check(np.array_equal(rows(nodes[0].reshape(-1, dimension + 1).astype(np.int64) - 1), rows(wanted)),
                  f"{path}: Gmsh has other elements in group {number}")
            if dimension == 3:
                volume = gmsh.model.mesh.getElementQualities(elements[0], "volume").sum()
                check(abs(volume / signed_volumes(ref.points, wanted).sum() - 1) < 1e-12, f"{path}: volume {volume}")
                beside = (ref.data["region_inside"] == number) | (ref.data["region_outside"] == number)
                own = np.unique(ref.patch[beside]) + 1
                bounds = gmsh.model.getAdjacencies(3, entity)[1]
                check(np.array_equal(np.sort(np.abs(bounds)), own), f"{path}: region {number} is bounded by {bounds}")
    gmsh.finalize()


def check_medit(path, ref):
    mesh = meshio.read(path)
    check_mesh(path, ref, mesh, of_type(mesh, "medit:ref", "tetra") - 1, of_type(mesh, "medit:ref", "triangle") - 1)
    check(np.array_equal(np.ravel(mesh.point_data["medit:ref"]), ref.kind), f"{path}: references of vertices")


def check_abaqus(path, ref):
    mesh = meshio.read(path)
    order = np.concatenate([np.flatnonzero(ref.region == r) for r in np.unique(ref.region)])
    tets = np.concatenate([c.data for c in mesh.cells])
    check(np.array_equal(mesh.points, ref.points), f"{path}: other points")
    check(np.array_equal(tets, ref.tets[order]), f"{path}: other tets")
    sizes = [len(c.data) for c in mesh.cells]
    check(sizes == [(ref.region == r).sum() for r in np.unique(ref.region)], f"{path}: blocks of {sizes}")
    sets, surfaces = read_abaqus_sets(path)
    check(set(surfaces) == {f"PATCH_{p}" for p in np.unique(ref.patch)}, f"{path}: surfaces {set(surfaces)}")
    for name, sides in surfaces.items():
        facets = np.concatenate([ref.tets[np.array(sets[s]) - 1][:, ABAQUS_FACES[face]] for s, face in sides])
        wanted = ref.triangles[ref.patch == int(name.split("_")[1])]
        check(np.array_equal(rows(np.sort(facets, axis=1)), rows(np.sort(wanted, axis=1))), f"{path}: faces of {name}")


def read_abaqus_sets(path):
    """Element sets, and surfaces as pairs of a set and a face: what meshio leaves out."""
    sets, surfaces, target = {}, {}, None
    for line in open(path):
        if line.startswith("*"):
            words = dict(w.strip().split("=") for w in line.split(",")[1:])
            keyword = line.split(",")[0].strip()
            target = {"*ELSET": lambda: sets.setdefault(words["ELSET"], []),
                      "*SURFACE": lambda: surfaces.setdefault(words["NAME"], [])}.get(keyword, lambda: None)()
            collected = keyword
        elif target is not None:
            check(len(line) <= 256, f"{path}: a line of {len(line)} characters")
            entries = [e.strip() for e in line.split(",")]
            target.extend([tuple(entries)] if collected == "*SURFACE" else map(int, entries))
    return sets, surfaces


def check_tetgen(path, ref):
    stem = path.rsplit(".", 1)[0]
    mesh = meshio.read(stem + ".ele")
    check_mesh(path, ref, mesh, of_type(mesh, "tetgen:ref", "tetra") - 1, None)
    faces = np.loadtxt(stem + ".face", skiprows=1, dtype=np.int64)
    check(open(stem + ".face").readline().split() == [str(len(faces)), "1"], f"{stem}.face: header")
    check(np.array_equal(faces[:, 0], np.arange(len(faces))), f"{stem}.face: numbers")
    faces[:, 4] -= 1
    check(np.array_equal(faces[:, 1:], ref.triangles_with_patch()), f"{stem}.face: other triangles")
    nodes = np.loadtxt(stem + ".node", skiprows=1)
    check(np.array_equal(nodes[:, 4] == 1, ref.kind > 0), f"{stem}.node: markers")
    program = shutil.which("tetgen")
    if program:
        # Reads the mesh back, refines nothing, writes nothing, says what it has.
        said = subprocess.run([program, "-rNEFV", stem + ".node"], capture_output=True, text=True).stdout
        for line in (f"Mesh points: {len(ref.points)}", f"Mesh tetrahedra: {len(ref.tets)}",
                     f"Mesh faces on facets: {len(ref.triangles)}"):
            check(line in said, f"{path}: TetGen does not say '{line}': {said[-1500:]}")
    else:
        print("no TetGen here", file=sys.stderr)


def check_obj(path, ref):
    reader = vtkOBJReader()
    reader.SetFileName(path)
    reader.Update()
    check(reader.GetOutput().GetNumberOfPolys() == len(ref.triangles), f"{path}: VTK has another count")
    points, triangles, patches, patch = [], [], [], None
    for line in open(path):
        word, *rest = line.split()
        if word == "v":
            points.append([float(x) for x in rest])
        elif word == "g":
            patch = int(rest[0].removeprefix("patch_"))
        elif word == "f":
            triangles.append([int(x) - 1 for x in rest])
            patches.append(patch)
    check(np.array_equal(points, ref.own), f"{path}: other points")
    check(np.array_equal(rows(np.column_stack([triangles, patches])),
                         rows(np.column_stack([ref.own_triangles, ref.patch]))), f"{path}: other triangles")
    solid = trimesh.load(path, force="mesh", process=True)
    check(solid.is_watertight and len(solid.faces) == len(ref.triangles), f"{path}: trimesh finds it open")


def check_stl(path, ref):
    reader = vtkSTLReader()
    reader.SetFileName(path)
    reader.Update()
    check(reader.GetOutput().GetNumberOfPolys() == len(ref.triangles), f"{path}: VTK has another count")
    solid = trimesh.load(path, process=False)
    text = open(path, "rb").read(5) == b"solid"
    corners = ref.own[ref.own_triangles]
    wanted = corners if text else corners.astype(np.float32).astype(np.float64)
    check(np.array_equal(solid.triangles, wanted), f"{path}: other triangles")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    check(np.allclose(solid.face_normals, normals, atol=1e-6), f"{path}: other normals")


def check_ply(path, ref):
    reader = vtkPLYReader()
    reader.SetFileName(path)
    reader.Update()
    check(reader.GetOutput().GetNumberOfPolys() == len(ref.triangles), f"{path}: VTK has another count")
    # Not meshio: it cannot read binary faces that have more than their corners.
    solid = trimesh.load(path, process=False)
    check(np.array_equal(solid.vertices, ref.own), f"{path}: other points")
    check(np.array_equal(solid.faces, ref.own_triangles), f"{path}: other triangles")
    raw = {name: element["data"] for name, element in solid.metadata["_ply_raw"].items()}
    check(np.array_equal(np.ravel(raw["vertex"]["vertex"]), ref.vertex), f"{path}: vertex")
    for name, values in ref.data.items():
        check(np.array_equal(np.ravel(raw["face"][name]), values), f"{path}: {name}")


CHECKS = {"msh": check_msh, "mesh": check_medit, "inp": check_abaqus, "node": check_tetgen,
          "obj": check_obj, "stl": check_stl, "ply": check_ply}


def main(mesh, surface, *files):
    ref = Reference(mesh, surface)
    for path in files:
        CHECKS[path.rsplit(".", 1)[1]](path, ref)


if __name__ == "__main__":
    main(*sys.argv[1:])
