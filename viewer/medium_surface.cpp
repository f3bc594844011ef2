#include "viewer/medium_surface.h"

#include <algorithm>
#include <cmath>

#include <osg/BlendFunc>
#include <osg/PointSprite>

#include "viewer/shaders.h"

namespace palp {
namespace {

// Lengths in particle spacings.
constexpr double kRadius = 0.78;          // of the spheres: neighbours overlap well
constexpr double kHalfAbove = 0.5;        // of a sphere above its centre: half of a particle
constexpr double kTintRadius = 1.2;       // sums over wider spheres have less grain
constexpr double kReach = 2.4;            // of the smoothing
constexpr double kRange = 3.0;            // of distances that belong to one surface
constexpr double kClampRange = 0.8;       // of distances behind a point that it may be pulled back to
constexpr double kSpread = 0.6;           // of what particles cover, where the outline is looked for
constexpr double kSkin = 2.0;             // the depth that gives an opaque medium its colour, ever less with depth
constexpr double kLift = 0.5;             // off the surface, where its light is asked for
constexpr double kTintShare = 0.5;        // of the surface's size: tints are smooth
constexpr double kThicknessShare = 0.25;  // and sums over all that is clear smoother still
constexpr double kOutlineShare = 0.5;

// The order of drawing in the picture: after what is solid, before glass.
constexpr int kOpaqueBin = 2, kClearBin = 4;
constexpr int kPassesOfOne = 32;
constexpr unsigned kSurfaceLooksUnit = 8, kWallsUnit = 9;  // past those that every shading program has (kShadowUnit)
constexpr double kLargeFrom = 12, kLargeTo = 10;           // spacings [pixels] that half the texels suit
constexpr std::size_t kSurface = 0, kTint = 1, kOutline = 3, kBeforeSmoothing = 4;  // among the passes

double overlap_share() { return 1 / (4.0 / 3.0 * M_PI * kTintRadius * kTintRadius * kTintRadius); }

osg::Uniform* number(const char* name, double value) { return new osg::Uniform(name, static_cast<float>(value)); }

osg::Vec2f size_of(const osg::Texture2D& texture) {
  return {static_cast<float>(texture.getTextureWidth()), static_cast<float>(texture.getTextureHeight())};
}

osg::ref_ptr<osg::Program> point_program(const char* fragment, const char* name) {
  return load_program(name, {"medium.vert", "sprite.glsl", "color.glsl", fragment});
}

void set_format(osg::Texture2D& texture, GLenum internal_format, GLenum format) {
  texture.setInternalFormat(static_cast<GLint>(internal_format));
  texture.setSourceFormat(format);
}

// Returns how many texels stand for so many pixels where a pixel has so many.
int texels_of(int pixels, double scale) { return std::max(1, static_cast<int>(std::lround(pixels * scale))); }

// The radius of a sphere in spacings is its state's own: depth and tint differ.
void draw_points(osg::StateSet& state, const char* fragment, const char* name) {
  state.setAttributeAndModes(point_program(fragment, name));
  state.setTextureAttributeAndModes(0, new osg::PointSprite);
  state.setMode(GL_VERTEX_PROGRAM_POINT_SIZE, osg::StateAttribute::ON);
}

}  // namespace

SurfaceQuality fine_surface(double spacing_pixels, const SurfaceQuality& now) {
  SurfaceQuality quality;
  quality.scale = spacing_pixels > (now.scale < 1 ? kLargeTo : kLargeFrom) ? 0.5 : 1;
  return quality;
}

SurfaceQuality quick_surface(int width, int height) {
  constexpr double kMostTexels = 640.0 * 360.0;
  const double scale = std::sqrt(kMostTexels / std::max(1.0, static_cast<double>(width) * height));
  return {std::clamp(scale, 0.5, 1.0), 1, 8, 1, 8};
}

MediumSurface::MediumSurface(Medium medium, osg::Node* particles, osg::Node* tinting, osg::Texture1D* color_map,
                             const PictureCopy* copy, osg::Texture2D* walls)
    : medium_(medium),
      root_(new osg::Group),
      smoothing_(new osg::Group),
      shading_(screen_rectangle()),
      walls_(walls),
      picture_scissor_(new osg::Scissor) {
  root_->getOrCreateStateSet()->addUniform(new osg::Uniform("is_clear", medium == Medium::clear));
  root_->getStateSet()->addUniform(new osg::Uniform("outline_taps", 1));
  root_->getStateSet()->addUniform(new osg::Uniform("ended_by_walls", false));
  root_->getStateSet()->addUniform(number("outline_stride", 1));
  root_->getStateSet()->addUniform(number("lump_over_spacing", 1));
  add_depth_pass(particles);
  add_tint_pass(tinting);
  add_outline_passes();
  root_->addChild(smoothing_);
  make_shading(color_map, copy);
  set_colors(false, {});
  root_->setNodeMask(0);
}

MediumSurface::Pass& MediumSurface::add_pass(GLenum internal_format, GLenum format, bool with_depth, double share) {
  Pass pass;
  pass.texture = float_texture(internal_format, format);
  const int order = (medium_ == Medium::clear ? kPassesOfOne : 0) + static_cast<int>(passes_.size());
  pass.camera = pass_into(pass.texture, order, with_depth);
  pass.scissor = new osg::Scissor;
  pass.share = share;
  osg::StateSet* state = pass.camera->getOrCreateStateSet();
  state->setAttributeAndModes(pass.scissor);
  state->addUniform(number("target_height", 1));
  passes_.push_back(pass);
  return passes_.back();
}

void MediumSurface::add_depth_pass(osg::Node* particles) {
  Pass& pass = add_pass(GL_RG32F, GL_RG, true, 1);
  osg::StateSet* state = pass.camera->getStateSet();
  draw_points(*state, "medium_depth.frag", "medium depth");
  pass.camera->addChild(particles);
  root_->addChild(pass.camera);
}

void MediumSurface::add_tint_pass(osg::Node* particles) {
  const double share = medium_ == Medium::clear ? kThicknessShare : kTintShare;
  Pass& pass = add_pass(GL_RGBA16F_ARB, GL_RGBA, false, share);
  surface_looks_ = float_texture(GL_RGBA16F_ARB, GL_RGBA);
  for (osg::Texture2D* texture : {pass.texture.get(), surface_looks_.get()}) {
    texture->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
    texture->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
  }
  pass.camera->attach(osg::Camera::COLOR_BUFFER1, surface_looks_);
  osg::StateSet* state = pass.camera->getStateSet();
  draw_points(*state, "medium_tint.frag", "medium tint");
  tint_program_ = static_cast<osg::Program*>(state->getAttribute(osg::StateAttribute::PROGRAM));
  thickness_program_ = point_program("medium_thickness.frag", "medium thickness");
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::ONE, osg::BlendFunc::ONE));
  state->setTextureAttribute(1, passes_[0].texture);
  state->addUniform(new osg::Uniform("surface", 1));
  state->addUniform(number("chord_share", overlap_share()));
  state->addUniform(new osg::Uniform("surface_per_target", osg::Vec2f(1 / share, 1 / share)));
  pass.camera->addChild(particles);
  root_->addChild(pass.camera);
}

