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

// The input of each device, by the index of its proxy in Scene::proxies. An input that is not finite, or whose
// orientation is no rotation, counts as not engaged.
using StepInput = std::array<DeviceInput, kMaxProxies>;

struct ProxyOutput {
  RigidState state;   // the handle after the step
  RigidState device;  // the device at the end of the step, extrapolated with its twist
  // Force on the device by the coupling [N]: where a contact answers (blend), from the two states above; elsewhere the
  // mean over the step.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // about the handle, from the two states above [N m]
  Eigen::Vector3d contact_force =
      Eigen::Vector3d::Zero();  // on the proxy by everything but coupling and gravity, mean [N]
  Eigen::Vector3d contact_torque = Eigen::Vector3d::Zero();  // about the handle [N m]
  CouplingGains gains = kDefaultGains;                       // gains that were used
  std::array<double, 2> blend{};                             // local stiffness: linear, angular, 0..1
  std::array<double, 2> energy{};                            // cumulative work of the proxy on the coupling [J]
};

struct BodyOutput {
  RigidState state;                                  // the body frame
  Eigen::Vector3d force = Eigen::Vector3d::Zero();   // by fluids and other bodies, mean over the step [N]; no gravity
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();  // about the centre of mass [N m]
};

struct Health {
  bool ok = true;
  std::string cause;                // one sentence when not ok
  std::string doubt;                // one sentence once the answer is spoilt, though it goes on (solver/fluid_watch.h)
  std::string notice;               // one sentence once it is less accurate than promised
  std::uint32_t non_finite = 0;     // number of particles with a non-finite state
  double max_speed = 0;             // [m/s]
  double max_compression = 0;       // max of rho/rho0 - 1 over fluid particles
  double expected_speed = 0;        // numerics.max_speed of the plan; 0: the scene has no fluid to judge [m/s]
  double expected_compression = 0;  // that the sound speed promises at that speed; 0: as above
  double mean_compression = 0;      // of the fluids, by mass; what is stretched counts as zero
  double kinetic_energy = 0;        // fluids and bodies [J]
  bool solves = false;              // there is an implicit elastic solve
  double unsolved = 0;              // share of an implicit elastic solve's result that its last round still changed
  std::uint32_t outside = 0;        // number of particles outside the domain
  std::uint32_t inactive = 0;       // number of these that are liquid and take no part any more
  double inactive_mass = 0;         // their mass [kg]
  std::uint32_t asleep = 0;         // number of particles that are not computed because they rest (physics/sleep.h)
};

struct StepOutput {
  std::uint64_t step = 0;
  double time = 0;  // at the end of the step [s]
  std::vector<ProxyOutput> proxies;
  std::vector<BodyOutput> bodies;  // one per Scene::bodies; fluids stay at zero
  Health health;
};

// The fields of all particles in the scene's order.
struct Snapshot {
  double time = 0;
  double support = 0;              // radius of the kernel [m]
  std::vector<float> position;     // x y z [m]
  std::vector<float> velocity;     // x y z [m/s]
  std::vector<float> density;      // [kg/m^3]
  std::vector<float> pressure;     // by the equation of state [Pa]; fluid_pressure.h has that of a gauge
  std::vector<float> temperature;  // [K]; empty when the scene has none
  // elastic energy of the particle, less what contact's push on its face gave to it, taken as there from the first
  // (physics/contact_stress.h) [J]; empty when the scene has no elastic bodies
  std::vector<float> stored;
  std::vector<float> heat;    // heat taken up by the particle since the start [J]; empty when nothing conducts
  std::vector<float> liquid;  // fraction, 0..1; NaN: it does not melt; empty when nothing conducts
  std::vector<float> solid;   // fraction K^d, 0..1; empty when nothing changes state
  // The body that the particle belongs to: the index of the scene's body. In a solid piece of matter that changes state
  // it is the index of a tool which the piece is bonded to, else the number of the scene's bodies plus the index of the
  // piece's first particle. Empty when nothing changes state.
  std::vector<std::uint32_t> body_id;
  std::vector<std::uint8_t> rigid;     // 1: its piece moves as a rigid body; empty when nothing becomes one
  std::vector<std::uint8_t> inactive;  // 1: it has left the domain and takes no part any more (physics/outside.h)
};

