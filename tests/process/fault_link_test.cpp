// The rows of the fault table that the server and the bus provoke, in the real processes: how long it takes until the
// hand is safe, by the bridge's own flight log.
#include <atomic>
#include <mutex>
#include <thread>

#include "idl/vendor.h"
#include "tests/process/fault_system.h"

namespace palp::test::fault_link_test {
namespace {

constexpr double kTick = 1;  // [ms]

double oldest(const Flight& flight, std::size_t from, std::size_t to) {
  double age = 0;
  for (std::size_t i = from; i < to; ++i) age = std::max(age, flight[i].age_ms);
  return age;
}

// Checks everywhere in a log that how much of the coupling is rendered follows from the sample's age alone.
void expect_age_obeyed(const Flight& flight) {
  for (const FlightTick& t : flight) {
    if (t.state == "waiting") continue;
    const double share = std::clamp((60 - t.age_ms) / 40, 0.0, 1.0);
    ASSERT_NEAR(t.stale_scale, share, 1e-6) << t.age_ms;
    if (t.age_ms >= 95) {
      ASSERT_TRUE(t.cut && t.state == "stale") << t.age_ms;
    }
    if (t.state == "engaged") {
      ASSERT_LE(t.age_ms, 20);
    }
    if (t.state == "degraded") {
      ASSERT_GT(t.age_ms, 20);
    }
  }
}

// The time when something stood still or went, and how long it was gone.
struct Silence {
  std::int64_t t_ns = 0;
  double for_ms = 0;
};

class FaultLink : public FaultSystem {
 protected:
  Silence stop_server_for(std::chrono::milliseconds time) {
    const Urgent urgent;
    const std::int64_t t = now_ns();
    server_->send_signal(SIGSTOP);
    std::this_thread::sleep_for(time);
    server_->send_signal(SIGCONT);
    return {t, ms_between(t, now_ns())};
  }
  // Asks the server for a reset; returns when it asked.
  std::int64_t reset() {
    Client client(watch().bus());
    EXPECT_TRUE(client.reaches_server()) << said();
    const std::int64_t t = now_ns();
    EXPECT_TRUE(client.ask(CommandKind::reset).ok) << said();
    return t;
  }
};

struct AgeRows {
  RowTimes young{"sample up to 20 ms old: rendered, its age", "server stopped for 15 ms"};
  RowTimes fading{"20 to 60 ms: fades from", "server stopped for 40 ms"};
  RowTimes damping{"60 to 95 ms: damping only", "server stopped for 80 ms"};
  RowTimes silent{"older: no force", "server stopped for 300 ms"};

