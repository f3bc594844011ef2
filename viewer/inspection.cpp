#include "viewer/inspection.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "viewer/medium.h"
#include "viewer/mesh.h"

namespace palp {
namespace {

// Over the spacing: about as large as beads are drawn, so that one cannot click between them.
constexpr double kPickRadius = 0.62;

bool draws_particles(const Session& session, const BodyDescription& body) {
  return session.draws_all() || !has_surface(body);
}

std::optional<osg::Vec3d> position_of(const Session& session, std::size_t particle) {
  if (!session.frame() || 3 * particle + 2 >= session.frame()->positions.size()) return std::nullopt;
  const float* p = session.frame()->positions.data() + 3 * particle;
  const osg::Vec3d place(p[0], p[1], p[2]);
  return place.valid() ? std::optional(place) : std::nullopt;
}

std::string place_words(const osg::Vec3d& p) { return fmt::format("{:.4f}  {:.4f}  {:.4f} m", p.x(), p.y(), p.z()); }

void describe_body(const Stage& stage, const BodyDescription& body, std::size_t index, PickedLines& out) {
  const auto kind = std::min(static_cast<std::size_t>(body.kind), kBodyKindNames.size() - 1);
  out.lines.emplace_back("body", body.name);
  out.lines.emplace_back("kind", kBodyKindNames[kind]);
  out.lines.emplace_back("density", fmt::format("{:.5g} kg/m³ at rest", body.density));
  out.lines.emplace_back("particles", fmt::format("{}", body.count));
  if (const auto pose = stage.scene().body_pose(index); pose && has_surface(body)) {
    const osg::Quat q = pose->getRotate();
    out.lines.emplace_back("position", place_words(pose->getTrans()));
    out.lines.emplace_back("orientation", fmt::format("{:.4f}  {:.4f}  {:.4f}  {:.4f}", q.x(), q.y(), q.z(), q.w()));
  }
}

// A ring in the picture.
std::vector<osg::Vec2d> ring(const osg::Vec2d& middle, double radius) {
  constexpr int kCorners = 24;
  std::vector<osg::Vec2d> line;
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2 * M_PI * i / kCorners;
    line.push_back(middle + osg::Vec2d(std::cos(angle), std::sin(angle)) * radius);
  }
  return line;
}

}  // namespace

std::optional<Picked> pick(const Stage& stage, const Session& session, const osg::Vec2d& place) {
  if (!session.scene()) return std::nullopt;
  const SceneDescription& scene = *session.scene();
  const Ray ray = stage.ray_through(place);
  if (!ray.direction.valid()) return std::nullopt;
  std::optional<Picked> nearest;
  double distance = 0;
  const auto take = [&](const std::optional<Hit>& hit, const Picked& picked) {
    if (!hit || (nearest && hit->distance >= distance)) return;
    nearest = picked;
    distance = hit->distance;
  };
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const BodyDescription& body = scene.bodies[b];
    if (draws_particles(session, body)) {
      if (!session.frame()) continue;
      const auto hit = pick_particle(ray, session.frame()->positions, body.first, body.count,
                                     kPickRadius * scene.spacing, stage.scene().clip());
      take(hit, {b, hit ? hit->index : 0});
    } else if (const auto pose = stage.scene().body_pose(b)) {
      take(pick_surface(ray, body.vertices, body.triangles, *pose, stage.scene().clip()), {b, std::nullopt});
    }
  }
  return nearest;
}

std::optional<PickedLines> describe(const Stage& stage, const Session& session, const Picked& picked) {
  if (!session.scene() || picked.body >= session.scene()->bodies.size()) return std::nullopt;
  const BodyDescription& body = session.scene()->bodies[picked.body];
  PickedLines out;
  out.title = body.name;
  if (picked.particle) {
    const auto place = position_of(session, *picked.particle);
    if (!place) return std::nullopt;
    out.title = fmt::format("particle {}", *picked.particle);
    out.lines.emplace_back("place", place_words(*place));
    const ParticleFrame& frame = *session.frame();
    if (*picked.particle < frame.scalars.size() && frame.field != ScalarField::none) {
      const ScalarFieldRow& field = row_of(frame.field);
      out.lines.emplace_back(field.name, fmt::format("{:.6g} {}", frame.scalars[*picked.particle], field.unit));
    }
  }
  if (picked.particle && *picked.particle < session.frame()->solid.size() && changes_look(body))
    out.lines.emplace_back("solid", fmt::format("{:.0f} %", session.frame()->solid[*picked.particle] / 2.55));
  describe_body(stage, body, picked.body, out);
  return out;
}

Marks marks_of(const Stage& stage, const Session& session, const Picked& picked) {
  Marks marks;
  if (!session.scene()) return marks;
  if (picked.particle) {
    const auto place = position_of(session, *picked.particle);
    const double pixels = place ? stage.pixels_of(session.scene()->spacing, *place) : 0;
    if (pixels > 0) marks.push_back(ring(stage.project(*place), std::clamp(0.75 * pixels, 5.0, 1e4)));
    return marks;
  }
  const auto pose = stage.scene().body_pose(picked.body);
  const osg::BoundingBox box = stage.scene().body_box(picked.body);
  if (!pose || !box.valid()) return marks;
  // corners that differ in one bit of their number are ends of an edge
  for (unsigned a = 0; a < 8; ++a) {
    for (const unsigned bit : {1u, 2u, 4u}) {
      if ((a & bit) != 0) continue;
      const osg::Vec3d from = osg::Vec3d(box.corner(a)) * *pose, to = osg::Vec3d(box.corner(a | bit)) * *pose;
      if (stage.pixels_of(1, from) > 0 && stage.pixels_of(1, to) > 0)
        marks.push_back({stage.project(from), stage.project(to)});
    }
  }
  return marks;
}

}  // namespace palp
