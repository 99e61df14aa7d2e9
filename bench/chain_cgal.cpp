// CGAL's whole chain for a mesh of good tets: Mesh_3 refinement, ODT smoothing, perturbation, exudation.
//
// usage: chain_cgal SURFACE.off VERTICES
// Refines with one size for facets and cells until there are about that many vertices, which takes a few tries; only the last is
// timed. Prints: vertices, tets, smallest dihedral angle, 1st percentile and mean of each tet's smallest, seconds of the thread.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_polyhedron_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_3.h>
#include <CGAL/make_mesh_3.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iostream>
#include <limits>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polyhedron = CGAL::Mesh_polyhedron_3<Kernel>::type;
using Domain = CGAL::Polyhedral_mesh_domain_3<Polyhedron, Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
using namespace CGAL::parameters;

// Tries for the count, and how near it must come.
static const int tries = 8;
static const double near_enough = 0.02;

static double seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

static Complex refined(const Domain& domain, double size) {
  const Criteria criteria(facet_angle = 25, facet_size = size, facet_distance = 0.1 * size,
                          cell_radius_edge_ratio = 2, cell_size = size);
  return CGAL::make_mesh_3<Complex>(domain, criteria, no_perturb(), no_exude());
}

static double smallest_dihedral(const Triangulation& triangulation, Complex::Cell_handle cell) {
  const auto tet = triangulation.tetrahedron(cell);
  double smallest = 180;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      int k = 0;
      while (k == i || k == j) ++k;
      const int l = 6 - i - j - k;
      smallest = std::min(smallest, std::abs(CGAL::approximate_dihedral_angle(tet[i], tet[j], tet[k], tet[l])));
    }
  return smallest;
}

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: chain_cgal SURFACE.off VERTICES" << std::endl;
    return 2;
  }
  Polyhedron polyhedron;
  std::ifstream file(argv[1]);
  if (!(file >> polyhedron) || polyhedron.empty()) {
    std::cerr << argv[1] << ": no surface in the OFF format" << std::endl;
    return 1;
  }
  const double wanted = std::atof(argv[2]);
  const Domain domain(polyhedron);
  const auto box = domain.bbox();
  double size = std::cbrt((box.xmax() - box.xmin()) * (box.ymax() - box.ymin()) * (box.zmax() - box.zmin()) / wanted);
  Complex mesh;
  double refinement = 0;
  for (int k = 0; k < tries; ++k) {
    const double begun = seconds();
    mesh = refined(domain, size);
    refinement = seconds() - begun;
    const double ratio = mesh.triangulation().number_of_vertices() / wanted;
    if (std::abs(ratio - 1) < near_enough) break;
    size *= std::cbrt(ratio);
  }
  const double begun = seconds();
  CGAL::odt_optimize_mesh_3(mesh, domain);
  CGAL::perturb_mesh_3(mesh, domain);
  CGAL::exude_mesh_3(mesh);
  const double chain = refinement + seconds() - begun;

  std::vector<double> angles;
  for (auto cell = mesh.cells_in_complex_begin(); cell != mesh.cells_in_complex_end(); ++cell)
    angles.push_back(smallest_dihedral(mesh.triangulation(), cell));
  std::sort(angles.begin(), angles.end());
  double sum = 0;
  for (double angle : angles) sum += angle;
  std::cout << mesh.triangulation().number_of_vertices() << ' ' << angles.size() << ' ' << angles.front() << ' '
            << angles[angles.size() / 100] << ' ' << sum / angles.size() << ' ' << chain << std::endl;
}
