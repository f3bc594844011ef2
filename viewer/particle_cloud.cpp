#include "viewer/particle_cloud.h"

#include <algorithm>
#include <cmath>

#include <osg/Image>
#include <osg/PointSprite>

#include "viewer/home_view.h"
#include "viewer/mesh.h"
#include "viewer/points.h"
#include "viewer/shaders.h"
#include "viewer/spray.h"

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

// Coordinates [m] beyond this are faults: nothing so far out is drawn.
constexpr float kFarthest = 1e5f;

constexpr std::size_t kStages = 32;  // between two looks: bodies mix those of their neighbours, so that no step is seen

constexpr float kNoScalar = -3e38f;  // the shader colours such a particle by its body
constexpr float kWhole = 1;          // where colours do not stand for numbers: all of a particle is part of the surface

bool deforms(BodyKind kind) { return kind == BodyKind::fluid || kind == BodyKind::elastic; }

// Solids that do not deform have a speed and a temperature, but their density and pressure are aids of the solver.
bool has_field(BodyKind kind, ScalarField field) {
  const bool of_density =
      field == ScalarField::density || field == ScalarField::density_error || field == ScalarField::pressure;
  return deforms(kind) || !of_density;
}

// The fourth byte says which look it has.
osg::Vec4ub to_bytes(const std::array<float, 3>& color, unsigned char look) {
  const auto byte = [](float v) { return static_cast<unsigned char>(std::lround(255 * std::clamp(v, 0.0f, 1.0f))); };
  return {byte(color[0]), byte(color[1]), byte(color[2]), look};
}

}  // namespace

ParticleCloud::ParticleCloud() : shared_(new osg::StateSet), map_(new osg::Texture1D) {
  map_->setImage(map_image(map_kind_));
  map_->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
  map_->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
  map_->setWrap(osg::Texture::WRAP_S, osg::Texture::CLAMP_TO_EDGE);
  map_->setResizeNonPowerOfTwoHint(false);
  shared_->addUniform(new osg::Uniform("by_scalar", false));
  shared_->addUniform(new osg::Uniform("value_range", osg::Vec2f(0, 1)));
  shared_->addUniform(new osg::Uniform("looks", static_cast<int>(kLooksUnit)));
  shared_->setTextureAttribute(kLooksUnit, looks_.texture());

  for (auto* node : {&switches_[0], &switches_[1], &switches_[2], &lumps_switch_}) {
    *node = new osg::Switch;
    (*node)->setCullingActive(false);
  }
  const auto side = static_cast<float>(Interior::kLumpOverSpacing);
  lumps_switch_->getOrCreateStateSet()->addUniform(new osg::Uniform("lump_over_spacing", side));
  osg::StateSet* state = points(Medium::beads)->getOrCreateStateSet();
  state->setAttributeAndModes(load_program(
      "particle", {"particle.vert", "sprite.glsl", "color.glsl", "particle.frag", "color.glsl", "lighting.glsl"}));
  state->setTextureAttributeAndModes(0, new osg::PointSprite);
  state->setTextureAttribute(0, map_);
  state->setMode(GL_VERTEX_PROGRAM_POINT_SIZE, osg::StateAttribute::ON);
  state->setMode(GL_SAMPLE_ALPHA_TO_COVERAGE, osg::StateAttribute::ON);
  state->addUniform(new osg::Uniform("color_map", 0));
  state->addUniform(new osg::Uniform("radius", 0.01f));
  state->addUniform(new osg::Uniform("picture_height", 720.0f));
  state->setRenderBinDetails(1, "RenderBin");

  for (Set& set : sets_) {
    set.vertices = new StreamedArray<osg::Vec4Array>;
    set.colors = new StreamedArray<osg::Vec4ubArray>;
    set.colors->setNormalize(true);
    const auto add_points = [&set](osg::Switch& to) {
      osg::ref_ptr<osg::Geometry> geometry = new Points(set.vertices, set.colors);
      to.addChild(geometry, false);
      return geometry;
    };
    for (std::size_t m = 0; m < kMediums; ++m) set.points[m] = add_points(*switches_[m]);
    set.clear_lumps = add_points(*lumps_switch_);
  }
}

void ParticleCloud::set_scene(const SceneDescription& scene) {
  bodies_.clear();
  looks_.clear();
  // rows that are left when each body has one, shared among those that can change
  const std::size_t rows = LookTable::kRows - std::min<std::size_t>(LookTable::kRows, scene.bodies.size());
  const auto changing = static_cast<std::size_t>(std::ranges::count_if(scene.bodies, changes_look));
  const std::size_t stages = std::clamp<std::size_t>(rows / std::max<std::size_t>(1, changing), 1, kStages);
  for (const BodyDescription& body : scene.bodies) {
    bodies_.push_back({body.kind, body.first, body.count, body.density, has_surface(body), usual_medium(body),
                       foams(body), tints_of(body, changes_look(body) ? stages : 1), nullptr});
  }
  rest_density_ = 0;
  for (const Body& body : bodies_) {
    if (!deforms(body.kind)) continue;
    const bool first = rest_density_ == 0;
    rest_density_ = first || rest_density_ == body.density ? body.density : -1;
  }
  points(Medium::beads)
      ->getStateSet()
      ->getUniform("radius")
      ->set(static_cast<float>(kRadiusOverSpacing * scene.spacing));
  spacing_ = scene.spacing;
  spray_.set_spacing(spacing_);
  steady_ = {};
  clear();
}

