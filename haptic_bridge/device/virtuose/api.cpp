#include "haptic_bridge/device/virtuose/api.h"

#include <dlfcn.h>

#include <filesystem>

#include <fmt/format.h>

#include "config/error.h"

namespace palp {

namespace {

constexpr const char* kAdvice = "give the path of Haption's VirtuoseAPI with --library or virtuose.library";

void* opened(const std::string& path) {
  if (void* handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) return handle;
  const char* reason = dlerror();
  const bool is_path = path.find('/') != std::string::npos;
  std::error_code ignored;
  if (is_path && !std::filesystem::exists(path, ignored))
    throw ConfigError(fmt::format("Virtuose library {}: there is no such file; {}", path, kAdvice));
  throw ConfigError(fmt::format("Virtuose library {}: it cannot be loaded ({}); {}", path,
                                reason ? reason : "no reason was given", kAdvice));
}

template <class F>
void find(void* handle, const std::string& path, const char* name, F*& function) {
  function = reinterpret_cast<F*>(dlsym(handle, name));
  if (!function)
    throw ConfigError(fmt::format("Virtuose library {}: it has no function {}, so it is not VirtuoseAPI version {}; {}",
                                  path, name, kVirtuoseMajorVersion, kAdvice));
}

}  // namespace

void VirtuoseApi::Unload::operator()(void* handle) const noexcept { dlclose(handle); }

VirtuoseApi::VirtuoseApi(const std::string& library) : path_(library), handle_(opened(library)) {
#define PALP_FIND(name, symbol, ...) find(handle_.get(), path_, #symbol, this->name.function);
  PALP_VIRTUOSE_CALLS(PALP_FIND)
#undef PALP_FIND
  find(handle_.get(), path_, "virtOpen", open);
  find(handle_.get(), path_, "virtGetErrorCode", error_code);
  find(handle_.get(), path_, "virtGetErrorMessage", error_message_);
  check_version();
}

void VirtuoseApi::check_version() {
  int (*read_version)(int*, int*) = nullptr;
  find(handle_.get(), path_, "virtAPIVersion", read_version);
  int major = 0, minor = 0;
  if (read_version(&major, &minor) != 0)
    throw ConfigError(fmt::format("Virtuose library {}: it does not tell its version; {}", path_, kAdvice));
  version_ = fmt::format("{}.{}", major, minor);
  if (major != kVirtuoseMajorVersion)
    throw ConfigError(fmt::format("Virtuose library {}: it is version {}, expected version {}; {}", path_, version_,
                                  kVirtuoseMajorVersion, kAdvice));
}

const char* VirtuoseApi::message(int code) const noexcept {
  const char* text = error_message_(code);
  return text && *text ? text : "unknown error";
}

}  // namespace palp
