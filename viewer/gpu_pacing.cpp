#include "viewer/gpu_pacing.h"

#include <sys/prctl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <numeric>
#include <utility>

#include <spdlog/spdlog.h>
#include <osg/GLExtensions>
#include <osg/State>

#include "idl/clock.h"

#ifndef APIENTRY
#define APIENTRY
#endif

namespace palp {
namespace {

constexpr double kPiecesOfGap = 3;                        // that are to fit between two steps
constexpr double kShortest = 40'000, kLongest = 200'000;  // [ns] that a piece is to take
constexpr double kNeverDrawnNs = 150'000;                 // [ns] that one is believed to take which was never drawn
constexpr double kMargin = 30'000;                        // [ns] that a piece may take longer than it usually does
constexpr double kTurnToViewer = 150'000;  // [ns] that the GPU needs for it after a step, as seen on an H100
constexpr std::int64_t kLook = 30'000;     // [ns] between two looks for a gap
// [ns] that a piece waits at most, and then for the end of a step. Where there are no gaps each piece delays a step: a
// quarter of them at most, by what a short piece takes.
constexpr std::int64_t kPatience = 4'000'000, kMoment = 1'000'000;
constexpr double kAsIfGap = 360'000;  // [ns] that no gap counts as: its pieces are of 60 us

}  // namespace

GpuPacing::GpuPacing(std::shared_ptr<GpuPage> page, World world) : page_(std::move(page)), world_(std::move(world)) {}

void GpuPacing::begin_picture() {
  next_ = 0;
  waited_ns_ = 0;
}

void GpuPacing::skip() {
  if (next_ == parts_.size()) parts_.push_back({});
  ++next_;
}

void GpuPacing::draw(int most_pieces, const DrawPiece& piece) {
  skip();
  Part& part = parts_[next_ - 1];
  shared_ = gap_of(*page_, world_.now_ns()).until_ns != kNever;
  if (!shared_) return piece(0, 1);
  if (part.pieces_ns.empty()) part.pieces_ns.assign(static_cast<std::size_t>(most_pieces), kNeverDrawnNs);
  work(part.before_ns, part.drawn, [] {});
  const int pieces = static_cast<int>(part.pieces_ns.size());
  for (int k = 0; k < pieces; ++k)
    work(part.pieces_ns[static_cast<std::size_t>(k)], part.drawn, [&] { piece(k, pieces); });
  if (std::exchange(part.drawn, true)) cut(part, most_pieces);
}

// A piece that a step has met takes long once: what is slower than usual counts by half, what is quicker at once.
void GpuPacing::work(double& usual_ns, bool learns, const std::function<void()>& piece) {
  const bool first = wait_for_gap(usual_ns);
  const std::int64_t begun = world_.now_ns();
  piece();
  world_.finish();
  const auto spent = static_cast<double>(world_.now_ns() - begun);
  if (first && spent < kTurnToViewer / 2) gap_ns_ = 0;  // OpenGL had nothing to do: the GPU has yet to turn
  const double took = std::max(0.0, spent - (first ? kTurnToViewer : 0));
  if (learns) usual_ns = took < usual_ns ? took : (took + usual_ns) / 2;
}

// Cuts a part anew when its pieces have come to be much longer or shorter than wanted.
void GpuPacing::cut(Part& part, int most_pieces) const {
  const std::vector<double> old = part.pieces_ns;
  const double all = std::accumulate(old.begin(), old.end(), 0.0), longest = std::ranges::max(old);
  const auto n = static_cast<double>(old.size());
  const double wanted =
      std::clamp(std::ceil(std::max(all, longest * n / 2) / wanted_piece_ns()), 1.0, static_cast<double>(most_pieces));
  if (wanted < 1.3 * n && wanted > 0.6 * n) return;
  part.pieces_ns.resize(static_cast<std::size_t>(wanted));
  for (std::size_t k = 0; k < part.pieces_ns.size(); ++k)
    part.pieces_ns[k] = old[k * old.size() / part.pieces_ns.size()] * n / wanted;
}

double GpuPacing::wanted_piece_ns() const {
  return std::clamp((usual_gap_ns_ - kTurnToViewer - kMargin) / kPiecesOfGap, kShortest, kLongest);
}

// Returns whether nothing was drawn in this gap yet.
bool GpuPacing::wait_for_gap(double piece_ns) {
  const std::int64_t begun = world_.now_ns();
  for (;;) {
    const std::int64_t now = world_.now_ns(), waited = now - begun;
    const GpuGap gap = gap_of(*page_, now);
    const bool first = gap.since_ns != gap_ns_;
    if (gap.since_ns != seen_ns_ && gap.until_ns > gap.since_ns && gap.until_ns != kNever) {
      seen_ns_ = gap.since_ns;
      usual_gap_ns_ += 0.1 * (static_cast<double>(gap.until_ns - gap.since_ns) - usual_gap_ns_);
    }
    const double needed = piece_ns + kMargin + (first ? kTurnToViewer : 0);
    const bool fits = static_cast<double>(gap.until_ns - now) >= needed;
    // what is late begins between two steps all the same, where there is a moment between them
    const bool late = waited >= kPatience && (gap.until_ns > now || waited >= kPatience + kMoment);
    if (fits || late) {
      if (!fits) {
        ++late_;
        usual_gap_ns_ += 0.1 * (kAsIfGap - usual_gap_ns_);
      }
      waited_ns_ += waited;
      gap_ns_ = gap.since_ns;
      page_->drawn_ns = now;
      return first;
    }
    world_.sleep(kLook);
  }
}

void in_pieces(osg::RenderInfo& info, int most_pieces, const DrawPiece& piece) {
  osg::Referenced* data = info.getState()->getGraphicsContext()->getUserData();
  auto* pacing = dynamic_cast<GpuPacing*>(data);
  if (pacing == nullptr) return piece(0, 1);
  pacing->draw(most_pieces, piece);
  if (!pacing->shared()) glFlush();  // the GPU begins while it is told the rest
}

void skip_pieces(osg::RenderInfo& info) {
  if (auto* pacing = dynamic_cast<GpuPacing*>(info.getState()->getGraphicsContext()->getUserData())) pacing->skip();
}

GpuPacing::World real_world() {
  return {now_ns,
          [](std::int64_t ns) {
            const timespec time = to_timespec(ns);
            nanosleep(&time, nullptr);
          },
          [] { glFinish(); }};
}

osg::ref_ptr<GpuPacing> pacing_of_current_gpu() {
  // from EXT_memory_object, which the headers of OpenGL 1.x lack
  constexpr GLenum kDeviceUuid = 0x9597;
  using GetBytes = void(APIENTRY*)(GLenum what, GLuint index, GLubyte * bytes);
  GetBytes get = nullptr;
  const auto* extensions = reinterpret_cast<const char*>(glGetString(GL_EXTENSIONS));
  if (extensions == nullptr || std::string(extensions).find("GL_EXT_memory_object") == std::string::npos) return {};
  if (!osg::setGLExtensionFuncPtr(get, "glGetUnsignedBytei_vEXT") || get == nullptr) return {};
  std::array<GLubyte, 16> uuid{};
  get(kDeviceUuid, 0, uuid.data());
  const std::string gpu = gpu_identity(uuid.data());
  if (gpu.empty()) return {};
  try {
    osg::ref_ptr<GpuPacing> pacing = new GpuPacing(open_gpu_page(gpu), real_world());
    prctl(PR_SET_TIMERSLACK, 1000);  // gaps are short
    return pacing;
  } catch (const std::exception& error) {
    spdlog::warn("{}", error.what());
    return {};
  }
}

}  // namespace palp
