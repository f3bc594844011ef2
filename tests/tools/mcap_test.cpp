// The MCAP writer and reader against each other, and against files that were cut or damaged.
#include <gtest/gtest.h>

#include <set>

#include "tests/support/files.h"
#include "tests/support/recordings.h"
#include "tests/support/seed.h"

namespace palp::test::mcap_test {
namespace {

TEST(Mcap, RoundTripKeepsEveryByteInTheOrderOfTime) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 2000, 1);
  const McapReader reader(folder / "a.mcap");
  ASSERT_TRUE(reader.indexed()) << reader.index_fault();
  std::vector<OwnedMessage> read = read_all(reader);
  for (std::size_t i = 1; i < read.size(); ++i) ASSERT_LE(read[i - 1].log_time_ns, read[i].log_time_ns);
  sort_by_sequence(read);
  EXPECT_EQ(read, written);
  McapScan result;
  std::vector<OwnedMessage> scanned = scan_all(reader, result);
  EXPECT_TRUE(result.complete);
  EXPECT_TRUE(result.damages.empty()) << result.damages.front();
  sort_by_sequence(scanned);
  EXPECT_EQ(scanned, written);
}

TEST(Mcap, SummaryCountsWhatIsInTheFile) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 500, 2);
  const McapReader reader(folder / "a.mcap");
  ASSERT_TRUE(reader.statistics());
  EXPECT_EQ(reader.statistics()->messages, 500u);
  EXPECT_EQ(reader.statistics()->chunks, reader.chunks().size());
  EXPECT_EQ(reader.statistics()->start_time_ns, written.front().log_time_ns);
  EXPECT_EQ(reader.statistics()->end_time_ns, written.back().log_time_ns);
  for (const auto& [id, channel] : reader.channels()) {
    const auto count = std::count_if(written.begin(), written.end(),
                                     [&, topic = channel.topic](const auto& m) { return m.topic == topic; });
    const auto& counts = reader.statistics()->channel_messages;
    EXPECT_EQ(counts.contains(id) ? counts.at(id) : 0, static_cast<std::uint64_t>(count)) << channel.topic;
    EXPECT_EQ(channel.metadata.at("qos"), "reliability: 1");
  }
  ASSERT_EQ(reader.metadata().size(), 1u);
  EXPECT_EQ(reader.metadata()[0].values.at("drops"), "0");
  EXPECT_EQ(reader.schemas().at(1).encoding, "omgidl");
}

TEST(Mcap, ChosenChannelsOnly) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 500, 3);
  const McapReader reader(folder / "a.mcap");
  std::size_t count = 0;
  reader.read(
      [&](const McapMessage& m) {
        EXPECT_EQ(m.channel_id, 3);
        ++count;
        return true;
      },
      {3});
  EXPECT_EQ(count, static_cast<std::size_t>(std::count_if(written.begin(), written.end(),
                                                          [](const auto& m) { return m.topic == "palp/lz4"; })));
}

TEST(Mcap, AnEmptyRecordingIsAWholeFile) {
  const ScratchFolder folder;
  McapWriter(folder / "a.mcap").close();
  const McapReader reader(folder / "a.mcap");
  EXPECT_TRUE(reader.indexed()) << reader.index_fault();
  EXPECT_TRUE(read_all(reader).empty());
}

TEST(Mcap, AnExistingFileIsNotOverwrittenUnasked) {
  const ScratchFolder folder;
  make_file(folder / "a.mcap", 10, 4);
  try {
    McapWriter again(folder / "a.mcap");
    ADD_FAILURE() << "the file was overwritten";
  } catch (const McapError& error) {
    EXPECT_NE(std::string(error.what()).find("--overwrite"), std::string::npos) << error.what();
  }
  {
    std::mt19937 random(4);
    McapWriter unfinished(folder / "b.mcap");
    fill(unfinished, 10, random);
  }
  EXPECT_TRUE(std::filesystem::exists(folder / ("b.mcap" + std::string(kUnfinishedSuffix))));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.mcap"));
  EXPECT_THROW(McapWriter(folder / "b.mcap"), McapError);
  McapWriterOptions options;
  options.overwrite = true;
  McapWriter(folder / "b.mcap", options).close();
  EXPECT_TRUE(std::filesystem::exists(folder / "b.mcap"));
}

