#include "config/scene_config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "config/parameter_ranges.h"
#include "config/scene_reader.h"
#include "config/text_file.h"

namespace palp {

namespace {

const std::vector<std::string> kMethods{"paper", "accurate"};
const std::vector<std::string> kAccuracies{"fast", "balanced", "accurate"};
const std::vector<std::string> kScalars = [] {
  std::vector<std::string> names;
  for (const ScalarFieldRow& row : kScalarFields) names.emplace_back(row.name);
  return names;
}();
const std::vector<std::string> kViscosity{"explicit", "staged"};
const std::vector<std::string> kElasticSolvers{"explicit", "implicit", "auto"};
constexpr Range kSpacing{"m", 1e-7, 1000};  // inertias of less are lost in single precision
// The widest grid that a solver can lay over a periodic axis needs three cells of one support radius.
constexpr double kCellsPerPeriod = 3;
// Past this many spacings along an axis, places in single precision are no longer told apart well.
constexpr double kMostSpacings = 1e6;

void read_general(TomlTable& root, SceneConfig& scene, const SceneOverrides& overrides) {
  TomlTable table = root.table("scene", Need::required);
  scene.name = table.text("name").value_or(std::filesystem::path(scene.path).stem().string());
  scene.description = table.text("description").value_or("");
  if (const auto index = table.choice("method", kMethods)) scene.method = static_cast<Method>(*index);
  if (const auto index = table.choice("accuracy", kAccuracies)) scene.accuracy = static_cast<Accuracy>(*index);
  scene.method = overrides.method.value_or(scene.method);
  scene.accuracy = overrides.accuracy.value_or(scene.accuracy);
  scene.gravity = read_vector(table, "gravity", range_of("gravity"), scene.gravity);
  scene.body_force = read_vector(table, "body_force", range_of("body_force"), scene.body_force);
  scene.gravity_ramp = table.number("gravity_ramp", not_negative("s")).value_or(scene.gravity_ramp);
  scene.rate_hz = table.number("rate_hz", {"Hz", 1, 1e6}).value_or(scene.rate_hz);
  scene.duration = table.number("duration", {"s", 0, 1e6, true}).value_or(scene.duration);
  if (scene.duration * scene.rate_hz < 1 - 1e-9)
    table.fault("duration",
                fmt::format("duration is {:g} s, expected at least one haptic step of {:g} s; make it longer "
                            "or raise rate_hz",
                            scene.duration, 1 / scene.rate_hz));
}

using NumberByLevel = std::array<std::optional<double>, 3>;

// Reads a table with a number for each accuracy level, of which that of `needed` must be there.
NumberByLevel read_levels(TomlTable& levels, const Range& range, std::optional<std::size_t> needed) {
  NumberByLevel values;
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = levels.number(kAccuracies[i], range, i == needed ? Need::required : Need::optional);
  return values;
}

// `spacing` is a number, or a table with a number for each accuracy level.
void read_spacing(TomlTable& table, TomlTable& root, SceneConfig& scene, const SceneOverrides& overrides) {
  const auto level = static_cast<std::size_t>(scene.accuracy);
  if (table.is_table("spacing")) {
    TomlTable levels = table.table("spacing");
    const NumberByLevel values =
        read_levels(levels, kSpacing, overrides.spacing ? std::nullopt : std::optional<std::size_t>(level));
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = i + 1; j < 3; ++j) {
        if (values[i] && values[j] && *values[j] > *values[i]) {
          levels.fault(kAccuracies[j],
                       fmt::format("spacing {} of '{}' is coarser than {} of '{}', expected at most that", *values[j],
                                   kAccuracies[j], *values[i], kAccuracies[i]));
        }
      }
    }
    scene.numerics.spacing = values[level];
  } else if (table.has("spacing")) {
    scene.numerics.spacing = table.number("spacing", kSpacing);
  } else if (!overrides.spacing) {
    const std::string missing =
        "spacing is missing, expected " + describe(kSpacing) + ", or a table {fast = .., balanced = .., accurate = ..}";
    table.exists() ? table.fault("", missing) : root.fault("", "numerics: " + missing);
  }
  if (overrides.spacing) scene.numerics.spacing = overrides.spacing;
}

