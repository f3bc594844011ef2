#include "tools/control_client.h"

#include "idl/clock.h"

namespace palp {
namespace {

using namespace std::chrono_literals;

constexpr auto kAskAgain = 250ms;
constexpr auto kOthersSpeak = 500ms;  // more than two periods of a server's status

}  // namespace

ControlClient::ControlClient(Bus& bus)
    : commands_(bus.writer<Command>()),
      replies_(bus.reader<CommandReply>()),
      statuses_(bus.reader<Status>()),
      session_(bus.session()) {}

void ControlClient::look() {
  replies_->wait(10ms);
  std::vector<Received<CommandReply>> replies;
  replies_->take_all(replies);
  for (const Received<CommandReply>& r : replies)
    if (r.message.command_session == session_)
      answers_[r.message.command_sequence][r.message.header.session] = r.message;
  std::vector<Received<Status>> statuses;
  statuses_->take_all(statuses);
  for (const Received<Status>& s : statuses) roster_.add(s);
  roster_.forget(now_ns());
}

std::uint64_t ControlClient::send(CommandKind kind, const std::string& name, const std::string& value) {
  Command command;
  command.kind = kind;
  command.name = name;
  command.value = value;
  commands_->publish(command);
  return command.header.sequence;
}

bool ControlClient::finds_servers(std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  while (answers_.empty() && std::chrono::steady_clock::now() < end) {
    send(CommandKind::get_parameter, "", "");
    listen(kAskAgain, [this] { return !answers_.empty(); });
  }
  if (answers_.empty()) return false;
  listen(kOthersSpeak, [] { return false; });
  return true;
}

std::map<std::uint64_t, std::string> ControlClient::servers() const {
  std::map<std::uint64_t, std::string> out;
  for (const auto& [sequence, replies] : answers_)
    for (const auto& [session, reply] : replies) out[session] = roster_.name_of_session(session);
  for (const Peer& peer : roster_.peers())
    if (peer.status.process == kServerName && !has_ended(peer.status)) out[peer.session()] = name_of(peer.status);
  return out;
}

std::map<std::uint64_t, CommandReply> ControlClient::ask(CommandKind kind, const std::string& name,
                                                         const std::string& value, std::chrono::milliseconds timeout) {
  const std::size_t expected = servers().size();
  const std::uint64_t sequence = send(kind, name, value);
  listen(timeout, [&] { return answers_[sequence].size() >= expected; });
  return answers_[sequence];
}

}  // namespace palp