TEST(Mcap, ARecordingThatNeverBeganLeavesNoFile) {
  const ScratchFolder folder;
  { McapWriter unfinished(folder / "a.mcap"); }
  EXPECT_FALSE(std::filesystem::exists(folder / ("a.mcap" + std::string(kUnfinishedSuffix))));
}

TEST(Mcap, ATruncatedFileGivesWholeMessagesUpToTheCut) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 60, 6);
  const Bytes whole = file_bytes(folder / "a.mcap");
  std::size_t best = 0;
  for (std::size_t length = 0; length < whole.size(); length += length + 200 < whole.size() ? 3 : 1) {
    write_file(folder / "cut.mcap", ByteView(whole).first(length));
    try {
      const McapReader reader(folder / "cut.mcap");
      EXPECT_FALSE(reader.indexed());
      McapScan result;
      const std::vector<OwnedMessage> read = scan_all(reader, result);
      EXPECT_GE(read.size(), best) << "a longer file gave less, at " << length;
      best = std::max(best, read.size());
      for (const OwnedMessage& m : read) ASSERT_EQ(m, written.at(m.sequence - 1));
    } catch (const McapError& error) {
      EXPECT_NE(std::string(error.what()).find("at byte"), std::string::npos) << error.what();
      EXPECT_EQ(best, 0u);
    }
  }
  EXPECT_EQ(best, written.size());
}

// Every message that a damaged file still gives must be one that was written, and nothing may crash.
TEST(Mcap, RandomDamageNeverGivesAWrongMessage) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 120, 7);
  const Bytes whole = file_bytes(folder / "a.mcap");
  const unsigned seed = drawn_seed();
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  int refused = 0;
  for (int round = 0; round < 1500; ++round) {
    Bytes damaged = whole;
    const std::size_t hits = 1 + random() % 4;
    for (std::size_t i = 0; i < hits; ++i) damaged[random() % damaged.size()] = static_cast<std::uint8_t>(random());
    write_file(folder / "damaged.mcap", damaged);
    const auto check = [&](const std::vector<OwnedMessage>& messages) {
      for (const OwnedMessage& m : messages) {
        ASSERT_GE(m.sequence, 1u);
        ASSERT_LE(m.sequence, written.size());
        // the topic's name stands outside of any chunk, so only the rest is held against the original
        EXPECT_EQ(m.data, written[m.sequence - 1].data) << "round " << round;
        EXPECT_EQ(m.log_time_ns, written[m.sequence - 1].log_time_ns) << "round " << round;
      }
    };
    try {
      const McapReader reader(folder / "damaged.mcap");
      McapScan result;
      check(scan_all(reader, result));
      check(read_all(reader));
    } catch (const McapError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 500);
}

// A message index begins with a channel's id, as a message does, and no checksum shields it.
TEST(Mcap, AMessageIndexWithAMessagesNumberIsDamage) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 120, 9);
  Bytes damaged = file_bytes(folder / "a.mcap");
  const std::vector<McapChunkIndex> chunks = McapReader(folder / "a.mcap").chunks();
  damaged.at(chunks.front().message_index.begin()->second) = static_cast<std::uint8_t>(Op::message);
  write_file(folder / "damaged.mcap", damaged);
  McapScan result;
  std::vector<OwnedMessage> read = scan_all(McapReader(folder / "damaged.mcap"), result);
  sort_by_sequence(read);
  EXPECT_EQ(read, written);
  ASSERT_EQ(result.damages.size(), 1u);
  EXPECT_NE(result.damages[0].find("a message outside of any chunk"), std::string::npos) << result.damages[0];
}

