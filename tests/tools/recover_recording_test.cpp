// Recordings that were cut short or damaged get a new index, also where the disk is full.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

#include "tests/support/files.h"
#include "tests/support/recordings.h"
#include "tools/recording/recover_recording.h"

namespace palp::test::recover_recording_test {
namespace {

TEST(Recovery, WhatAKilledRecorderFlushedIsRecovered) {
  const ScratchFolder folder;
  const std::string unfinished = folder / ("a.mcap" + std::string(kUnfinishedSuffix));
  std::mt19937 random(5);
  std::vector<OwnedMessage> written;
  {
    // the child writes the same messages and is killed without a chance to close
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    McapWriter writer(child == 0 ? folder / "a.mcap" : folder / "twin.mcap", small_chunks());
    written = fill(writer, 1000, random);
    writer.flush();
    if (child == 0) raise(SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
  }
  const McapReader cut(unfinished);
  EXPECT_FALSE(cut.indexed());
  EXPECT_NE(cut.index_fault().find("--recover"), std::string::npos) << cut.index_fault();
  EXPECT_THROW(cut.read([](const McapMessage&) { return true; }), McapError);

  ASSERT_EQ(recovered_name(unfinished), folder / "a.mcap");
  // by another spelling of its name the file that is read is still the one that is read
  const std::string alias = folder / "alias.tmp~";
  std::filesystem::create_symlink(unfinished, alias);
  EXPECT_EQ(recover_recording(alias, folder / "a.mcap", true).messages, 1000u);
  ASSERT_TRUE(std::filesystem::exists(unfinished));
  std::filesystem::remove(folder / "a.mcap");
  const Recovery recovery = recover_recording(unfinished, folder / "a.mcap", false);
  EXPECT_EQ(recovery.messages, 1000u);
  ASSERT_EQ(recovery.damages.size(), 1u);
  EXPECT_NE(recovery.damages[0].find("at byte"), std::string::npos) << recovery.damages[0];
  std::vector<OwnedMessage> read = read_all(McapReader(folder / "a.mcap"));
  sort_by_sequence(read);
  EXPECT_EQ(read, written);
}

TEST(Recovery, DamageInTheMiddleCostsOnlyItsChunk) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 1000, 9);
  McapChunkIndex hit;
  {
    const McapReader reader(folder / "a.mcap");
    hit = reader.chunks()[reader.chunks().size() / 2];
  }
  Bytes bytes = file_bytes(folder / "a.mcap");
  bytes[hit.offset + 3] = 0xff;  // the length of the chunk record
  write_file(folder / "a.mcap", bytes);
  EXPECT_THROW(read_all(McapReader(folder / "a.mcap")), McapError);
  const Recovery recovery = recover_recording(folder / "a.mcap", folder / "b.mcap", false);
  EXPECT_FALSE(recovery.damages.empty());
  EXPECT_LT(recovery.messages, 1000u);
  EXPECT_GT(recovery.messages, 950u);
  for (const OwnedMessage& m : read_all(McapReader(folder / "b.mcap"))) ASSERT_EQ(m, written.at(m.sequence - 1));
}

// Returns the exit status of `action` on a disk that is full after so many bytes: the limit on a file's size lets
// write() fail half-way through a chunk.
int run_on_a_full_disk(std::uint64_t bytes, const std::function<int()>& action) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      _exit(action());
    } catch (...) {
      _exit(3);
    }
  }
  int status = 0;
  return child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Recovery, ARecoveryOnAFullDiskLeavesNothingAndSaysWhatToDo) {
  const ScratchFolder folder;
  make_file(folder / "a.mcap", 2000, 12);
  const Bytes before = file_bytes(folder / "a.mcap");
  std::filesystem::create_directory(folder / "full");
  const auto recover = [&]() -> int {
    try {
      recover_recording(folder / "a.mcap", folder / "full/b.mcap", false);
      return 1;
    } catch (const McapError& error) {
      write_text(folder / "said", error.what());
      return 0;
    }
  };
  ASSERT_EQ(run_on_a_full_disk(20'000, recover), 0);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "full"));
  EXPECT_EQ(file_bytes(folder / "a.mcap"), before);
  const std::string said = text_of(folder / "said");
  EXPECT_EQ(said.find("--recover"), std::string::npos) << said;  // nothing is left that could be
  EXPECT_NE(said.find("File too large"), std::string::npos) << said;
  EXPECT_NE(said.find("--out"), std::string::npos) << said;
}

TEST(Recovery, AFullDiskIsOneErrorAndKeepsWhatWasWritten) {
  const ScratchFolder folder;
  const auto record = [&] {
    std::string first;
    std::string second;
    std::mt19937 random(10);
    McapWriter writer(folder / "a.mcap", small_chunks());
    try {
      fill(writer, 5000, random);
    } catch (const McapError& error) {
      first = error.what();
    }
    try {
      writer.close();
    } catch (const McapError& error) {
      second = error.what();
    }
    return !first.empty() && first == second && first.find("--recover") != std::string::npos ? 0 : 4;
  };
  EXPECT_EQ(run_on_a_full_disk(20'000, record), 0);
  const std::string unfinished = folder / ("a.mcap" + std::string(kUnfinishedSuffix));
  EXPECT_LE(std::filesystem::file_size(unfinished), 20'000u);
  const Recovery recovery = recover_recording(unfinished, folder / "a.mcap", false);
  EXPECT_GT(recovery.messages, 50u);
  EXPECT_EQ(recovery.damages.size(), 1u);
}

}  // namespace
}  // namespace palp::test::recover_recording_test
