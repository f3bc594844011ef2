// Everything that the viewer knows of the other processes: a thread takes the newest of every topic from the bus and
// keeps it until the thread that draws asks. The readers are best effort and keep nothing back, so a slow or stopped
// viewer costs the others nothing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "idl/bus.h"
#include "viewer/feed_state.h"

namespace palp {

class Feed {
 public:
  // Opens the bus and starts the thread. Throws std::runtime_error as open_bus does.
  explicit Feed(const BusOptions& options);
  ~Feed();

  // Any thread. Copies shared pointers and small structs only.
  FeedView view() const;
  // Any thread; the feed's own thread sends it.
  void send(CommandKind kind, const std::string& name = "", const std::string& value = "");
  // Any thread; published as the viewer's Status.
  void report(const std::string& state, std::vector<Metric> metrics);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palp
