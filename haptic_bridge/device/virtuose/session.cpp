#include "haptic_bridge/device/virtuose/session.h"

#include <stdexcept>

#include <fmt/format.h>

#include "config/error.h"

namespace palp {

namespace {

constexpr float kTimeout = 0.03F;  // of one exchange with the controller [s]: what other drivers call dead

std::string type_name(int type) {
  switch (type) {
    case 1:
      return "Virtuose 3D";
    case 3:
      return "Virtuose 6D";
    case 4:
      return "Virtuose 6D Desktop";
    case 8:
      return "INCA 6D";
    default:
      return fmt::format("Virtuose of type {}", type);
  }
}

float as_float(double value) { return static_cast<float>(value); }

}  // namespace

VirtuoseSession::VirtuoseSession(const VirtuoseSetup& setup)
    : api_(setup.library), address_(setup.address), mechanism_(setup.mode == VirtuoseMode::mechanism) {
  context_ = api_.open(address_.c_str());
  if (!context_) {
    const int code = api_.error_code(nullptr);
    throw std::runtime_error(
        fmt::format("Virtuose at {}: no connection: {} (error {}); check that the arm is on, its service runs and "
                    "--address names it",
                    address_, api_.message(code), code));
  }
  try {
    identify(setup);
    configure(setup);
  } catch (...) {
    close();
    throw;
  }
}

VirtuoseSession::~VirtuoseSession() { close(); }

template <class... A, class... B>
void VirtuoseSession::must(const VirtCall<A...>& call, B... arguments) {
  if (call.function(context_, arguments...) == 0) return;
  const int code = api_.error_code(context_);
  throw std::runtime_error(
      fmt::format("Virtuose at {}: {} failed: {} (error {})", address_, call.name, api_.message(code), code));
}

void VirtuoseSession::identify(const VirtuoseSetup& setup) {
  int major = 0, minor = 0, type = 0, serial = 0;
  must(api_.controller_version, &major, &minor);
  must(api_.device_id, &type, &serial);
  name_ = fmt::format("{} {}, controller {}.{}, API {}", type_name(type), serial, major, minor, api_.version());
  if (setup.device_type && *setup.device_type != type)
    throw ConfigError(
        fmt::format("Virtuose at {}: it is a {} (type {}), the profile is for a {} (type {}): give the "
                    "profile of this arm with --profile",
                    address_, type_name(type), type, type_name(*setup.device_type), *setup.device_type));
}

// The order matters: the manual wants factors and time step before the command type, frames before it, too, and power
// last. Factors stay at 1: the bridge scales, else its energy books would be wrong.
void VirtuoseSession::configure(const VirtuoseSetup& setup) {
  ArmPose origin = kArmOrigin;
  ArmVector still{};
  must(api_.set_timeout, kTimeout);
  must(api_.set_indexing, static_cast<int>(kVirtIndexAll));
  must(api_.set_force_factor, 1.0F);
  must(api_.set_speed_factor, 1.0F);
  must(api_.set_time_step, as_float(setup.period));
  must(api_.set_base_frame, origin.data());
  must(api_.set_observation_frame, origin.data());
  must(api_.set_observation_speed, still.data());
  must(api_.set_command_type, static_cast<int>(mechanism_ ? kVirtMechanism : kVirtImpedance));
  must(api_.saturate_torque, as_float(setup.limits.force), as_float(setup.limits.torque));
  must(api_.enable_feedback, mechanism_ ? 0 : 1);  // of the mechanism: when the loop is engaged
  if (mechanism_) attach(setup);
  must(api_.set_power_on, 1);
  if (!mechanism_) must(api_.set_force, still.data());
}

// The far end of the spring begins where the handle is, so nothing pulls.
void VirtuoseSession::attach(const VirtuoseSetup& setup) {
  const CouplingGains& k = setup.gains;
  constexpr double kSoftest = 1, kSoftestTurn = 1e-3;  // what is softer puts the target out of the arm's world
  if (!(k.stiffness >= kSoftest && k.angular_stiffness >= kSoftestTurn))
    throw ConfigError(
        fmt::format("Virtuose in mode virtmech: coupling.stiffness is {:g} N/m and coupling.angular_stiffness {:g} N "
                    "m/rad, expected at least {:g} and {:g}, for the arm's controller renders force by them",
                    k.stiffness, k.angular_stiffness, kSoftest, kSoftestTurn));
  ArmPose here = kArmOrigin;
  ArmVector still{};
  must(api_.get_avatar, here.data());
  must(api_.set_position, here.data());
  must(api_.set_speed, still.data());
  // these two take the rotation first
  const float kr = as_float(k.angular_stiffness), kt = as_float(k.stiffness);
  const float br = as_float(k.angular_damping), bt = as_float(k.damping);
  ArmVector stiffness{kr, kr, kr, kt, kt, kt}, damping{br, br, br, bt, bt, bt};
  must(api_.attach_qsvo, stiffness.data(), damping.data());
  attached_ = true;
}

void VirtuoseSession::make_safe() noexcept {
  if (!context_) return;
  ArmVector still{};
  if (mechanism_) {
    api_.enable_feedback.function(context_, 0);
  } else {
    api_.set_force.function(context_, still.data());
  }
  api_.set_power_on.function(context_, 0);
}

void VirtuoseSession::close() noexcept {
  if (!context_) return;
  make_safe();
  if (attached_) api_.detach_vo.function(context_);
  api_.close.function(context_);
  context_ = nullptr;
}

void power_off(const VirtuoseSetup& setup) {
  const VirtuoseApi api(setup.library);
  const VirtContext arm = api.open(setup.address.c_str());
  if (!arm) throw std::runtime_error(fmt::format("no connection to {}", setup.address));
  const int result = api.set_power_on.function(arm, 0);
  const std::string why = result == 0 ? "" : api.message(api.error_code(arm));
  api.close.function(arm);
  if (result != 0) throw std::runtime_error(fmt::format("{} failed: {}", api.set_power_on.name, why));
}

}  // namespace palp