void MediumSurface::add_outline_passes() {
  for (const bool upward : {false, true}) {
    osg::ref_ptr<osg::Texture2D> from = upward ? passes_.back().texture : passes_[0].texture;
    Pass& pass = add_pass(GL_RGBA16F_ARB, GL_RGBA, false, kOutlineShare);
    if (upward) {
      pass.texture->setFilter(osg::Texture::MIN_FILTER, osg::Texture::LINEAR);
      pass.texture->setFilter(osg::Texture::MAG_FILTER, osg::Texture::LINEAR);
    }
    osg::StateSet* state = pass.camera->getStateSet();
    state->setAttributeAndModes(load_program("medium outline", {"screen.vert", "medium_outline.frag"}));
    state->setTextureAttribute(0, from);
    state->addUniform(new osg::Uniform("covered", 0));
    state->addUniform(new osg::Uniform("along", upward ? 0 : 1, upward ? 1 : 0));
    state->addUniform(new osg::Uniform("by_distance", !upward));
    pass.camera->addChild(screen_rectangle());
    root_->addChild(pass.camera);
  }
}

void MediumSurface::make_smoothing() {
  smoothing_->removeChildren(0, smoothing_->getNumChildren());
  passes_.resize(kBeforeSmoothing);
  const auto add = [this](const char* fragment, const char* name) {
    osg::ref_ptr<osg::Texture2D> from =
        passes_.size() == kBeforeSmoothing ? passes_[0].texture : passes_.back().texture;
    Pass& pass = add_pass(GL_RG32F, GL_RG, false, 1);
    pass.camera->setClearMask(0);  // set_seen() has it draw over what the last picture left
    osg::StateSet* state = pass.camera->getStateSet();
    state->setAttributeAndModes(load_program(name, {"screen.vert", fragment}));
    state->setTextureAttribute(0, from);
    state->addUniform(new osg::Uniform("surface", 0));
    pass.camera->addChild(screen_rectangle());
    smoothing_->addChild(pass.camera);
    return state;
  };
  for (int round = 0; round < quality_.rounds; ++round) {
    for (const bool upward : {false, true}) {
      osg::StateSet* state = add("medium_smooth.frag", "medium smoothing");
      state->addUniform(new osg::Uniform("along", upward ? 0 : 1, upward ? 1 : 0));
      state->addUniform(new osg::Uniform("most_taps", quality_.most_taps));
      // the second round is finer: it smooths the steps between the taps of the first
      state->addUniform(number("reach", kReach * spacing_ / (1 << round)));
      state->addUniform(new osg::Uniform("fills", round == 0));
      state->setTextureAttribute(1, passes_[kOutline].texture);
      state->addUniform(new osg::Uniform("outline", 1));
    }
  }
  osg::StateSet* state = add("medium_clean.frag", "medium clean-up");
  state->setTextureAttribute(2, passes_[0].texture);
  state->addUniform(new osg::Uniform("unsmoothed", 2));
  state->addUniform(new osg::Uniform("most_taps", quality_.clean_taps));
  // streaks of a large picture are wider
  state->addUniform(new osg::Uniform("stride", std::clamp(static_cast<int>(quality_.scale * height_ / 500), 1, 3)));
  shading_->getStateSet()->setTextureAttribute(0, passes_.back().texture);
}

