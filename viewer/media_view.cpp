#include "viewer/media_view.h"

#include <algorithm>

#include "viewer/scene_graph.h"

namespace palp {
namespace {

constexpr std::array<Medium, 2> kSurfaceMedia{Medium::opaque, Medium::clear};
constexpr int kCopyBin = 3;  // after opaque media, before clear ones (medium_surface.cpp)
// Spacings [texels] up to which the filter reaches as far as it should, at its widest steps (medium_smooth.frag): past
// them beads show.
constexpr double kLargestSmoothed = 30;

}  // namespace

MediaView::MediaView(SceneGraph& scene)
    : scene_(scene), root_(new osg::Group), copy_(new PictureCopy), walls_(scene.hollow_walls()) {
  ParticleCloud& cloud = scene.cloud();
  osg::ref_ptr<osg::Group> particles = new osg::Group;
  particles->setStateSet(cloud.shared_state());
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const Medium medium = kSurfaceMedia[i];
    osg::Node* points = cloud.points(medium);
    osg::ref_ptr<osg::Group> tinting = new osg::Group;
    tinting->addChild(points);
    if (medium == Medium::clear) tinting->addChild(cloud.clear_lumps());
    surfaces_[i] =
        std::make_unique<MediumSurface>(medium, points, tinting, cloud.color_map_texture(), copy_, walls_.texture());
    particles->addChild(surfaces_[i]->node());
  }
  particles->addChild(walls_.node());
  copy_->getOrCreateStateSet()->setRenderBinDetails(kCopyBin, "RenderBin");
  particles->addChild(copy_);
  // what it draws is lit and cut open like all of the scene
  root_->setStateSet(scene.root()->getStateSet());
  root_->addChild(particles);
}

void MediaView::set_view(const PictureView& picture) {
  const ParticleCloud& cloud = scene_.cloud();
  const osg::Vec4d middle(scene_.content().center(), 1);
  const double away = std::max((middle * picture.view * picture.projection).w(), 1e-3);
  const double spacing_pixels = 0.5 * picture.height * picture.projection(1, 1) * scene_.spacing() / away;
  if (picture.whole && spacing_pixels < kLargestSmoothed)
    quality_ = SurfaceQuality{};
  else
    quality_ = picture.quick ? quick_surface(picture.width, picture.height) : fine_surface(spacing_pixels, quality_);
  copy_->set_size(picture.width, picture.height);
  copy_->setNodeMask(cloud.box(Medium::clear).valid() ? ~0u : 0u);
  // what is cut open has no mirror images
  const bool walls = scene_.hollow_walls()->getNumChildren() > 0 && scene_.clip() == kNoClip;
  walls_.set_drawn(walls);
  walls_.set_spacing(scene_.spacing());
  walls_.set_size(picture.width, picture.height);
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    MediumSurface& surface = *surfaces_[i];
    surface.set_ended_by_walls(walls);
    surface.set_spacing(scene_.spacing());
    surface.set_colors(cloud.shown_field() != ScalarField::none, cloud.one_tint(kSurfaceMedia[i]));
    surface.set_size(picture.width, picture.height, quality_);
    surface.set_seen(cloud.box(kSurfaceMedia[i]), picture.view, picture.projection);
  }
}

}  // namespace palp