  // Judges a silence by the age that samples came to, which is never exactly what was wanted. Times are since the
  // server stopped.
  void judge(const Flight& flight, const Silence& s) {
    const std::size_t begin = tick_at(flight, s.t_ns);
    const std::size_t end = tick_at(flight, s.t_ns + static_cast<std::int64_t>(1e6 * (s.for_ms + 20)));
    if (begin == 0 || end >= flight.size() || flight[begin - 1].felt() < 3) return;
    std::size_t i = begin;
    double late = 0;
    const auto until = [&](const auto& condition) {
      while (i < end && !condition(flight[i])) late += flight[i++].late_ms;
      return i < end ? ms_between(s.t_ns, flight[i].t_ns) : std::nan("");
    };
    const double age = oldest(flight, begin, end);
    if (age <= 20 && s.for_ms >= 14) young.add(age, 20);
    if (age <= 20) return;
    fading.add(until([](const FlightTick& t) { return t.state == "degraded"; }), 20 + 2 * kTick + late + kInFlight);
    if (age <= 61) return;
    damping.add(until([](const FlightTick& t) { return length(minus(t.force, damping_only(t))) < 0.1; }),
                60 + 2 * kTick + late + kInFlight);
    if (age <= 96) return;
    silent.add(until([](const FlightTick& t) { return t.cut && t.felt() == 0; }), 100);
  }
  void tell() const {
    for (const RowTimes* row : {&young, &fading, &damping, &silent}) row->tell();
  }
  // The time in which samples that were under way when the server stopped still come in [ms].
  static constexpr double kInFlight = 3;
};

// Expects the force to begin anew: it falls as fast as the slew limit allows, and comes back on the ramp.
void judge_new_begin(const Flight& flight, RowTimes row, std::size_t at) {
  ASSERT_GT(at, 0u);
  ASSERT_LT(at + 1000, flight.size());
  const double before = flight[at - 1].felt();
  ASSERT_GT(before, 3);
  EXPECT_EQ(flight[at].engagement, 0);
  std::size_t safe = at;
  double late = 0;
  while (safe < flight.size() && !flight[safe].safe()) late += flight[safe++].late_ms;
  ASSERT_LT(safe, flight.size());
  row.add(ms_between(flight[at].t_ns, flight[safe].t_ns), before / 0.3 + kTick + late);
  row.tell();
  for (std::size_t i = safe; i < at + 1000; ++i) {
    ASSERT_LE(flight[i].felt(), flight[i].engagement * length(flight[i].model) + 0.3) << i - at;
  }
}

void judge_stalls(const Flight& flight, const std::vector<Silence>& stalls) {
  AgeRows rows;
  for (const Silence& s : stalls) rows.judge(flight, s);
  rows.tell();
}

void judge_death(const Flight& flight, const Silence& death) {
  AgeRows dead;
  dead.silent = RowTimes{"older: no force", "server killed (kill -9)"};
  dead.judge(flight, death);
  dead.silent.tell();
}

void judge_reset(const Flight& flight, std::int64_t t_ns) {
  std::size_t at = tick_at(flight, t_ns);
  while (at < flight.size() && flight[at].sim_time >= flight[at - 1].sim_time) ++at;
  judge_new_begin(flight, {"simulation reset", "command"}, at);
}

// t_second_ns: when the second server began; handover: when the first one was killed.
void judge_handover(const Flight& flight, std::int64_t t_second_ns, const Silence& handover) {
  AgeRows second;
  second.silent = RowTimes{"server restarted", "killed while a second server answers"};
  second.judge(flight, handover);
  second.silent.tell();
  std::size_t at = tick_at(flight, t_second_ns);
  while (at < flight.size() && flight[at].verdict != "restarted") ++at;
  ASSERT_LT(at, flight.size());
  EXPECT_GT(flight[at].t_ns, handover.t_ns) << "the second one was felt while the first one lived";
  EXPECT_EQ(flight[at].engagement, 0) << "its force begins on a ramp";
}

TEST_F(FaultLink, ServersThatStallEndAndComeBack) {
  Watcher& watcher = watch();
  start_weights();
  start_simulated(0);
  ASSERT_TRUE(carries(watcher, 0, 4.5)) << said_by_all();
  std::vector<Silence> stalls;
  for (int i = 0; i < 3; ++i) {
    for (const auto time : {15ms, 40ms, 80ms}) {
      stalls.push_back(stop_server_for(time));
      std::this_thread::sleep_for(120ms);
    }
    ASSERT_TRUE(carries(watcher, 0, 4.5)) << said_by_all();
  }
  stalls.push_back(stop_server_for(300ms));
  watcher.status.clear();
  ASSERT_TRUE(carries(watcher, 0, 4.5)) << said_by_all();
  EXPECT_TRUE(watcher.has_event("the server has fallen silent")) << said_by(0);

  const std::int64_t t_reset = reset();
  std::this_thread::sleep_for(1200ms);
  ASSERT_TRUE(carries(watcher, 0, 4.5)) << said_by_all();

  // a second server comes while the first one runs: it is passed over until the first one dies
  const std::int64_t t_second = now_ns();
  const std::uint64_t first_session = watcher.proxy.header.session;
  const std::unique_ptr<ChildProcess> first = std::move(server_);
  start_weights();
  ASSERT_TRUE(watcher.sees([&] { return watcher.proxy.header.session != first_session; })) << said_by_all();
  ASSERT_TRUE(watcher.sees([&] { return watcher.has_event("two servers answer in this domain"); })) << said_by_all();
  ASSERT_TRUE(carries(watcher, 0, 4.5)) << said_by_all();
  const Silence handover{now_ns(), 300};
  first->stop(SIGKILL);
  watcher.status.clear();
  ASSERT_TRUE(watcher.sees([&] { return watcher.has_event("takes its place"); })) << said_by_all();
  watcher.status.clear();
  ASSERT_TRUE(carries(watcher, 0, 4.5)) << said_by_all();
  const Silence death{now_ns(), 300};
  server_->stop(SIGKILL);
  std::this_thread::sleep_for(400ms);
  EXPECT_EQ(bridge(0).stop(), 0) << said_by(0);

  const Flight log = flight(0);
  expect_limits_held(log);
  expect_age_obeyed(log);
  judge_stalls(log, stalls);
  judge_death(log, death);
  judge_reset(log, t_reset);
  judge_handover(log, t_second, handover);
}

// A server that answers this bridge with a pull, and lies when it is told to. It sends below the checks of the bus.
class LyingServer {
 public:
  using Lie = std::function<void(ProxySample&)>;
  LyingServer(const BusOptions& options, Bus& bus)
      : sink_(cyclone_sink<ProxySample>(open_cyclone(options))), devices_(bus.reader<DeviceSample>()) {
    thread_ = std::thread([this] { serve(); });
  }
  ~LyingServer() {
    stop_ = true;
    thread_.join();
  }
  LyingServer(const LyingServer&) = delete;
  LyingServer& operator=(const LyingServer&) = delete;

