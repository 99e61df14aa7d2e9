#!/bin/sh
# Times whole iterations, and CGAL's triangulation of the same seeds as well (see kernel_cgal.sh for what that needs).
# bench/iteration.sh SURFACE [--seeds N] [--iterations K] [--last L] [--threads T]
set -eu
surface=$(realpath "$1")
shift
cd "$(dirname "$0")/.."
cgal=$(sh bench/kernel_cgal.sh)
exec cargo bench --quiet --bench iteration -- "$surface" --cgal "$cgal" "$@"
