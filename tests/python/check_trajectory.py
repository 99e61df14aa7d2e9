"""Checks the trajectory against the mesh, and the triangulation against both.

usage: check_trajectory.py TRAJECTORY.npy FRAMES MESH DELAUNAY.vtu
"""
import sys

import numpy as np
from reading import check, outer_facets, read_tets, signed_volumes
from vtkmodules.util.numpy_support import vtk_to_numpy


def main(trajectory_path, frames, mesh_path, delaunay_path):
    trajectory = np.load(trajectory_path, allow_pickle=False)
    check(trajectory.dtype == np.float64 and trajectory.flags.c_contiguous, f"{trajectory_path}: type or order")
    check(np.isfinite(trajectory).all(), f"{trajectory_path}: not finite")
    mesh, points, _ = read_tets(mesh_path)
    check(trajectory.shape == (int(frames), len(points), 3), f"{trajectory_path}: shape {trajectory.shape}")
    seed = vtk_to_numpy(mesh.GetPointData().GetArray("seed"))
    check(np.array_equal(trajectory[-1][seed], points), f"{trajectory_path}: it does not end in the mesh")

    grid, own, tets = read_tets(delaunay_path)
    field = grid.GetFieldData()
    scale, shift = (vtk_to_numpy(field.GetArray(name)) for name in ("scale", "shift"))
    check(scale.shape == (1,) and shift.shape == (1, 3), f"{delaunay_path}: scale or shift")
    check(np.frexp(scale[0])[0] == 0.5, f"{delaunay_path}: the scale {scale[0]} is no power of two")
    seed = vtk_to_numpy(grid.GetPointData().GetArray("seed"))
    real = seed >= 0
    check(np.array_equal(np.sort(seed[real]), np.arange(len(points))), f"{delaunay_path}: seeds")
    check(np.array_equal(own[real] / scale + shift, trajectory[-1][seed[real]]),
          f"{delaunay_path}: scale and shift do not lead back to the seeds")
    check((signed_volumes(own, tets) > 0).all(), f"{delaunay_path}: a tet is inverted")
    empty_spheres(own, tets, delaunay_path)
    print(f"{trajectory_path}: {trajectory.shape}; {delaunay_path}: {len(tets)} tets")


def empty_spheres(points, tets, path):
    """No point is inside the circumsphere of a tet, up to rounding; the outer facets are a convex hull."""
    a = points[tets[:, 0]]
    m = 2 * (points[tets[:, 1:]] - a[:, None])
    centres = a + np.linalg.solve(m, (m * m).sum(axis=2)[..., None] / 4)[..., 0]
    radii2 = ((centres - a) ** 2).sum(axis=1)
    for centre, radius2 in zip(centres, radii2):
        distances2 = ((points - centre) ** 2).sum(axis=1)
        # Rounding of the centre grows with the sphere.
        check(distances2.min() >= radius2 - 1e-9 * max(1, radius2), f"{path}: a circumsphere is not empty")
    for a, b, c in points[outer_facets(tets)[0]]:
        heights = (points - a) @ np.cross(b - a, c - a)
        check(heights.max() < 1e-12, f"{path}: a point is outside the hull")


if __name__ == "__main__":
    main(*sys.argv[1:])