void MediumSurface::make_shading(osg::Texture1D* color_map, const PictureCopy* copy) {
  osg::StateSet* state = shading_->getOrCreateStateSet();
  state->setAttributeAndModes(
      load_program("medium", {"screen.vert", "medium_shade.frag", "color.glsl", "lighting.glsl"}));
  state->setAttributeAndModes(picture_scissor_);
  state->setAttributeAndModes(new osg::BlendFunc(osg::BlendFunc::SRC_ALPHA, osg::BlendFunc::ONE_MINUS_SRC_ALPHA));
  state->setTextureAttribute(1, passes_[kTint].texture);
  state->setTextureAttribute(2, copy->color());
  state->setTextureAttribute(3, copy->depth());
  state->setTextureAttribute(4, color_map);
  state->setTextureAttribute(5, passes_[kOutline].texture);
  state->setTextureAttribute(kSurfaceLooksUnit, surface_looks_);
  state->setTextureAttribute(kWallsUnit, walls_);
  state->addUniform(new osg::Uniform("walls", static_cast<int>(kWallsUnit)));
  state->addUniform(new osg::Uniform("surface_looks", static_cast<int>(kSurfaceLooksUnit)));
  int unit = 0;
  for (const char* name : {"surface", "tints", "scene_color", "scene_depth", "color_map", "outline"})
    state->addUniform(new osg::Uniform(name, unit++));
  state->setRenderBinDetails(medium_ == Medium::clear ? kClearBin : kOpaqueBin, "RenderBin");
  root_->addChild(shading_);
}

