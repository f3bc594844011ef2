// Asks servers on the bus to do something and waits until they have answered. One thread.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>

#include "idl/bus.h"
#include "idl/roster.h"

namespace palp {

class ControlClient {
 public:
  explicit ControlClient(Bus& bus);

  // Listens for that long, or until `enough` says that it is.
  template <class Enough>
  void listen(std::chrono::milliseconds time, Enough enough) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (!enough() && std::chrono::steady_clock::now() < end) look();
  }

  // Asks something harmless again and again until a server answers, for what is sent before a server has found its
  // sender is lost; then waits until every other server has had the time to be heard. False if none answers in that
  // time.
  bool finds_servers(std::chrono::milliseconds timeout);
  // Returns the servers that run, by session.
  std::map<std::uint64_t, std::string> servers() const;
  // Sends once and returns the replies that come in that time, by the server's session; not longer than all answer.
  std::map<std::uint64_t, CommandReply> ask(CommandKind kind, const std::string& name, const std::string& value,
                                            std::chrono::milliseconds timeout);

  const Roster& roster() const { return roster_; }

 private:
  void look();
  std::uint64_t send(CommandKind kind, const std::string& name, const std::string& value);

  std::unique_ptr<Writer<Command>> commands_;
  std::unique_ptr<Reader<CommandReply>> replies_;
  std::unique_ptr<Reader<Status>> statuses_;
  std::uint64_t session_;
  Roster roster_;
  std::map<std::uint64_t, std::map<std::uint64_t, CommandReply>> answers_;  // by command's sequence, by server
};

}  // namespace palp
