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
# Side by side: the same machine at the same time, each by the processor time of its one thread.
target/chain_cgal target/chain/surface.off "$count" > target/chain/cgal.txt &
cgal=$!
python3 - "$surface" "$count" > target/chain/ours.txt <<'END'
import json
import resource
import subprocess
import sys

folder = "target/chain"
subprocess.run(["target/release/tetcvt", "-q", sys.argv[1], "--seeds", sys.argv[2], "--threads", "1", "-o", f"{folder}/ours.vtu",
                "--surface", f"{folder}/ours.vtp", "--json", f"{folder}/ours.json"], check=True)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
with open(f"{folder}/ours.json") as file:
    mesh = json.load(file)["mesh"]
print(mesh["vertices"], mesh["tets"], mesh["min_dihedral"], mesh["mean_min_dihedral"], used.ru_utime + used.ru_stime)
END
wait $cgal
echo mesher,vertices,tets,min_dihedral,mean_min_dihedral,seconds
awk 'NR == 1 { printf "CGAL,%d,%d,%.1f,%.1f,%.2f\n", $1, $2, $3, $5, $6; chain = $6 }
     NR == 2 { printf "tetcvt,%d,%d,%.1f,%.1f,%.2f\n# tetcvt / CGAL: %.3f\n", $1, $2, $3, $4, $5, $5 / chain }' \
    target/chain/cgal.txt target/chain/ours.txt
