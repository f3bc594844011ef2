// A listener for the errors of OpenGL, told of each as it is made.
#pragma once

#include <functional>
#include <string>

namespace palp {

// Gets one sentence of the driver's for each error, within the call that made it.
using GlErrorListener = std::function<void(const std::string&)>;

// Has the context that is current tell the listener, which must outlive the context, of every error. A debug context
// says more than others. Returns false if the driver cannot (no KHR_debug).
bool listen_to_gl_errors(const GlErrorListener& listener);

}  // namespace palp