// The costs of a plan: for tests of lightness and for the printed report.
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

// Where the time of some haptic steps went.
struct StageTimes {
  struct Stage {
    std::string name;            // as in Footprint::launches
    double seconds = 0;          // of all its launches [s]
    std::uint64_t launches = 0;  // number of them
  };
  std::vector<Stage> stages;  // in the order of a step
  std::uint64_t steps = 0;    // haptic steps
};

// The positions and one scalar of all particles, for streaming without stopping the step.
struct Frame {
  double time = 0;
  std::uint64_t step = 0;
  std::vector<float> position;      // x y z
  std::vector<float> scalar;        // or empty
  std::vector<std::uint8_t> solid;  // how much of each particle is, in 255ths; empty when nothing changes state
};

class Simulation {
 public:
  virtual ~Simulation() = default;
  virtual const Scene& scene() const = 0;
  virtual std::string backend_name() const = 0;   // "cpu (AVX2), 2 threads, float", "cuda, NVIDIA H100, float"
  virtual std::string gpu() const { return {}; }  // whose memory it uses (idl/gpu_page.h); empty on a CPU
  virtual std::string numerics() const = 0;       // one line: the numbers that the accuracy level expanded to
  virtual double support_radius() const = 0;      // H [m]
  virtual int sub_steps() const = 0;              // sub-steps of a haptic step
  virtual int fluid_interval() const = 0;         // haptic steps that fluids take at once: one of so many costs more

  // Runs one haptic step of 1 / rate_hz seconds. The result is valid until the next call. No allocation after the first
  // step.
  virtual const StepOutput& step(const StepInput& input) = 0;
  // Has a GPU turn to this process, so that the next step need not wait for that. Never waits.
  virtual void take_gpu() {}
  // Returns the result of the last step, or the initial state before the first.
  virtual const StepOutput& output() const = 0;
  // Goes back to the initial state; the step count and time begin again.
  virtual void reset() = 0;
  // Changes a parameter between two steps: gravity, body_force ("0 0 -9.81" [m/s^2]), material.NAME.viscosity [Pa s],
  // numerics.artificial_viscosity, numerics.density_diffusion. Sub-steps follow. Throws ConfigError and changes nothing
  // when the name is unknown, the value is malformed or out of range, or no stable step exists.
  virtual void set_parameter(const std::string& name, const std::string& value) = 0;
  // Copies all fields out. Waits for the device.
  virtual void snapshot(Snapshot& out) = 0;
  // Starts copying a frame of the state after the last step; never waits. Returns false while an earlier one is in
  // flight.
  virtual bool begin_frame(ScalarField scalar) = 0;
  // Moves the frame begun into out and returns true when it has arrived. May be called from another thread than step().
  virtual bool take_frame(Frame& out) = 0;
  virtual Footprint footprint() const = 0;
  // Runs haptic steps with this input for at least so long [s of wall time], whole cycles of heat, and measures their
  // stages. The steps count like others but take longer: a GPU launches them one by one, not as a graph.
  virtual StageTimes time_stages(const StepInput& input, double seconds) = 0;
  // Returns what may be meant but is mostly a mistake in the scene, one sentence each (scene_warnings.h).
  virtual const std::vector<std::string>& warnings() const = 0;
};

// Makes a simulation. Throws std::runtime_error with one sentence when the back end is not built in, has no device, or
// lacks memory.
std::unique_ptr<Simulation> make_simulation(const Scene& scene, Backend backend);

}  // namespace palp
