// Measures on the host what a scene's [[probe]]s ask for, from one state of the simulation. See config/scenes/README.md
// for the quantities. Not for the real-time thread: a snapshot waits for the device.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/csv_file.h"
#include "sim_server/probes/fluid_pressure.h"
#include "sim_server/probes/solids_around.h"

namespace palp {

using ProbeRow = std::vector<std::optional<double>>;  // a missing value: nothing there to measure

// Returns the names of the columns with units, the time first.
std::vector<std::string> probe_columns(const ProbeConfig& probe);
// Returns whether a probe needs a snapshot; false when StepOutput alone gives its values.
bool needs_snapshot(const ProbeConfig& probe);

// Evaluates probes on one state. Fields at a point are interpolated over the fluid particles (temperature: over all,
// and solids that bound heat without any) within two spacings (Wendland C2 weights, divided by their sum), across
// periodic boundaries; missing where there are none. What a wall bears is summed with the kernel of fluids over the
// room that solids leave; missing within them.
class ProbeSampler {
 public:
  explicit ProbeSampler(const Scene& scene);  // keeps a reference

  // Before the first step give an output without bodies: their initial state is taken from the scene.
  // `snapshot` may be null when no probe to be evaluated needs it. Both must outlive the evaluation.
  void load(const Snapshot* snapshot, const StepOutput& output);
  // Returns one row, or for a line one per point.
  std::vector<ProbeRow> evaluate(const ProbeConfig& probe) const;

 private:
  ProbeRow at_point(const ProbeConfig& probe, const Eigen::Vector3d& point) const;
  // Returns what a place of a solid's surface bears per area [Pa]. Each particle pushes a solid by 2 p V times the
  // integral of W over its surface (physics/walls.h), so a place of a plane bears 2 sum V p W, and one between faces
  // sum V p W over the share of the kernel that solids leave. Air bears nothing: a gauge that is hardly wet reads
  // little.
  std::optional<double> on_wall(const Eigen::Vector3d& point) const;
  // Adds the solids that bound heat to the sums of a temperature at a point.
  void add_solids(const Eigen::Vector3d& point, double reach, double& weights, double& sum) const;
  ProbeRow front(const ProbeConfig& probe) const;
  ProbeRow energy(const ProbeConfig& probe) const;
  ProbeRow extremes(const ProbeConfig& probe) const;
  ProbeRow body(const ProbeConfig& probe) const;
  ProbeRow heat(const ProbeConfig& probe) const;
  ProbeRow pieces(const ProbeConfig& probe) const;
  BodyOutput body_state(std::size_t index) const;
  const SolidsAround& solids() const;
  bool counts(const ProbeConfig& probe, std::size_t body) const;

  const Scene& scene_;
  FluidPressure pressure_;
  const Snapshot* snapshot_ = nullptr;
  const StepOutput* output_ = nullptr;
  // of the fluid particles, and of all; each listed when a point of it is first asked for
  mutable std::optional<SnapshotPoints> fluids_, all_;
  mutable std::optional<SnapshotPoints> within_support_;  // all particles; listed when a wall is first asked for
  mutable std::optional<SolidsAround> solids_;            // made when one of them is first asked for
};

// Writes one CSV file per probe, each at its own rate: probe NAME into FOLDER/NAME.csv.
class ProbeRecorder {
 public:
  // Keeps a reference to the scene. Throws std::runtime_error when a file cannot be made.
  ProbeRecorder(const Scene& scene, const std::string& folder);
  // Returns whether some probe is due after step `step` (0: the initial state), and whether it needs a snapshot.
  bool due(std::uint64_t step) const;
  bool due_with_snapshot(std::uint64_t step) const;
  // Writes the probes that are due after output.step. Throws when the disk is full.
  void record(const Snapshot* snapshot, const StepOutput& output);
  // Writes what is buffered. Throws when the disk is full.
  void close();

 private:
  bool due(const ProbeConfig& probe, std::uint64_t step) const;

  const Scene& scene_;
  ProbeSampler sampler_;
  std::vector<CsvFile> files_;  // by probe
};

// True when sample number floor(step * rate / base_rate) begins at `step`: how all slower rates follow the steps.
bool rate_due(std::uint64_t step, double rate_hz, double base_rate_hz);

}  // namespace palp
