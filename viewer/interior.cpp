#include "viewer/interior.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace palp {
namespace {

constexpr int kDepth = 2;             // cells
constexpr double kMostCells = 6e7;    // where there would be more they are larger, and fewer particles are within
constexpr std::size_t kFewest = 125;  // particles that can surround one

// Returns what a row has n cells farther along x (n < 0: less far), nothing beyond its ends.
std::uint64_t shifted(const std::uint64_t* row, std::size_t words, std::size_t w, int n) {
  if (n > 0) return row[w] >> n | (w + 1 < words ? row[w + 1] << (64 - n) : 0);
  return row[w] << -n | (w > 0 ? row[w - 1] >> (64 + n) : 0);
}

// Returns the word w of all rows one after the other, n bits farther on (n < 0: before).
std::uint64_t moved(const std::vector<std::uint64_t>& bits, std::size_t w, std::ptrdiff_t n) {
  const auto word_at = [&](std::ptrdiff_t k) {
    return k >= 0 && k < static_cast<std::ptrdiff_t>(bits.size()) ? bits[static_cast<std::size_t>(k)] : 0;
  };
  const auto from = static_cast<std::ptrdiff_t>(w) + (n >> 6);
  const auto bit = static_cast<unsigned>(n & 63);
  return bit == 0 ? word_at(from) : word_at(from) >> bit | word_at(from + 1) << (64 - bit);
}

}  // namespace

void Interior::lay_grid(std::span<const osg::Vec4f> places, double spacing) {
  float high[3];
  std::fill_n(low_, 3, std::numeric_limits<float>::max());
  std::fill_n(high, 3, std::numeric_limits<float>::lowest());
  for (const osg::Vec4f& place : places)
    for (int a = 0; a < 3; ++a) {
      low_[a] = std::min(low_[a], place[a]);
      high[a] = std::max(high[a], place[a]);
    }
  double cell = kLumpOverSpacing * spacing;
  const auto along = [&](int a) { return std::floor((double(high[a]) - low_[a]) / cell) + 2; };
  const auto words = [&] { return std::ceil(along(0) / 64); };
  while (64 * words() * along(1) * along(2) > kMostCells) cell *= 1.5;
  per_metre_ = static_cast<float>(1 / cell);
  words_ = static_cast<std::size_t>(words());
  rows_[0] = static_cast<std::size_t>(along(1));
  rows_[1] = static_cast<std::size_t>(along(2));
}

// Leaves the cells around which, kDepth far along each axis, all are set.
void Interior::erode() {
  const std::size_t rows = rows_[0] * rows_[1];
  scratch_.resize(bits_.size());
  for (std::size_t r = 0; r < rows; ++r) {
    const std::uint64_t* row = bits_.data() + r * words_;
    for (std::size_t w = 0; w < words_; ++w) {
      std::uint64_t all = row[w];
      for (int n = 1; n <= kDepth; ++n) all &= shifted(row, words_, w, n) & shifted(row, words_, w, -n);
      scratch_[r * words_ + w] = all;
    }
  }
  const auto erode_along = [&](const std::vector<std::uint64_t>& from, std::vector<std::uint64_t>& to,
                               std::size_t stride, std::size_t count) {  // stride: rows to the next one along the axis
    for (std::size_t r = 0; r < rows; ++r) {
      const std::size_t at = r / stride % count;
      const bool inner = at >= kDepth && at + kDepth < count;
      for (std::size_t w = 0; w < words_; ++w) {
        std::uint64_t all = inner ? ~std::uint64_t{0} : 0;
        for (std::size_t k = 0; inner && k <= 2 * kDepth; ++k)
          all &= from[(r + k * stride - kDepth * stride) * words_ + w];
        to[r * words_ + w] = all;
      }
    }
  };
  erode_along(scratch_, bits_, 1, rows_[0]);
  erode_along(bits_, scratch_, rows_[0], rows_[1]);
  std::swap(bits_, scratch_);
}

