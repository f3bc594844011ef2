// The devices that EGL can draw on without a window, and which of them --gpu names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palp {

// Where a device sits on the PCI bus.
struct PciAddress {
  std::uint32_t domain = 0, bus = 0, device = 0, function = 0;
  bool operator==(const PciAddress&) const = default;
};

// Reads "0000:65:00.0", or "65:00.0" in domain 0, in hexadecimal digits. Returns nothing where the text is no address.
std::optional<PciAddress> parse_pci_address(std::string_view text);
std::string to_string(const PciAddress& address);
// Returns the address of the GPU behind a file such as /dev/dri/card0, which need not exist, by the system's own
// tables; nothing where it is on no PCI bus.
std::optional<PciAddress> address_of_drm(const std::string& file, const std::filesystem::path& tables = "/sys");

// A GPU as CUDA's driver knows it.
struct CudaDevice {
  std::optional<PciAddress> address;
  std::string identity;  // as gpu_identity() writes it; empty: unknown
};

// A device of EGL, whose number is its place in EGL's list.
struct GpuDevice {
  bool software = false;                // a rasteriser that computes on the CPU
  std::optional<PciAddress> address{};  // unset: unknown
  std::optional<int> cuda{};            // CUDA's number of it; unset: unknown, or it computes no CUDA
  std::string identity{};               // as gpu_identity() writes it; empty: unknown
  bool simulates = false;               // a server of this user on this host computes on it
};

// Fills in what CUDA knows of a device: its own number, found by identity, else by address, else the one that EGL told
// already; and address and identity, where EGL told none. all: CUDA's devices by their numbers.
void match_cuda(GpuDevice& device, const std::vector<CudaDevice>& all);

// Returns the numbers of those devices that gpu names (egl_window.h), the best first; none where it names Mesa's
// rasteriser. Throws std::runtime_error with one sentence that tells what there is.
std::vector<std::size_t> gpus_named(const std::string& gpu, const std::vector<GpuDevice>& devices);
// Returns by what names a device goes: "egl:0, pci:0000:65:00.0, cuda:1".
std::string names_of(const GpuDevice& device, std::size_t number);

}  // namespace palp
