#include "viewer/stage.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <spdlog/spdlog.h>
#include <osg/DisplaySettings>
#include <osgGA/OrbitManipulator>

#include "viewer/egl_window.h"
#include "viewer/picture_mean.h"
#include "viewer/window_beside.h"

namespace palp {

// Draws the overlay, and copies the finished picture out of OpenGL when someone wants it.
class Stage::ReadBack : public osg::Camera::DrawCallback {
 public:
  void operator()(osg::RenderInfo& info) const override {
    in_pieces(info, 1, [&](int, int) {
      if (overlay && overlay_in_pictures) overlay();
      if (wanted) read(info);
      if (overlay && !overlay_in_pictures) overlay();
    });
  }
  const std::function<void(Picture&&)>* wanted = nullptr;
  std::function<void()> overlay;
  bool overlay_in_pictures = false;

 private:
  void read(osg::RenderInfo& info) const {
    const osg::Viewport* viewport = info.getCurrentCamera()->getViewport();
    Picture picture;
    picture.width = static_cast<int>(viewport->width());
    picture.height = static_cast<int>(viewport->height());
    picture.rgb.resize(3u * static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, picture.width, picture.height, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
    (*wanted)(std::move(picture));
  }
};

namespace {

osg::ref_ptr<osg::GraphicsContext> open_x11_window(const StageOptions& options) {
  osg::ref_ptr<osg::GraphicsContext::Traits> traits =
      new osg::GraphicsContext::Traits(osg::DisplaySettings::instance());
  traits->readDISPLAY();
  traits->setUndefinedScreenDetailsToDefaultScreen();
  traits->x = options.x;
  traits->y = options.y;
  traits->width = options.width;
  traits->height = options.height;
  traits->stencil = 8;
  traits->samples = static_cast<unsigned>(options.samples);
  traits->sampleBuffers = options.samples > 0 ? 1 : 0;
  traits->windowDecoration = true;
  traits->doubleBuffer = true;
  traits->windowName = options.title;
  osg::ref_ptr<osg::GraphicsContext> context = osg::GraphicsContext::createGraphicsContext(traits);
  if (!context && options.samples > 0) {
    traits->samples = 0;
    traits->sampleBuffers = 0;
    context = osg::GraphicsContext::createGraphicsContext(traits);
  }
  return context;
}

}  // namespace

Stage::Stage(const StageOptions& options) : Stage(options, nullptr) {}
Stage::Stage(const StageOptions& options, Stage& first) : Stage(options, &first) {}

Stage::Stage(const StageOptions& options, Stage* first)
    : is_first_(first == nullptr),
      scene_(is_first_ ? std::make_shared<SceneGraph>() : first->scene_),
      media_(*scene_),
      viewer_(new osgViewer::Viewer),
      read_back_(new ReadBack),
      surfaces_(options.surfaces),
      mean_of_(options.mean_of),
      on_gl_error_(options.on_gl_error) {
  viewer_->setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
  viewer_->setLightingMode(osg::View::NO_LIGHT);
  viewer_->setKeyEventSetsDone(0);  // Escape has other uses, too (controls.h)
  if (is_first_)
    open_window(options);
  else
    window_ = open_window_beside(*first->window_, {options.width, options.height, options.title, options.x, options.y});

  osg::Camera* camera = viewer_->getCamera();
  camera->setGraphicsContext(window_);
  camera->setViewport(new osg::Viewport(0, 0, window_->getTraits()->width, window_->getTraits()->height));
  if (!options.headless) {
    // off-screen the context's own choice stands: a pbuffer has a back buffer alone by the EGL specification and a
    // front buffer alone in Mesa, and naming the other one is an invalid operation
    const GLenum buffer = window_->getTraits()->doubleBuffer ? GL_BACK : GL_FRONT;
    camera->setDrawBuffer(buffer);
    camera->setReadBuffer(buffer);
  }
  camera->setClearMask(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);  // the background is drawn all over
  camera->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
  camera->setFinalDrawCallback(read_back_);

  osg::ref_ptr<osg::Group> root = new osg::Group;
  root->addChild(scene_->root());
  root->addChild(media_.node());
  root->addChild(hud_.camera());
  viewer_->setSceneData(root);
  osg::ref_ptr<osgGA::OrbitManipulator> orbit = new osgGA::OrbitManipulator;
  orbit->setVerticalAxisFixed(true);
  orbit->setAllowThrow(false);
  orbit->setWheelZoomFactor(-0.1);
  viewer_->setCameraManipulator(orbit, false);

  viewer_->realize();
  if (!viewer_->isRealized() || !window_->makeCurrent()) {
    throw std::runtime_error("cannot make an OpenGL context current; try --headless");
  }
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  renderer_ = name != nullptr ? name : "unknown";
  if (is_first_ && on_gl_error_ && !listen_to_gl_errors(on_gl_error_))
    spdlog::warn("this OpenGL cannot tell of its errors as they happen");
  if (!software_rendered()) pace(pacing_of_current_gpu().get());
  window_->releaseContext();
  go_home();
}

// The context is closed while everything that lives in it still does, so that OpenGL objects are deleted with it
// current. A window beside another one goes without them: what it drew the other one draws, too, and what nobody draws
// any more OSG deletes with the other one's next picture.
Stage::~Stage() {
  viewer_->setDone(true);
  if (!is_first_) {
    viewer_->getCamera()->setGraphicsContext(nullptr);
    window_->setState(nullptr);
  }
  window_->close();
}

void Stage::open_window(const StageOptions& options) {
  if (options.headless) {
    window_ =
        make_egl_window(options.width, options.height, options.samples, options.gpu, options.on_gl_error != nullptr);
    return;
  }
  osg::ref_ptr<osg::GraphicsContext> context = open_x11_window(options);
  window_ = dynamic_cast<osgViewer::GraphicsWindow*>(context.get());
  if (!window_) throw std::runtime_error("cannot open a window on DISPLAY; try --headless");
}

bool Stage::software_rendered() const {
  return renderer_.find("llvmpipe") != std::string::npos || renderer_.find("softpipe") != std::string::npos ||
         renderer_.find("swrast") != std::string::npos;
}

int Stage::width() const { return static_cast<int>(viewer_->getCamera()->getViewport()->width()); }
int Stage::height() const { return static_cast<int>(viewer_->getCamera()->getViewport()->height()); }

void Stage::go_home_unless_moved() {
  if (viewer_->getCameraManipulator()->getMatrix() == home_) go_home();
}

// Steps back when a tool leaves the picture, unless someone has moved the camera. It never steps forth again, so a hand
// that goes to and fro does not shake the picture.
void Stage::keep_tools_in_picture() {
  if (viewer_->getCameraManipulator()->getMatrix() != home_) return;
  // the picture that is about to be drawn; how near and far it reaches does not matter
  const double aspect = static_cast<double>(width()) / height();
  const osg::Matrixd all = osg::Matrixd::inverse(home_) * osg::Matrixd::perspective(kFieldOfView, aspect, 1, 2);
  const std::vector<osg::Vec3d> corners = scene_->tools();
  const bool left = std::ranges::any_of(corners, [&](const osg::Vec3d& corner) {
    const osg::Vec4d p = osg::Vec4d(corner, 1) * all;
    return p.w() <= 0 || std::max(std::abs(p.x()), std::abs(p.y())) > p.w();
  });
  if (!left) return;
  scene_->widen_outline(corners);
  go_home();
}

void Stage::pace(GpuPacing* pacing) { pacing_ = pacing; }

void Stage::draw(const std::function<void(Picture&&)>& read) {
  if (!window_->valid()) return viewer_->setDone(true);
  if (pacing_) pacing_->begin_picture();
  window_->getState()->getGraphicsContext()->setUserData(pacing_);  // several windows may have one context
  hud_.set_size(width(), height());
  keep_tools_in_picture();
  // The events first, then the depth range that suits where they have put the camera.
  viewer_->advance();
  viewer_->eventTraversal();
  viewer_->updateTraversal();
  osg::Vec3d eye, center, up;
  viewer_->getCamera()->getViewMatrixAsLookAt(eye, center, up);
  const double radius = std::max(scene_->content().radius(), 1e-3);
  const double far = (eye - scene_->content().center()).length() + 6 * radius;
  const double near = std::max(far - 14 * radius, 0.02 * radius);
  viewer_->getCamera()->setProjectionMatrixAsPerspective(field_of_view_, static_cast<double>(width()) / height(), near,
                                                         far);
  const osg::Matrixd view = viewer_->getCamera()->getViewMatrix();
  if (!read || mean_of_ <= 1) return draw_from(view, true, read);
  // the camera turns by a part of a pixel: surfaces are found in eye space, where the projection displaces nothing
  const double pixel = 2 / (viewer_->getCamera()->getProjectionMatrix()(1, 1) * height());  // at a distance of 1
  PictureMean sum;
  for (int k = 0; k < mean_of_; ++k) {
    const osg::Vec2d by = displacement(k, mean_of_) * pixel;
    draw_from(view * osg::Matrixd::rotate(osg::Vec3d(0, 0, -1), osg::Vec3d(by, -1)), false,
              [&](Picture&& picture) { sum.add(picture); });
  }
  viewer_->getCamera()->setViewMatrix(view);
  read(sum.mean());
}

// hasty: surfaces may be as coarse as the renderer needs them.
void Stage::draw_from(const osg::Matrixd& view, bool hasty, const std::function<void(Picture&&)>& read) {
  viewer_->getCamera()->setViewMatrix(view);
  PictureView picture;
  picture.width = width();
  picture.height = height();
  picture.quick = hasty && (surfaces_ == Surfaces::automatic ? software_rendered() : surfaces_ == Surfaces::quick);
  picture.whole = !hasty;
  picture.draws_shadows = is_first_;
  picture.view = view;
  picture.projection = viewer_->getCamera()->getProjectionMatrix();
  scene_->set_view(picture);
  media_.set_view(picture);
  read_back_->wanted = read ? &read : nullptr;
  viewer_->renderingTraversals();
  read_back_->wanted = nullptr;
}

void Stage::set_overlay(std::function<void()> draw, bool in_pictures) {
  read_back_->overlay = std::move(draw);
  read_back_->overlay_in_pictures = in_pictures;
}

}  // namespace palp
