#include "viewer/spray_view.h"

#include <algorithm>

#include <osg/Depth>
#include <osg/PointSprite>

#include "viewer/blending.h"
#include "viewer/home_view.h"
#include "viewer/shaders.h"

namespace palp {
namespace {

constexpr double kDropOverSpacing = 0.62;  // the radius of a ball that holds what a particle does
constexpr double kMistOverSpacing = 1.5;   // of the white around it
constexpr std::size_t kKinds = 1024;       // of ways to fall apart
constexpr float kWhitest = 0.999f;         // what is left beside the kind's number
constexpr int kDropBin = 5, kMistBin = 6;  // after all media, before glass

}  // namespace

SprayView::SprayView() : root_(new osg::Group) {
  osg::StateSet* state = root_->getOrCreateStateSet();
  state->setTextureAttributeAndModes(0, new osg::PointSprite);
  state->setMode(GL_VERTEX_PROGRAM_POINT_SIZE, osg::StateAttribute::ON);
  state->addUniform(new osg::Uniform("picture_height", 720.0f));
  for (auto& node : switches_) {
    node = new osg::Switch;
    node->setCullingActive(false);
    root_->addChild(node);
    blend_over(node->getOrCreateStateSet());
    node->getStateSet()->addUniform(new osg::Uniform("radius", 0.01f));
  }
  osg::StateSet* drops = switches_[0]->getStateSet();
  drops->setAttributeAndModes(
      load_program("drops", {"drop.vert", "color.glsl", "drop.frag", "color.glsl", "lighting.glsl"}));
  drops->setAttributeAndModes(new osg::Depth);  // one drop hides another
  drops->setRenderBinDetails(kDropBin, "RenderBin");
  osg::StateSet* mist = switches_[1]->getStateSet();
  mist->setAttributeAndModes(
      load_program("mist", {"mist.vert", "sprite.glsl", "color.glsl", "lighting.glsl", "mist.frag"}));
  mist->setRenderBinDetails(kMistBin, "RenderBin");

  for (Set& set : sets_) {
    set.places = new StreamedArray<osg::Vec4Array>;
    set.motions = new StreamedArray<osg::Vec4Array>;
    set.tints = new StreamedArray<osg::Vec4ubArray>;
    set.tints->setNormalize(true);
    for (std::size_t k = 0; k < set.points.size(); ++k) {
      set.points[k] = new Points(set.places, set.tints, set.motions);
      switches_[k]->addChild(set.points[k], false);
    }
  }
}

void SprayView::set_spacing(double spacing) {
  const auto set = [&](osg::Switch& of, double radius) {
    of.getStateSet()->getUniform("radius")->set(static_cast<float>(radius * spacing));
  };
  set(*switches_[0], kDropOverSpacing);
  set(*switches_[1], kMistOverSpacing);
}

void SprayView::set_picture_height(int height) {
  root_->getStateSet()->getUniform("picture_height")->set(static_cast<float>(height));
}

void SprayView::clear() {
  for (auto& node : switches_) node->setAllChildrenOff();
  drops_ = 0;
}

void SprayView::begin() {
  clear();
  Set& set = sets_[next_];
  set.places->clear();
  set.motions->clear();
  set.tints->clear();
}

void SprayView::add(const osg::Vec4f& place, const osg::Vec4f& motion, const osg::Vec4ub& tint, std::size_t particle) {
  Set& set = sets_[next_];
  set.places->push_back(place);
  const auto kind = static_cast<float>(particle % kKinds);
  set.motions->push_back({motion.x(), motion.y(), motion.z(), kind + std::min(motion.w(), kWhitest)});
  set.tints->push_back(tint);
}

// Puts what is far from the home view first, so that a drop is mixed with those behind it, at its rim, too.
void SprayView::order(Set& set) {
  osg::Vec3f along(-kHomeSide);
  along.normalize();
  const std::span<const std::uint32_t> ranks = far_to_near_.rank(set.places->asVector(), -along);
  const auto sort = [&](auto& array) {
    auto sorted = array.asVector();
    for (std::size_t k = 0; k < ranks.size(); ++k) sorted[ranks[k]] = array[k];
    array.asVector().swap(sorted);
  };
  sort(*set.places);
  sort(*set.motions);
  sort(*set.tints);
}

void SprayView::end() {
  Set& set = sets_[next_];
  drops_ = set.places->size();
  if (drops_ == 0) return;
  order(set);
  set.places->changed();
  set.motions->changed();
  set.tints->changed();
  for (std::size_t k = 0; k < switches_.size(); ++k) {
    set.points[k]->removePrimitiveSet(0, set.points[k]->getNumPrimitiveSets());
    set.points[k]->addPrimitiveSet(new osg::DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(drops_)));
    switches_[k]->setSingleChildOn(static_cast<unsigned>(next_));
  }
  next_ = (next_ + 1) % kSets;
}

}  // namespace palp
