#include "viewer/scene_graph.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <osg/CullFace>
#include <osg/LineWidth>

#include "viewer/arrays.h"
#include "viewer/blending.h"
#include "viewer/pose_matrix.h"
#include "viewer/shaders.h"
#include "viewer/surroundings.h"
#include "viewer/wall_depths.h"

namespace palp {
namespace {

// The order of drawing: a later bin lies on top of what it cannot be sorted against.
// Background and ground come before them all (surroundings.cpp), opaque media in bin 2 and clear ones in bin 4
// (medium_surface.cpp) with a copy of the picture in between (media_view.cpp), drops in bins 5 and 6 (spray_view.cpp),
// marks of touch in bins 1 and 12 (touch_marks.cpp).
enum Bin { kSolidBin = 0, kGlassBin = 10, kEdgeBin = 11 };

osg::BoundingBoxd domain_of(const SceneDescription& scene) {
  const auto& a = scene.bounds_min;
  const auto& b = scene.bounds_max;
  osg::BoundingBoxd box(a[0], a[1], a[2], b[0], b[1], b[2]);
  const double size = box.valid() ? box.radius() : 0;
  return std::isfinite(size) && size > 0 ? box : osg::BoundingBoxd(-0.1, -0.1, 0, 0.1, 0.1, 0.1);
}

// Adds some of the points, evenly over their order.
template <class Point, class Keep>
void sample(std::size_t count, Point&& point, std::vector<osg::Vec3d>& out, Keep&& keep) {
  constexpr std::size_t kMost = 1500;
  const std::size_t stride = count / kMost + 1;
  for (std::size_t i = 0; i < count; i += stride) {
    if (const osg::Vec3d p = point(i); keep(p)) out.push_back(p);
  }
}

}  // namespace

SceneGraph::SceneGraph()
    : root_(new osg::Group),
      surfaces_(new osg::Group),
      solid_(new osg::StateSet),
      glass_(new osg::StateSet),
      edges_(new osg::StateSet),
      hollow_walls_(new osg::Group),
      ground_(make_ground()) {
  osg::StateSet* state = root_->getOrCreateStateSet();
  state->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
  state->addUniform(new osg::Uniform("glass", 0.0f));
  state->addUniform(new osg::Uniform("ghost", 0.0f));
  state->addUniform(new osg::Uniform("tint", osg::Vec4f(0, 0, 0, 0)));
  state->addUniform(new osg::Uniform("presence", 1.0f));
  state->addUniform(new osg::Uniform("clip_plane", osg::Vec4f(kNoClip)));
  state->addUniform(new osg::Uniform("surface_look", surface_numbers(Look{})));
  state->addUniform(new osg::Uniform("grain", osg::Vec4f(0, 0, 1, 0)));

  osg::ref_ptr<osg::Program> program = load_program("mesh", {"mesh.vert", "mesh.frag", "color.glsl", "lighting.glsl"});
  osg::ref_ptr<osg::CullFace> cull = new osg::CullFace(osg::CullFace::BACK);
  solid_->setAttributeAndModes(program);
  solid_->setAttributeAndModes(cull);
  solid_->setRenderBinDetails(kSolidBin, "RenderBin");
  glass_->setAttributeAndModes(program);
  glass_->setAttributeAndModes(cull);
  glass_->addUniform(new osg::Uniform("glass", 0.10f));
  blend_over(glass_);
  glass_->setRenderBinDetails(kGlassBin, "DepthSortedBin");
  edges_->setAttributeAndModes(new osg::LineWidth(1.5f));
  edges_->setMode(GL_LINE_SMOOTH, osg::StateAttribute::ON);
  blend_over(edges_);
  edges_->setRenderBinDetails(kEdgeBin, "RenderBin");

  root_->addChild(make_background());
  root_->addChild(ground_);
  root_->addChild(surfaces_);
  osg::ref_ptr<osg::Group> particles = new osg::Group;
  particles->setStateSet(cloud_.shared_state());
  particles->addChild(cloud_.points(Medium::beads));
  particles->addChild(cloud_.spray());
  root_->addChild(particles);
  add_shadows();
  for (std::uint32_t device = 0; device < kMaxDevices; ++device) {
    hands_[device] = std::make_unique<HandView>(device);
    root_->addChild(hands_[device]->node());
  }
  clear();
}

void SceneGraph::add_shadows() {
  shadow_map_.add_surfaces(surfaces_);
  // light goes through glass and clear liquids
  for (const Medium medium : {Medium::beads, Medium::opaque}) shadow_map_.add_points(cloud_.points(medium));
  shadow_map_.give_to(*root_->getOrCreateStateSet());
  root_->addChild(shadow_map_.node());
}

void SceneGraph::set_view(const PictureView& picture) {
  cloud_.set_picture_height(picture.height);
  // about as many texels as the picture has pixels over the scene
  if (picture.draws_shadows) shadow_map_.set_size(picture.quick ? 512 : picture.height <= 1024 ? 1024 : 2048);
  shadow_map_.node()->setNodeMask(picture.draws_shadows ? ~0u : 0u);
  shadow_map_.set_view(content_, picture.view);
  root_->getStateSet()->getUniform("clip_plane")->set(osg::Vec4f(osg::Matrixd::inverse(picture.view) * clip_));
  shadow_map_.set_clip(clip_);
  const osg::Matrixd to_pixels =
      picture.view * picture.projection * osg::Matrixd::scale(0.5 * picture.width, 0.5 * picture.height, 1);
  const float words = std::round(std::clamp(static_cast<float>(picture.height) / 46, 11.0f, 40.0f));
  for (auto& hand : hands_) {
    hand->set_value_size(words);
    hand->arrange_values(to_pixels);
  }
}

void SceneGraph::set_reading(const Reading& reading) {
  reading_ = reading;
  cut_open();
}

void SceneGraph::cut_open() {
  clip_ = equation_of(reading_.clip, content_);
  cloud_.set_reading(reading_, clip_);
  const bool open = clip_ != kNoClip;
  surfaces_->getOrCreateStateSet()->setMode(GL_CLIP_PLANE0, open ? osg::StateAttribute::ON : osg::StateAttribute::OFF);
  // one looks into what is cut open and sees its walls from behind
  for (osg::StateSet* state : {solid_.get(), glass_.get()})
    state->setMode(GL_CULL_FACE, open ? osg::StateAttribute::OFF : osg::StateAttribute::ON);
}

void SceneGraph::clear() {
  set_scene({});
  ground_->setNodeMask(0);
}

void SceneGraph::set_scene(const SceneDescription& scene) {
  surfaces_->removeChildren(0, surfaces_->getNumChildren());
  hollow_walls_->removeChildren(0, hollow_walls_->getNumChildren());
  bodies_.clear();
  for (const BodyDescription& description : scene.bodies) {
    PlacedBody body;
    body.kind = description.kind;
    body.first = description.first;
    body.count = description.count;
    body.place = new osg::MatrixTransform;
    body.place->setNodeMask(description.kind == BodyKind::fixed ? ~0u : 0u);
    body.look = description.look;
    body.place->getOrCreateStateSet()->addUniform(new osg::Uniform("surface_look", surface_numbers(body.look)));
    surfaces_->addChild(body.place);
    bodies_.push_back(std::move(body));
  }
  cloud_.set_scene(scene);
  spacing_ = scene.spacing;
  shadow_map_.set_spacing(scene.spacing);
  for (auto& hand : hands_) hand->clear();
  proxies_ = scene.proxies;
  std::erase_if(proxies_, [](const ProxyDescription& proxy) { return proxy.device >= kMaxDevices; });
  touch_.set_scene(scene);
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (osg::Node* marks = touch_.node(i)) bodies_[i].place->addChild(marks);
  force_scale_ = ForceScale();
  torque_scale_ = ForceScale(kSmallestTorque);
  seen_frame_ = false;
  first_frame_.init();
  first_outline_.clear();
  roamed_.clear();
  domain_ = domain_of(scene);
  update_content();
}

void SceneGraph::set_surface(std::size_t index, const BodyMesh& mesh) {
  if (index >= bodies_.size()) return;
  PlacedBody& body = bodies_[index];
  const auto add = [&](const osg::ref_ptr<osg::Geometry>& part, const osg::ref_ptr<osg::StateSet>& state) {
    if (!part) return;
    part->setStateSet(state);
    body.place->addChild(part);
    body.box.expandBy(part->getBoundingBox());
    for (const ProxyDescription& proxy : proxies_)
      if (proxy.body == index) hands_[proxy.device]->add_tool_part(*part);
    touch_.add_part(index, *part);
    const auto& vertices = static_cast<const osg::Vec3Array&>(*part->getVertexArray());
    sample(
        vertices.size(), [&](std::size_t i) { return osg::Vec3d(vertices[i]); }, body.outline,
        [](const osg::Vec3d&) { return true; });
  };
  add(mesh.solid, body.look.clear ? glass_ : solid_);
  add(mesh.glass, glass_);
  if (mesh.solid && body.look.clear) mesh.solid->setNodeMask(~kCastsShadow);
  if (mesh.glass) mesh.glass->setNodeMask(~kCastsShadow);
  if (body.look.grain > 0)
    body.place->getOrCreateStateSet()->addUniform(new osg::Uniform("grain", grain_numbers(body.look, body.box)));
  body.images = mesh.images;
  if (mesh.solid && mesh.glass) {
    body.wall = hollow_wall(*mesh.solid, *mesh.glass);
    body.wall->setMatrix(body.place->getMatrix());
    hollow_walls_->addChild(body.wall);
  }
  if (mesh.edges) {
    mesh.edges->setStateSet(edges_);
    body.place->addChild(mesh.edges);
    mesh.edges->setNodeMask(~kCastsShadow);
  }
  update_content();
}

void SceneGraph::set_soft_surface(std::size_t index, const BodyMesh& mesh, Skin skin) {
  if (index >= bodies_.size() || !mesh.solid || skin.particles() != bodies_[index].count) return;
  PlacedBody& body = bodies_[index];
  body.soft = std::make_unique<SoftSurface>(mesh, std::move(skin));
  body.soft->geometry()->setStateSet(solid_);
  body.place->addChild(body.soft->geometry());
}

void SceneGraph::set_draw_all(bool all) {
  cloud_.set_draw_all(all);
  surfaces_->setNodeMask(all ? 0u : ~0u);
}

void SceneGraph::set_poses(const BodyPoses& poses) {
  const std::size_t count = std::min(poses.body.size(), poses.pose.size());
  bool moved_fixed = false;
  for (std::size_t i = 0; i < count; ++i) {
    osg::Matrixd matrix;
    if (poses.body[i] >= bodies_.size() || !pose_matrix(poses.pose[i], matrix)) continue;
    PlacedBody& body = bodies_[poses.body[i]];
    moved_fixed = moved_fixed || (body.kind == BodyKind::fixed && body.place->getMatrix() != matrix);
    body.place->setMatrix(matrix);
    body.place->setNodeMask(~0u);
    if (body.wall) body.wall->setMatrix(matrix);
    for (const ProxyDescription& proxy : proxies_)
      if (proxy.body == poses.body[i]) hands_[proxy.device]->set_tool_pose(matrix, poses.sim_time);
  }
  if (moved_fixed && !seen_frame_) update_content();
}

// Shows the surfaces of soft bodies where the frame's particles carry them, or those particles.
void SceneGraph::follow_particles(const ParticleFrame& frame) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    PlacedBody& body = bodies_[i];
    if (!body.soft) continue;
    const bool has = frame.positions.size() / 3 >= std::size_t{body.first} + body.count;
    const bool shown = has && cloud_.takes_skins(frame);
    body.place->setNodeMask(shown ? ~0u : 0u);
    cloud_.set_skin(i, shown ? &body.soft->skin() : nullptr);
    if (shown)
      body.soft->follow(std::span(frame.positions).subspan(3 * std::size_t{body.first}, 3 * std::size_t{body.count}));
  }
}

