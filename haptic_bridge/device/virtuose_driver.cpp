// The row of the Virtuose in the table of drivers: its profile, its options, what it needs.
#include <cmath>

#include <fmt/format.h>

#include "config/error.h"
#include "haptic_bridge/device/virtuose.h"

namespace palp {

namespace {

// Where an axis of the arm points in the world: "+x", "-y", ...
Eigen::Vector3d direction(std::size_t choice) {
  return (choice % 2 == 0 ? 1 : -1) * Eigen::Vector3d::Unit(static_cast<int>(choice / 2));
}

void read_axes(TomlTable axes, Eigen::Matrix3d& m) {
  if (!axes.exists()) return;
  const char* const names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    if (const auto choice = axes.choice(names[i], {"+x", "-x", "+y", "-y", "+z", "-z"}, Need::required))
      m.col(i) = direction(*choice);
  }
  double turn = 0;
  read_number(axes, "turn_deg", {"degrees", -180, 180}, turn);
  if (std::abs(m.determinant() - 1) > 1e-9) {
    axes.fault("",
               "the axes are no rotation; expected three different ones, right-handed, such as x = \"-y\", y = "
               "\"+x\", z = \"+z\"");
    m = default_arm_axes();
  }
  m = Eigen::AngleAxisd(kDegree * turn, Eigen::Vector3d::UnitZ()) * m;
}

void read_virtuose(TomlTable table, VirtuoseSetup& setup) {
  if (const auto text = table.text("library")) setup.library = *text;
  if (const auto text = table.text("address")) setup.address = *text;
  if (const auto choice = table.choice("mode", {"impedance", "virtmech"}))
    setup.mode = *choice == 0 ? VirtuoseMode::impedance : VirtuoseMode::mechanism;
  if (const auto type = table.integer("device_type", 1, 1000)) setup.device_type = static_cast<int>(*type);
  read_number(table, "relay_time", {"s", 0, 60}, setup.relay_time);
}

void read_profile(TomlTable& root, DeviceProfile& profile) {
  VirtuoseSetup& setup = profile.setup<VirtuoseSetup>();
  read_axes(root.table("axes"), setup.axes);
  setup.in_profile = root.is_table("virtuose");
  read_virtuose(root.table("virtuose"), setup);
}

void prepare(DeviceRequest& request) {
  VirtuoseSetup& setup = request.profile.setup<VirtuoseSetup>();
  if (request.profile_file.empty()) {
    // wherever the arm stands, its handle begins at the tool
    request.profile.loop.workspace.relative = true;
  } else if (!setup.in_profile) {
    throw ConfigError(
        fmt::format("{}: it has no table [virtuose], so its limits are not for this arm: give one of "
                    "config/devices/virtuose_*.toml",
                    request.profile_file));
  }
  setup.library = request.option("--library", setup.library);
  setup.address = request.option("--address", setup.address);
  if (const std::string mode = request.option("--virtuose-mode"); !mode.empty())
    setup.mode = mode == "virtmech" ? VirtuoseMode::mechanism : VirtuoseMode::impedance;
  const VirtuoseApi can_be_used(setup.library);
}

VirtuoseSetup setup_of(const DeviceRequest& request) {
  VirtuoseSetup setup = request.profile.setup<VirtuoseSetup>();
  setup.limits = request.profile.loop.limits;
  setup.gains = request.profile.loop.gains;
  setup.period = 1e-9 * static_cast<double>(request.profile.loop.period_ns);
  return setup;
}

}  // namespace

Driver virtuose_driver() {
  return {
      .name = "virtuose",
      .what = "an arm by Haption",
      .needs = "Haption's VirtuoseAPI and its running service",
      .options = {{"--library", "FILE", "Haption's VirtuoseAPI, or one like it [libVirtuoseAPI.so]"},
                  {"--address", "HOST#PORT", "where its service listens [127.0.0.1#53210]"},
                  {"--virtuose-mode", "impedance|virtmech",
                   "impedance: the bridge renders the coupling and sends force; virtmech: the arm's controller does "
                   "[impedance]"}},
      .starts_in_scene = true,
      .read_profile = read_profile,
      .prepare = prepare,
      .open = [](const DeviceRequest& request, const HandleStart& start) -> std::unique_ptr<HapticDevice> {
        return std::make_unique<VirtuoseDevice>(setup_of(request), start.at);
      },
      .power_off = [](const DeviceRequest& request) { power_off(setup_of(request)); }};
}

}  // namespace palp
