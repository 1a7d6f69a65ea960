#include "acus/imaging/slicing/tracing/beam_labels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "acus/base/core/parallel.h"

namespace acus::tracing {

BeamLabels::BeamLabels(const SurfaceTracer& tracer, const Eigen::Affine3d& ct_from_index)
    : tracer_(tracer), ct_from_index_(ct_from_index) {}

std::size_t BeamLabels::num_pieces() const {
  std::size_t sum = 0;
  for (const Group& group : groups_) sum += group.num_pieces;
  return sum;
}

void BeamLabels::Prepare(const slicing::BeamBend& bend, int lines, int samples) {
  knots_.clear();
  if (bend.active()) {
    for (const int knot : bend.samples_of_knots()) {
      if (knot < samples) knots_.push_back(knot);
    }
  } else {
    knots_.push_back(0);
    if (samples > 1) knots_.push_back(samples - 1);
  }
  const auto groups = static_cast<std::size_t>((lines + kLines - 1) / kLines);
  while (groups_.size() < groups) groups_.emplace_back(tracer_);
  for (Group& group : groups_) {
    group.num_pieces = 0;
    group.knot_mm.resize(knots_.size() * kLines);
    group.path.reserve(knots_.size());
    group.changes.reserve(SurfaceTracer::kUsualCrossings + 1);
  }
}

/// Where the knots of 16 lines lie at rest.
void BeamLabels::PlaceKnots(const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                            int first, Group& group) const {
  slicing::BeamBend::Row row;
  for (std::size_t n = 0; n < knots_.size(); ++n) {
    float sample = 0.0F;
    const auto placed = bend.PlaceRow(lines, knots_[n], first, kLines, row, sample);
    for (int l = 0; l < kLines; ++l) {
      // In double: a straight line stays one.
      Eigen::Vector3d index;
      for (Eigen::Index a = 0; a < 3; ++a) {
        index[a] = static_cast<double>(placed.start[a][l]) +
                   static_cast<double>(sample) * static_cast<double>(placed.step[a][l]);
      }
      group.knot_mm[n * kLines + static_cast<std::size_t>(l)] = ct_from_index_ * index;
    }
  }
}

/// As few straight pieces as keep the knots, and with them all samples between, close to where they
/// are: each piece is as long as all speeds agree that keep its knots within the limit.
void BeamLabels::LayPath(int line, Group& group) const {
  constexpr double kLimitMm = kMaxBendErrorMm / std::numbers::sqrt3;  // By axis.
  const auto knot_mm = [&](std::size_t n) -> const Eigen::Vector3d& {
    return group.knot_mm[n * kLines + static_cast<std::size_t>(line)];
  };
  group.path.clear();
  group.path.push_back({knot_mm(0), static_cast<double>(knots_[0])});
  Eigen::Array3d slowest = Eigen::Array3d::Constant(-1e300);
  Eigen::Array3d fastest = Eigen::Array3d::Constant(1e300);
  for (std::size_t n = 1; n < knots_.size(); ++n) {
    const auto speed = [&](const PathPlace& from) {
      return ((knot_mm(n) - from.place_mm) / (knots_[n] - from.at)).array().eval();
    };
    Eigen::Array3d mm_per_sample = speed(group.path.back());
    if ((mm_per_sample < slowest).any() || (mm_per_sample > fastest).any()) {
      group.path.push_back({knot_mm(n - 1), static_cast<double>(knots_[n - 1])});
      mm_per_sample = speed(group.path.back());
      slowest.setConstant(-1e300);
      fastest.setConstant(1e300);
    }
    const double slack = kLimitMm / (knots_[n] - group.path.back().at);
    slowest = slowest.max(mm_per_sample - slack);
    fastest = fastest.min(mm_per_sample + slack);
  }
  if (knots_.size() > 1)
    group.path.push_back({knot_mm(knots_.size() - 1), static_cast<double>(knots_.back())});
}

void BeamLabels::Fill(const slicing::BeamLines& lines, const slicing::BeamBend& bend,
                      int num_threads, slicing::BeamImage& label) {
  Prepare(bend, label.lines(), label.samples());
  const auto fill = [&](int p) {
    Group& group = groups_[static_cast<std::size_t>(p)];
    PlaceKnots(lines, bend, p * kLines, group);
    const int last = std::min(kLines, label.lines() - p * kLines) - 1;
    for (int l = 0; l <= last; ++l) {
      LayPath(l, group);
      group.num_pieces += group.path.size() - 1;
      tracer_.Trace(group.path, group.buffers, group.changes);
      int k = 0;
      for (std::size_t n = 0; n < group.changes.size(); ++n) {
        const bool is_last = n + 1 == group.changes.size();
        const int end = is_last ? label.samples()
                                : std::min(label.samples(),
                                           static_cast<int>(std::ceil(group.changes[n + 1].at)));
        for (; k < end; ++k) {
          label.row(k)[p * kLines + l] = static_cast<float>(group.changes[n].label);
        }
      }
    }
    if (last + 1 == kLines) return;
    for (int k = 0; k < label.samples(); ++k) {
      float* row = label.row(k) + p * kLines;
      std::fill(row + last + 1, row + kLines, row[last]);
    }
  };
  ParallelFor((label.lines() + kLines - 1) / kLines, num_threads, std::ref(fill));
}

}  // namespace acus::tracing
