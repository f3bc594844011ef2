#include "viewer/touch_view.h"

namespace palp {

void TouchView::set_scene(const SceneDescription& scene) {
  tools_.clear();
  media_.clear();
  touch_.reset();
  for (const ProxyDescription& proxy : scene.proxies)
    if (proxy.body < scene.bodies.size()) tools_.try_emplace(proxy.body, scene.spacing);
  for (const BodyDescription& body : scene.bodies)
    if (body.kind != BodyKind::rigid && body.kind != BodyKind::fixed) media_.push_back({body.first, body.count});
}

osg::Node* TouchView::node(std::size_t body) {
  const auto tool = tools_.find(body);
  return tool != tools_.end() ? tool->second.node() : nullptr;
}

void TouchView::add_part(std::size_t body, const osg::Geometry& part) {
  if (const auto tool = tools_.find(body); tool != tools_.end()) tool->second.add_part(part);
}

void TouchView::set_marked(bool marked) {
  marked_ = marked;
  if (marked) return;
  touch_.reset();
  for (auto& [body, marks] : tools_) marks.hide();
}

void TouchView::mark(const ParticleFrame& frame, const std::function<std::optional<osg::Matrixd>(std::size_t)>& pose_of,
                     const PressureColors* pressures) {
  touch_.reset();
  if (!marked_) return;
  double force = 0;  // [N] of the pressures, all added up
  for (auto& [body, marks] : tools_) {
    const std::optional<osg::Matrixd> pose = pose_of(body);
    if (!pose) continue;
    const Touch one = marks.set(frame, media_, *pose, pressures);
    if (!touch_) touch_.emplace();
    touch_->area += one.area;
    force += one.area * one.pressure.value_or(0);
  }
  if (touch_ && pressures != nullptr && touch_->area > 0) touch_->pressure = force / touch_->area;
}

}  // namespace palp
