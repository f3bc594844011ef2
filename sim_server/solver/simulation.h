// The simulation as its callers see it: one haptic step at a time, on whichever back end was chosen.
// sim_server drives it at the haptic rate, palp-run and the tests as fast as it goes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "idl/coupling.h"
#include "sim_server/scene/scene.h"

namespace palp {

enum class Backend { automatic, cpu, cuda };

inline constexpr int kMaxProxies = 8;

// The state of one device for one step: the handle moves from it with its twist while the step lasts.
struct DeviceInput {
  bool engaged = false;                 // false: no coupling, the proxy is an ordinary rigid body held in place
  RigidState state;                     // of the handle
  CouplingGains gains = kDefaultGains;  // clipped to the proxy's limit
};

// By the index of the proxy in Scene::proxies. An input that is not finite, or whose orientation is no rotation, counts
// as not engaged.
using StepInput = std::array<DeviceInput, kMaxProxies>;

struct ProxyOutput {
  RigidState state;   // of the handle after the step
  RigidState device;  // of the device at the end of the step, moved on with its twist
  // On the device by the coupling [N]: where a contact answers (blend), from the two states above; elsewhere the mean
  // over the step.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // about the handle, from the two states above [N m]
  Eigen::Vector3d contact_force =
      Eigen::Vector3d::Zero();  // on the proxy by everything but coupling and gravity, mean [N]
  Eigen::Vector3d contact_torque = Eigen::Vector3d::Zero();  // about the handle [N m]
  CouplingGains gains = kDefaultGains;                       // used
  std::array<double, 2> blend{};                             // local stiffness: linear, angular, 0..1
  std::array<double, 2> energy{};                            // cumulative work of the proxy on the coupling [J]
};

struct BodyOutput {
  RigidState state;                                  // of the body frame
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // by fluids and other bodies, mean over the step [N]; no gravity
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // about the centre of mass [N m]
};

struct Health {
  bool ok = true;
  std::string cause;             // one sentence when not ok
  std::uint32_t non_finite = 0;  // particles
  double max_speed = 0;          // [m/s]
  double max_compression = 0;    // max of rho/rho0 - 1 over fluid particles
  double kinetic_energy = 0;     // [J], fluid and rigid
  double unsolved = 0;           // of an implicit elastic solve: share of its result that the last round still changed
  std::uint32_t outside = 0;     // particles outside the domain
  std::uint32_t gone = 0;        // of these, liquid that has left it and takes no part any more
  double gone_mass = 0;          // [kg]
};

struct StepOutput {
  std::uint64_t step = 0;
  double time = 0;  // [s] at the end of the step
  std::vector<ProxyOutput> proxies;
  std::vector<BodyOutput> bodies;  // one per Scene::bodies; fluids stay at zero
  Health health;
};

// Fields of all particles in the scene's order.
struct Snapshot {
  double time = 0;
  double support = 0;              // radius of the kernel [m]
  std::vector<float> position;     // x y z [m]
  std::vector<float> velocity;     // x y z [m/s]
  std::vector<float> density;      // [kg/m^3]
  std::vector<float> pressure;     // of the equation of state [Pa]; fluid_pressure.h has what a gauge would show
  std::vector<float> temperature;  // [K]; empty when the scene has none
  std::vector<float> stored;       // elastic energy of the particle [J]; empty when the scene has no elastic bodies
  std::vector<float> heat;         // taken up by the particle since the start [J]; empty when nothing conducts
  std::vector<float> liquid;       // fraction, 0..1; NaN: does not melt; empty when nothing conducts
  std::vector<float> solid;        // fraction K^d, 0..1; empty when nothing changes state
  // The body that the particle belongs to: the index of the scene's body, or, in a piece of what changes state and is
  // solid, that of a tool which holds the piece, else the number of the scene's bodies and the index of the piece's
  // first particle. Empty when nothing changes state.
  std::vector<std::uint32_t> body_id;
  std::vector<std::uint8_t> rigid;  // 1: its piece moves as a rigid body; empty when nothing becomes one
  std::vector<std::uint8_t> gone;   // 1: has left the domain and takes no part any more (physics/outside.h)
};

// What a plan costs: for tests of lightness and for the printed report.
struct Footprint {
  std::vector<std::pair<std::string, std::size_t>> arrays;  // name, bytes
  std::vector<std::string>
      launches;  // stages of one haptic step, in order; known after the first step (with heat: the first that conducts)
  std::size_t bytes() const {
    std::size_t sum = 0;
    for (const auto& [name, size] : arrays) sum += size;
    return sum;
  }
};

// Positions and one scalar, for streaming, without stopping the step.
struct Frame {
  double time = 0;
  std::uint64_t step = 0;
  std::vector<float> position;  // x y z
  std::vector<float> scalar;    // or empty
};

class Simulation {
 public:
  virtual ~Simulation() = default;
  virtual const Scene& scene() const = 0;
  virtual std::string backend_name() const = 0;  // "cpu (AVX2), 2 threads, float", "cuda, NVIDIA H100, float"
  virtual std::string numerics() const = 0;      // one line: what the accuracy level expanded to
  virtual double support_radius() const = 0;     // H [m]
  virtual int sub_steps() const = 0;             // of a haptic step

  // One haptic step of 1 / rate_hz seconds. Valid until the next call. No allocation after the first step.
  virtual const StepOutput& step(const StepInput& input) = 0;
  // After the last step; the initial state before the first.
  virtual const StepOutput& output() const = 0;
  // Back to the initial state; the step count and time begin again.
  virtual void reset() = 0;
  // Changes a parameter between two steps: gravity, body_force ("0 0 -9.81" [m/s^2]), material.NAME.viscosity [Pa s],
  // numerics.artificial_viscosity, numerics.density_diffusion. Sub-steps follow. Throws ConfigError and changes nothing
  // when the name is unknown, the value is malformed or out of range, or no stable step exists.
  virtual void set_parameter(const std::string& name, const std::string& value) = 0;
  // Copies all fields out. Waits for the device.
  virtual void snapshot(Snapshot& out) = 0;
  // Starts copying a frame of the state after the last step; never waits. False while an earlier one is in flight.
  virtual bool begin_frame(ScalarField scalar) = 0;
  // True when the frame begun has arrived; then it is moved into out. May be called from another thread than step().
  virtual bool take_frame(Frame& out) = 0;
  virtual Footprint footprint() const = 0;
};

// Throws std::runtime_error with one sentence when the back end is not built in, has no device, or lacks memory.
std::unique_ptr<Simulation> make_simulation(const Scene& scene, Backend backend);

}  // namespace palp