// The last cell of each row, column and layer is empty, so that a step along an axis is one along all rows, too.
void Interior::find_loose() {
  const auto row = static_cast<std::ptrdiff_t>(64 * words_), layer = static_cast<std::ptrdiff_t>(rows_[0]) * row;
  const std::ptrdiff_t steps[] = {1, row, layer};
  // leaves the cells that are in blocks of so many along each side that all are set
  const auto keep_blocks = [&](std::vector<std::uint64_t>& cells, int side) {
    for (const std::ptrdiff_t step : steps)  // the first cell of each block
      for (int n = 1; n < side; ++n)
        for (std::size_t w = 0; w < cells.size(); ++w) cells[w] &= moved(cells, w, step);
    for (const std::ptrdiff_t step : steps)
      for (int n = 1; n < side; ++n)
        for (std::size_t w = cells.size(); w-- > 0;) cells[w] |= moved(cells, w, -step);
  };
  const auto widen = [&](std::vector<std::uint64_t>& cells) {
    for (const std::ptrdiff_t step : steps) {
      scratch_ = cells;
      for (std::size_t w = 0; w < scratch_.size(); ++w)
        cells[w] |= moved(scratch_, w, step) | moved(scratch_, w, -step);
    }
  };
  loose_ = bits_;
  keep_blocks(loose_, 2);
  for (std::size_t w = 0; w < loose_.size(); ++w) loose_[w] = bits_[w] & ~loose_[w];
  // a small block of cells that each have a particle can be torn apart, too, but seldom far from what is loose
  widen(loose_);
  beside_loose_ = bits_;
  keep_blocks(beside_loose_, 3);
  for (std::size_t w = 0; w < loose_.size(); ++w) loose_[w] &= bits_[w] & ~beside_loose_[w];
  beside_loose_ = loose_;
  widen(beside_loose_);
}

void Interior::find(std::span<const osg::Vec4f> places, double spacing, bool with_loose) {
  cells_.clear();
  if (!(spacing > 0) || places.empty() || (places.size() < kFewest && !with_loose)) return;
  lay_grid(places, spacing);
  bits_.assign(words_ * rows_[0] * rows_[1], 0);
  cells_.resize(places.size());
  const int last[3] = {static_cast<int>(64 * words_) - 1, static_cast<int>(rows_[0]) - 1,
                       static_cast<int>(rows_[1]) - 1};
  const auto row = static_cast<std::uint32_t>(64 * words_), layer = static_cast<std::uint32_t>(rows_[0]) * row;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto along = [&](int a) {
      return static_cast<std::uint32_t>(std::min(static_cast<int>((places[i][a] - low_[a]) * per_metre_), last[a]));
    };
    cells_[i] = along(2) * layer + along(1) * row + along(0);
  }
  for (const std::uint32_t cell : cells_) bits_[cell / 64] |= std::uint64_t{1} << cell % 64;
  if (with_loose) find_loose();
  erode();
}

bool Interior::beside_loose(const osg::Vec3f& place) const {
  if (cells_.empty()) return false;
  std::size_t cell = 0;
  const std::size_t along[3] = {64 * words_, rows_[0], rows_[1]};
  for (int a = 2; a >= 0; --a) {
    const float at = (place[a] - low_[a]) * per_metre_;
    const std::size_t most = along[a];
    // there is no cell before the first one, which is next to a place there; after the last one with places there is
    if (!(at >= -1 && at < static_cast<float>(most))) return false;
    cell = cell * most + static_cast<std::size_t>(std::max(at, 0.0f));
  }
  return has(beside_loose_, static_cast<std::uint32_t>(cell));
}

void Interior::add_lumps(std::span<const osg::Vec4f> places, osg::Vec4Array& to) const {
  if (cells_.empty()) return;
  std::vector<std::uint32_t> before;  // lumps in the words before
  std::uint32_t count = 0;
  for (const std::uint64_t word : bits_) {
    before.push_back(count);
    count += static_cast<std::uint32_t>(std::popcount(word));
  }
  const osg::Vec4f low(low_[0], low_[1], low_[2], 0);
  std::vector<osg::Vec4f> lumps(count);  // sums of places from there, and how many they are
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    if (!contains(i)) continue;
    const std::uint64_t lower = (std::uint64_t{1} << cells_[i] % 64) - 1, word = cells_[i] / 64;
    const osg::Vec4f place = places[i] - low;
    lumps[before[word] + static_cast<std::uint32_t>(std::popcount(bits_[word] & lower))] +=
        osg::Vec4f(place.x(), place.y(), place.z(), 1);
  }
  for (const osg::Vec4f& lump : lumps) {
    if (lump.w() == 0) continue;
    const osg::Vec4f middle = lump / lump.w() + low;
    to.push_back({middle.x(), middle.y(), middle.z(), static_cast<float>(lump.w() / kParticlesOfLump)});
  }
}

}  // namespace palp