void MediumSurface::set_spacing(double spacing) {
  if (spacing == spacing_) return;
  spacing_ = spacing;
  const auto set = [spacing](osg::StateSet* state, const char* name, double spacings) {
    state->addUniform(number(name, spacings * spacing), osg::StateAttribute::ON);
  };
  osg::StateSet* all = root_->getStateSet();
  set(all, "range", kRange);
  set(all, "clamp_range", kClampRange);
  set(all, "skin", kSkin);
  set(all, "lift", kLift);
  set(all, "spread", kSpread);
  set(all, "sink", kRadius - kHalfAbove);
  set(passes_[0].camera->getStateSet(), "radius", kRadius);
  set(passes_[kTint].camera->getStateSet(), "radius", kTintRadius);
  width_ = 0;  // passes that depend on it are made anew
}

void MediumSurface::set_colors(bool by_scalar, const std::optional<OneTint>& tint) {
  const bool is_clear = medium_ == Medium::clear;
  if (by_scalar != by_scalar_ || (is_clear && tint.has_value() != one_tint_)) width_ = 0;  // other formats
  by_scalar_ = by_scalar;
  one_tint_ = tint.has_value();
  osg::StateSet* state = shading_->getOrCreateStateSet();
  state->getOrCreateUniform("one_tint", osg::Uniform::BOOL)->set(one_tint_);
  passes_[kTint].camera->setNodeMask(one_tint_ && !is_clear ? 0u : ~0u);
  if (!tint) return;
  const auto depth = static_cast<float>(0.5 * kSkin * spacing_);  // what the pass sums up in matter that is deeper
  state->getOrCreateUniform("own_tint", osg::Uniform::FLOAT_VEC4)->set(osg::Vec4f(tint->color, depth));
  state->getOrCreateUniform("own_look", osg::Uniform::FLOAT_VEC4)->set(tint->surface);
}

// The fewer numbers a texel has, the quicker it is drawn, cleared and read: beside distances there is a scalar only
// where colours show it, and of what is clear and has one look there is the thickness alone.
void MediumSurface::choose_formats() {
  const bool scalar = by_scalar_, thickness = medium_ == Medium::clear && one_tint_;
  for (std::size_t i = 0; i < passes_.size(); ++i) {
    osg::Texture2D& texture = *passes_[i].texture;
    if (i == kTint)
      set_format(texture, thickness ? GL_R16F : GL_RGBA16F_ARB, thickness ? GL_RED : GL_RGBA);
    else if (i == kSurface || i >= kBeforeSmoothing)
      set_format(texture, scalar ? GL_RG32F : GL_R32F, scalar ? GL_RG : GL_RED);
  }
  osg::Camera& tint = *passes_[kTint].camera;
  tint.getStateSet()->setAttributeAndModes(thickness ? thickness_program_ : tint_program_);
  if (thickness)
    tint.detach(osg::Camera::COLOR_BUFFER1);
  else
    tint.attach(osg::Camera::COLOR_BUFFER1, surface_looks_);
}

void MediumSurface::set_ended_by_walls(bool ended) { root_->getStateSet()->getUniform("ended_by_walls")->set(ended); }

