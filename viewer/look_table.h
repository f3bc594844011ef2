// The looks of a scene's bodies as shaders take them.
#pragma once

#include <vector>

#include <osg/BoundingBox>
#include <osg/Texture2D>
#include <osg/Vec4f>
#include <osg/ref_ptr>

#include "idl/look.h"

namespace palp {

// The texture unit that the table has in every program that draws particles as media.
inline constexpr unsigned kLooksUnit = 6;

// Returns roughness, softness, reflection where one looks straight at it, and how much of a metal it is. Softness, 0 to
// nearly 1, is the scattering length against the few millimetres over which a surface turns from the light.
osg::Vec4f surface_numbers(const Look& look);

// Returns the axis along which wood of these bounds grows, its longest one, and its contrast.
osg::Vec4f grain_numbers(const Look& look, const osg::BoundingBox& box);

// Returns the look a share t, 0 .. 1, of the way from a to b.
Look between(const Look& a, const Look& b, float t);

// Rows of a texture, one for each look that differs. Calls from the thread that renders, between frames.
class LookTable {
 public:
  static constexpr int kRows = 128;
  // The bit of the byte with a particle's row that says that it is seen in a hollow alone (MirrorImages).
  static constexpr unsigned char kInHollow = 128;

  LookTable();
  osg::Texture2D* texture() const { return texture_; }
  void clear() { looks_.clear(); }
  // Returns the row of this look. Past kRows of them the last row serves.
  unsigned char row_of(const Look& look);
  // Returns the surface_numbers() of that row.
  osg::Vec4f surface_of(unsigned char row) const { return texel(1, row); }
  // Returns what the look of that row absorbs and its haze [1/m].
  osg::Vec4f depth_of(unsigned char row) const { return texel(0, row); }

 private:
  static constexpr int kColumns = 3;
  osg::Vec4f texel(int column, int row) const;

  std::vector<Look> looks_;
  osg::ref_ptr<osg::Texture2D> texture_;
};

}  // namespace palp
