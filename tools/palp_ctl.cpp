// palp-ctl: says who is on the bus and how they fare, and gives commands to the server.
// Exit status: 0 done, 1 refused or nobody answered, 2 bad usage.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "config/command_line.h"
#include "config/number_between.h"
#include "idl/bus_options.h"
#include "idl/clock.h"
#include "tools/control_client.h"
#include "tools/control_text.h"

namespace palp {
namespace {

struct Arguments {
  BusOptions bus;
  bool json = false;
  bool all = false;
  double timeout = 5;     // [s]
  double listen_for = 2;  // [s]
  std::string name;
  std::vector<std::string> value;
};

struct Verb {
  const char* word;
  const char* help;
  CommandKind kind;
};
constexpr std::array<Verb, 8> kVerbs{{
    {"pause", "let the simulation stand still", CommandKind::pause},
    {"resume", "let it run again", CommandKind::resume},
    {"step", "do one haptic step while it is paused", CommandKind::step},
    {"reset", "begin again with the scene's initial state", CommandKind::reset},
    {"quit", "end the server", CommandKind::quit},
    {"set", "change a parameter while the simulation runs", CommandKind::set_parameter},
    {"get", "say what parameters are, all or one", CommandKind::get_parameter},
    {"load", "go over to another scene, or read the same one anew", CommandKind::load_scene},
}};

std::chrono::milliseconds to_ms(double seconds) { return std::chrono::milliseconds(std::llround(1e3 * seconds)); }

int fail(const Arguments& a, const std::string& sentence) {
  if (a.json) fmt::print("{}", json_text({{"ok", false}, {"text", sentence}}));
  fmt::print(stderr, "palp-ctl: {}\n", sentence);
  return 1;
}

std::string bus_name(const BusOptions& bus) { return fmt::format("{}, domain {}", to_string(bus.vendor), bus.domain); }

int list(const Arguments& a) {
  const auto bus = open_bus(a.bus);
  ControlClient client(*bus);
  client.listen(to_ms(a.listen_for), [] { return false; });
  const std::vector<Peer>& peers = client.roster().peers();
  if (peers.empty())
    return fail(a,
                fmt::format("nobody was heard on {} within {:g} s: check --domain, and --network or --peer for other "
                            "hosts",
                            bus_name(a.bus), a.listen_for));
  const std::int64_t now = now_ns();
  Json all = Json::array();
  for (const Peer& peer : peers) all.push_back(json_of(peer, now));
  if (a.json) {
    fmt::print("{}", json_text({{"ok", true}, {"processes", all}}));
  } else {
    for (const Peer& peer : peers) fmt::print("{}\n", line_of(peer, now));
  }
  if (client.servers().size() > 1)
    fmt::print(stderr, "palp-ctl: {} servers run in one domain: end all but one, or give them another --domain\n",
               client.servers().size());
  return 0;
}

// Prints what one server replied; `from` is empty where there is only one.
void print_reply(const std::string& from, const CommandReply& reply, bool is_list) {
  const std::string prefix = from.empty() ? "" : from + ": ";
  if (!reply.ok) {
    fmt::print(stderr, "palp-ctl: {}refused: {}\n", prefix, reply.text);
  } else if (is_list) {
    for (const ListedParameter& p : parse_parameters(reply.text)) fmt::print("{}{}\n", prefix, line_of(p));
  } else {
    fmt::print("{}{}\n", prefix, reply.text);
  }
}

Json json_of_reply(const std::string& from, const CommandReply& reply, bool is_list) {
  Json json{{"server", from}, {"ok", reply.ok}};
  if (!is_list || !reply.ok) {
    json["text"] = reply.text;
    return json;
  }
  json["parameters"] = Json::array();
  for (const ListedParameter& p : parse_parameters(reply.text)) json["parameters"].push_back(json_of(p));
  return json;
}

int command(const Arguments& a, CommandKind kind) {
  const auto bus = open_bus(a.bus);
  ControlClient client(*bus);
  if (!client.finds_servers(to_ms(a.timeout)))
    return fail(a,
                fmt::format("no sim_server answered on {} within {:g} s: check that one runs, --domain, and --network "
                            "or --peer for another host",
                            bus_name(a.bus), a.timeout));
  const auto servers = client.servers();
  if (servers.size() > 1 && !a.all) {
    std::string names;
    for (const auto& [session, name] : servers) names += (names.empty() ? "" : " and ") + name;
    return fail(a, fmt::format("{} run on {}, and a command reaches all of them: end all but one, or give --all", names,
                               bus_name(a.bus)));
  }
  std::string value;
  for (const std::string& word : a.value) value += (value.empty() ? "" : " ") + word;
  const auto replies = client.ask(kind, a.name, value, to_ms(a.timeout));
  const bool is_list = kind == CommandKind::get_parameter && a.name != kBillName && a.name != kScenesName;
  bool ok = true;
  Json json = Json::array();
  for (const auto& [session, name] : servers) {
    const auto reply = replies.find(session);
    if (reply == replies.end()) {
      fmt::print(stderr, "palp-ctl: {} has not replied within {:g} s\n", name, a.timeout);
      ok = false;
      continue;
    }
    ok = ok && reply->second.ok;
    json.push_back(json_of_reply(name, reply->second, is_list));
    if (!a.json) print_reply(servers.size() > 1 ? name : "", reply->second, is_list);
  }
  if (a.json) fmt::print("{}", json_text({{"ok", ok}, {"replies", json}}));
  return ok ? 0 : 1;
}

void declare(CLI::App& app, Arguments& a) {
  app.require_subcommand(1);
  app.fallthrough();  // options may stand behind the word, too
  app.add_flag("--json", a.json, "print JSON");
  app.add_option("--timeout", a.timeout, "wait this long for a server and for its reply [s]")
      ->check(number_between(0.1, 600.0))
      ->capture_default_str();
  app.add_flag("--all", a.all, "where several servers run: give the command to all of them");
  add_bus_options(app, a.bus);
  app.add_subcommand("list", "say who is on the bus and how they fare")
      ->add_option("--listen", a.listen_for, "listen this long [s]")
      ->check(number_between(0.1, 600.0))
      ->capture_default_str();
  for (const Verb& verb : kVerbs) {
    CLI::App* sub = app.add_subcommand(verb.word, verb.help);
    if (verb.kind == CommandKind::set_parameter) {
      sub->add_option("name", a.name, "of the parameter; get lists them")->required();
      sub->add_option("value", a.value, "as a scene file would state it; a vector as three numbers")->required();
    } else if (verb.kind == CommandKind::get_parameter) {
      sub->add_option(
          "name", a.name,
          "of the parameter; without it, all; bill: what is computed, and why; scenes: those that load takes");
    } else if (verb.kind == CommandKind::load_scene) {
      sub->add_option("name", a.name, "of the scene; get scenes lists them; without it, the same scene anew");
    }
  }
}

int run(const CLI::App& app, const Arguments& a) {
  for (const Verb& verb : kVerbs)
    if (app.got_subcommand(verb.word)) return command(a, verb.kind);
  return list(a);
}

}  // namespace
}  // namespace palp

int main(int argc, char** argv) {
  CLI::App app("Says who is on palp's bus and how they fare, and gives commands to palp-sim-server.");
  app.footer(
      "Exit status: 0 done, 1 refused or nobody answered, 2 bad usage.\n"
      "Example: palp-ctl set gravity 0 0 -5");
  palp::Arguments arguments;
  palp::declare(app, arguments);
  return palp::run_program("palp-ctl", app, argc, argv, [&] { return palp::run(app, arguments); });
}