// The same of `support_over_spacing`, whose table may leave levels to derive theirs.
std::optional<double> read_support(TomlTable& table, Accuracy accuracy) {
  const char* const key = "support_over_spacing";
  const Range range = range_of("numerics.support_over_spacing");
  if (!table.is_table(key)) return table.number(key, range);
  TomlTable levels = table.table(key);
  return read_levels(levels, range, std::nullopt)[static_cast<std::size_t>(accuracy)];
}

void read_numerics(TomlTable& root, SceneConfig& scene, const SceneOverrides& overrides) {
  TomlTable table = root.table("numerics");
  table.set_title("numerics");
  NumericsConfig& n = scene.numerics;
  read_spacing(table, root, scene, overrides);
  n.support_over_spacing = read_support(table, scene.accuracy);
  n.sound_speed = table.number("sound_speed", range_of("numerics.sound_speed"));
  n.max_speed = table.number("max_speed", range_of("numerics.max_speed"));
  n.where = table.where(n.sound_speed ? "sound_speed" : "max_speed");
  n.artificial_viscosity = table.number("artificial_viscosity", range_of("numerics.artificial_viscosity"));
  n.density_diffusion = table.number("density_diffusion", range_of("numerics.density_diffusion"));
  n.shift = table.number("shift", range_of("numerics.shift"));
  if (const auto scheme = table.choice("viscosity", kViscosity)) n.viscosity = static_cast<ViscosityScheme>(*scheme);
  if (const auto solver = table.choice("elastic_solver", kElasticSolvers); solver && *solver < 2)
    n.elastic_solver = static_cast<ElasticSolver>(*solver);
  if (const auto rounds = table.integer("elastic_rounds", 1, 1000)) n.elastic_rounds = static_cast<int>(*rounds);
  if (n.elastic_rounds && n.elastic_solver == ElasticSolver::explicit_)
    table.fault("elastic_rounds",
                "elastic_rounds is of an implicit solve, but elastic_solver is \"explicit\"; "
                "leave one of them out");
  n.tension = table.boolean("tension");
  n.solid_particles = table.boolean("solid_particles").value_or(false) || overrides.solid_particles;
  if (const auto steps = table.integer("sub_steps", 1, 100000)) n.sub_steps = static_cast<int>(*steps);
  if (const auto steps = table.integer("fluid_interval", 1, 100)) n.fluid_interval = static_cast<int>(*steps);
  n.skin_over_spacing = table.number("skin_over_spacing", range_of("numerics.skin_over_spacing"));
  n.sleep_speed = table.number("sleep_speed", range_of("numerics.sleep_speed"));
  n.region_of_interest = table.number("region_of_interest", range_of("numerics.region_of_interest"));
  n.safety = table.number("safety", range_of("numerics.safety")).value_or(n.safety);
  if (n.sound_speed && n.max_speed && *n.sound_speed <= *n.max_speed) {
    table.fault("sound_speed", fmt::format("sound_speed is {}, expected more than max_speed, which is {} (ten times "
                                           "it keeps the density within 1 %)",
                                           *n.sound_speed, *n.max_speed));
  }
}

void read_domain(TomlTable& root, SceneConfig& scene) {
  TomlTable table = root.table("domain", Need::required);
  table.set_title("domain");
  // a corner that cannot be read is nowhere, so that nothing is said of where it stands to others
  const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  scene.domain_min = read_vector(table, "min", "m", nowhere, Need::required);
  scene.domain_max = read_vector(table, "max", "m", nowhere, Need::required);
  if (const auto periodic = table.booleans3("periodic")) scene.periodic = *periodic;
}

