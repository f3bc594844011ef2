#include "viewer/particle_cloud.h"

#include <algorithm>
#include <cmath>

#include <osg/Image>
#include <osg/PointSprite>
#include <osg/PrimitiveSet>

#include "viewer/shaders.h"

namespace palp {
namespace {

// A little more than half the spacing: neighbours touch and overlap slightly, and the fluid looks whole.
constexpr double kRadiusOverSpacing = 0.58;

osg::ref_ptr<osg::Image> map_image(ColorMapKind kind) {
  osg::ref_ptr<osg::Image> image = new osg::Image;
  image->allocateImage(kColorMapSize, 1, 1, GL_RGB, GL_UNSIGNED_BYTE);
  const auto map = color_map(kind);
  for (int i = 0; i < kColorMapSize; ++i) {
    unsigned char* pixel = image->data(static_cast<unsigned>(i));
    const Rgb8 c = map[static_cast<std::size_t>(i)];
    pixel[0] = c.r;
    pixel[1] = c.g;
    pixel[2] = c.b;
  }
  return image;
}

constexpr float kNoScalar = -3e38f;  // the shader colours such a particle by its body

bool deforms(BodyKind kind) { return kind == BodyKind::fluid || kind == BodyKind::elastic; }

// Solids that do not deform have a speed and a temperature, but their density and pressure are aids of the solver.
bool has_field(BodyKind kind, ScalarField field) {
  return deforms(kind) || (field != ScalarField::density && field != ScalarField::pressure);
}

osg::Vec4ub to_bytes(const std::array<float, 3>& color) {
  const auto byte = [](float v) { return static_cast<unsigned char>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); };
  return {byte(color[0]), byte(color[1]), byte(color[2]), 255};
}

}  // namespace

ParticleCloud::ParticleCloud() : switch_(new osg::Switch), map_(new osg::Texture1D) {
  map_->setImage(map_image(map_kind_));
  map_->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
  map_->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
  map_->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
  map_->setResizeNonPowerOfTwoHint(false);

  osg::StateSet* state = switch_->getOrCreateStateSet();
  state->setAttributeAndModes(load_program("particle", {"particle.vert", "particle.frag", "lighting.glsl"}));
  state->setTextureAttributeAndModes(0, new osg::PointSprite);
  state->setTextureAttribute(0, map_);
  state->setMode(GL_VERTEX_PROGRAM_POINT_SIZE, osg::StateAttribute::ON);
  state->setMode(GL_SAMPLE_ALPHA_TO_COVERAGE, osg::StateAttribute::ON);
  state->addUniform(new osg::Uniform("color_map", 0));
  state->addUniform(new osg::Uniform("radius", 0.01f));
  state->addUniform(new osg::Uniform("picture_height", 720.0f));
  state->addUniform(new osg::Uniform("by_scalar", false));
  state->addUniform(new osg::Uniform("value_range", osg::Vec2f(0, 1)));
  state->setRenderBinDetails(1, "RenderBin");
  switch_->setCullingActive(false);

  for (auto& set : sets_) {
    set = new osg::Geometry;
    set->setUseDisplayList(false);
    set->setUseVertexBufferObjects(true);
    set->setCullingActive(false);
    osg::ref_ptr<osg::Vec4Array> vertices = new osg::Vec4Array;
    osg::ref_ptr<osg::Vec4ubArray> colors = new osg::Vec4ubArray;
    colors->setNormalize(true);
    set->setVertexArray(vertices);
    set->setColorArray(colors, osg::Array::BIND_PER_VERTEX);
    // positions change with every frame and colours seldom: separate buffers, so that only what changed is sent
    vertices->setVertexBufferObject(new osg::VertexBufferObject);
    vertices->getVertexBufferObject()->setUsage(GL_STREAM_DRAW);
    colors->setVertexBufferObject(new osg::VertexBufferObject);
    switch_->addChild(set, false);
  }
}

void ParticleCloud::set_scene(const SceneDescription& scene) {
  bodies_.clear();
  for (const BodyDescription& body : scene.bodies) {
    const bool surface = !body.vertices.empty() && !body.triangles.empty();
    bodies_.push_back({body.kind, body.first, body.count, body.density, body.color, surface});
  }
  rest_density_ = 0;
  for (const Body& body : bodies_) {
    if (!deforms(body.kind)) continue;
    const bool first = rest_density_ == 0;
    rest_density_ = first || rest_density_ == body.density ? body.density : -1;
  }
  switch_->getStateSet()->getUniform("radius")->set(static_cast<float>(kRadiusOverSpacing * scene.spacing));
  steady_ = {};
  clear();
  for (auto& set : sets_) static_cast<osg::Vec4ubArray*>(set->getColorArray())->clear();
}