std::vector<osg::Vec4ub> ParticleCloud::tints_of(const BodyDescription& body, std::size_t stages) {
  std::vector<osg::Vec4ub> tints;
  for (std::size_t k = 0; k < stages; ++k) {
    const float t = stages > 1 ? static_cast<float>(k) / static_cast<float>(stages - 1) : 0;
    std::array<float, 3> color{};
    for (std::size_t c = 0; c < 3; ++c) color[c] = std::lerp(body.color[c], body.changed_color[c], t);
    tints.push_back(to_bytes(color, looks_.row_of(between(body.look, body.changed_look, t))));
  }
  return tints;
}

void ParticleCloud::set_reading(const Reading& reading, const osg::Vec4d& clip) {
  reading_ = reading;
  clip_ = clip;
}

void ParticleCloud::set_picture_height(int height) {
  points(Medium::beads)->getStateSet()->getUniform("picture_height")->set(static_cast<float>(height));
  spray_.set_picture_height(height);
}

void ParticleCloud::clear() {
  for (auto& node : switches_) node->setAllChildrenOff();
  lumps_switch_->setAllChildrenOff();
  for (osg::BoundingBoxd& box : boxes_) box.init();
  for (auto& tints : tints_) tints.clear();
  drawn_ = 0;
  seen_ = 0;
  spray_.clear();
}

std::optional<OneTint> ParticleCloud::one_tint(Medium medium) const {
  if (shown_ != ScalarField::none) return OneTint{};
  const std::vector<osg::Vec4ub>& tints = tints_[static_cast<std::size_t>(medium)];
  if (tints.size() != 1) return std::nullopt;
  const osg::Vec4ub& t = tints[0];
  const osg::Vec4f surface = looks_.surface_of(t.a()), depth = looks_.depth_of(t.a());
  if (medium == Medium::opaque) return OneTint{osg::Vec3f(t.r(), t.g(), t.b()) / 255, surface};
  return OneTint{{depth.x(), depth.y(), depth.z()}, {surface.x(), depth.w(), surface.z(), surface.w()}};
}

// Returns how the particles of a body are drawn now, or nothing where its surface stands for them. Colours that stand
// for numbers must not be looked through.
std::optional<Medium> ParticleCloud::medium_of(const Body& body) const {
  if (!draw_all_ && body.has_surface) return std::nullopt;
  if (draw_all_ || beads_ || body.medium == Medium::beads) return Medium::beads;
  return shown_ == ScalarField::none ? body.medium : Medium::opaque;
}

// Returns the values of fluids and deformable bodies, or of all that is drawn where there are none: walls and tools
// must not stretch the range.
std::vector<float> ParticleCloud::values_for_range(const ParticleFrame& frame) const {
  std::vector<float> values;
  for (const bool all : {false, true}) {
    for (const Body& body : bodies_) {
      if (!all && !deforms(body.kind)) continue;
      if (!draw_all_ && body.has_surface) continue;
      const std::span<const float> part = part_of(body, frame.scalars, 1);
      values.insert(values.end(), part.begin(), part.end());
    }
    if (!values.empty()) break;
  }
  return values;
}

// Returns whether the frame has a value of the field that is wanted for each particle.
bool ParticleCloud::carries_wanted(const ParticleFrame& frame) const {
  return !frame.scalars.empty() && 3 * frame.scalars.size() == frame.positions.size() && frame.field == wanted_;
}

bool ParticleCloud::takes_skins(const ParticleFrame& frame) const {
  const bool by_number = wanted_ != ScalarField::none && carries_wanted(frame);
  return !draw_all_ && !beads_ && !by_number && clip_ == kNoClip;
}

void ParticleCloud::choose_colors(const ParticleFrame& frame) {
  shown_ = carries_wanted(frame) ? wanted_ : ScalarField::none;
  shared_->getUniform("by_scalar")->set(shown_ != ScalarField::none);
  if (shown_ == ScalarField::none) return;

  const std::optional<ValueRange>& held = reading_.held_of(shown_);
  range_ = held ? *held : steady_.update(shown_, suitable_range(shown_, values_for_range(frame), rest_density_));
  shared_->getUniform("value_range")->set(osg::Vec2f(static_cast<float>(range_.low), static_cast<float>(range_.high)));
  if (map_kind_ != reading_.map_of(shown_)) {
    map_kind_ = reading_.map_of(shown_);
    map_->setImage(map_image(map_kind_));
  }
}