void SceneGraph::set_frame(const ParticleFrame& frame, const ParticleFrame* earlier) {
  follow_particles(frame);
  cloud_.set_solids(standing_solids());
  cloud_.set_frame(frame, earlier);
  const PressureColors colors{cloud_.range(), cloud_.color_map_kind()};
  touch_.mark(
      frame, [this](std::size_t body) { return body_pose(body); },
      cloud_.shown_field() == ScalarField::pressure ? &colors : nullptr);
  if (seen_frame_) return;
  seen_frame_ = true;
  const auto particle = [&](std::size_t i) {
    const float* p = frame.positions.data() + 3 * i;
    return osg::Vec3d(p[0], p[1], p[2]);
  };
  const auto within = [this](const osg::Vec3d& p) { return p.valid() && domain_.contains(p); };
  const std::size_t count = frame.positions.size() / 3;
  for (std::size_t i = 0; i < count; ++i) {
    if (within(particle(i))) first_frame_.expandBy(particle(i));
  }
  sample(count, particle, first_outline_, within);
  update_content();
}

void SceneGraph::set_proxy(const ProxySample& sample) {
  if (sample.device >= kMaxDevices) return;
  const auto& f = sample.wrench.force;
  const auto& t = sample.wrench.torque;
  HandScale scale;
  scale.full_force = force_scale_.update(std::hypot(f[0], f[1], f[2]), sample.sim_time);
  scale.full_torque = torque_scale_.update(std::hypot(t[0], t[1], t[2]), sample.sim_time);
  scale.arrow_length = arrow_length();
  scale.scene_radius = content_.radius();
  hands_[sample.device]->set(sample, scale);
}

