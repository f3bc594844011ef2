#include "viewer/egl_window.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include <osg/GL>
#include <osg/State>

#include "viewer/egl_devices.h"

namespace palp {
namespace {

[[noreturn]] void fail(const std::string& step) {
  char code[16];
  std::snprintf(code, sizeof code, "0x%x", static_cast<unsigned>(eglGetError()));
  throw std::runtime_error("cannot render off-screen: " + step + " (EGL error " + code +
                           "); check that libegl1 and libgl1-mesa-dri are installed, or choose another --gpu");
}

EGLDisplay open_display(EGLenum platform, void* device) {
  const auto get = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (get == nullptr) return EGL_NO_DISPLAY;
  const EGLDisplay display = get(platform, device, nullptr);
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return EGL_NO_DISPLAY;
  return display;
}

EGLDisplay choose_display(const std::string& gpu) {
  const std::vector<void*> handles = gpu == "cpu" ? std::vector<void*>() : egl_device_handles();
  const bool asks_cuda = gpu.starts_with("pci:") || gpu.starts_with("cuda:");
  for (const std::size_t number : gpus_named(gpu, describe_devices(handles, asks_cuda))) {
    const EGLDisplay display = open_display(EGL_PLATFORM_DEVICE_EXT, handles[number]);
    if (display != EGL_NO_DISPLAY) return display;
    if (gpu != "auto") fail("EGL device " + std::to_string(number) + " cannot be opened");
  }
  const EGLDisplay display = open_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY);
  if (display == EGL_NO_DISPLAY) fail("Mesa's surfaceless platform cannot be opened");
  return display;
}

EGLConfig choose_config(EGLDisplay display, int samples) {
  for (int n = samples; n >= 0; n = n > 1 ? n / 2 : n - 1) {
    const EGLint wanted[] = {EGL_SURFACE_TYPE,
                             EGL_PBUFFER_BIT,
                             EGL_RENDERABLE_TYPE,
                             EGL_OPENGL_BIT,
                             EGL_RED_SIZE,
                             8,
                             EGL_GREEN_SIZE,
                             8,
                             EGL_BLUE_SIZE,
                             8,
                             EGL_ALPHA_SIZE,
                             8,
                             EGL_DEPTH_SIZE,
                             24,
                             EGL_STENCIL_SIZE,
                             8,
                             EGL_SAMPLE_BUFFERS,
                             n > 1 ? 1 : 0,
                             EGL_SAMPLES,
                             n > 1 ? n : 0,
                             EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    if (eglChooseConfig(display, wanted, &config, 1, &count) && count > 0) return config;
  }
  fail("no configuration with 8-bit colour, 24-bit depth and 8-bit stencil");
}

class EglWindow : public osgViewer::GraphicsWindow {
 public:
  EglWindow(int width, int height, int samples, const std::string& gpu, bool debug) {
    display_ = choose_display(gpu);
    if (!eglBindAPI(EGL_OPENGL_API)) fail("desktop OpenGL is not offered");
    config_ = choose_config(display_, samples);
    make_surface(width, height);
    const EGLint profile[] = {EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT,
                              debug ? EGL_CONTEXT_OPENGL_DEBUG : EGL_NONE, EGL_TRUE, EGL_NONE};
    context_ = eglCreateContext(display_, config_, EGL_NO_CONTEXT, profile);
    if (context_ == EGL_NO_CONTEXT) fail("no OpenGL compatibility context");

    setState(new osg::State);
    getState()->setGraphicsContext(this);
    getState()->setContextID(osg::GraphicsContext::createNewContextID());
  }

  // Another surface of the first one's context.
  EglWindow(EglWindow& first, int width, int height)
      : first_(&first), display_(first.display_), config_(first.config_), context_(first.context_) {
    make_surface(width, height);
    setState(first.getState());
  }

  bool valid() const override { return context_ != EGL_NO_CONTEXT && (!first_ || first_->valid()); }
  bool realizeImplementation() override { return realized_ = true; }
  bool isRealizedImplementation() const override { return realized_; }
  void closeImplementation() override {
    if (context_ == EGL_NO_CONTEXT) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (!first_) eglDestroyContext(display_, context_);
    eglDestroySurface(display_, surface_);
    context_ = EGL_NO_CONTEXT;
    realized_ = false;
  }
  bool makeCurrentImplementation() override {
    return valid() && eglMakeCurrent(display_, surface_, surface_, context_);
  }
  bool releaseContextImplementation() override {
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  // A pbuffer has nothing to swap; waiting for the picture keeps frames from piling up in the driver.
  void swapBuffersImplementation() override { glFinish(); }
  void grabFocus() override {}
  void grabFocusIfPointerInWindow() override {}
  void raiseWindow() override {}

 protected:
  ~EglWindow() override { closeImplementation(); }

 private:
  void make_surface(int width, int height) {
    const EGLint size[] = {EGL_WIDTH, width, EGL_HEIGHT, height, EGL_NONE};
    surface_ = eglCreatePbufferSurface(display_, config_, size);
    if (surface_ == EGL_NO_SURFACE) fail("no surface of the asked size");
    _traits = new osg::GraphicsContext::Traits;
    _traits->width = width;
    _traits->height = height;
    _traits->doubleBuffer = false;
    eglGetConfigAttrib(display_, config_, EGL_SAMPLES, reinterpret_cast<EGLint*>(&_traits->samples));
    getEventQueue()->syncWindowRectangleWithGraphicsContext();
  }

  osg::ref_ptr<EglWindow> first_;  // whose context it is; null: its own
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLConfig config_ = nullptr;
  EGLSurface surface_ = EGL_NO_SURFACE;
  EGLContext context_ = EGL_NO_CONTEXT;
  bool realized_ = false;
};

// Returns what OpenGL calls itself on that device of EGL, or why it cannot be asked.
std::string renderer_of(std::size_t number) {
  try {
    const auto window = make_egl_window(16, 16, 0, "egl:" + std::to_string(number), false);
    const auto* name = window->realize() && window->makeCurrent() ? glGetString(GL_RENDERER) : nullptr;
    std::string renderer = name != nullptr ? reinterpret_cast<const char*>(name) : "no OpenGL context becomes current";
    window->close();
    return renderer;
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

}  // namespace

osg::ref_ptr<osgViewer::GraphicsWindow> make_egl_window(int width, int height, int samples, const std::string& gpu,
                                                        bool debug) {
  return new EglWindow(width, height, samples, gpu, debug);
}

osg::ref_ptr<osgViewer::GraphicsWindow> make_egl_window_beside(osgViewer::GraphicsWindow& first, int width,
                                                               int height) {
  auto* window = dynamic_cast<EglWindow*>(&first);
  return window != nullptr ? new EglWindow(*window, width, height) : nullptr;
}

std::string list_gpus() {
  const std::vector<GpuDevice> devices = describe_devices(egl_device_handles(), true);
  if (devices.empty()) return "EGL has no devices here: cpu is left\n";
  std::string lines;
  for (std::size_t i = 0; i < devices.size(); ++i)
    lines += names_of(devices[i], i) + ": " + renderer_of(i) +
             (devices[i].simulates ? ", a palp-sim-server computes on it" : "") + "\n";
  return lines;
}

}  // namespace palp