// Past the checksums: the parsers themselves.
TEST(Mcap, RandomDamageWithoutChecksumsNeverCrashes) {
  const ScratchFolder folder;
  make_file(folder / "a.mcap", 120, 8);
  const Bytes whole = file_bytes(folder / "a.mcap");
  const unsigned seed = drawn_seed();
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  McapReaderOptions options;
  options.check_crc = false;
  for (int round = 0; round < 1500; ++round) {
    Bytes damaged = whole;
    const std::size_t hits = 1 + random() % 4;
    for (std::size_t i = 0; i < hits; ++i) {
      // lengths are the dangerous part: also write large and odd 32-bit values
      const std::size_t at = random() % (damaged.size() - 4);
      if (random() % 2 == 0) {
        damaged[at] = static_cast<std::uint8_t>(random());
      } else {
        const std::uint32_t value = random() % 2 == 0 ? 0xffffffffu : random() % 4096;
        patch(damaged, at, value);
      }
    }
    if (random() % 4 == 0) damaged.resize(random() % damaged.size());
    write_file(folder / "damaged.mcap", damaged);
    try {
      const McapReader reader(folder / "damaged.mcap", options);
      McapScan result;
      scan_all(reader, result);
      reader.metadata();
      read_all(reader);
    } catch (const McapError&) {
    }
  }
}

// Bits flip inside of some chunks: exactly these are missing from a read that goes on behind damage.
TEST(Mcap, AReadThatGoesOnLosesTheDamagedChunksAndNothingElse) {
  const ScratchFolder folder;
  const std::vector<OwnedMessage> written = make_file(folder / "a.mcap", 600, 11);
  const Bytes whole = file_bytes(folder / "a.mcap");
  const std::vector<McapChunkIndex> chunks = McapReader(folder / "a.mcap").chunks();
  const unsigned seed = drawn_seed();
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (int round = 0; round < 300; ++round) {
    Bytes damaged = whole;
    std::set<std::uint64_t> hit;  // offsets
    for (std::size_t i = 1 + random() % 4; i > 0; --i) {
      const McapChunkIndex& chunk = chunks[random() % chunks.size()];
      hit.insert(chunk.offset);
      damaged[chunk.offset + random() % chunk.length] ^= static_cast<std::uint8_t>(1u << random() % 8);
    }
    write_file(folder / "damaged.mcap", damaged);
    const McapReader reader(folder / "damaged.mcap");
    std::vector<OwnedMessage> read;
    std::set<std::string> damages;
    reader.read(
        [&](const McapMessage& m) {
          read.push_back(owned(m, reader.channels().at(m.channel_id).topic));
          return true;
        },
        {}, [&](const std::string& damage) { damages.insert(damage); });
    EXPECT_LE(damages.size(), hit.size()) << "round " << round;
    std::uint64_t kept = 0;  // messages in the chunks that were not hit
    for (const McapChunkIndex& chunk : chunks)
      if (!hit.contains(chunk.offset)) kept += (chunk.message_index_length - 15 * chunk.message_index.size()) / 16;
    EXPECT_GE(read.size(), kept) << "round " << round;
    for (const OwnedMessage& m : read) ASSERT_EQ(m, written.at(m.sequence - 1)) << "round " << round;
  }
}

TEST(Mcap, OtherFilesAreRefusedWithOneSentence) {
  const ScratchFolder folder;
  const auto refused = [](const std::string& path) -> std::string {
    try {
      McapReader reader(path);
    } catch (const McapError& error) {
      return error.what();
    }
    return {};
  };
  write_file(folder / "empty.mcap", {});
  EXPECT_NE(refused(folder / "empty.mcap").find("too short"), std::string::npos);
  write_file(folder / "text.mcap", Bytes(100, 'a'));
  EXPECT_NE(refused(folder / "text.mcap").find("at byte 0: is not an MCAP file"), std::string::npos);
  EXPECT_NE(refused(folder / "absent.mcap").find("cannot be opened"), std::string::npos);
  EXPECT_NE(refused(folder / "").find("not a regular file"), std::string::npos);
}

TEST(Mcap, AChunkThatClaimsToUnpackToTooMuchIsRefused) {
  EXPECT_THROW(decompress(Bytes(10), Compression::zstd, kMaxChunkBytes + 1), std::runtime_error);
  const Bytes packed = compress(Bytes(1 << 20), Compression::zstd);
  EXPECT_THROW(decompress(packed, Compression::zstd, 100), std::runtime_error);
  const Bytes framed = compress(Bytes(1 << 20), Compression::lz4);
  EXPECT_THROW(decompress(framed, Compression::lz4, 100), std::runtime_error);
  EXPECT_THROW(decompress(ByteView(framed).first(framed.size() / 2), Compression::lz4, 1 << 20), std::runtime_error);
}

}  // namespace
}  // namespace palp::test::mcap_test
