// The parts of the scene reader. Not for use outside config/ and its tests.
#pragma once

#include "config/scene_config.h"
#include "config/toml_reader.h"

namespace palp {

// Reads all tables of a scene and gathers faults in the file; TomlFile::finish is left to the caller.
SceneConfig read_scene(TomlFile& file, const std::string& path, const SceneOverrides& overrides);

// Each reads its tables from the root. Materials before bodies, bodies before proxies, heat and probes.
void read_materials(TomlTable& root, SceneConfig& scene);
void read_bodies(TomlTable& root, SceneConfig& scene);
void read_proxies(TomlTable& root, SceneConfig& scene);
void read_heat(TomlTable& root, SceneConfig& scene);
void read_probes(TomlTable& root, SceneConfig& scene);
// Looks at the disk: turns the names of hands, which read_proxies took as they stand, into paths, and says which files
// that the scene names are missing.
void find_files(TomlTable& root, SceneConfig& scene);

// Read the keys of a [[material]] and of a [[body]] that concern heat, when the other keys have been read.
void read_heat_keys(TomlTable& table, MaterialConfig& material);
bool read_hold_temperature(TomlTable& table, const BodyConfig& body);
// Returns whether some body has a temperature, or a file of particles that may bring one.
bool has_temperature(const SceneConfig& scene);
// Returns the body that a table names, or null. A name of no body is a fault.
const BodyConfig* read_body_name(TomlTable& table, const SceneConfig& scene, Need need);

// Returns the orientation from `orientation` (quaternion x y z w) or `rotation_deg` (axis and angle), else no rotation.
Eigen::Quaterniond read_orientation(TomlTable& table);
Eigen::Vector3d read_vector(TomlTable& table, std::string_view key, const char* unit, const Eigen::Vector3d& fallback,
                            Need need = Need::optional);
Eigen::Vector3d read_vector(TomlTable& table, std::string_view key, const Range& range, const Eigen::Vector3d& fallback,
                            Need need = Need::optional);
// Returns a name that is fit for messages, tables and (file_name) files and not taken yet, and titles the table
// "<kind> '<name>'".
std::string read_name(TomlTable& table, const std::string& kind, const std::vector<std::string>& taken, bool file_name);

}  // namespace palp
