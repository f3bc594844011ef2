#include "viewer/touch_marks.h"

#include <algorithm>
#include <cmath>

#include <osg/BlendFunc>
#include <osg/ColorMask>
#include <osg/CullFace>
#include <osg/Depth>
#include <osg/PolygonOffset>
#include <osg/Stencil>

#include "viewer/refine.h"
#include "viewer/shadow_map.h"
#include "viewer/smooth_step.h"

namespace palp {
namespace {

// Over the spacing: a medium's first layer lies half a spacing off a wall, so that no place on the wall is farther than
// 0.87 from one of its particles; the second layer is 1.5 off.
constexpr float kTouchWhole = 0.9f, kTouchEnd = 1.2f;
// The cosine between a normal and the way to what touches there: of a medium's first layer something is seen at 0.57 or
// more; what is farther to the side is mostly behind another wall of the tool.
constexpr float kFacing = 0.3f;
constexpr double kFinestEdge = 0.75;
constexpr double kManyTriangles = 100'000;  // of a part, about: larger ones are marked less finely
constexpr float kOpacity = 0.85f, kHiddenOpacity = 0.45f;
constexpr int kReachedBin = 1;  // after solids, before media
constexpr int kMarkBin = 12;    // after all that may hide a mark, before what belongs to the hand

double area_of(const Surface& surface) {
  double area = 0;
  for (const Triangle& t : surface.triangles) area += static_cast<double>(t.area);
  return area;
}

// 1 where a mark is whole, 0 from where it ends.
float nearness(float spacings) { return smooth_step(kTouchEnd, kTouchWhole, spacings); }

// Returns what is drawn in that bin where it is before or behind what the picture has there.
osg::ref_ptr<osg::Geometry> make_marks(osg::Depth::Function where, int bin) {
  osg::ref_ptr<osg::Geometry> marks = new osg::Geometry;
  marks->setUseVertexBufferObjects(true);
  marks->setDataVariance(osg::Object::DYNAMIC);
  marks->setCullingActive(false);
  marks->getOrCreateStateSet()->setAttributeAndModes(new osg::Depth(where, 0, 1, false));
  marks->getOrCreateStateSet()->setRenderBinDetails(bin, "RenderBin");
  return marks;
}

}  // namespace

// While only solids are drawn, the stencil takes where none of them hides a mark; then what hides it is a medium.
TouchMarks::TouchMarks(double spacing)
    : spacing_(static_cast<float>(spacing)),
      root_(new osg::Group),
      reached_(make_marks(osg::Depth::LEQUAL, kReachedBin)),
      seen_(make_marks(osg::Depth::LEQUAL, kMarkBin)),
      hidden_(make_marks(osg::Depth::GREATER, kMarkBin)) {
  osg::StateSet* state = root_->getOrCreateStateSet();
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
  state->setAttributeAndModes(new osg::CullFace(osg::CullFace::BACK));
  state->setAttributeAndModes(new osg::PolygonOffset(-0.05f, -4));
  osg::ref_ptr<osg::Stencil> take = new osg::Stencil, ask = new osg::Stencil;
  take->setFunction(osg::Stencil::ALWAYS, 1, ~0u);
  take->setOperation(osg::Stencil::KEEP, osg::Stencil::KEEP, osg::Stencil::REPLACE);
  ask->setFunction(osg::Stencil::EQUAL, 1, ~0u);
  reached_->getOrCreateStateSet()->setAttributeAndModes(take);
  reached_->getOrCreateStateSet()->setAttributeAndModes(new osg::ColorMask(false, false, false, false));
  hidden_->getOrCreateStateSet()->setAttributeAndModes(ask);
  for (osg::Geometry* marks : {reached_.get(), seen_.get(), hidden_.get()}) root_->addChild(marks);
  hide();
}

void TouchMarks::add_part(const osg::Geometry& part) { uncut_.emplace_back(&part); }

void TouchMarks::cut_parts() {
  if (uncut_.empty()) return;
  for (const auto& part : uncut_) {
    Surface fine = surface_of(*part);
    // a triangle that is cut has about a quarter of the square of its longest edge
    refine(fine, std::max({kFinestEdge * static_cast<double>(spacing_), std::sqrt(4 * area_of(fine) / kManyTriangles),
                           1e-6}));
    const auto before = static_cast<unsigned>(surface_.vertices.size());
    surface_.vertices.insert(surface_.vertices.end(), fine.vertices.begin(), fine.vertices.end());
    for (Triangle triangle : fine.triangles) {
      for (unsigned& corner : triangle.corner) corner += before;
      surface_.triangles.push_back(triangle);
    }
  }
  uncut_.clear();
  normals_.assign(surface_.vertices.size(), {});
  areas_.assign(surface_.vertices.size(), 0);
  for (const Triangle& triangle : surface_.triangles) {
    for (const unsigned corner : triangle.corner) {
      normals_[corner] += triangle.normal * triangle.area;
      areas_[corner] += triangle.area / 3;
    }
  }
  for (osg::Vec3f& normal : normals_) normal.normalize();
  osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array(surface_.vertices.begin(), surface_.vertices.end());
  for (osg::Geometry* marks : {reached_.get(), seen_.get(), hidden_.get()}) {
    marks->setVertexArray(vertices);
    marks->setColorArray(new osg::Vec4ubArray(vertices->size()), osg::Array::BIND_PER_VERTEX);
    marks->getColorArray()->setNormalize(true);
    marks->removePrimitiveSet(0, marks->getNumPrimitiveSets());
    marks->addPrimitiveSet(new osg::DrawElementsUInt(GL_TRIANGLES));
  }
  const float reach = kTouchEnd * spacing_;
  const auto* first = surface_.vertices.empty() ? nullptr : surface_.vertices.front().ptr();
  cells_ = Cells({first, 3 * surface_.vertices.size()}, static_cast<double>(reach));
  box_.init();
  for (const osg::Vec3f& v : surface_.vertices)
    if (v.valid()) box_.expandBy(v);
  if (!box_.valid()) return;
  box_._min -= osg::Vec3f(reach, reach, reach);
  box_._max += osg::Vec3f(reach, reach, reach);
}

void TouchMarks::add(const osg::Vec3f& particle, float pressure) {
  const float reach = kTouchEnd * spacing_;
  cells_.around({particle.x(), particle.y(), particle.z()}, [&](std::size_t v) {
    const osg::Vec3f away = particle - surface_.vertices[v];
    if (!(away.length2() < reach * reach) || !(away * normals_[v] > kFacing * away.length())) return;
    const float near = nearness(away.length() / spacing_);
    touched_[v] = std::max(touched_[v], near);
    weights_[v] += near;
    pressure_[v] += near * pressure;
  });
}

Touch TouchMarks::set(const ParticleFrame& frame, std::span<const ParticleRange> media, const osg::Matrixd& pose,
                      const PressureColors* pressures) {
  cut_parts();
  for (std::vector<float>* values : {&touched_, &weights_, &pressure_}) values->assign(surface_.vertices.size(), 0);
  const std::size_t count = frame.positions.size() / 3;
  if (frame.scalars.size() != count) pressures = nullptr;
  osg::BoundingBoxd reached;  // in the world
  for (unsigned i = 0; i < 8 && box_.valid(); ++i) reached.expandBy(osg::Vec3d(box_.corner(i)) * pose);
  const osg::Matrixd to_body = osg::Matrixd::inverse(pose);
  for (const ParticleRange& range : media) {
    const std::size_t end = std::min<std::size_t>(count, std::size_t{range.first} + range.count);
    for (std::size_t i = range.first; i < end; ++i) {
      const float* p = frame.positions.data() + 3 * i;
      const osg::Vec3d place(p[0], p[1], p[2]);
      if (!reached.contains(place)) continue;
      const osg::Vec3f particle(place * to_body);
      const float pressure = pressures != nullptr ? frame.scalars[i] : 0;
      if (box_.contains(particle) && std::isfinite(pressure)) add(particle, pressure);
    }
  }
  Touch touch;
  double force = 0;
  for (std::size_t v = 0; v < touched_.size(); ++v) {
    if (weights_[v] > 0) pressure_[v] /= weights_[v];
    const double area = static_cast<double>(areas_[v]) * static_cast<double>(touched_[v]);
    touch.area += area;
    force += area * static_cast<double>(pressure_[v]);
  }
  if (pressures != nullptr && touch.area > 0) touch.pressure = force / touch.area;
  draw(pressures);
  return touch;
}

void TouchMarks::draw(const PressureColors* pressures) {
  root_->setNodeMask(0);
  if (surface_.triangles.empty()) return;
  const auto map = color_map(pressures != nullptr ? pressures->map : ColorMapKind::sequential);
  auto& seen = static_cast<osg::Vec4ubArray&>(*seen_->getColorArray());
  auto& hidden = static_cast<osg::Vec4ubArray&>(*hidden_->getColorArray());
  const auto byte = [](float share) { return static_cast<unsigned char>(std::lround(255 * share)); };
  for (std::size_t v = 0; v < touched_.size(); ++v) {
    Rgb8 color{byte(kTouchedColor[0]), byte(kTouchedColor[1]), byte(kTouchedColor[2])};
    if (pressures != nullptr) {
      const double share =
          (static_cast<double>(pressure_[v]) - pressures->range.low) / (pressures->range.high - pressures->range.low);
      color = map[static_cast<std::size_t>(std::lround((kColorMapSize - 1) * std::clamp(share, 0.0, 1.0)))];
    }
    seen[v] = {color.r, color.g, color.b, byte(kOpacity * touched_[v])};
    hidden[v] = {color.r, color.g, color.b, byte(kHiddenOpacity * touched_[v])};
  }
  std::vector<unsigned> drawn;
  for (const Triangle& triangle : surface_.triangles) {
    const auto& [a, b, c] = triangle.corner;
    if (touched_[a] + touched_[b] + touched_[c] > 0) drawn.insert(drawn.end(), {a, b, c});
  }
  for (osg::Geometry* marks : {reached_.get(), seen_.get(), hidden_.get()}) {
    static_cast<osg::DrawElementsUInt&>(*marks->getPrimitiveSet(0)).assign(drawn.begin(), drawn.end());
    marks->getPrimitiveSet(0)->dirty();
    marks->getColorArray()->dirty();
  }
  if (!drawn.empty()) root_->setNodeMask(~kCastsShadow);
}

}  // namespace palp
