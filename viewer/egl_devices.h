// The devices that can draw without a window, by what EGL, the system and CUDA's driver tell of them.
#pragma once

#include <vector>

#include "viewer/gpu_devices.h"

namespace palp {

// Returns EGL's handles of its devices, in its order; none where it cannot list them.
std::vector<void*> egl_device_handles();

// Returns what is known of each. ask_cuda: CUDA's driver is opened, too, where there is one and a device that is no
// software, which may take tenths of a second.
std::vector<GpuDevice> describe_devices(const std::vector<void*>& handles, bool ask_cuda);

}  // namespace palp