void SceneGraph::set_reaches(const std::map<std::uint32_t, HandReach>& reaches) {
  for (std::uint32_t device = 0; device < kMaxDevices; ++device) {
    const auto reach = reaches.find(device);
    hands_[device]->set_reach(reach != reaches.end() ? std::optional(reach->second) : std::nullopt);
  }
}

void SceneGraph::set_values_shown(bool shown) {
  for (auto& hand : hands_) hand->set_values_shown(shown);
}

std::vector<StandingSolid> SceneGraph::standing_solids() const {
  std::vector<StandingSolid> solids;
  for (const PlacedBody& body : bodies_)
    if (body.images && body.place->getNodeMask() != 0) solids.push_back({body.images, body.place->getMatrix()});
  return solids;
}

std::vector<osg::Vec3d> SceneGraph::tools() const {
  std::vector<osg::Vec3d> corners;
  for (const ProxyDescription& proxy : proxies_) {
    if (proxy.body >= bodies_.size()) continue;
    const PlacedBody& body = bodies_[proxy.body];
    if (!body.box.valid() || body.place->getNodeMask() == 0) continue;
    if (!domain_.contains(body.place->getMatrix().getTrans())) continue;
    for (unsigned i = 0; i < 8; ++i) corners.push_back(osg::Vec3d(body.box.corner(i)) * body.place->getMatrix());
  }
  return corners;
}

