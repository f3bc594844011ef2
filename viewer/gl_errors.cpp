#include "viewer/gl_errors.h"

#include <osg/GLExtensions>

#ifndef APIENTRY
#define APIENTRY
#endif

namespace palp {
namespace {

// From KHR_debug, which the headers of OpenGL 1.x lack.
constexpr GLenum kDebugOutput = 0x92E0, kDebugOutputSynchronous = 0x8242, kDebugTypeError = 0x824C;

using DebugCallback = void(APIENTRY*)(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                      const char* message, const void* user);
using SetDebugCallback = void(APIENTRY*)(DebugCallback callback, const void* user);

void APIENTRY tell(GLenum /*source*/, GLenum type, GLuint /*id*/, GLenum /*severity*/, GLsizei /*length*/,
                   const char* message, const void* user) {
  if (type == kDebugTypeError) (*static_cast<const GlErrorListener*>(user))(message);
}

}  // namespace

bool listen_to_gl_errors(const GlErrorListener& listener) {
  SetDebugCallback set_callback = nullptr;
  if (!osg::setGLExtensionFuncPtr(set_callback, "glDebugMessageCallback", "glDebugMessageCallbackKHR") ||
      set_callback == nullptr)
    return false;
  set_callback(tell, &listener);
  glEnable(kDebugOutput);
  glEnable(kDebugOutputSynchronous);
  return true;
}

}  // namespace palp