void ParticleCloud::set_picture_height(int height) {
  switch_->getStateSet()->getUniform("picture_height")->set(static_cast<float>(height));
}

void ParticleCloud::clear() {
  switch_->setAllChildrenOff();
  drawn_ = 0;
}

void ParticleCloud::choose_runs(std::size_t count) {
  runs_.clear();
  for (const Body& body : bodies_) {
    if (!draw_all_ && body.has_surface) continue;
    const std::size_t first = std::min<std::size_t>(body.first, count);
    const std::size_t n = std::min<std::size_t>(body.count, count - first);
    if (n > 0) runs_.emplace_back(static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(n));
  }
}

// Returns the values of fluids and deformable bodies, or of all that is drawn where there are none: walls and tools
// must not stretch the range.
std::vector<float> ParticleCloud::values_for_range(const ParticleFrame& frame) const {
  std::vector<float> values;
  for (const bool all : {false, true}) {
    for (const Body& body : bodies_) {
      if (!all && !deforms(body.kind)) continue;
      if (!draw_all_ && body.has_surface) continue;
      const std::size_t first = std::min<std::size_t>(body.first, frame.scalars.size());
      const std::size_t n = std::min<std::size_t>(body.count, frame.scalars.size() - first);
      const auto begin = frame.scalars.begin() + static_cast<std::ptrdiff_t>(first);
      values.insert(values.end(), begin, begin + static_cast<std::ptrdiff_t>(n));
    }
    if (!values.empty()) break;
  }
  return values;
}

void ParticleCloud::choose_colors(const ParticleFrame& frame) {
  const bool carried =
      !frame.scalars.empty() && 3 * frame.scalars.size() == frame.positions.size() && frame.field == wanted_;
  shown_ = carried ? wanted_ : ScalarField::none;
  osg::StateSet* state = switch_->getStateSet();
  state->getUniform("by_scalar")->set(shown_ != ScalarField::none);
  if (shown_ == ScalarField::none) return;

  range_ = steady_.update(shown_, suitable_range(shown_, values_for_range(frame), rest_density_));
  state->getUniform("value_range")->set(osg::Vec2f(static_cast<float>(range_.low), static_cast<float>(range_.high)));
  if (map_kind_ != color_map_of(shown_)) {
    map_kind_ = color_map_of(shown_);
    map_->setImage(map_image(map_kind_));
  }
}

void ParticleCloud::set_frame(const ParticleFrame& frame) {
  const std::size_t count = frame.positions.size() / 3;
  const bool with_scalar = frame.scalars.size() == count;
  choose_runs(count);
  choose_colors(frame);

  osg::Geometry& set = *sets_[next_];
  auto& vertices = static_cast<osg::Vec4Array&>(*set.getVertexArray());
  auto& colors = static_cast<osg::Vec4ubArray&>(*set.getColorArray());
  vertices.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const float* p = frame.positions.data() + 3 * i;
    vertices[i].set(p[0], p[1], p[2], with_scalar ? frame.scalars[i] : 0.0f);
  }
  for (const Body& body : bodies_) {
    if (has_field(body.kind, shown_)) continue;
    const std::size_t end = std::min<std::size_t>(std::size_t{body.first} + body.count, count);
    for (std::size_t i = body.first; i < end; ++i) vertices[i].w() = kNoScalar;
  }
  vertices.dirty();
  if (colors.size() != count) {
    colors.assign(count, osg::Vec4ub(200, 200, 200, 255));
    for (const Body& body : bodies_) {
      const std::size_t first = std::min<std::size_t>(body.first, count);
      const std::size_t n = std::min<std::size_t>(body.count, count - first);
      std::fill_n(colors.begin() + static_cast<std::ptrdiff_t>(first), n, to_bytes(body.color));
    }
    colors.dirty();
  }
  set.removePrimitiveSet(0, set.getNumPrimitiveSets());
  drawn_ = 0;
  for (const auto& [first, n] : runs_) {
    set.addPrimitiveSet(new osg::DrawArrays(GL_POINTS, static_cast<GLint>(first), static_cast<GLsizei>(n)));
    drawn_ += n;
  }
  switch_->setSingleChildOn(static_cast<unsigned>(next_));
  next_ = (next_ + 1) % kSets;
}

}  // namespace palp
