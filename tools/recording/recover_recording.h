// Gives a recording that was cut short or damaged a new index.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palp {

struct Recovery {
  std::uint64_t messages = 0;        // saved
  std::vector<std::string> damages;  // what was lost and where, a sentence each
};

// Copies what can be read of `from` into the new file `to`. Messages, times, topics and schemas stay as they were.
// While it grows the new file is called NAME.recovering~; nothing of it is left when it cannot be finished, and `from`
// is never written to. Throws McapError when `from` is no MCAP file at all or `to` cannot be written.
Recovery recover_recording(const std::string& from, const std::string& to, bool overwrite);

// Returns where the recovered file goes when nobody says: NAME.mcap for NAME.mcap.tmp~, else NAME.recovered.mcap.
std::string recovered_name(const std::string& path);

}  // namespace palp
