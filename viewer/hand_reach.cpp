#include "viewer/hand_reach.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <system_error>

#include <osg/LineWidth>

#include "viewer/blending.h"
#include "viewer/metric.h"

namespace palp {
namespace {

constexpr std::string_view kBridge = "haptic_bridge ";
// Over the half of the box: where a side begins to show, and is whole.
constexpr double kReachFrom = 0.75, kReachWhole = 0.97;
constexpr float kGridOpacity = 0.7f, kEdgeOpacity = 0.9f;
// Cells of a side's grid along its length and across it, and how far from the hand its lines fade by 1 / e, over the
// longer half of the box. A grid, as a face would colour the liquid that it cuts.
constexpr unsigned kCells = 12;
constexpr double kFades = 0.45;
constexpr std::size_t kEdgeEnds = 8, kGridEnds = 2 * (kCells - 1) * kCells * 2;  // of a side's segments
constexpr float kClutchedShare = 0.5f;  // of all sides while the clutch is held
constexpr int kReachBin = 13;           // as the ghosts of tools

// Returns a place on a side, u and v from -1 to 1.
osg::Vec3d place_on(const HandReach& reach, std::size_t side, double u, double v) {
  const int axis = static_cast<int>(side / 2), across = (axis + 1) % 3, along = (axis + 2) % 3;
  osg::Vec3d at = reach.center;
  at[axis] += (side % 2 == 0 ? -1 : 1) * reach.half[axis];
  at[across] += u * reach.half[across];
  at[along] += v * reach.half[along];
  return at;
}

// Ends of a side's edges in turn.
osg::Vec3d edge_end(const HandReach& reach, std::size_t side, std::size_t end) {
  const std::size_t corner = (end + 1) / 2 % 4;
  return place_on(reach, side, corner == 0 || corner == 3 ? -1 : 1, corner < 2 ? -1 : 1);
}

// Ends of the segments of a side's lines in turn: those along u, then those along v.
osg::Vec3d grid_end(const HandReach& reach, std::size_t side, std::size_t end) {
  const std::size_t segment = end / 2, line = segment / kCells;
  const auto at = [](std::size_t cell) { return 2.0 * static_cast<double>(cell) / kCells - 1; };
  const double way = at(segment % kCells + end % 2), beside = at(line % (kCells - 1) + 1);
  return line < kCells - 1 ? place_on(reach, side, way, beside) : place_on(reach, side, beside, way);
}

osg::ref_ptr<osg::Geometry> make_part(std::size_t vertices) {
  osg::ref_ptr<osg::Geometry> part = new osg::Geometry;
  part->setUseVertexBufferObjects(true);
  part->setDataVariance(osg::Object::DYNAMIC);
  part->setCullingActive(false);
  part->setVertexArray(new osg::Vec3Array(static_cast<unsigned>(vertices)));
  part->setColorArray(new osg::Vec4Array(static_cast<unsigned>(vertices)), osg::Array::BIND_PER_VERTEX);
  return part;
}

}  // namespace

std::map<std::uint32_t, HandReach> reaches_of(const std::map<std::string, Status>& newest) {
  std::map<std::uint32_t, HandReach> reaches;
  for (const auto& [process, status] : newest) {
    std::uint32_t device = 0;
    if (!process.starts_with(kBridge)) continue;
    const char* const end = process.data() + process.size();
    const auto [at, error] = std::from_chars(process.data() + kBridge.size(), end, device);
    if (error != std::errc() || at != end) continue;
    const auto value = [&status = status](const char* name) { return metric(status, name).value_or(0); };
    const HandReach reach{{value("reach_x_m"), value("reach_y_m"), value("reach_z_m")},
                          {value("reach_half_x_m"), value("reach_half_y_m"), value("reach_half_z_m")},
                          value("clutch") > 0};
    if (reach.half.x() > 0 && reach.half.y() > 0 && reach.half.z() > 0) reaches[device] = reach;
  }
  return reaches;
}

std::array<float, 6> reach_shown(const HandReach& reach, const osg::Vec3d& handle) {
  std::array<float, 6> shown{};
  for (std::size_t side = 0; side < shown.size(); ++side) {
    const int axis = static_cast<int>(side / 2);
    const double way = (side % 2 == 0 ? -1 : 1) * (handle[axis] - reach.center[axis]) / reach.half[axis];
    const double share = std::clamp((way - kReachFrom) / (kReachWhole - kReachFrom), 0.0, 1.0);
    shown[side] = std::max(static_cast<float>(share), reach.clutched ? kClutchedShare : 0.0f);
  }
  return shown;
}

ReachBox::ReachBox(const osg::Vec4f& color)
    : color_(color), root_(new osg::Group), grid_(make_part(6 * kGridEnds)), edges_(make_part(6 * kEdgeEnds)) {
  grid_->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 6 * kGridEnds));
  edges_->addPrimitiveSet(new osg::DrawArrays(GL_LINES, 0, 6 * kEdgeEnds));
  edges_->getOrCreateStateSet()->setAttributeAndModes(new osg::LineWidth(2));
  osg::StateSet* state = root_->getOrCreateStateSet();
  blend_over(state);
  state->setRenderBinDetails(kReachBin, "RenderBin");
  root_->addChild(grid_);
  root_->addChild(edges_);
  root_->setNodeMask(0);
}

void ReachBox::set(const std::optional<HandReach>& reach, const osg::Vec3d& handle) {
  root_->setNodeMask(0);
  if (!reach || !handle.valid()) return;
  const std::array<float, 6> shown = reach_shown(*reach, handle);
  if (*std::ranges::max_element(shown) <= 0) return;
  const auto fill = [&](osg::Geometry& part, auto&& end_of, auto&& opacity_at) {
    auto& vertices = static_cast<osg::Vec3Array&>(*part.getVertexArray());
    auto& colors = static_cast<osg::Vec4Array&>(*part.getColorArray());
    const std::size_t each = vertices.size() / shown.size();
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const osg::Vec3d at = end_of(*reach, k / each, k % each);
      vertices[k] = at;
      colors[k] = osg::Vec4f(color_.x(), color_.y(), color_.z(), opacity_at(at) * shown[k / each]);
    }
    vertices.dirty();
    colors.dirty();
  };
  const double fades = kFades * std::max({reach->half.x(), reach->half.y(), reach->half.z()});
  fill(*grid_, grid_end, [&](const osg::Vec3d& at) {
    return kGridOpacity * static_cast<float>(std::exp(-(at - handle).length2() / (fades * fades)));
  });
  fill(*edges_, edge_end, [](const osg::Vec3d&) { return kEdgeOpacity; });
  root_->setNodeMask(~0u);
}

}  // namespace palp
