#include "idl/latest.h"

#include <gtest/gtest.h>

#include <memory>
#include <thread>

namespace palp::test::latest_test {
namespace {

// Large enough to tear, were it copied while being written.
struct Block {
  std::array<std::uint64_t, 32> words{};
  static Block of(std::uint64_t n) {
    Block b;
    b.words.fill(n);
    return b;
  }
};

TEST(Latest, IsEmptyUntilSomethingIsPut) {
  Latest<int> mailbox;
  int out = 7;
  EXPECT_FALSE(mailbox.take(out));
  EXPECT_EQ(out, 7);
}

TEST(Latest, GivesTheNewestValueOnce) {
  Latest<int> mailbox;
  int out = 0;
  mailbox.put(1);
  mailbox.put(2);
  mailbox.put(3);
  ASSERT_TRUE(mailbox.take(out));
  EXPECT_EQ(out, 3);
  EXPECT_FALSE(mailbox.take(out));
  mailbox.put(4);
  ASSERT_TRUE(mailbox.take(out));
  EXPECT_EQ(out, 4);
}

TEST(TripleBuffer, SaysWhenAValueWasReplaced) {
  TripleBuffer<int> buffer;
  EXPECT_TRUE(buffer.publish());
  EXPECT_FALSE(buffer.publish());
  EXPECT_TRUE(buffer.update());
  EXPECT_TRUE(buffer.publish());
}

TEST(Latest, NeitherTearsNorGoesBackBetweenThreads) {
  constexpr std::uint64_t kLast = 100'000;
  const auto mailbox = std::make_unique<Latest<Block>>();
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) mailbox->put(Block::of(i));
  });
  std::uint64_t last = 0;
  bool torn = false;
  bool back = false;
  Block out;
  while (last < kLast) {
    if (!mailbox->take(out)) {
      std::this_thread::yield();
      continue;
    }
    for (const std::uint64_t word : out.words) torn = torn || word != out.words[0];
    back = back || out.words[0] <= last;
    last = out.words[0];
  }
  writer.join();
  EXPECT_FALSE(torn);
  EXPECT_FALSE(back);
}

}  // namespace
}  // namespace palp::test::latest_test
