// The Python module palp: simulations that are stepped, and the bus that is heard and spoken to. Arrays are NumPy's;
// units and frames are those of sim_server/solver/simulation.h and idl/messages.h.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "config/version.h"
#include "idl/bus.h"
#include "idl/clock.h"
#include "idl/frame_assembler.h"
#include "sim_server/scene/scene_files.h"
#include "sim_server/solver/simulation.h"

namespace py = pybind11;

namespace palp {
namespace {

py::array_t<float> rows_of_three(const std::vector<float>& values) {
  const auto rows = static_cast<py::ssize_t>(values.size() / 3);
  return py::array_t<float>(std::vector<py::ssize_t>{rows, 3}, values.data());
}

Accuracy accuracy_from(const std::string& name) {
  if (name == "fast") return Accuracy::fast;
  if (name == "balanced") return Accuracy::balanced;
  if (name == "accurate") return Accuracy::accurate;
  throw py::value_error("accuracy '" + name + "': fast, balanced or accurate was expected");
}

Backend backend_from(const std::string& name) {
  if (name == "auto") return Backend::automatic;
  if (name == "cpu") return Backend::cpu;
  if (name == "cuda") return Backend::cuda;
  throw py::value_error("backend '" + name + "': auto, cpu or cuda was expected");
}

// A simulation and what its tools are to do in the next steps.
class SteppedSimulation {
 public:
  SteppedSimulation(const std::string& scene, const std::string& accuracy, const std::string& backend) {
    SceneOverrides overrides;
    overrides.accuracy = accuracy_from(accuracy);
    simulation_ = make_simulation(sample_scene(load_scene(find_scene_file(scene), overrides), particles_in_memory()),
                                  backend_from(backend));
  }

  void move_tool(std::size_t tool, const std::array<double, 3>& position, const std::array<double, 3>& velocity) {
    DeviceInput& device = input_.at(checked(tool));
    device.engaged = true;
    device.state = simulation_->output().proxies[tool].state;
    device.state.position = Eigen::Vector3d(position.data());
    device.state.linear = Eigen::Vector3d(velocity.data());
  }
  void step(int count) {
    for (int i = 0; i < count; ++i) {
      const StepOutput& output = simulation_->step(input_);
      if (!output.health.ok) throw std::runtime_error(output.health.cause);
    }
  }
  py::dict tool(std::size_t tool) const {
    const ProxyOutput& output = simulation_->output().proxies[checked(tool)];
    py::dict values;
    values["position"] = to_array(output.state.position);
    values["velocity"] = to_array(output.state.linear);
    values["force"] = to_array(output.force);
    values["torque"] = to_array(output.torque);
    return values;
  }
  py::dict particles() const {
    Snapshot snapshot;
    simulation_->snapshot(snapshot);
    py::dict fields;
    fields["position"] = rows_of_three(snapshot.position);
    fields["velocity"] = rows_of_three(snapshot.velocity);
    fields["density"] = to_numpy(snapshot.density);
    fields["pressure"] = to_numpy(snapshot.pressure);
    if (!snapshot.temperature.empty()) fields["temperature"] = to_numpy(snapshot.temperature);
    return fields;
  }
  double time() const { return simulation_->output().time; }
  double rate_hz() const { return simulation_->scene().config.rate_hz; }
  std::string backend() const { return simulation_->backend_name(); }

 private:
  static py::array_t<double> to_array(const Eigen::Vector3d& v) { return py::array_t<double>(3, v.data()); }
  static py::array_t<float> to_numpy(const std::vector<float>& values) {
    return py::array_t<float>(static_cast<py::ssize_t>(values.size()), values.data());
  }
  std::size_t checked(std::size_t tool) const {
    if (tool >= simulation_->output().proxies.size()) throw py::index_error("the scene has no such tool");
    return tool;
  }

  std::unique_ptr<Simulation> simulation_;
  StepInput input_;
};

// Readers and writers of what a device and a spectator need. Belongs to one thread.
class SharedBus {
 public:
  SharedBus(int domain, const std::string& dds) {
    BusOptions options;
    options.domain = domain;
    options.vendor = vendor_from(dds);
    bus_ = open_bus(options);
    devices_ = bus_->writer<DeviceSample>();
    proxies_ = bus_->reader<ProxySample>();
    scenes_ = bus_->reader<SceneDescription>();
    chunks_ = bus_->reader<ParticleChunk>();
  }

