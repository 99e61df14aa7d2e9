#!/usr/bin/env python3
"""Runs tetcvt again and again on models at random counts, threads and options, and judges what comes of it.

usage: soak.py EXE [--runs N] [--first I] [--random-seed S] [--most N] [--folder DIR] [--log FILE] MODEL...

Run i follows from S, i and the models alone: `--first i --runs 1` repeats it. Each run has `--check`, so that the program
verifies every invariant itself after every iteration. Right are: status 0, with a mesh of the asked count whose tets are
positive, whose vertices are all in use, and whose regions have closed boundaries without irregular edges; and the refusals,
statuses 1, 3 and 5, with a message. Everything else is a failure: a panic, a hang, wrong usage, an invalid mesh. Ends with
status 1 if there was one. Needs numpy and meshio.
"""
import argparse
import json
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import meshio
import numpy as np

MESH_FORMATS = ["vtu", "vtk", "msh", "mesh", "inp", "node"]
CURVED_FORMATS = ["vtu", "vtk", "msh", "inp"]
SURFACE_FORMATS = ["vtp", "vtk", "obj", "stl", "ply"]
LONGEST = 300  # seconds
FACETS = [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]


def options(rng, most):
    """Options of one run, and its count."""
    count = int(round(100 * (most / 100) ** (rng.random() ** 2)))
    chosen = ["--seeds", str(count), "--threads", str(rng.choice([1, 2, 3, 5])), "--random-seed", str(rng.randrange(10))]

    def maybe(share, *words):
        if rng.random() < share:
            chosen.extend(words)

    maybe(0.2, "--boundary", "free")
    maybe(0.5, "--start", rng.choice(["bcc", "blue", "random"]))
    maybe(0.5, "--optimizer", rng.choice(["lbfgs", "nesterov", "lloyd"]))
    maybe(0.5, "--update", rng.choice(["bicell", "paper", "vertex", "check", "rebuild"]))
    maybe(0.5, "--iterations", str(rng.choice([0, 1, 3, 10, 30])))
    maybe(0.2, "--tolerance", rng.choice(["0", "1e-3"]))
    maybe(0.3, "--feature-angle", str(rng.choice([5, 20, 60, 180])))
    maybe(0.1, "--time-limit", rng.choice(["0", "0.1", "1"]))
    maybe(0.2, "--repair")
    maybe(0.3, "--regions", "nested")
    if rng.random() < 0.2:
        chosen.append("--no-improve")
    else:
        maybe(0.2, "--min-dihedral", str(rng.choice([0, 20, 45, 60])))
    return chosen, count


def tets_of(path):
    """Points, tets (corners) and regions of a mesh file."""
    if path.suffix == ".node":
        points = np.loadtxt(path, skiprows=1, ndmin=2)[:, 1:4]
        rows = np.loadtxt(path.with_suffix(".ele"), skiprows=1, dtype=int, ndmin=2)
        return points, rows[:, 1:5], rows[:, 5]
    mesh = meshio.read(path)
    blocks = [i for i, c in enumerate(mesh.cells) if c.type in ("tetra", "tetra10")]
    tets = np.vstack([mesh.cells[i].data[:, :4] for i in blocks])
    for name in ("region", "gmsh:physical", "medit:ref"):
        if name in mesh.cell_data:
            return mesh.points, tets, np.concatenate([mesh.cell_data[name][i] for i in blocks])
    # Abaqus: a block for each region.
    return mesh.points, tets, np.concatenate([np.full(len(mesh.cells[i].data), k) for k, i in enumerate(blocks)])


def flaw(path, count):
    """What is wrong with a mesh; None where nothing is."""
    points, tets, regions = tets_of(path)
    used = np.unique(tets)
    if len(used) != count:
        return f"{len(used)} vertices in use, not {count}"
    corners = points[tets]
    size = np.abs(points[used] - points[used].mean(0)).max()
    edges = (corners[:, 1:] - corners[:, :1]) / size
    if not (np.einsum("ij,ij->i", np.cross(edges[:, 0], edges[:, 1]), edges[:, 2]) > 0).all():
        return "a tet is not positive"
    facets = np.sort(np.stack([tets[:, f] for f in FACETS], 1).reshape(-1, 3), 1)
    of_region = np.column_stack([np.repeat(regions, 4), facets])
    _, times = np.unique(facets, axis=0, return_counts=True)
    if times.max() > 2:
        return "a facet has more than two tets"
    for what, rows in [("mesh", np.column_stack([np.zeros(len(facets), int), facets])), ("region", of_region)]:
        rows, times = np.unique(rows, axis=0, return_counts=True)
        outer = rows[times == 1]
        ends = np.vstack([outer[:, [0, i, j]] for i, j in [(1, 2), (2, 3), (1, 3)]])
        _, around = np.unique(ends, axis=0, return_counts=True)
        if (around != 2).any():
            return f"{(around != 2).sum()} irregular edges on the boundary of a {what}"
    return None


