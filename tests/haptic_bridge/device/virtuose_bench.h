// The driver of the Virtuose before the simulated one, in lock step: one read, one millisecond.
#pragma once

#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "haptic_bridge/device/virtuose.h"
#include "haptic_bridge/loop/local_model.h"
#include "tests/support/files.h"

namespace palp::test {

inline const std::string kFakeLibrary = PALP_LIB_DIR "/libvirtuose_sim.so";
inline constexpr std::int64_t kTickNs = 1'000'000;

struct LoggedCall {
  double time = 0;
  std::string name, arguments;
  int code = 0;
};

class VirtuoseBench : public ::testing::Test {
 protected:
  void TearDown() override {
    device_.reset();
    unsetenv("PALP_FAKE_VIRTUOSE");
  }

  // Writes a script of the simulated arm, with what every test wants; returns its file.
  std::string script(const std::string& more) {
    std::string file = folder_ / "script.toml";
    std::ofstream(file) << "clock = \"lock_step\"\nregrip = false\nlog = \"calls.log\"\ntrace = \"trace.csv\"\n"
                        << more;
    return file;
  }
  static std::string event(const std::string& name, double time, double duration, const std::string& more = "") {
    std::ostringstream text;
    text << "\n[[event]]\nevent = \"" << name << "\"\ntime = " << time << "\n";
    if (duration > 0) text << "duration = " << duration << "\n";
    text << more << "\n";
    return text.str();
  }
  VirtuoseSetup setup(const std::string& more = "") {
    VirtuoseSetup s;
    s.library = kFakeLibrary;
    s.address = script(more);
    s.limits = {10, 1, 300, 30};
    s.relay_time = 0.05;
    return s;
  }
  VirtuoseDevice& open(const VirtuoseSetup& s) {
    device_.reset();
    device_ = std::make_unique<VirtuoseDevice>(s, kStart);
    now_ = 1'000'000'000;
    return *device_;
  }
  VirtuoseDevice& open(const std::string& more = "") { return open(setup(more)); }

  template <class Error>
  std::string refusal(const VirtuoseSetup& s) {
    try {
      open(s);
    } catch (const Error& error) {
      return error.what();
    } catch (const std::exception& error) {
      return std::string("another kind of error: ") + error.what();
    }
    return "no error";
  }
  static void expect_sentence(const std::string& text, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " in: " << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  }
  bool tick(DeviceReading& reading, const Wrench<double>& wrench = zero_wrench()) {
    now_ += kTickNs;
    const bool good = device_->read(now_, reading);
    device_->write(wrench);
    return good;
  }
  // Ticks so many times, all of which must succeed, and returns the last reading.
  DeviceReading ticks(int n, const Wrench<double>& wrench = zero_wrench()) {
    DeviceReading reading;
    for (int i = 0; i < n; ++i) EXPECT_TRUE(tick(reading, wrench)) << device_->trouble();
    return reading;
  }

  // Closes the device and returns the calls that the simulated arm got.
  std::vector<LoggedCall> calls() {
    device_.reset();
    std::vector<LoggedCall> all;
    std::ifstream in(folder_ / "calls.log");
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      LoggedCall call;
      words >> call.time >> call.name;
      std::getline(words, call.arguments);
      const std::size_t mark = call.arguments.rfind("= ");
      if (mark != std::string::npos) call.code = std::stoi(call.arguments.substr(mark + 2));
      all.push_back(call);
    }
    return all;
  }
  static std::vector<std::string> names(const std::vector<LoggedCall>& calls) {
    std::vector<std::string> out;
    for (const LoggedCall& c : calls) out.push_back(c.name);
    return out;
  }
  // Returns what the simulated arm rendered, in columns: time, dead_man, powered, chain_closed, shifted, alarms, 6 of
  // force.
  std::vector<std::vector<double>> trace() {
    device_.reset();
    std::vector<std::vector<double>> rows;
    std::ifstream in(folder_ / "trace.csv");
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
      std::istringstream cells(line);
      rows.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::strtod(cell.c_str(), nullptr));
    }
    return rows;
  }

  inline static const RigidState kStart =
      at_rest({0.3, -0.4, 0.5}, Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, -1).normalized())));

  const ScratchFolder folder_;
  std::unique_ptr<VirtuoseDevice> device_;
  std::int64_t now_ = 0;
};

}  // namespace palp::test
