#include "tools/recording/recover_recording.h"

#include <unistd.h>

#include <filesystem>
#include <map>
#include <utility>

#include "idl/mcap/mcap_reader.h"
#include "idl/mcap/mcap_writer.h"

namespace palp {
namespace {

constexpr const char* kRecoveringSuffix = ".recovering~";

// The new file cannot be written. No McapError, which a scan takes for damage of the old file.
class CannotWrite : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <class Action>
void writing(Action&& action) {
  try {
    action();
  } catch (const McapError& error) {
    throw CannotWrite(error.what());
  }
}

std::string advice(const std::string& from) {
  return "; nothing of it is left and " + from +
         " is as it was: make room, or name a file on another disk with --out, and recover again";
}

// Channels are added with their first message: only then is their compression known.
class Copier {
 public:
  explicit Copier(McapWriter& out) : out_(out) {}

  McapVisitor visitor() {
    McapVisitor v;
    v.schema = [this](const McapSchema& schema) { schemas_.try_emplace(schema.id, schema); };
    v.channel = [this](const McapChannel& channel) { channels_.try_emplace(channel.id, channel); };
    v.metadata = [this](const McapMetadata& metadata) { writing([&] { out_.add_metadata(metadata); }); };
    v.message = [this](const McapMessage& message, Compression compression) {
      if (message.data.size() > kMaxMessageBytes) {
        too_large.push_back("a message of " + std::to_string(message.data.size()) + " bytes is too large and left out");
        return;
      }
      writing([&] {
        McapMessage copy = message;
        copy.channel_id = channel_id(message.channel_id, compression);
        out_.write(copy);
      });
    };
    return v;
  }

  std::vector<std::string> too_large;

 private:
  std::uint16_t schema_id(std::uint16_t from) {
    const auto schema = schemas_.find(from);
    if (schema == schemas_.end()) return 0;
    const auto [it, added] = new_schemas_.try_emplace(from, std::uint16_t{0});
    if (added) it->second = out_.add_schema(schema->second.name, schema->second.encoding, schema->second.data);
    return it->second;
  }
  std::uint16_t channel_id(std::uint16_t from, Compression compression) {
    const auto [it, added] = new_channels_.try_emplace(from, std::uint16_t{0});
    if (added) {
      const McapChannel& c = channels_.at(from);
      it->second = out_.add_channel(c.topic, schema_id(c.schema_id), c.encoding, c.metadata, compression);
    }
    return it->second;
  }

  McapWriter& out_;
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::map<std::uint16_t, std::uint16_t> new_schemas_;
  std::map<std::uint16_t, std::uint16_t> new_channels_;
};

bool are_one_file(const std::string& a, const std::string& b) {
  std::error_code none;
  return std::filesystem::equivalent(a, b, none) && !none;
}

}  // namespace

Recovery recover_recording(const std::string& from, const std::string& to, bool overwrite) {
  const McapReader in(from);
  if (!overwrite && access(to.c_str(), F_OK) == 0)
    throw McapError(to + ": the file exists already; name another one with --out, or give --overwrite to replace it");
  McapWriterOptions options;
  options.library = in.library();
  options.overwrite = true;  // of the unfinished file, which only a recovery that was killed can have left
  options.unfinished_suffix = kRecoveringSuffix;
  options.keep_unfinished = false;
  if (are_one_file(to + kRecoveringSuffix, from))
    throw McapError(from + ": the recovered file would be written over it; name another one with --out");
  try {
    McapWriter out(to, options);
    Copier copier(out);
    McapScan scan = in.scan(copier.visitor());
    out.close();
    scan.damages.insert(scan.damages.end(), copier.too_large.begin(), copier.too_large.end());
    return {scan.messages - copier.too_large.size(), std::move(scan.damages)};
  } catch (const std::runtime_error& error) {
    throw McapError(error.what() + advice(from));
  }
}

std::string recovered_name(const std::string& path) {
  const std::string unfinished = kUnfinishedSuffix;
  if (path.ends_with(unfinished)) return path.substr(0, path.size() - unfinished.size());
  const std::string ending = ".mcap";
  return (path.ends_with(ending) ? path.substr(0, path.size() - ending.size()) : path) + ".recovered.mcap";
}

}  // namespace palp