// Finds which places of a body are drawn: not those beyond the cut, nor what is no place. And which tint is theirs.
void ParticleCloud::find_seen(const Body& body, const ParticleFrame& frame) {
  const std::size_t count = frame.positions.size() / 3, first = body.first;
  const std::span<const float> positions = part_of(body, frame.positions, 3);
  const std::size_t end = first + positions.size() / 3;
  const bool with_scalar = shown_ != ScalarField::none && frame.scalars.size() == count && has_field(body.kind, shown_);
  const float otherwise = shown_ == ScalarField::none ? kWhole : kNoScalar;
  const bool whole = clip_ == kNoClip;
  const bool changes = body.tints.size() > 1 && frame.solid.size() == count;
  const auto last_stage = static_cast<unsigned>(body.tints.size() - 1);
  const bool with_spray = flies(body);
  places_.clear();
  stages_.clear();
  left_out_.clear();
  places_.reserve(end - first);
  for (std::size_t i = first; i < end; ++i) {
    if (body.skin != nullptr && !body.skin->bare(i - first)) continue;
    const float* p = &positions[3 * (i - first)];
    const bool is_place = std::abs(p[0]) < kFarthest && std::abs(p[1]) < kFarthest && std::abs(p[2]) < kFarthest;
    if (!is_place || !(whole || keeps(clip_, osg::Vec3d(p[0], p[1], p[2])))) {
      if (with_spray) left_out_.push_back(static_cast<std::uint32_t>(i - first));
      continue;
    }
    const bool has_scalar = with_scalar && std::isfinite(frame.scalars[i]);
    places_.emplace_back(p[0], p[1], p[2], has_scalar ? frame.scalars[i] : otherwise);
    if (!changes) continue;
    const unsigned changed = body.kind == BodyKind::fluid ? frame.solid[i] : 255u - frame.solid[i];
    stages_.push_back(static_cast<unsigned char>((changed * last_stage + 127) / 255));
  }
  interior_.find(places_, spacing_, with_spray);
  drawn_ += end - first;
}

std::span<const float> ParticleCloud::part_of(const Body& body, std::span<const float> values, std::size_t each) {
  const std::size_t count = values.size() / each, first = std::min<std::size_t>(body.first, count);
  return values.subspan(each * first, each * std::min<std::size_t>(body.count, count - first));
}

// Makes drops of the places that fly alone: as much of them as is a drop is no part of the surface.
void ParticleCloud::let_fly(const Body& body, const ParticleFrame& frame, const ParticleFrame* earlier) {
  std::vector<std::span<const float>> others;
  for (const Body& other : bodies_)
    if (&other != &body && other.kind == BodyKind::fluid) others.push_back(part_of(other, frame.positions, 3));
  std::size_t before = 0;  // of those left out
  for (const Flying& drop : find_flying(places_, interior_, spacing_, others)) {
    while (before < left_out_.size() && left_out_[before] <= drop.place + before) ++before;
    const std::size_t particle = body.first + drop.place + before;
    const osg::Vec3f v = velocity_of(particle, frame, earlier);
    osg::Vec4f& place = places_[drop.place];
    place.w() = kWhole - drop.alone;
    spray_.add({place.x(), place.y(), place.z(), drop.alone}, {v.x(), v.y(), v.z(), whiteness(drop.airy, v.length())},
               body.tints[stages_.empty() ? 0 : stages_[drop.place]], particle);
  }
}

// Adds the places that can be seen to those of their medium, and where the body is looked through lumps of the others.
void ParticleCloud::add_body(const Body& body, Medium medium, Set& set) {
  Outer& outer = outer_[static_cast<std::size_t>(medium)];
  const std::size_t before = outer.places.size();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (interior_.contains(i)) continue;
    outer.places.push_back(places_[i]);
    outer.tints.push_back(body.tints[stages_.empty() ? 0 : stages_[i]]);
  }
  if (outer.places.size() == before) return;
  if (medium != Medium::beads) {
    note_tints(body, medium);
    add_images(before, medium);
  }
  if (medium != Medium::clear) return;
  const std::size_t first = set.vertices->size();
  if (stages_.empty())
    interior_.add_lumps(places_, *set.vertices);
  else
    add_within(body, set);
  set.colors->resize(set.vertices->size(), body.tints[0]);
  if (const std::size_t lumps = set.vertices->size() - first; lumps > 0)
    set.clear_lumps->addPrimitiveSet(
        new osg::DrawArrays(GL_POINTS, static_cast<GLint>(first), static_cast<GLsizei>(lumps)));
}

