// Which particles of a body nobody sees, because the body's others surround them, and which are loose. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <osg/Array>
#include <osg/Vec3f>
#include <osg/Vec4f>

namespace palp {

// Space is parted into cells in which particles that are not torn apart always have a neighbour. A particle is within
// where all cells around its own, two deep, have particles: at least two layers of particles lie over it.
class Interior {
 public:
  static constexpr double kLumpOverSpacing = 1.5;  // the side of a lump, which is a cell
  static constexpr double kParticlesOfLump = kLumpOverSpacing * kLumpOverSpacing * kLumpOverSpacing;  // that fill it
  // Finds which of these places are within. x, y, z: finite [m]; w is not looked at. spacing: of the particles [m];
  // where it is no length, nothing is within. with_loose: finds what is loose, too.
  void find(std::span<const osg::Vec4f> places, double spacing, bool with_loose = false);
  // Returns true if the place of that index, of those that were given last, is within.
  bool contains(std::size_t index) const { return !cells_.empty() && has(bits_, cells_[index]); }

  // Return, where find() was asked for it, whether a place is loose, in or next to a cell in no block of 2x2x2 that all
  // have particles, and in none of 3x3x3 itself, as drops and thin sheets are; and whether its cell is next to such a
  // one.
  bool loose(std::size_t index) const { return !cells_.empty() && has(loose_, cells_[index]); }
  bool beside_loose(std::size_t index) const { return !cells_.empty() && has(beside_loose_, cells_[index]); }
  // The same of any place, which need not be finite.
  bool beside_loose(const osg::Vec3f& place) const;

  // Adds those within of the places that were given last as lumps, one a cell: their middle, and how many they are over
  // kParticlesOfLump.
  void add_lumps(std::span<const osg::Vec4f> places, osg::Vec4Array& to) const;

 private:
  static bool has(const std::vector<std::uint64_t>& bits, std::uint32_t cell) {
    return (bits[cell / 64] >> cell % 64 & 1u) != 0;
  }
  void find_loose();
  void lay_grid(std::span<const osg::Vec4f> places, double spacing);
  void erode();

  float low_[3] = {};         // corner of the grid [m]
  float per_metre_ = 0;       // cells
  std::size_t words_ = 0;     // of a row along x, a bit a cell
  std::size_t rows_[2] = {};  // along y and z
  std::vector<std::uint64_t> bits_, scratch_, loose_, beside_loose_;
  std::vector<std::uint32_t> cells_;  // of the places; empty: none is within
};

}  // namespace palp
