#include "tools/haptic_bench/link.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>

namespace palp::bench {

namespace {

constexpr double kMilli = 1e-3;

std::int64_t to_ns(double seconds) { return std::llround(1e9 * seconds); }

// In text form, as on the command line.
const std::map<std::string, std::string>& known_links() {
  static const std::map<std::string, std::string> kLinks{
      {"none", "delay=0"},
      {"local", "delay=0.05"},
      {"lan", "delay=0.3,jitter=0.2"},
      {"far", "delay=2,jitter=1,loss=0.02"},
      {"stall", "delay=0.3,jitter=0.2,stall_every=370,stall_for=15"},
      {"burst", "delay=0.5,jitter=0.3,loss=0.1,loss_run=6"},
      {"reorder", "delay=0.5,jitter=0.5,reorder=0.1,reorder_by=3"},
      {"double", "delay=0.5,jitter=0.5,duplicate=0.3"},
      {"clock", "delay=0.3,jitter=0.2,clock_step=70,clock_step_at=1300"},
      {"clock_back", "delay=0.3,jitter=0.2,clock_step=-70,clock_step_at=1300"},
      {"slow_up", "up_delay=5,up_jitter=0.5,down_delay=0.1"},
      {"slow_down", "up_delay=0.1,down_delay=5,down_jitter=0.5"},
      {"wifi", "delay=1,jitter=1.5,loss=0.03,loss_run=3,reorder=0.02,duplicate=0.02,stall_every=900,stall_for=12"},
  };
  return kLinks;
}

void set(LinkConfig& c, const std::string& key, double value) {
  if (key == "delay")
    c.delay = kMilli * value;
  else if (key == "jitter")
    c.jitter = kMilli * value;
  else if (key == "loss")
    c.loss = value;
  else if (key == "loss_run")
    c.loss_run = value;
  else if (key == "duplicate")
    c.duplicate = value;
  else if (key == "reorder")
    c.reorder = value;
  else if (key == "reorder_by")
    c.reorder_by = kMilli * value;
  else if (key == "stall_every")
    c.stall_every = kMilli * value;
  else if (key == "stall_for")
    c.stall_for = kMilli * value;
  else
    throw std::invalid_argument("a link has no property '" + key + "'");
}

void set(LinkPair& pair, const std::string& key, double value) {
  if (!std::isfinite(value) || (value < 0 && key != "clock_step"))
    throw std::invalid_argument("the link's " + key + " must be a number from 0 on");
  if (key == "clock_step")
    pair.clock_step = kMilli * value;
  else if (key == "clock_step_at")
    pair.clock_step_at = kMilli * value;
  else if (key.rfind("up_", 0) == 0)
    set(pair.up, key.substr(3), value);
  else if (key.rfind("down_", 0) == 0)
    set(pair.down, key.substr(5), value);
  else {
    set(pair.up, key, value);
    set(pair.down, key, value);
  }
}

double number(const std::string& text) {
  std::size_t used = 0;
  double value = 0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size()) throw std::invalid_argument("'" + text + "' in a link is not a number");
  return value;
}

}  // namespace

LinkPair link_from(const std::string& text) {
  const std::size_t colon = text.find(':');
  LinkPair pair;
  pair.name = text.substr(0, colon);
  std::string properties = colon == std::string::npos ? "" : text.substr(colon + 1);
  if (colon == std::string::npos) {
    const auto known = known_links().find(text);
    if (known == known_links().end())
      throw std::invalid_argument("there is no link '" + text +
                                  "': use local, lan, far or another of --help, or NAME:delay=2,jitter=1,loss=0.02");
    properties = known->second;
  }
  std::istringstream in(properties);
  for (std::string item; std::getline(in, item, ',');) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos) throw std::invalid_argument("'" + item + "' in a link is not of the form delay=2");
    set(pair, item.substr(0, equals), number(item.substr(equals + 1)));
  }
  return pair;
}

std::string description_of(const std::string& text) {
  const auto known = known_links().find(text);
  return known != known_links().end() ? known->second : text.substr(text.find(':') + 1);
}

const std::vector<std::string>& listed_links() {
  static const std::vector<std::string> kNames{"local", "lan", "far"};
  return kNames;
}

const std::vector<std::string>& further_links() {
  static const std::vector<std::string> kNames{"stall",      "burst",   "reorder",   "double", "clock",
                                               "clock_back", "slow_up", "slow_down", "wifi"};
  return kNames;
}

double Link::wait() { return config_.delay - config_.jitter * std::log1p(-uniform()); }

// A chain of two states: losing and not losing, with the wanted share and the wanted mean length of a run.
void Link::send(std::int64_t t_ns, std::uint64_t index) {
  // a fixed number of draws a sample, so that links that differ in one property differ in nothing else
  const double lose = uniform(), first = wait(), twice = uniform(), second = wait(), late = uniform();
  if (config_.loss > 0) {
    const double run = std::max(config_.loss_run, 1 / std::max(1e-9, 1 - config_.loss));
    const double stop = 1 / run, start = stop * config_.loss / (1 - config_.loss);
    losing_ = losing_ ? lose >= stop : lose < start;
    if (losing_) return;
  }
  const bool reordered = late < config_.reorder;
  fly(t_ns, index, first + (reordered ? config_.reorder_by : 0), reordered);
  if (twice < config_.duplicate) fly(t_ns, index, first + second - config_.delay, true);
}

void Link::fly(std::int64_t t_ns, std::uint64_t index, double delay, bool past_reader) {
  std::int64_t arrival = t_ns + to_ns(delay);
  if (config_.stall_every > 0) {
    const std::int64_t into = arrival % to_ns(config_.stall_every);
    if (into < to_ns(config_.stall_for)) arrival += to_ns(config_.stall_for) - into;
  }
  const Flight flight{arrival, index, past_reader};
  const auto after = std::upper_bound(flying_.begin(), flying_.end(), flight,
                                      [](const Flight& a, const Flight& b) { return a.arrival_ns < b.arrival_ns; });
  flying_.insert(after, flight);
}

bool Link::take(std::int64_t t_ns, std::uint64_t& index, std::int64_t& t_receive_ns) {
  bool came = false;
  std::size_t arrived = 0;
  for (; arrived < flying_.size() && flying_[arrived].arrival_ns <= t_ns; ++arrived) {
    const Flight& f = flying_[arrived];
    if (handed_on_ && f.index <= newest_ && !f.past_reader) continue;
    newest_ = handed_on_ ? std::max(newest_, f.index) : f.index;
    handed_on_ = came = true;
    index = f.index;
    t_receive_ns = f.arrival_ns;
  }
  flying_.erase(flying_.begin(), flying_.begin() + static_cast<std::ptrdiff_t>(arrived));
  return came;
}

}  // namespace palp::bench
