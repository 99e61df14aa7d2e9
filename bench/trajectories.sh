#!/bin/sh
# The 3D experiments of the paper, ours and CGAL's, as tables and plots: see bench/README.md.
# CGAL needs g++, libcgal-dev, libgmp-dev, libmpfr-dev; without them its columns stay empty.
set -eu
cd "$(dirname "$0")/.."
mkdir -p target
source=bench/trajectories/cgal.cpp
program=target/trajectories_cgal
about="$(date -u +%F); $(sed -n 's/^model name[^:]*: *//p' /proc/cpuinfo 2>/dev/null | sort -u | head -n 1); $(rustc --version | cut -d' ' -f1,2)"
if [ ! -x $program ] || [ $source -nt $program ]; then
    # A failure leaves no old program behind.
    rm -f $program
    g++ -O3 -march=native -DNDEBUG -std=c++17 $source -o $program -lgmp -lmpfr ||
        echo "trajectories.sh: the CGAL part does not compile here" >&2
fi
if [ -x $program ]; then
    cgal=$(sed -n 's/^#define CGAL_VERSION \([0-9.]*\).*/CGAL \1/p' /usr/include/CGAL/version.h 2>/dev/null || true)
    set -- --cgal "$PWD/$program" --about "$about; ${cgal:-CGAL}, g++ -O3 -march=native" "$@"
else
    set -- --about "$about" "$@"
fi
exec cargo bench --quiet --bench trajectories -- "$@"
