#include "viewer/gpu_devices.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>

#include <fmt/format.h>

namespace palp {
namespace {

// Reads all of the text as a number that is not negative.
std::optional<std::uint32_t> number_in(std::string_view text, int base) {
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value, base);
  if (error != std::errc() || rest != end) return std::nullopt;
  return value;
}

// Takes what stands behind the last such sign off the text; nothing where there is none.
std::optional<std::string_view> take_behind(std::string_view& text, char sign) {
  const std::size_t at = text.rfind(sign);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view behind = text.substr(at + 1);
  text = text.substr(0, at);
  return behind;
}

[[noreturn]] void refuse(const std::string& gpu, const std::string& expected, const std::vector<GpuDevice>& devices) {
  std::string there;
  for (std::size_t i = 0; i < devices.size(); ++i)
    there += fmt::format("{}{}{}", i > 0 ? "; " : "", names_of(devices[i], i), devices[i].software ? ", software" : "");
  throw std::runtime_error(fmt::format("--gpu {}: expected {}; EGL has {} here{}{}", gpu, expected,
                                       devices.empty() ? "no devices" : "these devices", devices.empty() ? "" : ": ",
                                       there));
}

}  // namespace

std::optional<PciAddress> parse_pci_address(std::string_view text) {
  const auto function = take_behind(text, '.');
  const auto device = function ? take_behind(text, ':') : std::nullopt;
  if (!device) return std::nullopt;
  const std::string_view whole = text;
  const std::string_view bus = take_behind(text, ':').value_or(whole);
  const std::string_view domain = bus.size() == whole.size() ? "0" : text;
  // how many digits each has at most, and how large it is at most
  struct Part {
    std::string_view digits;
    std::size_t longest;
    std::uint32_t largest;
  };
  std::array<std::uint32_t, 4> values{};
  const std::array<Part, 4> parts{Part{domain, 8, 0xffffffff}, Part{bus, 2, 0xff}, Part{*device, 2, 0x1f},
                                  Part{*function, 1, 7}};
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const auto value = number_in(parts[k].digits, 16);
    if (!value || parts[k].digits.size() > parts[k].longest || *value > parts[k].largest) return std::nullopt;
    values[k] = *value;
  }
  return PciAddress{values[0], values[1], values[2], values[3]};
}

std::string to_string(const PciAddress& a) {
  return fmt::format("{:04x}:{:02x}:{:02x}.{:x}", a.domain, a.bus, a.device, a.function);
}

std::optional<PciAddress> address_of_drm(const std::string& file, const std::filesystem::path& tables) {
  const std::filesystem::path node = std::filesystem::path(file).filename();
  std::error_code error;
  const auto device = std::filesystem::read_symlink(tables / "class" / "drm" / node / "device", error);
  return error ? std::nullopt : parse_pci_address(device.filename().string());
}

void match_cuda(GpuDevice& device, const std::vector<CudaDevice>& all) {
  const auto take = [&](auto&& same) {
    const auto found = std::ranges::find_if(all, same);
    if (found != all.end()) device.cuda = static_cast<int>(found - all.begin());
    return found != all.end();
  };
  if (device.identity.empty() || !take([&](const CudaDevice& c) { return c.identity == device.identity; }))
    if (device.address) take([&](const CudaDevice& c) { return c.address == device.address; });
  if (!device.cuda || static_cast<std::size_t>(*device.cuda) >= all.size()) return;
  const CudaDevice& known = all[static_cast<std::size_t>(*device.cuda)];
  if (!device.address) device.address = known.address;
  if (device.identity.empty()) device.identity = known.identity;
}

std::string names_of(const GpuDevice& device, std::size_t number) {
  std::string names = fmt::format("egl:{}", number);
  if (device.address) names += fmt::format(", pci:{}", to_string(*device.address));
  if (device.cuda) names += fmt::format(", cuda:{}", *device.cuda);
  return names;
}

std::vector<std::size_t> gpus_named(const std::string& gpu, const std::vector<GpuDevice>& devices) {
  if (gpu == "cpu") return {};
  std::vector<std::size_t> numbers;
  const auto add_those = [&](auto&& wanted) {
    for (std::size_t i = 0; i < devices.size(); ++i)
      if (wanted(devices[i])) numbers.push_back(i);
  };
  if (gpu == "auto") {
    add_those([](const GpuDevice& d) { return !d.software && !d.simulates; });
    add_those([](const GpuDevice& d) { return !d.software && d.simulates; });
    return numbers;
  }
  const std::string_view kind = std::string_view(gpu).substr(0, 4);
  if (kind == "egl:") {
    const auto number = number_in(std::string_view(gpu).substr(4), 10);
    if (!number || *number >= devices.size())
      refuse(gpu, fmt::format("egl:N with N below {}", devices.size()), devices);
    return {*number};
  }
  if (kind == "pci:") {
    const auto address = parse_pci_address(std::string_view(gpu).substr(4));
    if (!address) refuse(gpu, "an address as in pci:0000:65:00.0 or pci:65:00.0", devices);
    add_those([&](const GpuDevice& d) { return d.address == address; });
    if (numbers.empty()) refuse(gpu, "the address of a GPU that EGL can draw on", devices);
  } else if (gpu.starts_with("cuda:")) {
    const auto number = number_in(std::string_view(gpu).substr(5), 10);
    add_those([&](const GpuDevice& d) { return number && d.cuda == static_cast<int>(*number); });
    if (numbers.empty()) refuse(gpu, "CUDA's number of a GPU that EGL can draw on, as in cuda:0", devices);
  } else {
    refuse(gpu, "auto, cpu, list, egl:N, pci:DDDD:BB:DD.F or cuda:N", devices);
  }
  return numbers;
}

}  // namespace palp
