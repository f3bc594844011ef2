// The flight log on disks that are well, full or not there.
#include "haptic_bridge/log/flight_log.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "haptic_bridge/log/rerun.h"
#include "tests/haptic_bridge/log/small_disk.h"
#include "tests/support/files.h"

namespace palp::test::flight_log_test {
namespace {

class LogFile : public testing::Test {
 protected:
  void SetUp() override {
    for (std::uint64_t i = 1; i <= 25; ++i) {
      record_.tick = i;
      record_.t_ns = static_cast<std::int64_t>(1'000'000'000'000'000 + i);
      record_.sent.force = {0.1 * static_cast<double>(i), 0, 0};
      log_.add(record_, {});
    }
  }
  static std::vector<std::string> lines(const std::filesystem::path& path) {
    std::ifstream in(path);
    std::vector<std::string> all;
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  const ScratchFolder folder_;
  TickRecord record_;
  FlightLog log_{10};
};

TEST_F(LogFile, HoldsTheLastTicksOldestFirst) {
  EXPECT_EQ(log_.size(), 10u);
  log_.write_csv(folder_ / "new/log.csv");
  const std::vector<std::string> all = lines(folder_ / "new/log.csv");
  ASSERT_EQ(all.size(), 11u);
  EXPECT_EQ(all[0].find("tick,t_ns,lateness_us,missed,state,"), 0u);
  EXPECT_EQ(all[1].find("16,1000000000000016,"), 0u);
  EXPECT_EQ(all[10].find("25,1000000000000025,"), 0u);
  const auto commas = [](const std::string& s) { return std::count(s.begin(), s.end(), ','); };
  for (const std::string& line : all) EXPECT_EQ(commas(line), commas(all[0]));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new/log.csv.part"));
}

TEST_F(LogFile, EveryColumnIsExplained) {
  log_.write_csv(folder_ / "log.csv");
  std::stringstream names(lines(folder_ / "log.csv")[0]), help(flight_log_columns());
  std::string name, line;
  while (std::getline(names, name, ',')) {
    ASSERT_TRUE(std::getline(help, line));
    EXPECT_EQ(line.find(name + ": "), 0u);
  }
}

TEST_F(LogFile, AFullDiskLeavesWhatWasThereAndSaysSo) {
  write_text(folder_ / "log.csv", "before\n");
  // a file that takes nothing stands where the temporary file goes
  std::filesystem::create_symlink("/dev/full", folder_ / "log.csv.part");
  try {
    log_.write_csv(folder_ / "log.csv");
    FAIL() << "nothing was said";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos) << error.what();
  }
  EXPECT_EQ(lines(folder_ / "log.csv"), std::vector<std::string>{"before"});
}

TEST_F(LogFile, ADiskThatFillsDuringTheRunCostsNothing) {
  const SmallDisk disk(folder_ / "disk", 1);
  if (!disk.there) GTEST_SKIP() << "no right to mount a small disk";
  {
    const LogRoom room(disk.path / "log.csv", 500);
    disk.fill();
    FlightLog log(500);
    for (int i = 0; i < 500; ++i) log.add(record_, {});
    log.write_csv(disk.path / "log.csv");
  }
  EXPECT_EQ(lines(disk.path / "log.csv").size(), 501u);
  EXPECT_FALSE(std::filesystem::exists(disk.path / "log.csv.part"));
}

TEST_F(LogFile, ADiskWithoutRoomForTheLogIsRefusedBeforeTheRun) {
  const SmallDisk disk(folder_ / "disk", 1);
  if (!disk.there) GTEST_SKIP() << "no right to mount a small disk";
  try {
    const LogRoom room(disk.path / "log.csv", 60000);
    FAIL() << "nothing was said";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("there is no room for its"), std::string::npos) << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(disk.path / "log.csv.part"));
}

TEST_F(LogFile, WhatAFullDiskStillTookStaysBesideThePath) {
  const SmallDisk disk(folder_ / "disk", 1);
  if (!disk.there) GTEST_SKIP() << "no right to mount a small disk";
  FlightLog log(20000);
  for (int i = 0; i < 20000; ++i) log.add(record_, {});
  EXPECT_THROW(log.write_csv(disk.path / "log.csv"), std::runtime_error);
  EXPECT_GT(lines(disk.path / "log.csv.part").size(), 1000u);
}

TEST_F(LogFile, ARunThatNeverBeganLeavesNothing) {
  { const LogRoom room(folder_ / "log.csv", 1000); }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(LogFile, APathThatCannotBeIsRefusedBeforeTheRun) {
  EXPECT_THROW(LogRoom("/proc/none/log.csv", 10), std::runtime_error);
  EXPECT_NO_THROW(LogRoom(folder_ / "deep/er/log.csv", 10));
}

}  // namespace
}  // namespace palp::test::flight_log_test