  // Spoils the next samples; returns when each was sent.
  std::vector<std::int64_t> lie(const Lie& lie, std::size_t samples) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      lie_ = lie;
      told_.clear();
      wanted_ = samples;
    }
    for (int i = 0; i < 5000; ++i) {
      std::this_thread::sleep_for(1ms);
      const std::lock_guard<std::mutex> lock(mutex_);
      if (told_.size() == samples) return told_;
    }
    return {};
  }

 private:
  void serve() {
    const Urgent urgent;
    Received<DeviceSample> in;
    while (!stop_) {
      if (!devices_->wait(10ms) || !devices_->take_latest(in)) continue;
      const std::lock_guard<std::mutex> lock(mutex_);
      ProxySample s = answer(in.message);
      if (told_.size() < wanted_) {
        lie_(s);
        told_.push_back(now_ns());
      }
      sink_->write(s);
    }
  }
  ProxySample answer(const DeviceSample& d) {
    ProxySample s;
    s.header.session = 77;
    s.header.sequence = ++sequence_;
    s.header.t_send_ns = now_ns();
    s.flags = kEngaged | kHealthy;
    s.sim_time = 1e-3 * static_cast<double>(sequence_);
    s.device_session = d.header.session;
    s.device_sequence = d.header.sequence;
    s.t_device_ns = d.t_device_ns;
    s.device_pose = s.proxy_pose = d.pose;
    s.gains = d.gains;
    s.wrench.force = {0, 0, -4};
    return s;
  }

  std::unique_ptr<Sink<ProxySample>> sink_;
  std::unique_ptr<Reader<DeviceSample>> devices_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  Lie lie_;
  std::size_t wanted_ = 0;
  std::vector<std::int64_t> told_;
  std::uint64_t sequence_ = 0;
};

void judge_silence(const std::string& row, const Flight& log, std::int64_t t_ns) {
  std::size_t i = tick_at(log, t_ns);
  ASSERT_LT(i, log.size());
  ASSERT_GT(log[i - 1].felt(), 1);
  while (i < log.size() && !(log[i].cut && log[i].felt() == 0)) ++i;
  ASSERT_LT(i, log.size());
  RowTimes times(row, "a server that lies");
  times.add(ms_between(t_ns, log[i].t_ns), 100);
  times.tell();
}

