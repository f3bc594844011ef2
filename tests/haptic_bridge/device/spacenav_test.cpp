// The 3D mouse, before a libspnav of our own.
#include "haptic_bridge/device/spacenav.h"

#include <array>
#include <cstdlib>

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "config/error.h"
#include "haptic_bridge/loop/local_model.h"
#include "tests/support/count_allocations.h"
#include "tests/support/count_locks.h"

namespace palp::test::spacenav_test {
namespace {

using Vec3 = Eigen::Vector3d;
const std::string kLibrary = PALP_LIB_DIR "/libfake_spnav.so";

class Spacenav : public ::testing::Test {
 protected:
  void SetUp() override {
    library_ = dlopen(kLibrary.c_str(), RTLD_NOW);
    ASSERT_NE(library_, nullptr);
    say_ = reinterpret_cast<void (*)(const int*)>(dlsym(library_, "fake_spnav_say"));
    hang_up_ = reinterpret_cast<void (*)()>(dlsym(library_, "fake_spnav_hang_up"));
    ASSERT_TRUE(say_ && hang_up_);
    SpacenavSetup setup;
    setup.library = kLibrary;
    device_ = std::make_unique<SpacenavDevice>(setup, start_);
  }
  void TearDown() override {
    device_.reset();
    if (library_) dlclose(library_);
  }
  void say(std::array<int, 8> words) { say_(words.data()); }
  // Moves for a second; the last reading.
  DeviceReading second() {
    DeviceReading reading;
    for (int i = 0; i < 1000; ++i) {
      now_ += 1'000'000;
      EXPECT_TRUE(device_->read(now_, reading));
    }
    return reading;
  }

  const RigidState start_ = at_rest({0.1, 0.2, 0.3}, Eigen::Quaterniond::Identity());
  void* library_ = nullptr;
  void (*say_)(const int*) = nullptr;
  void (*hang_up_)() = nullptr;
  std::unique_ptr<SpacenavDevice> device_;
  std::int64_t now_ = 1'000'000'000;
};

TEST_F(Spacenav, TheCapMovesTheHandleThatWay) {
  EXPECT_LT((second().state.position - start_.position).norm(), 1e-12);
  const std::array<std::pair<std::array<int, 8>, Vec3>, 3> ways{
      {{{1, 350, 0, 0}, Vec3::UnitX()}, {{1, 0, 350, 0}, Vec3::UnitZ()}, {{1, 0, 0, 350}, Vec3::UnitY()}}};
  for (const auto& [words, way] : ways) {
    const Vec3 before = second().state.position;
    say(words);
    EXPECT_LT((second().state.position - before - 0.2 * way).norm(), 0.01);  // it takes 30 ms to set off
    say({1, 5, -5, 5});                                                      // at rest, nearly
    second();
  }
  say({1, 0, 0, 0, 0, 350, 0});
  EXPECT_LT((rotation_between(start_.orientation, second().state.orientation) - Vec3(0, 0, 1)).norm(), 0.05);
}

TEST_F(Spacenav, TheForceHoldsTheHandleBack) {
  say({1, 350, 0, 0});
  second();
  device_->write({{-8, 0, 0}, {0, 0, 0}});
  second();
  EXPECT_LT(second().state.linear.norm(), 1e-6);
  EXPECT_FALSE(device_->write({{std::nan(""), 0, 0}, {0, 0, 0}}));
}

TEST_F(Spacenav, ButtonsAreRead) {
  say({2, 1, 1});
  EXPECT_EQ(second().buttons, 2u);
  say({2, 0, 1});
  EXPECT_EQ(second().buttons, 0u);
}

TEST_F(Spacenav, ADaemonThatGoesIsNoticedAtOnce) {
  say({1, 350, 0, 0});
  second();
  hang_up_();
  DeviceReading reading;
  EXPECT_FALSE(device_->read(now_ + 1'000'000, reading));
  EXPECT_NE(device_->trouble().find("daemon has gone"), std::string::npos);
}

TEST_F(Spacenav, ATickAllocatesNothingAndTakesNoLock) {
  say({1, 350, 0, 0});
  DeviceReading reading;
  start_counting_allocations();
  start_counting_locks();
  for (int i = 0; i < 100; ++i) device_->read(now_ += 1'000'000, reading);
  EXPECT_EQ(stop_counting_locks(), 0u);
  EXPECT_EQ(stop_counting_allocations(), 0u);
}

TEST_F(Spacenav, AMissingLibraryOrDaemonIsTold) {
  const auto refusal = [&](const std::string& library) -> std::string {
    SpacenavSetup setup;
    setup.library = library;
    try {
      SpacenavDevice device(setup, start_);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_NE(refusal("libpalp_no_such_library.so").find("cannot be loaded"), std::string::npos);
  EXPECT_NE(refusal(PALP_LIB_DIR "/libvirtuose_sim.so").find("no function spnav_open"), std::string::npos);
  setenv("PALP_NO_SPACENAV", "1", 1);
  EXPECT_NE(refusal(kLibrary).find("spacenavd"), std::string::npos);
  unsetenv("PALP_NO_SPACENAV");
}

}  // namespace
}  // namespace palp::test::spacenav_test
