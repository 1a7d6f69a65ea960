#include "acus/imaging/slicing/beam_bend.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/imaging/slicing/bend_row.h"

namespace acus::slicing {
namespace {

/// What a step of zero looks like to the kernels.
alignas(64) constexpr std::array<float, BeamBend::kMaxLanes> kNoStep{};

constexpr int kMaxStep = 64;

int StepOf(double spacing_mm, double unit_mm) {
  return std::clamp(static_cast<int>(std::lround(spacing_mm / unit_mm)), 1, kMaxStep);
}

}  // namespace

void PlaceLines(const acoustics::ScanGrid& grid, const Eigen::Affine3d& index_from_ct,
                const Eigen::Isometry3d& ct_from_probe, BeamLines& lines) {
  ACUS_REQUIRE(ct_from_probe.matrix().allFinite(), "probe pose: has a value that is not finite");
  const Eigen::Affine3d index_from_probe = index_from_ct * ct_from_probe;
  // Far outside is outside: keeps indices within what an int holds.
  constexpr double kFar = 1e8;
  const int lanes = kernels::RoundUp(grid.lines());
  for (int a = 0; a < 3; ++a) {
    lines.start[a].Reserve(static_cast<std::size_t>(lanes));
    lines.step[a].Reserve(static_cast<std::size_t>(lanes));
    const Eigen::RowVector2d row = index_from_probe.linear().block<1, 2>(a, 0);
    const double offset = index_from_probe.translation()[a];
    for (int l = 0; l < lanes; ++l) {
      const std::size_t line = static_cast<std::size_t>(std::min(l, grid.lines() - 1));
      const double start = offset + row * grid.start_mm[line];
      const double step = grid.step_mm * (row * grid.direction[line])(0);
      lines.start[a].data()[l] = static_cast<float>(std::clamp(start, -kFar, kFar));
      lines.step[a].data()[l] = static_cast<float>(std::clamp(step, -kFar, kFar));
    }
  }
}

void BeamBend::Axis::Spread(int count, int step, int rounded_count) {
  knot.clear();
  cell.clear();
  weight.clear();
  for (int at = 0; at < count - 1; at += step) knot.push_back(at);
  knot.push_back(std::max(0, count - 1));
  if (knot.size() == 1) knot.push_back(knot[0] + 1);  // Cells need two ends.
  int c = 0;
  for (int i = 0; i < rounded_count; ++i) {
    const int at = std::min(i, count - 1);
    while (c + 2 < static_cast<int>(knot.size()) && knot[static_cast<std::size_t>(c) + 1] <= at)
      ++c;
    const auto n = static_cast<std::size_t>(c);
    cell.push_back(c);
    weight.push_back(static_cast<float>(at - knot[n]) / static_cast<float>(knot[n + 1] - knot[n]));
  }
}

void BeamBend::Lay(const acoustics::ScanGrid& grid, double spacing_mm) {
  laid_for_mm_ = spacing_mm;
  const double line_mm = grid.lines() > 1 ? grid.LateralSpacingMm(grid.samples / 2) : spacing_mm;
  across_.Spread(grid.lines(), StepOf(spacing_mm, line_mm), kernels::RoundUp(grid.lines()));
  along_.Spread(grid.samples, StepOf(spacing_mm, grid.step_mm), grid.samples);
  lanes_ = kernels::RoundUp(grid.lines());
  for (auto& at_knot : at_knot_) at_knot.resize(across_.knot.size());
  for (auto& offset : offset_) {
    offset.Reserve(static_cast<std::size_t>(lanes_) * along_.knot.size());
  }
}

void BeamBend::SpreadKnots(std::size_t row) {
  for (std::size_t a = 0; a < 3; ++a) {
    kernels::SpreadRow({.knot = across_.knot.data(),
                        .cells = static_cast<int>(across_.knot.size()) - 1,
                        .weight = across_.weight.data(),
                        .offset = at_knot_[a].data()},
                       lanes_, offset_[a].data() + row * static_cast<std::size_t>(lanes_));
  }
}

void BeamBend::Set(const acoustics::ScanGrid& grid, const Eigen::Isometry3d& ct_from_probe,
                   const Eigen::Affine3d& index_from_ct, const RestMap* rest) {
  active_ = false;
  if (rest == nullptr) return;
  if (laid_for_mm_ != rest->SpacingMm()) Lay(grid, rest->SpacingMm());
  std::size_t row = 0;
  for (const int k : along_.knot) {
    std::size_t n = 0;
    Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();  // From the place to its rest.
    for (const int line : across_.knot) {
      const auto l = static_cast<std::size_t>(std::min(line, grid.lines() - 1));
      const Eigen::Vector2d in_plane_mm =
          grid.start_mm[l] + static_cast<double>(k) * grid.step_mm * grid.direction[l];
      const Eigen::Vector3d place_mm =
          ct_from_probe * Eigen::Vector3d(in_plane_mm[0], in_plane_mm[1], 0.0);
      moved_mm = rest->RestInCtMm(place_mm, place_mm + moved_mm) - place_mm;
      const Eigen::Vector3d offset = index_from_ct.linear() * moved_mm;
      for (std::size_t a = 0; a < 3; ++a) {
        at_knot_[a][n] = static_cast<float>(offset[static_cast<Eigen::Index>(a)]);
      }
      active_ = active_ || !offset.isZero(0.0);
      ++n;
    }
    SpreadKnots(row++);
  }
}

kernels::Lines BeamBend::PlaceRow(const BeamLines& lines, int k, int first, int count, Row& row,
                                  float& sample) const noexcept {
  kernels::Lines placed{};
  for (std::size_t a = 0; a < 3; ++a) {
    placed.start[a] = lines.start[a].data() + first;
    placed.step[a] = lines.step[a].data() + first;
  }
  sample = static_cast<float>(k);
  if (!active_) return placed;

  const auto at = static_cast<std::size_t>(k);
  const std::ptrdiff_t above = std::ptrdiff_t{along_.cell[at]} * lanes_ + first;
  for (std::size_t a = 0; a < 3; ++a) {
    kernels::BendRow({.start = placed.start[a],
                      .step = placed.step[a],
                      .sample = sample,
                      .above = offset_[a].data() + above,
                      .below = offset_[a].data() + above + lanes_,
                      .down = along_.weight[at]},
                     count, row.place[a]);
    placed.start[a] = row.place[a];
    placed.step[a] = kNoStep.data();
  }
  sample = 0.0F;
  return placed;
}

}  // namespace acus::slicing