// Adds the mirror images of the places of a medium from that one on.
void ParticleCloud::add_images(std::size_t from, Medium medium) {
  if (clip_ != kNoClip) return;
  Outer& outer = outer_[static_cast<std::size_t>(medium)];
  const std::size_t end = outer.places.size();
  std::vector<osg::Vec3f> images;
  for (const StandingSolid& solid : solids_) {
    const osg::BoundingBox& box = solid.images->box();
    const osg::Matrixf to_world(solid.pose), to_solid(osg::Matrixd::inverse(solid.pose));
    osg::BoundingBox reached;  // in the world, which passes most particles over
    for (unsigned k = 0; k < 8 && box.valid(); ++k) reached.expandBy(box.corner(k) * to_world);
    for (std::size_t i = from; i < end; ++i) {
      const osg::Vec4f place = outer.places[i];
      const osg::Vec3f in_world(place.x(), place.y(), place.z());
      if (!reached.contains(in_world)) continue;
      images.clear();
      if (solid.images->add_of(in_world * to_solid, images)) outer.tints[i].a() |= LookTable::kInHollow;
      for (const osg::Vec3f& image : images) {
        outer.places.emplace_back(image * to_world, place.w());
        outer.tints.push_back(outer.tints[i]);
      }
    }
  }
}

// Adds the places of a medium that can be seen, what is near the home view first. The camera's way of looking would do
// better from other sides, but then the last bit of a picture depended on the camera of the one before.
void ParticleCloud::add_outer(Medium medium, Set& set) {
  const auto m = static_cast<std::size_t>(medium);
  const Outer& outer = outer_[m];
  if (outer.places.empty()) return;
  osg::Vec3f along(-kHomeSide);
  along.normalize();
  const std::span<const std::uint32_t> ranks = front_to_back_.rank(outer.places, along);
  const std::size_t first = set.vertices->size(), count = outer.places.size();
  set.vertices->resize(first + count);
  set.colors->resize(first + count);
  for (std::size_t k = 0; k < count; ++k) {
    (*set.vertices)[first + ranks[k]] = outer.places[k];
    (*set.colors)[first + ranks[k]] = outer.tints[k];
  }
  boxes_[m].expandBy(osg::BoundingBoxd(front_to_back_.box()));
  seen_ += count;
  set.points[m]->addPrimitiveSet(
      new osg::DrawArrays(GL_POINTS, static_cast<GLint>(first), static_cast<GLsizei>(count)));
}

// Notes the tints that the places have.
void ParticleCloud::note_tints(const Body& body, Medium medium) {
  std::vector<osg::Vec4ub>& tints = tints_[static_cast<std::size_t>(medium)];
  std::array<bool, kStages> used{};
  if (stages_.empty()) used[0] = true;
  for (const unsigned char stage : stages_) used[stage] = true;
  for (std::size_t k = 0; k < body.tints.size(); ++k) {
    osg::Vec4ub tint = body.tints[k];
    if (medium == Medium::clear) tint.set(0, 0, 0, tint.a());
    if (used[k] && std::ranges::find(tints, tint) == tints.end()) tints.push_back(tint);
  }
}

// Adds the places within one by one, each as a lump of itself: their tints differ.
void ParticleCloud::add_within(const Body& body, Set& set) {
  constexpr auto kShare = static_cast<float>(1 / Interior::kParticlesOfLump);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (!interior_.contains(i)) continue;
    set.vertices->push_back({places_[i].x(), places_[i].y(), places_[i].z(), kShare});
    set.colors->push_back(body.tints[stages_[i]]);
  }
}

void ParticleCloud::set_frame(const ParticleFrame& frame, const ParticleFrame* earlier) {
  const auto newest = static_cast<unsigned>(next_);
  Set& set = sets_[next_];
  next_ = (next_ + 1) % kSets;
  clear();
  choose_colors(frame);
  set.vertices->clear();
  set.colors->clear();
  for (auto& geometry : set.points) geometry->removePrimitiveSet(0, geometry->getNumPrimitiveSets());
  set.clear_lumps->removePrimitiveSet(0, set.clear_lumps->getNumPrimitiveSets());
  spray_.begin();
  for (Outer& outer : outer_) {
    outer.places.clear();
    outer.tints.clear();
  }
  for (const Body& body : bodies_) {
    const std::optional<Medium> medium = medium_of(body);
    if (!medium) continue;
    find_seen(body, frame);
    if (flies(body)) let_fly(body, frame, earlier);
    add_body(body, *medium, set);
  }
  for (const Medium medium : {Medium::beads, Medium::opaque, Medium::clear}) add_outer(medium, set);
  set.vertices->changed();
  set.colors->changed();
  spray_.end();
  for (auto& node : switches_) node->setSingleChildOn(newest);
  lumps_switch_->setSingleChildOn(newest);
}

}  // namespace palp
