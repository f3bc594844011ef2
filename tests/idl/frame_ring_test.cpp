// The ring of frames in shared memory: what a reader takes of what was written, and of what no sound server writes.
#include "idl/frame_ring.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <random>
#include <thread>

#include "idl/clock.h"
#include "idl/validate.h"
#include "tests/support/eventually.h"
#include "tests/support/seed.h"

namespace palp::test::frame_ring_test {
namespace {

constexpr std::uint32_t kParticles = 1000;

class FrameRing : public testing::Test {
 protected:
  FrameRing() {
    std::string name = "/dev/shm/palp-test-XXXXXX";
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    place_ = {7, 0xfeedface, kParticles, name};
  }
  ~FrameRing() override { std::filesystem::remove_all(place_.folder); }

  std::size_t files() const {
    const std::filesystem::directory_iterator entries(place_.folder);
    return static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
  }
  void overwrite(std::size_t at, const void* data, std::size_t bytes) const {
    const RingFile file(open(path_of(place_).c_str(), O_RDWR));
    ASSERT_EQ(pwrite(file.number(), data, bytes, static_cast<off_t>(at)), static_cast<ssize_t>(bytes));
  }
  template <class T>
  void overwrite(std::size_t at, T value) const {
    overwrite(at, &value, sizeof value);
  }
  std::string refusal() const {
    try {
      const FrameRingReader reader(place_);
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

  RingPlace place_;
};

// All values of such a frame are its number.
ParticleFrame frame_of(std::uint64_t number, ScalarField field = ScalarField::speed, bool with_solid = true) {
  ParticleFrame f;
  f.frame = number;
  f.sim_time = static_cast<double>(number);
  f.field = field;
  f.positions.assign(3 * kParticles, static_cast<float>(number));
  if (field != ScalarField::none) f.scalars.assign(kParticles, static_cast<float>(number));
  if (with_solid) f.solid.assign(kParticles, static_cast<std::uint8_t>(number));
  return f;
}

void expect_same(const ParticleFrame& a, const ParticleFrame& b) {
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.sim_time, b.sim_time);
  EXPECT_EQ(a.field, b.field);
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.scalars, b.scalars);
  EXPECT_EQ(a.solid, b.solid);
}

std::size_t in_slot(std::uint64_t number, std::size_t at) { return slot_begin(number % kRingSlots, kParticles) + at; }

TEST_F(FrameRing, AReaderTakesEachFrameOnceAndWhole) {
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  ParticleFrame out;
  EXPECT_EQ(reader.take(out), RingAnswer::nothing);
  const std::int64_t before = now_ns();
  for (const ParticleFrame& frame : {frame_of(5), frame_of(6, ScalarField::none, false), frame_of(7)}) {
    ASSERT_TRUE(writer.write(frame));
    ASSERT_EQ(reader.take(out), RingAnswer::frame);
    expect_same(out, frame);
    EXPECT_EQ(out.session, place_.session);
    EXPECT_LE(before, out.t_send_ns);
    EXPECT_LE(out.t_send_ns, out.t_receive_ns);
    EXPECT_EQ(reader.take(out), RingAnswer::nothing);
  }
}

TEST_F(FrameRing, TheNewestFrameWinsAndTheWriterWaitsForNobody) {
  FrameRingWriter writer(place_);
  FrameRingReader one(place_), other(place_);
  for (std::uint64_t number = 1; number <= 100; ++number) ASSERT_TRUE(writer.write(frame_of(number)));
  ParticleFrame out;
  for (FrameRingReader* reader : {&one, &other}) {
    ASSERT_EQ(reader->take(out), RingAnswer::frame);
    expect_same(out, frame_of(100));
  }
}

TEST_F(FrameRing, WhoComesLateBeginsWithTheNextFrame) {
  FrameRingWriter writer(place_);
  ASSERT_TRUE(writer.write(frame_of(1)));
  FrameRingReader reader(place_);
  ParticleFrame out;
  EXPECT_EQ(reader.take(out), RingAnswer::nothing) << "a frame of long ago";
  ASSERT_TRUE(writer.write(frame_of(2)));
  EXPECT_EQ(reader.take(out), RingAnswer::frame);
}

TEST_F(FrameRing, ASceneWithoutParticlesHasFramesToo) {
  place_.particle_count = 0;
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  ParticleFrame out;
  ASSERT_TRUE(writer.write({}));
  EXPECT_EQ(reader.take(out), RingAnswer::frame);
}

TEST_F(FrameRing, TheWriterKnowsWhetherAnybodyReads) {
  FrameRingWriter writer(place_);
  EXPECT_FALSE(writer.has_readers());
  auto one = std::make_unique<FrameRingReader>(place_), other = std::make_unique<FrameRingReader>(place_);
  EXPECT_TRUE(writer.has_readers());
  one.reset();
  EXPECT_TRUE(writer.has_readers());
  other.reset();
  EXPECT_FALSE(writer.has_readers());
  const pid_t killed = fork();
  if (killed == 0) {
    const FrameRingReader reader(place_);
    pause();
  }
  EXPECT_TRUE(eventually([&] { return writer.has_readers(); }));
  kill(killed, SIGKILL);
  waitpid(killed, nullptr, 0);
  EXPECT_FALSE(writer.has_readers());
}

TEST_F(FrameRing, ASlotThatIsWrittenAnewMeanwhileIsNotShown) {
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  ParticleFrame out;
  ASSERT_TRUE(writer.write(frame_of(1)));
  overwrite(offsetof(RingHeader, begun) + 1 * sizeof(std::uint64_t), std::uint64_t{4});
  EXPECT_EQ(reader.take(out), RingAnswer::nothing) << "the writer has come round to it";
  ASSERT_TRUE(writer.write(frame_of(2)));
  ASSERT_EQ(reader.take(out), RingAnswer::frame);
  expect_same(out, frame_of(2));
}

TEST_F(FrameRing, NoFrameIsOfTwoWhateverTheWritersHaste) {
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  std::jthread haste([&](const std::stop_token& stop) {
    ParticleFrame frame = frame_of(1);
    for (std::uint64_t number = 1; !stop.stop_requested(); ++number) {
      frame.frame = number;
      std::ranges::fill(frame.positions, static_cast<float>(number));
      std::ranges::fill(frame.scalars, static_cast<float>(number));
      EXPECT_TRUE(writer.write(frame));
    }
  });
  ParticleFrame out;
  for (int frames = 0; frames < 300;) {
    const RingAnswer answer = reader.take(out);
    ASSERT_NE(answer, RingAnswer::refused);
    if (answer != RingAnswer::frame) continue;
    ++frames;
    const auto value = static_cast<float>(out.frame);
    ASSERT_TRUE(std::ranges::all_of(out.positions, [&](float x) { return x == value; }));
    ASSERT_TRUE(std::ranges::all_of(out.scalars, [&](float x) { return x == value; }));
  }
}

TEST_F(FrameRing, IsNotOpenedWhereItIsAnothers) {
  EXPECT_NE(refusal().find("cannot be opened"), std::string::npos) << "there is none";
  {
    const FrameRingWriter writer(place_);
    EXPECT_EQ(refusal(), "");
    const RingPlace right = place_;
    ++place_.session;
    EXPECT_NE(refusal(), "") << "of another server";
    place_ = right;
    ++place_.domain;
    EXPECT_NE(refusal(), "") << "of another domain";
    place_ = right;
    --place_.particle_count;
    EXPECT_NE(refusal(), "") << "of another scene";
    place_ = right;
    for (const std::size_t field :
         {offsetof(RingHeader, magic), offsetof(RingHeader, layout), offsetof(RingHeader, domain),
          offsetof(RingHeader, session), offsetof(RingHeader, particle_count)}) {
      std::uint64_t value = 0;
      const RingFile file(open(path_of(place_).c_str(), O_RDWR));
      ASSERT_EQ(pread(file.number(), &value, sizeof value, static_cast<off_t>(field)), ssize_t{sizeof value});
      overwrite(field, value + 1);
      EXPECT_NE(refusal().find("is not the ring"), std::string::npos) << "byte " << field;
      overwrite(field, value);
      EXPECT_EQ(refusal(), "");
    }
    ASSERT_EQ(truncate(path_of(place_).c_str(), static_cast<off_t>(slot_begin(kRingSlots, kParticles)) - 1), 0);
    EXPECT_NE(refusal().find("is not the ring"), std::string::npos) << "a byte too short";
    ASSERT_EQ(truncate(path_of(place_).c_str(), 0), 0);
    EXPECT_NE(refusal().find("is not the ring"), std::string::npos) << "empty";
  }
  ASSERT_EQ(mkfifo(path_of(place_).c_str(), 0600), 0);
  EXPECT_NE(refusal().find("no file of this user"), std::string::npos) << "a pipe, which must not make it wait";
  unlink(path_of(place_).c_str());
  ASSERT_EQ(symlink("/dev/zero", path_of(place_).c_str()), 0);
  EXPECT_NE(refusal().find("cannot be opened"), std::string::npos) << "a link";
}

TEST_F(FrameRing, IsNotOpenedWhereItIsAnotherUsers) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a file away";
  const FrameRingWriter writer(place_);
  ASSERT_EQ(chown(path_of(place_).c_str(), 12345, 12345), 0);
  EXPECT_NE(refusal().find("no file of this user"), std::string::npos);
}

TEST_F(FrameRing, ValuesThatTheBusWouldRefuseAreRefused) {
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  ParticleFrame out;
  std::uint64_t number = 0;
  const auto answer_to = [&](std::size_t at, auto value) {
    EXPECT_TRUE(writer.write(frame_of(++number)));
    overwrite(in_slot(number, at), value);
    return reader.take(out);
  };
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(answer_to(offsetof(SlotHeader, field), static_cast<std::uint32_t>(kScalarFields.size())),
            RingAnswer::refused);
  EXPECT_EQ(answer_to(offsetof(SlotHeader, with_solid), 2u), RingAnswer::refused);
  EXPECT_EQ(answer_to(offsetof(SlotHeader, sim_time), -1.0), RingAnswer::refused);
  EXPECT_EQ(answer_to(offsetof(SlotHeader, sim_time), std::nan("")), RingAnswer::refused);
  EXPECT_EQ(answer_to(sizeof(SlotHeader) + 12 * kParticles - 4, kNan), RingAnswer::refused) << "the last coordinate";
  EXPECT_EQ(answer_to(sizeof(SlotHeader) + 16 * kParticles - 4, INFINITY), RingAnswer::refused) << "the last scalar";
  EXPECT_EQ(answer_to(sizeof(SlotHeader) + 16 * kParticles, std::uint8_t{255}), RingAnswer::frame);
}

TEST_F(FrameRing, AFileThatIsCutShortWhileItIsReadHarmsNobody) {
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  ParticleFrame out;
  ASSERT_TRUE(writer.write(frame_of(1)));
  ASSERT_EQ(truncate(path_of(place_).c_str(), 4096), 0);
  EXPECT_EQ(reader.take(out), RingAnswer::refused);
  ASSERT_EQ(truncate(path_of(place_).c_str(), 0), 0);
  EXPECT_EQ(reader.take(out), RingAnswer::closed);
  EXPECT_TRUE(writer.write(frame_of(2))) << "it grows again";
}

TEST_F(FrameRing, WhateverLiesInTheFileOnlySoundFramesComeOut) {
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  const unsigned seed = drawn_seed();
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  const std::size_t bytes = slot_begin(kRingSlots, kParticles);
  ParticleFrame out;
  int frames = 0;
  for (int round = 0; round < 20'000; ++round) {
    if (random() % 2 == 0) writer.write(frame_of(static_cast<std::uint64_t>(round)));
    const bool in_head = random() % 2 == 0;
    const std::size_t at = in_head ? random() % sizeof(RingHeader) : random() % (bytes - 8);
    overwrite(at, random() % 4 == 0 ? random() : random() % 16);
    if (reader.take(out) != RingAnswer::frame) continue;
    ++frames;
    ASSERT_EQ(validate(out), Fault::none);
    ASSERT_EQ(out.positions.size(), 3 * kParticles);
  }
  EXPECT_GT(frames, 1000);
}

TEST_F(FrameRing, WhenMemoryIsUsedUpReadersLearnThatNoFrameWillCome) {
  FrameRingWriter writer(place_);
  FrameRingReader reader(place_);
  ParticleFrame out;
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit one_page{4096, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &one_page);
  const bool written = writer.write(frame_of(1));
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_FALSE(written);
  EXPECT_EQ(reader.take(out), RingAnswer::closed);
  EXPECT_NE(refusal().find("closed"), std::string::npos);
  EXPECT_FALSE(writer.write(frame_of(2))) << "once is for ever";
}

TEST_F(FrameRing, AFrameOfAnotherSceneIsNotWritten) {
  FrameRingWriter writer(place_);
  ParticleFrame frame = frame_of(1);
  frame.positions.resize(3);
  EXPECT_FALSE(writer.write(frame));
}

TEST_F(FrameRing, TheNextServerRemovesWhatADeadOneLeftAndNothingElse) {
  const RingPlace own = place_;
  const pid_t child = fork();
  if (child == 0) {
    place_.session = 1;
    const FrameRingWriter killed(place_);
    kill(getpid(), SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  EXPECT_EQ(files(), 1u);
  {
    const RingFile other(open((place_.folder + "/another").c_str(), O_CREAT | O_RDWR, 0600));
    const FrameRingWriter writer(place_);
    EXPECT_EQ(files(), 2u) << "its own and the other one's";
    place_.session = 2;
    const FrameRingWriter beside(place_);
    EXPECT_EQ(files(), 3u) << "a server that lives keeps its ring";
    const FrameRingReader reader(own);
  }
  EXPECT_EQ(files(), 1u) << "servers that end take theirs away";
}

TEST_F(FrameRing, SaysWhyItCannotBeMade) {
  place_.folder += "/none";
  try {
    const FrameRingWriter writer(place_);
    FAIL() << "it was made in a folder that is not there";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("cannot be made: No such file"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace palp::test::frame_ring_test