void check_domain(TomlTable& root, const SceneConfig& scene) {
  TomlTable table = root.table("domain");
  table.set_title("domain");
  const double dx = scene.numerics.spacing.value_or(std::numeric_limits<double>::quiet_NaN());
  const double support =
      scene.numerics.support_over_spacing.value_or(range_of("numerics.support_over_spacing").min) * dx;
  for (int axis = 0; axis < 3; ++axis) {
    const char name = "xyz"[axis];
    const double low = scene.domain_min[axis], high = scene.domain_max[axis];
    if (low >= high) {
      table.fault("max", fmt::format("max is {} on axis {}, expected more than min, which is {}", high, name, low));
    } else if (scene.periodic[static_cast<std::size_t>(axis)] && high - low < kCellsPerPeriod * support * (1 - 1e-9)) {
      table.fault("periodic", fmt::format("axis {} is periodic and {:g} m long, expected at least {:g} m ({} support "
                                          "radii); make it longer or the spacing finer",
                                          name, high - low, kCellsPerPeriod * support, kCellsPerPeriod));
    } else if (high - low > kMostSpacings * dx) {
      table.fault("max", fmt::format("axis {} is {:g} m long, expected at most {:g} m ({:g} spacings)", name,
                                     high - low, kMostSpacings * dx, kMostSpacings));
    } else if (std::max(std::abs(low), std::abs(high)) > kMostSpacings * dx) {
      table.fault(high > -low ? "max" : "min",
                  fmt::format("axis {} reaches {:g} m from the origin, expected at most {:g} m ({:g} spacings)", name,
                              std::max(std::abs(low), std::abs(high)), kMostSpacings * dx, kMostSpacings));
    } else if (high - low < dx) {
      table.fault("max", fmt::format("axis {} is {:g} m long, expected at least the particle spacing {:g} m", name,
                                     high - low, dx));
    }
  }
}

void read_stream(TomlTable& root, SceneConfig& scene) {
  TomlTable table = root.table("stream");
  table.set_title("stream");
  scene.stream.particle_rate_hz =
      table.number("particle_rate_hz", range_of("stream.particle_rate_hz")).value_or(scene.stream.particle_rate_hz);
  if (const auto index = table.choice("scalar", kScalars)) scene.stream.scalar = static_cast<ScalarField>(*index);
}

// FNV-1a, 64 bits.
std::uint64_t hash_of(const std::string& text, std::uint64_t hash = 14695981039346656037ULL) {
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

std::uint64_t hash_of_overrides(const SceneOverrides& overrides, std::uint64_t hash) {
  if (overrides.method) hash = hash_of(fmt::format("method {}", to_string(*overrides.method)), hash);
  if (overrides.accuracy) hash = hash_of(fmt::format("accuracy {}", to_string(*overrides.accuracy)), hash);
  if (overrides.spacing) hash = hash_of(fmt::format("spacing {:a}", *overrides.spacing), hash);
  for (const std::string& setting : overrides.settings) hash = hash_of("set " + setting, hash);
  if (overrides.solid_particles) hash = hash_of("solid particles", hash);
  return hash;
}

}  // namespace

SceneConfig read_scene(TomlFile& file, const std::string& path, const SceneOverrides& overrides) {
  SceneConfig scene;
  scene.path = path;
  for (const std::string& setting : overrides.settings) file.set(setting);
  TomlTable root = file.root();
  read_general(root, scene, overrides);
  read_domain(root, scene);
  if (overrides.spacing && !(*overrides.spacing >= kSpacing.min && *overrides.spacing <= kSpacing.max)) {
    file.fault(0,
               fmt::format("spacing on the command line is {}, expected {}", *overrides.spacing, describe(kSpacing)));
  }
  read_numerics(root, scene, overrides);
  check_domain(root, scene);
  read_stream(root, scene);
  read_materials(root, scene);
  read_bodies(root, scene);
  read_proxies(root, scene);
  read_heat(root, scene);
  read_probes(root, scene);
  scene.hash = hash_of_overrides(overrides, hash_of(file.text()));
  return scene;
}

SceneConfig load_scene(const std::string& path, const SceneOverrides& overrides) {
  TomlFile file = TomlFile::read(path);
  SceneConfig scene = read_scene(file, path, overrides);
  TomlTable root = file.root();
  find_files(root, scene);
  file.finish();
  return scene;
}

const char* to_string(Method method) { return kMethods[static_cast<std::size_t>(method)].c_str(); }
const char* to_string(Accuracy accuracy) { return kAccuracies[static_cast<std::size_t>(accuracy)].c_str(); }

}  // namespace palp