def run(exe, models, index, arguments):
    """One run: its record, with what was wrong or None."""
    rng = random.Random(f"{arguments.random_seed} {index}")
    folder = Path(arguments.folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    model = rng.choice(models)
    chosen, count = options(rng, arguments.most)
    curved = rng.random() < 0.2
    output = folder / f"out.{rng.choice(CURVED_FORMATS if curved else MESH_FORMATS)}"
    surface = folder / f"surface.{rng.choice(SURFACE_FORMATS)}"
    chosen += ["--second-order"] * curved + ["-o", str(output), "--surface", str(surface), "--check", "-q"]
    if rng.random() < 0.3 and (output.suffix == ".msh" or surface.suffix in (".stl", ".ply")):
        chosen.append("--ascii")
    for option, name in [("--voronoi", "cells.vtu"), ("--delaunay", "all.vtu"), ("--json", "run.json"),
                         ("--trajectory", "way.npy")]:
        if rng.random() < 0.2:
            chosen += [option, str(folder / name)]
    command = [exe, str(model), *chosen]
    started = time.time()
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, cwd=folder)
    except subprocess.TimeoutExpired:
        return {"run": index, "command": command, "status": None, "wrong": f"no end after {LONGEST} s"}
    seconds = time.time() - started
    message = done.stderr.strip()
    wrong = None
    if done.returncode == 0:
        wrong = flaw(output, count)
        if wrong is None and output.suffix in (".vtu", ".vtk") and not curved and rng.random() < 0.3:
            # The mesh, carried on.
            again = [exe, str(model), "--init", str(output), "-o", str(folder / "again.vtu"), "--check", "-q",
                     *(["--repair"] if "--repair" in chosen else []),
                     *(["--regions", "nested"] if "nested" in chosen else [])]
            try:
                carried = subprocess.run(again, capture_output=True, text=True, timeout=LONGEST, cwd=folder)
                message = carried.stderr.strip()
                if carried.returncode == 0:
                    wrong = flaw(folder / "again.vtu", count)
                elif carried.returncode != 5 and not refuses_free(carried, chosen):
                    wrong = f"--init: status {carried.returncode}"
            except subprocess.TimeoutExpired:
                wrong = f"--init: no end after {LONGEST} s"
    elif done.returncode == 4 and "single precision" in message:
        pass
    elif done.returncode not in (1, 3, 5) or "panicked" in message or not message.startswith("error:"):
        lines = [line for line in message.splitlines() if line.startswith("error:")]
        if done.returncode not in (1, 3, 5) or not lines:
            wrong = f"status {done.returncode}"
    return {"run": index, "command": command, "status": done.returncode, "seconds": round(seconds, 2),
            "message": message[-600:], "wrong": wrong}


def refuses_free(carried, chosen):
    """Whether points of free seeds, which may be off the surface, were refused as a start."""
    return carried.returncode == 2 and "free" in chosen


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("exe")
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--random-seed", type=int, default=1)
    parser.add_argument("--most", type=int, default=5000, help="vertices at most")
    parser.add_argument("--folder", default="target/soak")
    parser.add_argument("--log")
    arguments = parser.parse_args()
    models = sorted(model.resolve() for model in arguments.models)
    arguments.folder = Path(arguments.folder).resolve()
    exe = str(Path(arguments.exe).resolve())
    log = open(arguments.log, "a") if arguments.log else None
    statuses, failures = {}, 0
    for index in range(arguments.first, arguments.first + arguments.runs):
        record = run(exe, models, index, arguments)
        statuses[record["status"]] = statuses.get(record["status"], 0) + 1
        if log:
            print(json.dumps(record), file=log, flush=True)
        if record["wrong"]:
            failures += 1
            print(f"run {index}: {record['wrong']}\n  {' '.join(record['command'])}\n  {record.get('message', '')}", flush=True)
    print(f"{arguments.runs} runs, {failures} failures; by exit status: {statuses}")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
