// The same trajectory through CGAL: reads frames of a recorded trajectory, builds or moves, and answers one line per
// request of bench/trajectories.
//
// Standard input, one request per line:
//   open OFFSET SEEDS FILE   float64 triples from byte OFFSET on, SEEDS to a frame
//   build K                  builds the triangulation of frame K
//   move K                   builds that of frame K - 1 (not timed), and moves each vertex to its place in frame K
// Answers: nanoseconds of the thread and number of cells, infinite ones included; "0 0" to open.
//
// build: default data structure and location policy; the range constructor sorts the points spatially. The container of a
// triangulation gives its memory back when it is cleared, so malloc is told to keep it: later builds find it mapped.
//
// move: a vertex whose cells stay positive and locally Delaunay is moved in place; every other one goes by
// move_if_no_collision, which removes and inserts. This is the use that CGAL's own comment on move_if_no_collision
// proposes for small displacements; the test is written out here, as CGAL's is_delaunay_after_displacement does not look
// at the facets opposite the vertex.

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include <malloc.h>

#include <cstdint>
#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel>;
using CellBase = CGAL::Delaunay_triangulation_cell_base_3<Kernel>;
using Numbered = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using WithInfo = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Numbered, CellBase>>;

struct Trajectory {
  std::ifstream file;
  std::streamoff offset = 0;
  std::size_t seeds = 0;

  void open(const std::string& path, std::streamoff from, std::size_t count) {
    file.close();
    file.clear();
    file.open(path, std::ios::binary);
    offset = from;
    seeds = count;
  }

  std::vector<Point> frame(std::size_t k) {
    std::vector<double> xyz(3 * seeds);
    const auto bytes = static_cast<std::streamsize>(xyz.size() * sizeof(double));
    file.seekg(offset + static_cast<std::streamoff>(k) * bytes);
    file.read(reinterpret_cast<char*>(xyz.data()), bytes);
    std::vector<Point> points;
    if (!file) return points;
    points.reserve(seeds);
    for (std::size_t i = 0; i < xyz.size(); i += 3) points.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
    return points;
  }
};

// Time that this thread has spent computing.
static std::int64_t cpu_nanoseconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t{1000000000} * t.tv_sec + t.tv_nsec;
}

static void answer(std::int64_t ns, std::size_t cells) { std::cout << ns << ' ' << cells << std::endl; }

static void build(const std::vector<Point>& points) {
  const std::int64_t start = cpu_nanoseconds();
  const Triangulation triangulation(points.begin(), points.end());
  const std::int64_t ns = cpu_nanoseconds() - start;
  answer(ns, triangulation.number_of_cells());
}

// Whether the triangulation stays Delaunay with v at p; if so, v is there.
static bool moves_in_place(WithInfo& triangulation, WithInfo::Vertex_handle v, const Point& p,
                           std::vector<WithInfo::Cell_handle>& cells) {
  const Point old = v->point();
  cells.clear();
  triangulation.incident_cells(v, std::back_inserter(cells));
  v->set_point(p);
  bool stays = true;
  for (auto c = cells.begin(); stays && c != cells.end(); ++c) {
    const auto& cell = *c;
    stays = triangulation.is_infinite(cell) ||
            CGAL::orientation(cell->vertex(0)->point(), cell->vertex(1)->point(), cell->vertex(2)->point(),
                              cell->vertex(3)->point()) == CGAL::POSITIVE;
  }
  for (auto c = cells.begin(); stays && c != cells.end(); ++c) {
    for (int i = 0; stays && i < 4; ++i) {
      const auto neighbor = (*c)->neighbor(i);
      const auto opposite = neighbor->vertex(neighbor->index(*c));
      // A facet that v is a vertex of is met from both of its cells.
      if ((*c)->vertex(i) != v && &*neighbor < &**c) continue;
      if (triangulation.is_infinite(opposite)) {
        const auto apex = (*c)->vertex(i);
        stays = triangulation.is_infinite(apex) ||
                triangulation.side_of_sphere(neighbor, apex->point(), true) == CGAL::ON_UNBOUNDED_SIDE;
      } else {
        stays = triangulation.side_of_sphere(*c, opposite->point(), true) == CGAL::ON_UNBOUNDED_SIDE;
      }
    }
  }
  if (!stays) v->set_point(old);
  return stays;
}

static void move(const std::vector<Point>& from, const std::vector<Point>& to) {
  std::vector<std::pair<Point, std::uint32_t>> numbered;
  numbered.reserve(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) numbered.emplace_back(from[i], static_cast<std::uint32_t>(i));
  WithInfo triangulation(numbered.begin(), numbered.end());
  std::vector<WithInfo::Vertex_handle> vertices(from.size());
  for (auto v : triangulation.finite_vertex_handles()) vertices[v->info()] = v;

  std::vector<WithInfo::Cell_handle> cells;
  const std::int64_t start = cpu_nanoseconds();
  for (std::size_t i = 0; i < to.size(); ++i) {
    if (vertices[i]->point() == to[i]) continue;
    if (!moves_in_place(triangulation, vertices[i], to[i], cells)) triangulation.move_if_no_collision(vertices[i], to[i]);
  }
  const std::int64_t ns = cpu_nanoseconds() - start;
  answer(ns, triangulation.number_of_cells());
}

int main() {
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  Trajectory trajectory;
  std::string verb;
  while (std::cin >> verb) {
    if (verb == "open") {
      std::string path;
      std::streamoff offset = 0;
      std::size_t seeds = 0;
      std::cin >> offset >> seeds;
      std::cin.ignore();
      std::getline(std::cin, path);
      trajectory.open(path, offset, seeds);
      answer(0, 0);
      continue;
    }
    std::size_t k = 0;
    std::cin >> k;
    const std::vector<Point> to = trajectory.frame(k);
    const std::vector<Point> from = verb == "move" ? trajectory.frame(k - 1) : std::vector<Point>();
    if (to.empty() || (verb == "move" && from.empty())) {
      std::cout << "frame " << k << " cannot be read" << std::endl;
    } else if (verb == "move") {
      move(from, to);
    } else {
      build(to);
    }
  }
}
