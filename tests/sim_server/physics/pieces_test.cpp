// Which particles hang together, against a search of the test's own.
#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "sim_server/physics/pieces.h"
#include "tests/support/random.h"

namespace palp::test::pieces_test {
namespace {

// Slots with bonds of any kind, numbered as the stages do it.
class Pieces : public RandomCase {
 protected:
  void resize(std::uint32_t n) {
    count_ = n;
    solid_.assign(n, real(1));
    bonds_.assign(n, 0);
    bond_.assign(std::size_t(n) * kMaxBonds, 0);
    id_.assign(n, 0);
    a_ = b_ = id_;
    still_.assign(kPieceRounds, 1);
  }
  void bond(std::uint32_t i, std::uint32_t j) {
    if (i == j || bonds_[i] == kMaxBonds || bonds_[j] == kMaxBonds) return;
    bond_[std::size_t(i) * kMaxBonds + bonds_[i]++] = j;
    bond_[std::size_t(j) * kMaxBonds + bonds_[j]++] = i;
  }
  void part_all() { bonds_.assign(count_, 0); }

  // One change; true when the numbering has ended.
  bool change() {
    ChangeViews change;
    change.count = count_;
    change.solid = solid_.data();
    change.bonds = bonds_.data();
    change.bond = bond_.data();
    change.piece = id_.data();
    const PieceViews views{a_.data(), b_.data(), still_.data()};
    const auto each = [&](const auto& f) {
      // the order of threads must not matter
      std::vector<std::uint32_t> order(count_);
      std::iota(order.begin(), order.end(), 0);
      std::shuffle(order.begin(), order.end(), random_);
      for (const std::uint32_t k : order) f(k);
    };
    each(BeginPieces{change, views});
    for (std::uint32_t r = 0; r < kPieceRounds; ++r) BeginRounds{views}(r);
    for (std::uint32_t r = 0; r < kPieceRounds; ++r) {
      each(JoinPieces{change, views, r});
      each(JumpPieces{views, r});
    }
    each(NamePieces{change, views});
    return still_.back() != 0;
  }
  int changes_to_settle() {
    for (int n = 1;; ++n)
      if (change()) return n;
  }

  // Union-find.
  std::vector<std::uint32_t> expected() const {
    std::vector<std::uint32_t> root(count_);
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](std::uint32_t i) {
      while (root[i] != i) i = root[i] = root[root[i]];
      return i;
    };
    for (std::uint32_t i = 0; i < count_; ++i)
      for (std::uint32_t n = 0; n < bonds_[i]; ++n) {
        const std::uint32_t j = bond_[std::size_t(i) * kMaxBonds + n];
        if (!(solid_[i] > kPieceSolid) || !(solid_[j] > kPieceSolid)) continue;
        const std::uint32_t p = find(i), q = find(j);
        root[std::max(p, q)] = std::min(p, q);
      }
    std::vector<std::uint32_t> id(count_);
    for (std::uint32_t i = 0; i < count_; ++i) id[i] = solid_[i] > kPieceSolid ? find(i) : kNone;
    return id;
  }

  std::uint32_t count_ = 0;
  std::vector<real> solid_;
  std::vector<std::uint32_t> bonds_, bond_, id_, a_, b_, still_;
};

TEST_F(Pieces, AreWhatBondsJoin) {
  for (int round = 0; round < 200; ++round) {
    resize(1 + random_() % 2000);
    const double bonds = between(0, 2) * count_;
    for (int k = 0; k < bonds; ++k) bond(random_() % count_, random_() % count_);
    for (real& K : solid_) K = static_cast<real>(between(0, 1) < 0.1 ? between(0, 1) : 1);
    ASSERT_LE(changes_to_settle(), 2) << count_;
    ASSERT_EQ(id_, expected()) << round;
    // bonds end, others form, matter melts and freezes
    part_all();
    for (int k = 0; k < bonds; ++k) bond(random_() % count_, random_() % count_);
    for (real& K : solid_) K = static_cast<real>(between(0, 1) < 0.2 ? between(0, 1) : 1);
    ASSERT_LE(changes_to_settle(), 2);
    ASSERT_EQ(id_, expected()) << round;
  }
}

// The slowest there is: a chain of slots in random order.
TEST_F(Pieces, AreFoundAtTheEndsOfALongChain) {
  for (const std::uint32_t n : {1u, 2u, 10u, 100u, 1000u, 10000u, 100000u}) {
    resize(n);
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random_);
    for (std::uint32_t k = 1; k < n; ++k) bond(order[k - 1], order[k]);
    const int changes = changes_to_settle();
    RecordProperty("changes_for_" + std::to_string(n), changes);
    EXPECT_LE(changes, n > 10000 ? 4 : 2) << n;
    EXPECT_EQ(id_, expected()) << n;
  }
}

TEST_F(Pieces, OfALumpAreFoundAtOnce) {
  constexpr int kEdge = 30;
  resize(kEdge * kEdge * kEdge);
  std::vector<std::uint32_t> order(count_);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), random_);
  const auto at = [&](int x, int y, int z) {
    const int place = (z * kEdge + y) * kEdge + x;
    return order[static_cast<std::size_t>(place)];
  };
  for (int z = 1; z < kEdge; ++z)
    for (int y = 1; y < kEdge; ++y)
      for (int x = 1; x < kEdge; ++x)
        for (const auto& [dx, dy, dz] : {std::array{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}})
          bond(at(x, y, z), at(x - dx, y - dy, z - dz));
  EXPECT_TRUE(change());
  EXPECT_EQ(id_, expected());
}

TEST_F(Pieces, ThatMeltWhileTheyAreNumberedHaveNone) {
  resize(20000);
  std::vector<std::uint32_t> order(count_);
  std::iota(order.begin(), order.end(), 0);
  for (int round = 0; round < 5; ++round) {
    std::shuffle(order.begin(), order.end(), random_);
    part_all();
    for (std::uint32_t k = 1; k < count_; ++k) bond(order[k - 1], order[k]);
    change();
    for (real& K : solid_) K = static_cast<real>(between(0, 1) < 0.5 ? 0 : 1);
    change();
    for (std::uint32_t k = 0; k < count_; ++k) ASSERT_TRUE(solid_[k] > kPieceSolid || id_[k] == kNone);
    changes_to_settle();
    change();
    changes_to_settle();
    EXPECT_EQ(id_, expected());
  }
}

}  // namespace
}  // namespace palp::test::pieces_test
