"""Renders a tet mesh cut open, off screen: the picture of the README.

usage: picture.py MESH.vtu PICTURE.png [--normal X Y Z] [--at 0.58] [--size 1100]

Tets whose centroid is beyond the plane are left out whole, so that their shapes show. Needs the packages of
tests/python/requirements.txt.
"""
import argparse
import io

import numpy as np
import pyvista
from PIL import Image, ImageChops

OUTSIDE, INSIDE = "#9fc3dd", "#f2c14e"


def picture(path, normal, at, size):
    mesh = pyvista.read(path)
    normal = np.asarray(normal, float) / np.linalg.norm(normal)
    centres = mesh.cell_centers().points @ normal
    extent = np.asarray(mesh.points) @ normal
    plane = extent.min() + at * (extent.max() - extent.min())

    mesh.cell_data["kept"] = (centres < plane).astype(np.uint8)
    mesh.point_data["original"] = np.arange(mesh.n_points)
    whole = mesh.extract_surface(algorithm="dataset_surface")
    boundary = {tuple(sorted(f)) for f in whole.point_data["original"][whole.regular_faces].tolist()}
    kept = mesh.extract_cells(np.flatnonzero(mesh.cell_data["kept"])).extract_surface(algorithm="dataset_surface")
    faces = kept.point_data["original"][kept.regular_faces].tolist()
    kept.cell_data["cut"] = np.array([tuple(sorted(f)) not in boundary for f in faces], np.uint8)

    plotter = pyvista.Plotter(off_screen=True, window_size=[size, size * 3 // 4])
    plotter.set_background("white")
    for cut, colour in [(0, OUTSIDE), (1, INSIDE)]:
        part = kept.extract_cells(np.flatnonzero(kept.cell_data["cut"] == cut))
        if part.n_cells:
            plotter.add_mesh(part, color=colour, show_edges=True, edge_color="#30475e", line_width=1, ambient=0.15)
    plotter.view_vector(normal + np.array([0.5, 0.3, 0]), viewup=(0, 1, 0))
    plotter.camera.zoom(1.2)
    plotter.enable_anti_aliasing("ssaa")
    return plotter.screenshot(return_img=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("picture")
    parser.add_argument("--normal", type=float, nargs=3, default=[0, 0, 1])
    parser.add_argument("--at", type=float, default=0.58)
    parser.add_argument("--size", type=int, default=1100)
    arguments = parser.parse_args()
    image = Image.fromarray(picture(arguments.mesh, arguments.normal, arguments.at, arguments.size))
    # A palette keeps it small.
    data = io.BytesIO()
    image = image.crop(ImageChops.difference(image, Image.new("RGB", image.size, "white")).getbbox())
    image.quantize(64).save(data, "PNG", optimize=True)
    with open(arguments.picture, "wb") as file:
        file.write(data.getvalue())
    print(f"{arguments.picture}: {len(data.getvalue()) // 1000} kB")


if __name__ == "__main__":
    main()
