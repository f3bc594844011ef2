#include "viewer/egl_devices.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <exception>
#include <memory>
#include <string>

#include "idl/clock.h"
#include "idl/gpu_page.h"

namespace palp {
namespace {

template <class Function>
Function egl_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

bool has(const std::string& extensions, const std::string& name) {
  return (" " + extensions + " ").find(" " + name + " ") != std::string::npos;
}

std::string text_of(EGLDeviceEXT device, EGLint what) {
  const auto query = egl_function<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
  const char* text = query == nullptr ? nullptr : query(device, what);
  return text == nullptr ? "" : text;
}

std::string identity_of(EGLDeviceEXT device) {
  const auto query = egl_function<PFNEGLQUERYDEVICEBINARYEXTPROC>("eglQueryDeviceBinaryEXT");
  std::array<unsigned char, 16> uuid{};
  EGLint written = 0;
  if (query == nullptr || !query(device, EGL_DEVICE_UUID_EXT, uuid.size(), uuid.data(), &written)) return "";
  return written == static_cast<EGLint>(uuid.size()) ? gpu_identity(uuid.data()) : "";
}

// Asks the few functions that are needed of CUDA's driver, without being linked to it.
std::vector<CudaDevice> cuda_devices() {
  const std::unique_ptr<void, int (*)(void*)> driver(dlopen("libcuda.so.1", RTLD_NOW | RTLD_LOCAL), dlclose);
  if (!driver) return {};
  const auto find = [&]<class Function>(Function& f, const char* name) {
    f = reinterpret_cast<Function>(dlsym(driver.get(), name));
    return f != nullptr;
  };
  int (*init)(unsigned) = nullptr;
  int (*count_of)(int*) = nullptr;
  int (*address_of)(char*, int, int) = nullptr;
  int (*uuid_of)(void*, int) = nullptr;
  int count = 0;
  if (!find(init, "cuInit") || !find(count_of, "cuDeviceGetCount") || !find(address_of, "cuDeviceGetPCIBusId") ||
      !find(uuid_of, "cuDeviceGetUuid") || init(0) != 0 || count_of(&count) != 0)
    return {};
  std::vector<CudaDevice> devices(static_cast<std::size_t>(std::max(count, 0)));
  for (int k = 0; k < count; ++k) {
    CudaDevice& device = devices[static_cast<std::size_t>(k)];
    std::array<char, 32> address{};
    std::array<unsigned char, 16> uuid{};
    // a handle of CUDA's driver is the number of the device
    if (address_of(address.data(), address.size() - 1, k) == 0) device.address = parse_pci_address(address.data());
    if (uuid_of(uuid.data(), k) == 0) device.identity = gpu_identity(uuid.data());
  }
  return devices;
}

// Says whether a server computes there. Whoever cannot see its page does not know of it.
bool is_simulated_on(const std::string& identity) {
  if (identity.empty()) return false;
  try {
    return in_use(*open_gpu_page(identity), now_ns());
  } catch (const std::exception&) {
    return false;
  }
}

GpuDevice known_of(EGLDeviceEXT handle) {
  const std::string extensions = text_of(handle, EGL_EXTENSIONS);
  GpuDevice device;
  device.software = extensions.empty() || has(extensions, "EGL_MESA_device_software");
  if (has(extensions, "EGL_EXT_device_persistent_id")) device.identity = identity_of(handle);
  if (has(extensions, "EGL_EXT_device_drm")) device.address = address_of_drm(text_of(handle, EGL_DRM_DEVICE_FILE_EXT));
  if (!device.address && has(extensions, "EGL_EXT_device_drm_render_node"))
    device.address = address_of_drm(text_of(handle, EGL_DRM_RENDER_NODE_FILE_EXT));
  const auto query = egl_function<PFNEGLQUERYDEVICEATTRIBEXTPROC>("eglQueryDeviceAttribEXT");
  EGLAttrib number = 0;
  if (has(extensions, "EGL_NV_device_cuda") && query != nullptr && query(handle, EGL_CUDA_DEVICE_NV, &number))
    device.cuda = static_cast<int>(number);
  return device;
}

}  // namespace

std::vector<void*> egl_device_handles() {
  const auto query = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  EGLint count = 0;
  if (query == nullptr || !query(0, nullptr, &count) || count <= 0) return {};
  std::vector<EGLDeviceEXT> devices(static_cast<std::size_t>(count));
  if (!query(count, devices.data(), &count)) return {};
  devices.resize(static_cast<std::size_t>(count));
  return devices;
}

std::vector<GpuDevice> describe_devices(const std::vector<void*>& handles, bool ask_cuda) {
  std::vector<GpuDevice> devices(handles.size());
  std::ranges::transform(handles, devices.begin(), known_of);
  const bool hardware = std::ranges::any_of(devices, [](const GpuDevice& d) { return !d.software; });
  if (ask_cuda && hardware) {
    const std::vector<CudaDevice> cuda = cuda_devices();
    for (GpuDevice& device : devices) match_cuda(device, cuda);
  }
  for (GpuDevice& device : devices) device.simulates = is_simulated_on(device.identity);
  return devices;
}

}  // namespace palp