  // The scene that a server told, or None.
  py::object scene() {
    Received<SceneDescription> received;
    if (!scenes_->take_latest(received)) return py::none();
    py::list tools;
    for (const ProxyDescription& proxy : received.message.proxies) {
      py::dict tool;
      tool["device"] = proxy.device;
      tool["position"] = proxy.pose.position;
      tool["orientation"] = proxy.pose.orientation;
      tools.append(tool);
    }
    py::dict scene;
    scene["name"] = received.message.name;
    scene["particles"] = received.message.particle_count;
    scene["tools"] = tools;
    return scene;
  }
  void send_device(std::uint32_t device, const std::array<double, 3>& position,
                   const std::array<double, 4>& orientation, const std::array<double, 3>& velocity, double stiffness,
                   double damping) {
    DeviceSample sample;
    sample.device = device;
    sample.flags = kEngaged | kHealthy;
    sample.t_device_ns = now_ns();
    sample.pose = {position, orientation};
    sample.twist.linear = velocity;
    sample.gains = {stiffness, damping, 0.01 * stiffness, 0.01 * damping};
    devices_->publish(sample);
  }
  // The newest answer to a device, or None.
  py::object proxy() {
    Received<ProxySample> received;
    if (!proxies_->take_latest(received)) return py::none();
    const ProxySample& sample = received.message;
    py::dict proxy;
    proxy["device"] = sample.device;
    proxy["time"] = sample.sim_time;
    proxy["position"] = sample.proxy_pose.position;
    proxy["force"] = sample.wrench.force;
    proxy["torque"] = sample.wrench.torque;
    return proxy;
  }
  // The newest whole frame of particles that comes within `timeout` seconds, or None.
  py::object particles(double timeout) {
    {
      py::gil_scoped_release other_threads_run;
      const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout);
      while (!frame_came()) {
        if (std::chrono::steady_clock::now() > end) break;
        chunks_->wait(std::chrono::milliseconds(10));
      }
    }
    if (!fresh_) return py::none();
    fresh_ = false;
    py::dict frame;
    frame["time"] = frame_.sim_time;
    frame["position"] = rows_of_three(frame_.positions);
    return frame;
  }

 private:
  bool frame_came() {
    arrived_.clear();
    chunks_->take_all(arrived_);
    for (const auto& chunk : arrived_) assembler_.add(chunk);
    return fresh_ = assembler_.take(frame_) || fresh_;
  }

  std::unique_ptr<Bus> bus_;
  std::unique_ptr<Writer<DeviceSample>> devices_;
  std::unique_ptr<Reader<ProxySample>> proxies_;
  std::unique_ptr<Reader<SceneDescription>> scenes_;
  std::unique_ptr<Reader<ParticleChunk>> chunks_;
  std::vector<Received<ParticleChunk>> arrived_;
  FrameAssembler assembler_;
  ParticleFrame frame_;
  bool fresh_ = false;
};

}  // namespace

PYBIND11_MODULE(palp, m) {
  m.doc() = "palp: simulations that are stepped, and the bus that is heard and spoken to. SI units, world frame.";
  m.attr("__version__") = version();
  py::class_<SteppedSimulation>(m, "Simulation")
      .def(py::init<const std::string&, const std::string&, const std::string&>(), py::arg("scene"),
           py::arg("accuracy") = "fast", py::arg("backend") = "auto", "scene: a file, or a bare name of palp's own")
      .def("step", &SteppedSimulation::step, py::arg("count") = 1, py::call_guard<py::gil_scoped_release>(),
           "haptic steps of 1 / rate_hz seconds; raises RuntimeError when the simulation is no longer sound")
      .def("move_tool", &SteppedSimulation::move_tool, py::arg("tool"), py::arg("position"),
           py::arg("velocity") = std::array<double, 3>{}, "couples a tool to a device at a position [m], [m/s]")
      .def("tool", &SteppedSimulation::tool, py::arg("tool") = 0, "position, velocity, force [N], torque [N m]")
      .def("particles", &SteppedSimulation::particles, "fields of all particles, by name, in the scene's order")
      .def_property_readonly("time", &SteppedSimulation::time, "simulated [s]")
      .def_property_readonly("rate_hz", &SteppedSimulation::rate_hz, "haptic steps per second")
      .def_property_readonly("backend", &SteppedSimulation::backend);
  py::class_<SharedBus>(m, "Bus")
      .def(py::init<int, const std::string&>(), py::arg("domain") = 0, py::arg("dds") = "cyclone")
      .def("scene", &SharedBus::scene, "name, number of particles and tools of the scene, or None if none came")
      .def("send_device", &SharedBus::send_device, py::arg("device"), py::arg("position"), py::arg("orientation"),
           py::arg("velocity") = std::array<double, 3>{}, py::arg("stiffness") = 300.0, py::arg("damping") = 2.0,
           "a device's pose, 1000 times a second; quaternion x y z w, [N/m], [N s/m]")
      .def("proxy", &SharedBus::proxy, "time, position, force and torque of the newest answer, or None")
      .def("particles", &SharedBus::particles, py::arg("timeout") = 1.0, "time and positions of a frame, or None");
}

}  // namespace palp
