#include "sim_server/sampling.h"

#include <algorithm>
#include <cmath>

namespace palp {

namespace {

constexpr double kThinnest = 0.6;  // of a spacing: a stretch between faces that is thinner spoils the lattice of boxes

// Cells of one stretch after another along an axis: centre, width, and the stretch they belong to.
struct Axis {
  std::vector<double> center, width;
  std::vector<std::size_t> stretch;
};

double cells_in(double length, double spacing) { return std::max(1.0, std::round(length / spacing)); }

Axis divide(const std::vector<double>& cuts, double spacing, std::size_t most) {
  Axis axis;
  for (std::size_t s = 0; s + 1 < cuts.size(); ++s) {
    const double length = cuts[s + 1] - cuts[s], count = cells_in(length, spacing);
    for (double i = 0; i < count && axis.center.size() <= most; ++i) {
      axis.center.push_back(cuts[s] + (i + 0.5) * (length / count));
      axis.width.push_back(length / count);
      axis.stretch.push_back(s);
    }
  }
  return axis;
}

Particles fill_boxes(const BoxCells& cells, double spacing, std::size_t max_particles) {
  const Axis x = divide(cells.cuts[0], spacing, max_particles), y = divide(cells.cuts[1], spacing, max_particles);
  const Axis z = divide(cells.cuts[2], spacing, max_particles);
  Particles out;
  out.exact = true;
  for (std::size_t k = 0; k < z.center.size(); ++k) {
    for (std::size_t j = 0; j < y.center.size(); ++j) {
      for (std::size_t i = 0; i < x.center.size(); ++i) {
        if (!cells.at(x.stretch[i], y.stretch[j], z.stretch[k])) continue;
        out.position.emplace_back(x.center[i], y.center[j], z.center[k]);
        out.volume.push_back(x.width[i] * y.width[j] * z.width[k]);
        if (out.position.size() > max_particles) return out;
      }
    }
  }
  return out;
}

bool too_thin(const BoxCells& cells, double spacing) {
  for (const auto& cuts : cells.cuts) {
    if (cuts.size() == 2) continue;  // a single box, however thin, is one layer
    for (std::size_t s = 0; s + 1 < cuts.size(); ++s) {
      if (cuts[s + 1] - cuts[s] < kThinnest * spacing) return true;
    }
  }
  return false;
}

Particles fill_lattice(const Solid& solid, double spacing, std::size_t max_particles) {
  const Eigen::AlignedBox3d anchor = solid.parts.front().bounds;
  Eigen::Vector3d step, low, high;  // low and high: range of cell indices
  for (int a = 0; a < 3; ++a) {
    step[a] = anchor.sizes()[a] / cells_in(anchor.sizes()[a], spacing);
    low[a] = std::floor((solid.bounds.min()[a] - anchor.min()[a]) / step[a] + 1e-9);
    high[a] = std::ceil((solid.bounds.max()[a] - anchor.min()[a]) / step[a] - 1e-9);
  }
  const auto center = [&](int a, double i) { return anchor.min()[a] + (i + 0.5) * step[a]; };
  Particles out;
  std::vector<Interval> inside;
  for (double j = low.y(); j < high.y(); ++j) {
    for (double i = low.x(); i < high.x(); ++i) {
      solid.column(center(0, i), center(1, j), inside);
      for (const Interval& z : inside) {
        for (double k = std::ceil((z.low - anchor.min().z()) / step.z() - 0.5); center(2, k) < z.high; ++k) {
          out.position.emplace_back(center(0, i), center(1, j), center(2, k));
          out.volume.push_back(step.prod());
          if (out.position.size() > max_particles) return out;
        }
      }
    }
  }
  return out;
}

}  // namespace

Particles fill_solid(const Solid& solid, double spacing, std::size_t max_particles) {
  if (solid.aligned_boxes()) {
    const BoxCells cells = box_cells(solid);
    if (!too_thin(cells, spacing)) return fill_boxes(cells, spacing, max_particles);
  }
  return fill_lattice(solid, spacing, max_particles);
}

std::vector<std::size_t> empty_parts(const Solid& solid, const Particles& filled) {
  std::vector<std::size_t> empty;
  for (std::size_t p = 0; p < solid.parts.size(); ++p) {
    if (solid.parts[p].subtract) continue;
    const bool any = std::any_of(filled.position.begin(), filled.position.end(),
                                 [&](const Eigen::Vector3d& x) { return solid.parts[p].contains(x); });
    if (!any) empty.push_back(p);
  }
  return empty;
}

}  // namespace palp