// A way to lie, and when samples were sent that do: a few, which are dropped, and many, which end the force.
struct LieRow {
  const char* row;
  LyingServer::Lie lie;
  std::vector<std::int64_t> few{}, many{};
};

void judge_lies(const Flight& flight, const LieRow& lies) {
  SCOPED_TRACE(lies.row);
  ASSERT_EQ(lies.few.size() + lies.many.size(), 15u);
  for (std::size_t i = tick_at(flight, lies.few.front()); i < tick_at(flight, lies.few.back() + 10'000'000); ++i) {
    ASSERT_FALSE(flight[i].cut) << "three of them are dropped";
  }
  std::size_t i = tick_at(flight, lies.many.front());
  ASSERT_GT(flight[i - 1].felt(), 1);
  while (i < flight.size() && !flight[i].safe()) ++i;
  ASSERT_LT(i, flight.size());
  EXPECT_TRUE(flight[i].cut && flight[i].state == "locked") << flight[i].state;
  // four make a row; two that come in one tick may count as one
  RowTimes times(lies.row, "a server that lies");
  times.add(ms_between(lies.many.front(), flight[i].t_ns),
            ms_between(lies.many[0], lies.many[7]) + 3 * kTick + flight[i].late_ms);
  times.tell();
}

TEST_F(FaultLink, SamplesThatCannotBe) {
  Watcher& watcher = watch();
  start_bridge_of(0, {"--profile", profile(0, kNeverLate), "--home", "0", "0", "0.4"});
  LyingServer server(on(Vendor::cyclone), watcher.bus());
  const double kNan = std::nan("");
  std::vector<LieRow> rows{
      {"samples: a force that is no number", [&](ProxySample& s) { s.wrench.force[0] = kNan; }},
      {"samples: no orientation", [](ProxySample& s) { s.proxy_pose.orientation[3] = 0.5; }},
      {"samples: a force of 1e9 N", [](ProxySample& s) { s.wrench.force[1] = 1e9; }},
      {"samples: gains not agreed on", [](ProxySample& s) { s.gains.stiffness *= 10; }},
      {"samples: an answer to the future", [](ProxySample& s) { s.t_device_ns += 3'600'000'000'000; }},
  };
  for (LieRow& row : rows) {
    ASSERT_TRUE(carries(watcher, 0)) << said_by_all();
    row.few = server.lie(row.lie, 3);
    std::this_thread::sleep_for(60ms);
    row.many = server.lie(row.lie, 12);
    watcher.status.clear();
  }
  ASSERT_TRUE(carries(watcher, 0)) << said_by_all();
  const auto reordered = server.lie([](ProxySample& s) { s.header.sequence = 3; }, 8);
  std::this_thread::sleep_for(60ms);
  const auto repeated = server.lie([](ProxySample& s) { s.header.sequence = 3; }, 200);
  watcher.status.clear();
  ASSERT_TRUE(carries(watcher, 0)) << said_by_all();
  // of another session, which is held once the first has been silent, then of the one before again
  watcher.status.clear();
  const auto restarted = server.lie([](ProxySample& s) { s.header.session = 78; }, 2500);
  std::this_thread::sleep_for(150ms);
  EXPECT_EQ(bridge(0).stop(), 0) << said_by(0);

  const Flight log = flight(0);
  expect_limits_held(log);
  expect_age_obeyed(log);
  for (const LieRow& row : rows) judge_lies(log, row);
  ASSERT_EQ(reordered.size() + repeated.size(), 208u);
  for (std::size_t i = tick_at(log, reordered.front()); i < tick_at(log, reordered.back()); ++i) {
    ASSERT_FALSE(log[i].cut) << "a link that reorders is no fault";
  }
  judge_silence("samples: older than the last one, nothing newer", log, repeated.front());
  ASSERT_EQ(restarted.size(), 2500u);
  judge_silence("samples: of the session before, nothing newer", log, restarted.back());
}

}  // namespace
}  // namespace palp::test::fault_link_test
