// Where palp's own files are found: scenes, hands, device profiles, tables of the trade between speed and accuracy. No
// path of the machine that built a program is in it, so programs run from any folder, installed or out of a build tree.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace palp {

// A kind of palp's own files: its folder below data_dir(), and what people call one of them.
struct DataKind {
  const char* folder;
  const char* noun;
};
inline constexpr DataKind kSceneFiles{"scenes", "scene file"};
inline constexpr DataKind kHandFiles{"hands", "hand script"};
inline constexpr DataKind kDeviceProfiles{"devices", "device profile"};
inline constexpr DataKind kFilmScripts{"films", "script of a film's camera"};
inline constexpr DataKind kTradeTables{"trade", "table of the trade"};  // JSON: machine_class.h finds them

// The folder that holds `scenes`, `hands` and `devices`: PALP_DATA_DIR where that is set; else share/palp beside the
// program's bin; else config/ of the source tree whose build folder the program lies in; else palp in XDG_DATA_DIRS.
// Empty where there is none. Throws ConfigError when PALP_DATA_DIR names no folder.
std::filesystem::path data_dir();

// Folders in which a bare name of this kind is looked for: ./config/KIND, then palp's own.
std::vector<std::filesystem::path> data_folders(const DataKind& kind);

// Names, without .toml and in order, of the files that lie in these folders.
std::vector<std::string> names_in(const std::vector<std::filesystem::path>& folders);

// A path that exists is taken as it is. A bare name ("tray_fluid", with or without .toml) is looked for in
// data_folders(). Throws ConfigError that lists the names there are.
std::string find_data_file(const DataKind& kind, const std::string& name);

// A library that palp loads at run time, as libvirtuose_sim.so: in lib/palp beside the program's bin, or lib of its
// build tree. The bare file name, for the system's loader, where neither has it.
std::string find_own_library(const std::string& file);

}  // namespace palp
