#include "viewer/refine.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace palp {
namespace {

constexpr std::size_t kMostTriangles = 1'000'000;
constexpr unsigned kNotHalved = ~0u;

}  // namespace

void refine(Surface& surface, double longest_edge) {
  const auto longest2 = static_cast<float>(longest_edge * longest_edge);
  bool halved = true;
  while (halved && surface.triangles.size() < kMostTriangles) {
    halved = false;
    std::map<std::pair<unsigned, unsigned>, unsigned> middles;  // by edge, so that both its triangles have the same one
    const auto middle_of = [&](unsigned a, unsigned b) {
      const osg::Vec3f from = surface.vertices[a], to = surface.vertices[b];
      if (!((to - from).length2() > longest2)) return kNotHalved;
      const auto [at, is_new] = middles.emplace(std::minmax(a, b), static_cast<unsigned>(surface.vertices.size()));
      if (is_new) surface.vertices.push_back((from + to) * 0.5f);
      return at->second;
    };
    std::vector<Triangle> before;
    before.swap(surface.triangles);
    for (const Triangle& t : before) {
      const auto add = [&](unsigned a, unsigned b, unsigned c) {
        Triangle part = t;
        part.corner = {a, b, c};
        part.area =
            0.5f * ((surface.vertices[b] - surface.vertices[a]) ^ (surface.vertices[c] - surface.vertices[a])).length();
        surface.triangles.push_back(part);
      };
      // the corners in turn, each followed by the middle of the edge to the next one where that is long
      std::vector<unsigned> around;
      for (std::size_t k = 0; k < 3; ++k) {
        around.push_back(t.corner[k]);
        if (const unsigned m = middle_of(t.corner[k], t.corner[(k + 1) % 3]); m != kNotHalved) around.push_back(m);
      }
      halved = halved || around.size() > 3;
      // cuts off the corner between two middles until a triangle is left; with one middle, a line from it to the corner
      // across
      while (around.size() > 3) {
        const auto is_corner = [&](unsigned v) { return std::ranges::find(t.corner, v) != t.corner.end(); };
        const std::size_t n = around.size();
        std::size_t k = 0;
        while (k < n && !(is_corner(around[k]) && !is_corner(around[(k + 1) % n]) &&
                          (n == 4 || !is_corner(around[(k + n - 1) % n]))))
          ++k;
        add(around[(k + n - 1) % n], around[k], around[(k + 1) % n]);
        around.erase(around.begin() + static_cast<std::ptrdiff_t>(k));
      }
      add(around[0], around[1], around[2]);
    }
  }
}

}  // namespace palp