std::optional<osg::Matrixd> SceneGraph::body_pose(std::size_t body) const {
  if (body >= bodies_.size() || bodies_[body].place->getNodeMask() == 0) return std::nullopt;
  return bodies_[body].place->getMatrix();
}

void SceneGraph::widen_outline(const std::vector<osg::Vec3d>& points) {
  roamed_.insert(roamed_.end(), points.begin(), points.end());
  outline_.insert(outline_.end(), points.begin(), points.end());
}

void SceneGraph::update_content() {
  osg::BoundingBoxd box = first_frame_;
  outline_ = first_outline_;
  outline_.insert(outline_.end(), roamed_.begin(), roamed_.end());
  for (const PlacedBody& body : bodies_) {
    if (!body.box.valid() || body.place->getNodeMask() == 0) continue;
    for (unsigned i = 0; i < 8; ++i) box.expandBy(osg::Vec3d(body.box.corner(i)) * body.place->getMatrix());
    for (const osg::Vec3d& p : body.outline) outline_.push_back(p * body.place->getMatrix());
  }
  const bool usable = box.valid() && std::isfinite(box.radius()) && box.radius() > 0;
  content_ = usable ? box : domain_;
  if (!usable || outline_.empty()) {
    outline_.clear();
    for (unsigned i = 0; i < 8; ++i) outline_.push_back(content_.corner(i));
  }
  place_ground();
  cut_open();
}

void SceneGraph::place_ground() {
  ground_->setNodeMask(~0u);
  const osg::Vec3d middle = content_.center();
  const auto reach = static_cast<float>(4.0 * content_.radius());
  const auto x = static_cast<float>(middle.x()), y = static_cast<float>(middle.y());
  const auto z = static_cast<float>(content_.zMin() - 0.004 * content_.radius());
  ground_->setVertexArray(array_of<osg::Vec3Array>(
      {{x - reach, y - reach, z}, {x + reach, y - reach, z}, {x - reach, y + reach, z}, {x + reach, y + reach, z}}));
  ground_->dirtyBound();
  osg::StateSet* state = ground_->getStateSet();
  state->getUniform("footprint")
      ->set(osg::Vec4f(static_cast<float>(content_.xMin()), static_cast<float>(content_.yMin()),
                       static_cast<float>(content_.xMax()), static_cast<float>(content_.yMax())));
  state->getUniform("fade")->set(osg::Vec2f(0.25f * reach, 0.95f * reach));
  state->getUniform("cell")->set(static_cast<float>(nice_ceiling(content_.radius() / 12)));
}

}  // namespace palp
