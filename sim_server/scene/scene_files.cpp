#include "sim_server/scene/scene_files.h"

#include <fstream>

#include "config/data_dir.h"

namespace palp {

namespace {

// An estimate, on the safe side: the scene, the state of the CPU back end and a snapshot, of one particle.
constexpr std::size_t kBytesOfParticleInMemory = 600;

}  // namespace

std::string find_scene_file(const std::string& name) { return find_data_file(kSceneFiles, name); }

std::size_t particles_in_memory() {
  std::ifstream info("/proc/meminfo");
  std::string key;
  std::size_t kilobytes = 0;
  while (info >> key) {
    if (key == "MemAvailable:" && info >> kilobytes) break;
    info.ignore(1000, '\n');
  }
  constexpr std::size_t kUnknown = std::size_t{4} << 20;  // 4 GiB, in kB, where the system does not say
  return (kilobytes > 0 ? kilobytes : kUnknown) * 1024 / 4 * 3 / kBytesOfParticleInMemory;
}

}  // namespace palp
