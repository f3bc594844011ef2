// A connection to an arm through VirtuoseAPI: opened in the order of Haption's manual, every call checked, and closed
// in the reverse order whatever happened in between.
#pragma once

#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "haptic_bridge/device/virtuose/api.h"
#include "haptic_bridge/device/virtuose/frames.h"
#include "haptic_bridge/loop/force_limits.h"
#include "idl/messages.h"

namespace palp {

enum class VirtuoseMode {
  impedance,  // the bridge renders the coupling and sends force
  mechanism,  // the arm's controller holds spring and damper, the bridge moves their far end
};

struct VirtuoseSetup {
  std::string library = "libVirtuoseAPI.so";
  std::string address = "127.0.0.1#53210";  // of Haption's service
  VirtuoseMode mode = VirtuoseMode::impedance;
  std::optional<int> device_type;  // what virtGetDeviceID must say: 3 is a 6D, 4 a 6D Desktop; none: any
  double relay_time = 3;           // after power comes, until the motors may be relied on [s]
  Eigen::Matrix3d axes = default_arm_axes();
  bool in_profile = false;  // the profile has a table [virtuose]
  // Given by the profile at large and the loop:
  WrenchLimits limits;
  CouplingGains gains = kDefaultGains;  // of the controller's coupling in mode mechanism
  double period = 1e-3;                 // between ticks [s]
};

class VirtuoseSession {
 public:
  // Throws ConfigError when the library cannot be used, std::runtime_error with the failed call and the library's own
  // message when the arm cannot; what was opened is closed again.
  explicit VirtuoseSession(const VirtuoseSetup& setup);
  // Zero force, power off, detach, close. Failures on the way do not keep it from going on.
  ~VirtuoseSession();
  VirtuoseSession(const VirtuoseSession&) = delete;
  VirtuoseSession& operator=(const VirtuoseSession&) = delete;

  // No force, then no power: at once and however often. No allocation, no lock; makes calls to the arm.
  void make_safe() noexcept;

  const VirtuoseApi& api() const { return api_; }
  VirtContext context() const { return context_; }
  const std::string& name() const { return name_; }  // "Virtuose 6D 1234, controller 4.2, API 4.4"

 private:
  template <class... A, class... B>
  void must(const VirtCall<A...>& call, B... arguments);
  void identify(const VirtuoseSetup& setup);
  void configure(const VirtuoseSetup& setup);
  void attach(const VirtuoseSetup& setup);
  void close() noexcept;

  VirtuoseApi api_;
  std::string address_, name_;
  VirtContext context_ = nullptr;
  bool attached_ = false;
  bool mechanism_ = false;
};

// Connects to the arm from wherever this is called and takes its power off. For when its own connection has died with
// its process. Throws as VirtuoseSession does.
void power_off(const VirtuoseSetup& setup);

}  // namespace palp
