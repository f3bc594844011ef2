#include "tools/haptic_bench/bus_time.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <stdexcept>
#include <thread>

#include "haptic_bridge/guard/realtime.h"
#include "idl/bus.h"
#include "idl/histogram.h"

namespace palp::bench {

namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr auto kToMeet = 20s;      // two vendors' processes begin one after the other
constexpr auto kUnderWay = 200ms;  // after the last sample was sent

BusOptions on(Vendor vendor, int domain) {
  BusOptions options;
  options.vendor = vendor;
  options.domain = domain;
  return options;
}

bool meets(const std::function<bool()>& partner) {
  const auto end = steady_clock::now() + kToMeet;
  while (!partner()) {
    if (steady_clock::now() > end) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

void send(Vendor vendor, int domain, std::size_t samples) {
  const auto bus = open_bus(on(vendor, domain));
  const auto writer = bus->writer<ProxySample>();
  if (!meets([&] { return writer->matched_readers() > 0; })) return;
  std::this_thread::sleep_for(kUnderWay);
  RealClock clock;
  std::int64_t due = clock.now_ns();
  for (std::size_t k = 0; k < samples; ++k) {
    clock.sleep_until(due += kPeriodNs);
    ProxySample sample;
    writer->publish(sample);
  }
  std::this_thread::sleep_for(kUnderWay);
}

pid_t start_sender(Vendor vendor, int domain, std::size_t samples) {
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error("no process can be started for the bus's other end");
  if (pid > 0) return pid;
  try {
    const PriorityHere urgent(RealtimeOptions{}.priority);
    send(vendor, domain, samples);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
  }
  _exit(0);
}

BusTime receive(Vendor vendor, int domain, std::size_t samples) {
  const auto bus = open_bus(on(vendor, domain));
  const auto reader = bus->reader<ProxySample>();
  const std::string name = to_string(vendor);
  if (!meets([&] { return reader->matched_writers() > 0; }))
    throw std::runtime_error(name + ": the two processes have not met on the loopback interface: try another --domain");
  Histogram times;
  std::vector<Received<ProxySample>> batch;
  std::uint64_t session = 0;
  auto last = steady_clock::now();
  // what is lost does not come: the end is when nothing more does
  while (times.count() < samples && steady_clock::now() - last < 2s) {
    batch.clear();
    if (!reader->wait(20ms) || reader->take_all(batch) == 0) continue;
    last = steady_clock::now();
    for (const auto& r : batch) {
      if (session == 0) session = r.message.header.session;
      const std::int64_t sent = r.message.header.t_send_ns;
      // another program of this domain may say anything
      if (r.message.header.session == session && sent > 0 && sent <= r.t_receive_ns) times.add(r.t_receive_ns - sent);
    }
  }
  if (times.count() == 0) throw std::runtime_error(name + ": no sample arrived");
  return {
      name,          samples, times.count(), times.quantile_us(0.5), times.quantile_us(0.99), times.quantile_us(0.999),
      times.max_us()};
}

}  // namespace

std::vector<BusTime> bus_times(int domain, double seconds) {
  const auto samples = static_cast<std::size_t>(std::lround(1e9 * seconds / kPeriodNs));
  std::vector<BusTime> times;
  for (const Vendor vendor : {Vendor::cyclone, Vendor::fastdds}) {
    const pid_t sender = start_sender(vendor, domain, samples);
    const PriorityHere urgent(RealtimeOptions{}.priority);
    try {
      times.push_back(receive(vendor, domain, samples));
    } catch (...) {
      kill(sender, SIGKILL);
      waitpid(sender, nullptr, 0);
      throw;
    }
    waitpid(sender, nullptr, 0);
  }
  return times;
}

std::string markdown(const std::vector<BusTime>& times) {
  std::string text = "| bus | sent | received | median | 99 % | 99.9 % | most |\n|---|---|---|---|---|---|---|\n";
  for (const BusTime& t : times)
    text += fmt::format("| {} | {} | {} | {:.1f} us | {:.1f} us | {:.1f} us | {:.1f} us |\n", t.vendor, t.sent,
                        t.received, t.median_us, t.p99_us, t.p999_us, t.max_us);
  return text;
}

}  // namespace palp::bench
