#include "config/version.h"

namespace palp {

std::string version() { return PALP_VERSION; }
std::string version_of(const std::string& program) { return program + " " + version(); }

}  // namespace palp
