#include "haptic_bridge/device/spacenav.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <dlfcn.h>
#include <spnav.h>
#include <sys/socket.h>

#include <fmt/format.h>

#include "config/error.h"
#include "haptic_bridge/loop/force_limits.h"
#include "idl/coupling.h"

namespace palp {

namespace {

constexpr double kFullPush = 350;       // what the daemon sends when the cap is pushed fully
constexpr double kDeadZone = 0.05;      // of that: a cap at rest is not quite at rest
constexpr double kLongestPause = 0.05;  // after a longer pause of the loop the handle stood still [s]
constexpr double kSettling = 0.03;      // of the speed [s]: the cap moves in steps
constexpr int kEventsATick = 64;
constexpr double kForceLimit = 8, kTorqueLimit = 0.5;  // that hold the handle back fully [N], [N m]

// The library is opened at run time and may be of a later version than the header: some have longer events.
struct EventRoom {
  spnav_event known;
  unsigned char room[256 - sizeof(spnav_event)];
};

double push(int value) {
  const double share = std::clamp(value / kFullPush, -1.0, 1.0);
  return std::abs(share) < kDeadZone ? 0 : (share - std::copysign(kDeadZone, share)) / (1 - kDeadZone);
}

// Its x is to the right, y up, z away from the user: the world's x, z and y.
Eigen::Vector3d to_world(int x, int y, int z) { return {push(x), push(z), push(y)}; }

}  // namespace

struct SpacenavDevice::Library {
  explicit Library(const std::string& path) : handle(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (!handle) {
      const char* reason = dlerror();
      throw ConfigError(
          fmt::format("3D mouse: the library {} cannot be loaded ({}); install libspnav or name it with "
                      "--library",
                      path, reason ? reason : "no reason was given"));
    }
    find(path, "spnav_open", open);
    find(path, "spnav_close", close);
    find(path, "spnav_fd", fd);
    find(path, "spnav_poll_event", poll_event);
  }
  ~Library() {
    if (connected) close();
    if (handle) dlclose(handle);
  }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  void connect() {
    if (open() == -1)
      throw std::runtime_error("3D mouse: the spacenav daemon does not answer; start spacenavd and plug the mouse in");
    connected = true;
  }

  template <class F>
  void find(const std::string& path, const char* name, F*& function) {
    function = reinterpret_cast<F*>(dlsym(handle, name));
    if (function) return;
    dlclose(handle);
    throw ConfigError(fmt::format("3D mouse: the library {} has no function {}, so it is not libspnav", path, name));
  }

  void* handle;
  bool connected = false;
  int (*open)() = nullptr;
  int (*close)() = nullptr;
  int (*fd)() = nullptr;
  int (*poll_event)(spnav_event*) = nullptr;
};

SpacenavDevice::SpacenavDevice(const SpacenavSetup& setup, const RigidState& start)
    : setup_(setup),
      library_(std::make_unique<Library>(setup.library)),
      info_{"3D mouse", kForceLimit, kTorqueLimit, false},
      state_(start),
      felt_(zero_wrench()) {
  library_->connect();
}

SpacenavDevice::~SpacenavDevice() = default;

void SpacenavDevice::check(const SpacenavSetup& setup) { Library(setup.library).connect(); }

bool SpacenavDevice::read(std::int64_t now_ns, DeviceReading& out) noexcept {
  if (!started_) t_last_ns_ = now_ns;
  started_ = true;
  take_events();
  if (gone_) return false;
  move(std::clamp(1e-9 * static_cast<double>(now_ns - t_last_ns_), 0.0, kLongestPause));
  t_last_ns_ = now_ns;
  out.state = state_;
  out.dead_man = grip_.holds(now_ns);
  out.powered = out.chain_closed = true;
  out.buttons = buttons_;
  return true;
}

void SpacenavDevice::take_events() noexcept {
  EventRoom room{};
  const spnav_event& event = room.known;
  int n = 0;
  for (; n < kEventsATick && library_->poll_event(&room.known) != 0; ++n) {
    if (event.type == SPNAV_EVENT_MOTION) {
      push_ = to_world(event.motion.x, event.motion.y, event.motion.z);
      twist_ = to_world(event.motion.rx, event.motion.ry, event.motion.rz);
    } else if (event.type == SPNAV_EVENT_BUTTON && event.button.bnum >= 0 && event.button.bnum < 32) {
      const std::uint32_t bit = 1u << event.button.bnum;
      buttons_ = event.button.press ? buttons_ | bit : buttons_ & ~bit;
    }
  }
  // without the daemon the last push would last for ever
  char byte = 0;
  if (n == 0 && recv(library_->fd(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0) gone_ = true;
}

void SpacenavDevice::move(double dt) noexcept {
  if (dt <= 0) return;
  const double share = std::min(1.0, dt / kSettling);
  const Eigen::Vector3d v = setup_.speed * (saturated(push_, 1) + felt_.force / kForceLimit);
  const Eigen::Vector3d w = setup_.turn * (saturated(twist_, 1) + felt_.torque / kTorqueLimit);
  state_.linear += share * (v - state_.linear);
  state_.angular += share * (w - state_.angular);
  state_.position += dt * state_.linear;
  state_.orientation = (rotation_by(dt * state_.angular) * state_.orientation).normalized();
}

bool SpacenavDevice::write(const Wrench<double>& wrench) noexcept {
  if (!is_finite(wrench)) return false;
  felt_ = {saturated(wrench.force, kForceLimit), saturated(wrench.torque, kTorqueLimit)};
  return true;
}

std::string SpacenavDevice::trouble() const {
  return gone_ ? "3D mouse: the spacenav daemon has gone: start spacenavd and the bridge again" : "";
}

Driver spacenav_driver() {
  return {.name = "spacenav",
          .what = "a 3D mouse, without force",
          .needs = "libspnav and a running spacenavd",
          .options = {{"--library", "FILE", "[libspnav.so.0]"}},
          .starts_in_scene = true,
          .read_profile =
              [](TomlTable& root, DeviceProfile& profile) {
                SpacenavSetup& setup = profile.setup<SpacenavSetup>();
                TomlTable table = root.table("spacenav");
                if (const auto text = table.text("library")) setup.library = *text;
                read_number(table, "speed", {"m/s", 0, 2, true}, setup.speed);
                read_number(table, "turn", {"rad/s", 0, 10, true}, setup.turn);
              },
          .prepare =
              [](DeviceRequest& request) {
                SpacenavSetup& setup = request.profile.setup<SpacenavSetup>();
                setup.library = request.option("--library", setup.library);
                SpacenavDevice::check(setup);
              },
          .open = [](const DeviceRequest& request, const HandleStart& start) -> std::unique_ptr<HapticDevice> {
            return std::make_unique<SpacenavDevice>(request.profile.setup<SpacenavSetup>(), start.at);
          },
          .power_off = nullptr};
}

}  // namespace palp
