// The surface of a soft body, which its particles carry along. Pure.
//
// A vertex is where the affine field lies that fits the places of the particles around it best (moving least squares:
// Lancaster & Salkauskas 1981; Mueller et al. 2004), whose weights depend on places at rest alone: x = sum N_j x_j with
// sum N_j = 1 and sum N_j X_j = X. So the surface follows whatever is affine exactly, half a spacing beyond the
// outermost particles, too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <osg/Vec3f>

namespace palp {

class Skin {
 public:
  // Binds vertices to particles. vertices, rest: where both are at rest [m], rest as x y z each; spacing: of the
  // particles [m], above 0. Returns nothing where some vertex has too few particles around it, or none off a plane, as
  // those of a sheet one particle thick. Any thread; tens of microseconds a vertex.
  static std::optional<Skin> bind(std::span<const osg::Vec3f> vertices, std::span<const float> rest, double spacing);

  std::size_t vertices() const { return first_.size() - 1; }
  std::size_t particles() const { return torn_.size(); }

  // Takes where the particles are now, x y z each [m], as many as particles(). Returns whether nothing is torn.
  bool find_tears(std::span<const float> places);
  // Return, for the places that were taken last, whether a vertex is beside a tear, where the surface ends, and whether
  // a particle is, which is to be drawn by itself then.
  bool torn(std::size_t vertex) const { return ends_[vertex] != 0; }
  bool bare(std::size_t particle) const { return bare_[particle] != 0; }

  // Writes where the vertices are, vertices() of them, among such places. Those beside a tear are anywhere.
  void carry(std::span<const float> places, std::span<osg::Vec3f> vertices) const;

 private:
  struct Weight {
    std::uint32_t particle;
    float share;  // N_j
  };
  struct Edge {
    std::uint32_t a, b;
    float longest2;  // the square of the length from which on it is torn [m^2]
  };

  void spread_bareness();

  std::vector<std::uint32_t> first_;  // by vertex, of weights_
  std::vector<Weight> weights_;
  std::vector<Edge> edges_;  // between particles that are next to each other at rest
  std::vector<unsigned char> torn_, bare_, reached_;
  std::vector<unsigned char> ends_;
};

}  // namespace palp
