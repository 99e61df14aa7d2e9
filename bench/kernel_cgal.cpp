// The same points through CGAL: reads the points that bench/kernel.rs wrote, builds, and answers one line per request.
//
// Standard input, one request per line: "time FILE -" or "tets FILE OUT".
// Answers: nanoseconds of the thread and number of finite tets.
//
// Default_tds and default location policy: the cell base of a Delaunay triangulation, no hierarchy. The range constructor
// sorts the points spatially.

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel>;
using CellBase = CGAL::Delaunay_triangulation_cell_base_3<Kernel>;
using Numbered = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using WithInfo = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Numbered, CellBase>>;

static std::vector<Point> read_points(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<double> xyz(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(xyz.data()), static_cast<std::streamsize>(xyz.size() * sizeof(double)));
  std::vector<Point> points;
  points.reserve(xyz.size() / 3);
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) points.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
  return points;
}

// Time that this thread has spent computing.
static std::int64_t cpu_nanoseconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t{1000000000} * t.tv_sec + t.tv_nsec;
}

static void time_build(const std::vector<Point>& points) {
  const std::int64_t start = cpu_nanoseconds();
  const Triangulation triangulation(points.begin(), points.end());
  const std::int64_t ns = cpu_nanoseconds() - start;
  std::cout << ns << ' ' << triangulation.number_of_finite_cells() << std::endl;
}

static void write_tets(const std::vector<Point>& points, const std::string& path) {
  std::vector<std::pair<Point, std::uint32_t>> numbered;
  for (std::size_t i = 0; i < points.size(); ++i) numbered.emplace_back(points[i], static_cast<std::uint32_t>(i));
  const WithInfo triangulation(numbered.begin(), numbered.end());
  std::vector<std::array<std::uint32_t, 4>> tets;
  for (auto cell : triangulation.finite_cell_handles()) {
    std::array<std::uint32_t, 4> tet;
    for (int i = 0; i < 4; ++i) tet[i] = cell->vertex(i)->info();
    std::sort(tet.begin(), tet.end());
    tets.push_back(tet);
  }
  std::sort(tets.begin(), tets.end());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(tets.data()), static_cast<std::streamsize>(tets.size() * sizeof(tets[0])));
  file.close();
  std::cout << 0 << ' ' << tets.size() << std::endl;
}

int main() {
  std::string verb, path, argument;
  while (std::cin >> verb >> path >> argument) {
    const std::vector<Point> points = read_points(path);
    if (verb == "tets") {
      write_tets(points, argument);
    } else {
      time_build(points);
    }
  }
}
