// A GraphicsWindow of OpenSceneGraph on an off-screen EGL surface: rendering, events and read-back with no X server.
#pragma once

#include <string>

#include <osg/ref_ptr>
#include <osgViewer/GraphicsWindow>

namespace palp {

// gpu: "auto" takes the first EGL device that is real hardware, first of those that no server of this user computes on,
// else Mesa's software rasteriser; "egl:N" the N-th EGL device; "pci:0000:65:00.0" or "pci:65:00.0" the one at this PCI
// address; "cuda:N" the one that CUDA's driver numbers so in this process; "cpu" the software rasteriser. samples: 0 or
// samples per pixel wanted (fewer are taken when there are not as many). The context is the newest compatibility
// profile, because Debian's OSG draws nothing in a core profile. debug: a debug context, which explains its errors (see
// gl_errors.h).
// Throws std::runtime_error with one sentence saying which step of EGL failed, or what devices there are.
osg::ref_ptr<osgViewer::GraphicsWindow> make_egl_window(int width, int height, int samples, const std::string& gpu,
                                                        bool debug);

// Returns a surface of that size on the context of a window that make_egl_window() has made, or null where first is
// none of these (window_beside.h). Throws as make_egl_window() does.
osg::ref_ptr<osgViewer::GraphicsWindow> make_egl_window_beside(osgViewer::GraphicsWindow& first, int width, int height);

// Returns a line for each device of EGL: the names that gpu takes, what OpenGL calls itself there, and whether a server
// of this user computes on it. Opens each of them once.
std::string list_gpus();

}  // namespace palp
