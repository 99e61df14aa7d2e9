#!/bin/sh
# Times Delaunay::build against CGAL on the same points (see kernel_cgal.sh for what that needs).
# bench/kernel.sh [--compare] [--only NAME]
set -eu
cd "$(dirname "$0")/.."
cgal=$(sh bench/kernel_cgal.sh)
exec cargo bench --quiet --bench kernel -- --cgal "$cgal" "$@"
