#include "sim_server/scene/sampling.h"

#include <algorithm>
#include <cmath>

namespace palp {

namespace {

constexpr double kThinnest = 0.6;  // of a spacing: a stretch between faces that is thinner spoils the lattice of boxes
constexpr double kMisfit = 0.005;  // of a curved solid's volume, that its particles may lack or exceed
constexpr int kMostPercent = 4;    // that its lattice is made finer or coarser for it
constexpr std::size_t kParticlesForVolume = 200000;  // have the solid's volume well enough

// Cells of one stretch after another along an axis: centre, width, and the first of each stretch, past the last one
// too.
struct Axis {
  std::vector<double> center, width;
  std::vector<std::size_t> first;
};

double cells_in(double length, double spacing) { return std::max(1.0, std::round(length / spacing)); }

Axis divide(const std::vector<double>& cuts, double spacing, std::size_t most) {
  Axis axis;
  for (std::size_t s = 0; s + 1 < cuts.size(); ++s) {
    const double length = cuts[s + 1] - cuts[s], count = cells_in(length, spacing);
    axis.first.push_back(axis.center.size());
    for (double i = 0; i < count && axis.center.size() <= most; ++i) {
      axis.center.push_back(cuts[s] + (i + 0.5) * (length / count));
      axis.width.push_back(length / count);
    }
  }
  axis.first.push_back(axis.center.size());
  return axis;
}

Particles fill_boxes(const BoxCells& cells, double spacing, std::size_t max_particles) {
  const Axis x = divide(cells.cuts[0], spacing, max_particles), y = divide(cells.cuts[1], spacing, max_particles);
  const Axis z = divide(cells.cuts[2], spacing, max_particles);
  Particles out;
  out.exact = true;
  // what is empty is left out by the stretch: bodies far apart have far more of it than particles
  const auto row_is_empty = [&](std::size_t t, std::size_t u) {
    for (std::size_t s = 0; s < cells.count(0); ++s)
      if (cells.at(s, t, u)) return false;
    return true;
  };
  const auto fill_row = [&](std::size_t j, std::size_t k, std::size_t t, std::size_t u) {
    for (std::size_t s = 0; s < cells.count(0); ++s) {
      if (!cells.at(s, t, u)) continue;
      for (std::size_t i = x.first[s]; i < x.first[s + 1] && out.position.size() <= max_particles; ++i) {
        out.position.emplace_back(x.center[i], y.center[j], z.center[k]);
        out.volume.push_back(x.width[i] * y.width[j] * z.width[k]);
      }
    }
  };
  for (std::size_t u = 0; u < cells.count(2); ++u)
    for (std::size_t k = z.first[u]; k < z.first[u + 1]; ++k)
      for (std::size_t t = 0; t < cells.count(1); ++t) {
        if (row_is_empty(t, u)) continue;
        for (std::size_t j = y.first[t]; j < y.first[t + 1]; ++j) {
          fill_row(j, k, t, u);
          if (out.position.size() > max_particles) return out;
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

// Cells of equal size, one of them with its low corner at `corner`.
struct Lattice {
  Eigen::Vector3d corner, step;
  double center(int axis, double i) const { return corner[axis] + (i + 0.5) * step[axis]; }
};

Lattice fitted_lattice(const Eigen::AlignedBox3d& anchor, double spacing) {
  Lattice lattice{anchor.min(), anchor.sizes()};
  for (int a = 0; a < 3; ++a) lattice.step[a] /= cells_in(anchor.sizes()[a], spacing);
  return lattice;
}

Particles fill_lattice(const Solid& solid, const Lattice& lattice, std::size_t max_particles) {
  Eigen::Vector3d low, high;  // range of cell indices
  for (int a = 0; a < 3; ++a) {
    low[a] = std::floor((solid.bounds.min()[a] - lattice.corner[a]) / lattice.step[a] + 1e-9);
    high[a] = std::ceil((solid.bounds.max()[a] - lattice.corner[a]) / lattice.step[a] - 1e-9);
  }
  Particles out;
  std::vector<Interval> inside;
  for (double j = low.y(); j < high.y(); ++j) {
    for (double i = low.x(); i < high.x(); ++i) {
      solid.column(lattice.center(0, i), lattice.center(1, j), inside);
      for (const Interval& z : inside) {
        double k = std::ceil((z.low - lattice.corner.z()) / lattice.step.z() - 0.5);
        for (; lattice.center(2, k) < z.high; ++k) {
          out.position.emplace_back(lattice.center(0, i), lattice.center(1, j), lattice.center(2, k));
          out.volume.push_back(lattice.step.prod());
          if (out.position.size() > max_particles) return out;
        }
      }
    }
  }
  return out;
}

double misfit(const Particles& particles, double volume) {
  const double filled = static_cast<double>(particles.volume.size()) * particles.volume.front();
  return std::abs(filled / volume - 1);
}

// The cells whose centres lie inside a curved solid have not quite its volume. Tries lattices a little finer and
// coarser, with a cell or a corner in the middle, until they have.
Particles fill_curved(const Solid& solid, double volume, double spacing, std::size_t max_particles) {
  const Part& first = solid.parts.front();
  const Lattice fitted = fitted_lattice(first.bounds, spacing);
  Particles best = fill_lattice(solid, fitted, max_particles);
  if (first.type == ShapeType::box || best.position.empty() || best.position.size() > kParticlesForVolume) return best;
  const std::size_t empty = empty_parts(solid, best).size();
  const int axes = first.type == ShapeType::cylinder ? 2 : 3;  // the caps of a cylinder stay where they are
  for (int percent = 0; percent <= kMostPercent && misfit(best, volume) > kMisfit; ++percent) {
    for (const double scale : {1 + 0.01 * percent, 1 - 0.01 * percent}) {
      for (const double corner : {0.0, 0.5}) {
        Lattice lattice = fitted;
        for (int a = 0; a < axes; ++a) {
          lattice.step[a] = scale * spacing;
          lattice.corner[a] = first.bounds.center()[a] + corner * lattice.step[a];
        }
        Particles tried = fill_lattice(solid, lattice, max_particles);
        if (tried.position.empty() || misfit(tried, volume) >= misfit(best, volume)) continue;
        if (empty_parts(solid, tried).size() <= empty) best = std::move(tried);
      }
    }
  }
  return best;
}

}  // namespace

Particles fill_solid(const Solid& solid, double volume, double spacing, std::size_t max_particles) {
  if (solid.aligned_boxes()) {
    const BoxCells cells = box_cells(solid);
    if (!too_thin(cells, spacing)) return fill_boxes(cells, spacing, max_particles);
  }
  return fill_curved(solid, volume, spacing, max_particles);
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
