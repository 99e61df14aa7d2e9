#!/bin/sh
# Times Delaunay::build against CGAL on the same points (needs g++, libcgal-dev, libgmp-dev, libmpfr-dev).
# bench/kernel.sh [--compare] [--only NAME]
set -eu
cd "$(dirname "$0")/.."
mkdir -p target
if [ ! -x target/kernel_cgal ] || [ bench/kernel_cgal.cpp -nt target/kernel_cgal ]; then
    g++ -O3 -march=native -DNDEBUG -std=c++17 bench/kernel_cgal.cpp -o target/kernel_cgal -lgmp -lmpfr
fi
exec cargo bench --quiet --bench kernel -- --cgal "$PWD/target/kernel_cgal" "$@"
