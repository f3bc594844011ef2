// How a picture is drawn on a GPU that a simulation computes on, too: in pieces, each in a gap between two of its steps
// (idl/gpu_page.h). Where there is no such simulation, all is drawn at once.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <osg/Referenced>
#include <osg/RenderInfo>

#include "idl/gpu_page.h"

namespace palp {

// Draws the k-th of n pieces of something.
using DrawPiece = std::function<void(int k, int n)>;

// Decides when each piece is drawn, and into how many pieces what is drawn next in a picture is cut: by how long it
// took in the pictures before. The thread that renders uses it.
class GpuPacing : public osg::Referenced {
 public:
  struct World {
    std::function<std::int64_t()> now_ns;
    std::function<void(std::int64_t)> sleep;  // [ns]
    std::function<void()> finish;             // waits for what OpenGL was told to do
  };
  GpuPacing(std::shared_ptr<GpuPage> page, World world);

  void begin_picture();
  // Draws a part of the picture in as many pieces as suit, at most so many, after what OpenGL was told to do since the
  // last one. When gaps are too short for a piece, or there are none, it waits for a while and then draws it all the
  // same: pictures come slowly, but they come.
  void draw(int most_pieces, const DrawPiece& piece);
  // In place of draw(), for a part that is left out of this picture: parts are known by their order.
  void skip();

  std::int64_t waited_ns() const { return waited_ns_; }  // for gaps, in this picture
  std::uint64_t late_pieces() const { return late_; }    // that were drawn without a gap
  bool shared() const { return shared_; }                // whether a simulation used the GPU at the last piece

 private:
  struct Part {                     // what is drawn by one call of draw(): how long it usually takes [ns]
    double before_ns = 0;           // what OpenGL was told since the part before
    std::vector<double> pieces_ns;  // each of its pieces
    bool drawn = false;             // the first time counts for nothing: shaders are compiled and textures made
  };
  double wanted_piece_ns() const;
  bool wait_for_gap(double piece_ns);
  void work(double& usual_ns, bool learns, const std::function<void()>& piece);
  void cut(Part& part, int most_pieces) const;

  std::shared_ptr<GpuPage> page_;
  World world_;
  std::vector<Part> parts_;  // in the order in which they are drawn
  std::size_t next_ = 0;
  std::int64_t waited_ns_ = 0;
  std::int64_t gap_ns_ = 0, seen_ns_ = 0;  // beginning of the gap that was drawn in last, and of the one seen last
  double usual_gap_ns_ = 500'000;
  std::uint64_t late_ = 0;
  bool shared_ = false;
};

// Draws in pieces where the context has a GpuPacing as its user data, else at once.
void in_pieces(osg::RenderInfo& info, int most_pieces, const DrawPiece& piece);
void skip_pieces(osg::RenderInfo& info);

// Returns the pacing of the current context's GPU; null where it has no identity, as a software rasteriser. Warns where
// there is one, and no page for it.
osg::ref_ptr<GpuPacing> pacing_of_current_gpu();
// The real clock, and OpenGL.
GpuPacing::World real_world();

}  // namespace palp
