// A link between the two processes as the bench plays it: delay, jitter, loss, doubles, late comers and stalls of the
// samples one way, drawn from a seed. Times are integer nanoseconds of the bench's clock.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace palp::bench {

struct LinkConfig {
  double delay = 0.05e-3;    // [s]
  double jitter = 0;         // mean of an exponential added to the delay [s]
  double loss = 0;           // share of the samples, 0..1
  double loss_run = 1;       // mean number of samples that are lost in a row
  double duplicate = 0;      // share that comes twice, the second after another draw of the jitter
  double reorder = 0;        // share that comes reorder_by later and is handed on although newer ones came before it
  double reorder_by = 3e-3;  // [s]
  double stall_every = 0;    // nothing arrives for stall_for at the start of each such period; then all at once [s]
  double stall_for = 0;      // [s]
};

// Both ways, and what is wrong with the clocks at their ends.
struct LinkPair {
  std::string name;
  LinkConfig up, down;       // device samples to the server, proxy samples to the bridge
  double clock_step = 0;     // the server's clock jumps by this [s]
  double clock_step_at = 0;  // after this time of the run [s]; again and again with this period
};

// "local", "lan", "far", ... (link_names) or "name:delay=2,jitter=1,loss=0.02,..." with times in ms; a key beginning
// with up_ or down_ sets one way only. Throws std::invalid_argument with one sentence.
LinkPair link_from(const std::string& text);
// Returns what a link's name stands for, in the same form.
std::string description_of(const std::string& text);
// The names of the links of the specification, then those of links that are worse.
const std::vector<std::string>& listed_links();
const std::vector<std::string>& further_links();

// Decides which of the samples sent arrive, and when. The same seed and times give the same arrivals.
class Link {
 public:
  Link(const LinkConfig& config, std::uint64_t seed) : config_(config), random_(seed) {}

  // Sends a sample at t_ns; index: the caller's own, growing from sample to sample.
  void send(std::int64_t t_ns, std::uint64_t index);
  // Takes the sample that is in the mailbox at t_ns: of all that have arrived since the last call, the last. False:
  // none. A best-effort reader hands on nothing older than what it has handed on, in both bus vendors, so late ones are
  // dropped; those of `reorder` get past it.
  bool take(std::int64_t t_ns, std::uint64_t& index, std::int64_t& t_receive_ns);

 private:
  struct Flight {
    std::int64_t arrival_ns;
    std::uint64_t index;
    bool past_reader;
  };
  void fly(std::int64_t t_ns, std::uint64_t index, double delay, bool past_reader);
  double uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  double wait();

  LinkConfig config_;
  std::mt19937_64 random_;
  std::vector<Flight> flying_;  // by arrival
  bool losing_ = false;
  bool handed_on_ = false;
  std::uint64_t newest_ = 0;
};

}  // namespace palp::bench
