// A GraphicsWindow of OpenSceneGraph on an off-screen EGL surface: rendering, events and read-back with no X server.
#pragma once

#include <string>

#include <osg/ref_ptr>
#include <osgViewer/GraphicsWindow>

namespace palp {

// gpu: "auto" takes the first EGL device that is real hardware, else Mesa's software rasteriser; "egl:N" the N-th EGL
// device; "cpu" the software rasteriser. samples: 0 or samples per pixel wanted (fewer are taken when there are not as
// many). The context is the newest compatibility profile, because Debian's OSG draws nothing in a core profile.
// debug: a debug context, which explains its errors (see gl_errors.h).
// Throws std::runtime_error with one sentence saying which step of EGL failed.
osg::ref_ptr<osgViewer::GraphicsWindow> make_egl_window(int width, int height, int samples, const std::string& gpu,
                                                        bool debug);

}  // namespace palp
