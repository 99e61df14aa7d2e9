#!/bin/sh
# Compiles kernel_cgal.cpp where that is not done yet (needs g++, libcgal-dev, libgmp-dev, libmpfr-dev), and prints its path.
set -eu
cd "$(dirname "$0")/.."
mkdir -p target
if [ ! -x target/kernel_cgal ] || [ bench/kernel_cgal.cpp -nt target/kernel_cgal ]; then
    g++ -O3 -march=native -DNDEBUG -std=c++17 bench/kernel_cgal.cpp -o target/kernel_cgal -lgmp -lmpfr
fi
echo "$PWD/target/kernel_cgal"
