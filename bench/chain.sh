#!/bin/sh
# A whole run of tetcvt beside CGAL's chain of Mesh_3 refinement, ODT, perturbation and exudation at the same count, one thread each
# (needs g++, libcgal-dev, libgmp-dev, libmpfr-dev, python3).
# bench/chain.sh [SURFACE.obj] [VERTICES]
set -eu
surface=$(realpath "${1:-$(dirname "$0")/../models/bunny.obj}")
count=${2:-20000}
cd "$(dirname "$0")/.."
mkdir -p target/chain
if [ ! -x target/chain_cgal ] || [ bench/chain_cgal.cpp -nt target/chain_cgal ]; then
    g++ -O3 -march=native -DNDEBUG -std=c++17 bench/chain_cgal.cpp -o target/chain_cgal -lgmp -lmpfr
fi
cargo build --quiet --release
# CGAL reads OFF; vertices and triangles are all that it takes.
awk '$1 == "v" { v[++n] = $2 " " $3 " " $4 }
     $1 == "f" { for (i = 2; i <= 4; i++) { split($i, c, "/"); t[i] = c[1] - 1 } f[++m] = "3 " t[2] " " t[3] " " t[4] }
     END { print "OFF"; print n, m, 0; for (i = 1; i <= n; i++) print v[i]; for (i = 1; i <= m; i++) print f[i] }' \
    "$surface" > target/chain/surface.off
# Side by side: the same machine at the same time.
target/chain_cgal target/chain/surface.off "$count" > target/chain/cgal.txt &
cgal=$!
target/release/tetcvt -q "$surface" --seeds "$count" --threads 1 \
    -o target/chain/ours.vtu --surface target/chain/ours.vtp --json target/chain/ours.json
wait $cgal
python3 - target/chain/ours.json target/chain/cgal.txt <<'END'
import json
import sys

with open(sys.argv[1]) as file:
    report = json.load(file)
ours, seconds = report["mesh"], report["time"]["total"]
with open(sys.argv[2]) as file:
    vertices, tets, smallest, first, mean, chain = map(float, file.read().split())
print("mesher,vertices,tets,min_dihedral,mean_min_dihedral,seconds")
print(f"CGAL,{vertices:.0f},{tets:.0f},{smallest:.1f},{mean:.1f},{chain:.1f}")
print(f"tetcvt,{ours['vertices']},{ours['tets']},{ours['min_dihedral']:.1f},{ours['mean_min_dihedral']:.1f},{seconds:.1f}")
print(f"# tetcvt / CGAL: {seconds / chain:.3f}")
END