void MediumSurface::set_size(int width, int height, const SurfaceQuality& quality) {
  if (width == width_ && height == height_ && quality == quality_) return;
  width_ = width;
  height_ = height;
  quality_ = quality;
  make_smoothing();
  choose_formats();
  drawn_ = {};
  for (Pass& pass : passes_) {
    const double scale = quality_.scale * pass.share;
    const int across = texels_of(width, scale), up = texels_of(height, scale);
    if (&pass == &passes_[kTint]) {
      surface_looks_->setTextureSize(across, up);
      surface_looks_->dirtyTextureObject();
    }
    resize_pass(*pass.camera, *pass.texture, across, up);
    pass.camera->getStateSet()->getUniform("target_height")->set(static_cast<float>(up));
  }
  const osg::Vec2f surface = size_of(*passes_[0].texture), tints = size_of(*passes_[kTint].texture);
  passes_[kTint]
      .camera->getStateSet()
      ->getUniform("surface_per_target")
      ->set(osg::Vec2f(surface.x() / tints.x(), surface.y() / tints.y()));
  osg::StateSet* state = shading_->getStateSet();
  state->addUniform(new osg::Uniform("target_size", osg::Vec2f(static_cast<float>(width), static_cast<float>(height))));
  state->addUniform(new osg::Uniform("surface_size", surface));
}

void MediumSurface::set_seen(const osg::BoundingBoxd& box, const osg::Matrixd& view, const osg::Matrixd& projection) {
  root_->setNodeMask(box.valid() ? ~0u : 0u);
  if (!box.valid()) return;
  // the box's corners in the picture; one at or behind the eye may be seen anywhere
  Share seen{{1, 1}, {0, 0}};
  double nearest = 1e30;
  for (unsigned i = 0; i < 8; ++i) {
    osg::Vec3d corner = box.corner(i);
    for (unsigned k = 0; k < 3; ++k) corner[static_cast<int>(k)] += ((i >> k & 1u) != 0 ? 2 : -2) * spacing_;
    const osg::Vec4d p = osg::Vec4d(corner, 1) * view * projection;
    nearest = std::min(nearest, p.w());
    for (int k = 0; k < 2; ++k) {
      const double at = p.w() > 1e-6 ? std::clamp(0.5 * (p[k] / p.w() + 1), 0.0, 1.0) : 0;
      seen.low[k] = std::min(seen.low[k], at);
      seen.high[k] = std::max(seen.high[k], p.w() > 1e-6 ? at : 1.0);
    }
  }
  // how far the outline spreads what is nearest; farther things spread less
  const double spread = 0.5 * passes_[kOutline].texture->getTextureHeight() * projection(1, 1) * kSpread * spacing_;
  const double reach = std::max(std::ceil(2.2 * spread / std::max(nearest, spacing_)), 2.0);
  const double taps = std::min<double>(reach, quality_.outline_taps);
  root_->getStateSet()->getUniform("outline_taps")->set(static_cast<int>(taps));
  root_->getStateSet()->getUniform("outline_stride")->set(static_cast<float>(std::min(reach / taps, 2.0)));
  // passes that are not cleared draw nothing, too, where the last picture had something
  Share both = seen;
  for (int k = 0; k < 2; ++k) {
    both.low[k] = std::min(both.low[k], drawn_.low[k]);
    both.high[k] = std::max(both.high[k], drawn_.high[k]);
  }
  drawn_ = seen;
  for (const Pass& pass : passes_)
    confine(*pass.scissor, pass.camera->getClearMask() == 0 ? both : seen, pass.texture->getTextureWidth(),
            pass.texture->getTextureHeight());
  confine(*picture_scissor_, seen, width_, height_);
}

void MediumSurface::confine(osg::Scissor& scissor, const Share& to, double width, double height) {
  const auto x = static_cast<int>(std::floor(to.low[0] * width)), y = static_cast<int>(std::floor(to.low[1] * height));
  scissor.setScissor(x, y, static_cast<int>(std::ceil(to.high[0] * width)) - x,
                     static_cast<int>(std::ceil(to.high[1] * height)) - y);
}

}  // namespace palp
