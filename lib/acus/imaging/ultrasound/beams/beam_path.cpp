#include "acus/imaging/ultrasound/beams/beam_path.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace acus::ultrasound {
namespace {

/// Far outside is outside: keeps indices within what an int holds.
constexpr double kFar = 1e8;

float Near(double value) {
  return static_cast<float>(std::clamp(value, -kFar, kFar));
}

/// Every `step`-th number from 0, and the last.
std::vector<int> Knots(int count, int step) {
  std::vector<int> knots;
  for (int at = 0; at < count - 1; at += step) knots.push_back(at);
  knots.push_back(std::max(1, count - 1));
  return knots;
}

}  // namespace

BeamPath::BeamPath(const Frame& frame)
    : frame_(frame),
      lanes_(slicing::kernels::RoundUp(frame.grid->lines())),
      sets_(frame.lattice_from_index ? 2 : 1) {
  const acoustics::ScanGrid& grid = *frame_.grid;
  for (int l = 0; l < lanes_; ++l) {
    const auto line = static_cast<std::size_t>(std::min(l, grid.lines() - 1));
    x_.push_back(static_cast<float>(grid.start_mm[line].x()));
    y_.push_back(static_cast<float>(grid.start_mm[line].y()));
    dx_.push_back(static_cast<float>(grid.direction[line].x()));
    dy_.push_back(static_cast<float>(grid.direction[line].y()));
  }
  places_.Reserve(static_cast<std::size_t>(6 * lanes_));
  Lay(0.0);
}

void BeamPath::Lay(double spacing_mm) {
  const acoustics::ScanGrid& grid = *frame_.grid;
  laid_for_mm_ = spacing_mm;
  int step = grid.samples;
  int line_step = grid.lines();
  // Lines out of the plane follow the width of the beam.
  if (!frame_.elevation_mm.empty()) step = std::max(1, grid.samples / 16);
  if (spacing_mm > 0.0) {
    const double line_mm = grid.lines() > 1 ? grid.LateralSpacingMm(grid.samples / 2) : spacing_mm;
    step = std::clamp(static_cast<int>(spacing_mm / grid.step_mm), 1, step);
    line_step = std::clamp(static_cast<int>(spacing_mm / line_mm), 1, 64);
  }
  knot_samples_ = Knots(grid.samples, step);
  knot_lines_ = Knots(grid.lines(), line_step);
  cell_of_lane_.clear();
  share_of_lane_.clear();
  std::size_t c = 0;
  for (int l = 0; l < lanes_; ++l) {
    const int at = std::min(l, grid.lines() - 1);
    while (c + 2 < knot_lines_.size() && knot_lines_[c + 1] <= at) ++c;
    cell_of_lane_.push_back(static_cast<int>(c));
    share_of_lane_.push_back(static_cast<float>(at - knot_lines_[c]) /
                             static_cast<float>(knot_lines_[c + 1] - knot_lines_[c]));
  }
  piece_of_.clear();
  for (int k = 0, p = 0; k < grid.samples; ++k) {
    while (p + 2 < static_cast<int>(knot_samples_.size()) &&
           knot_samples_[static_cast<std::size_t>(p) + 1] <= k) {
      ++p;
    }
    piece_of_.push_back(p);
  }
  offset_.resize(knot_samples_.size() * knot_lines_.size());
  lines_.Reserve((knot_samples_.size() - 1) * static_cast<std::size_t>(FloatsPerPiece()));
}

slicing::kernels::Lines BeamPath::LinesAt(int set, int first) const {
  slicing::kernels::Lines lines{};
  const float* data = lines_.data() + static_cast<std::ptrdiff_t>(set) * 6 * lanes_ + first;
  for (int a = 0; a < 3; ++a) {
    lines.start[a] = data + static_cast<std::ptrdiff_t>(2 * a) * lanes_;
    lines.step[a] = data + static_cast<std::ptrdiff_t>(2 * a + 1) * lanes_;
  }
  return lines;
}

void BeamPath::Set(const Eigen::Isometry3d& ct_from_probe, const slicing::RestMap* rest) {
  const double spacing_mm = rest == nullptr ? 0.0 : rest->SpacingMm();
  if (laid_for_mm_ != spacing_mm) Lay(spacing_mm);
  index_from_probe_ = frame_.index_from_ct * ct_from_probe;
  straight_ = true;
  if (rest != nullptr) AskAtKnots(ct_from_probe, rest);
  // The same pieces with and without a map that moves nothing, out of the plane as well.
  if (straight_ && laid_for_mm_ != 0.0 && !frame_.elevation_mm.empty()) Lay(0.0);
  if (straight_ && frame_.elevation_mm.empty()) {
    // The same pieces with and without a map that moves nothing.
    MakePiece(0, 0, 1);
    const auto size = static_cast<std::size_t>(FloatsPerPiece());
    for (std::size_t p = 1; p + 1 < knot_samples_.size(); ++p) {
      std::copy_n(lines_.data(), size, lines_.data() + p * size);
    }
    return;
  }
  for (std::size_t p = 0; p + 1 < knot_samples_.size(); ++p) {
    MakePiece(static_cast<int>(p), knot_samples_[p], knot_samples_[p + 1]);
  }
}

void BeamPath::AskAtKnots(const Eigen::Isometry3d& ct_from_probe, const slicing::RestMap* rest) {
  const acoustics::ScanGrid& grid = *frame_.grid;
  std::size_t n = 0;
  for (const int k : knot_samples_) {
    const double z =
        frame_.elevation_mm.empty()
            ? 0.0
            : frame_.elevation_mm[static_cast<std::size_t>(std::min(k, grid.samples - 1))];
    Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();  // From the place to its rest.
    for (const int line : knot_lines_) {
      const auto l = static_cast<std::size_t>(std::min(line, grid.lines() - 1));
      const Eigen::Vector2d at = grid.start_mm[l] + k * grid.step_mm * grid.direction[l];
      const Eigen::Vector3d place_mm = ct_from_probe * Eigen::Vector3d(at.x(), at.y(), z);
      moved_mm = rest->RestInCtMm(place_mm, place_mm + moved_mm) - place_mm;
      offset_[n] = frame_.index_from_ct.linear() * moved_mm;
      straight_ = straight_ && offset_[n].isZero(0.0);
      ++n;
    }
  }
}

void BeamPath::PlaceKnotRow(std::size_t row, std::array<float*, 3> place) const {
  const acoustics::ScanGrid& grid = *frame_.grid;
  const int k = knot_samples_[row];
  const auto along_mm = static_cast<float>(k * grid.step_mm);
  const double z =
      frame_.elevation_mm.empty()
          ? 0.0
          : frame_.elevation_mm[static_cast<std::size_t>(std::min(k, grid.samples - 1))];
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const auto mx = static_cast<float>(index_from_probe_.linear()(i, 0));
    const auto my = static_cast<float>(index_from_probe_.linear()(i, 1));
    const float base =
        Near(index_from_probe_.translation()[i] + z * index_from_probe_.linear()(i, 2));
    float* out = place[a];
    for (int l = 0; l < lanes_; ++l) {
      const auto n = static_cast<std::size_t>(l);
      out[l] = base + mx * (x_[n] + along_mm * dx_[n]) + my * (y_[n] + along_mm * dy_[n]);
    }
    if (straight_) continue;
    const Eigen::Vector3d* offset = offset_.data() + row * knot_lines_.size();
    for (int l = 0; l < lanes_;) {
      const int c = cell_of_lane_[static_cast<std::size_t>(l)];
      const auto left = static_cast<float>(offset[c][i]);
      const auto rise = static_cast<float>(offset[c + 1][i] - offset[c][i]);
      int end = l + 1;
      while (end < lanes_ && cell_of_lane_[static_cast<std::size_t>(end)] == c) ++end;
      for (; l < end; ++l) out[l] += left + share_of_lane_[static_cast<std::size_t>(l)] * rise;
    }
  }
}

void BeamPath::MakePiece(int piece, int first_sample, int last_sample) {
  const auto at = static_cast<std::ptrdiff_t>(lanes_);
  std::array<float*, 3> low{places_.data(), places_.data() + at, places_.data() + 2 * at};
  std::array<float*, 3> high{places_.data() + 3 * at, places_.data() + 4 * at,
                             places_.data() + 5 * at};
  float* lines = lines_.data() + piece * FloatsPerPiece();
  if (straight_ && frame_.elevation_mm.empty()) {
    for (int a = 0; a < 3; ++a) {
      const Eigen::RowVector2d row = index_from_probe_.linear().block<1, 2>(a, 0);
      const double base = index_from_probe_.translation()[a];
      for (int l = 0; l < lanes_; ++l) {
        const auto line = static_cast<std::size_t>(std::min(l, frame_.grid->lines() - 1));
        lines[2 * a * at + l] = Near(base + row * frame_.grid->start_mm[line]);
        lines[(2 * a + 1) * at + l] =
            Near(frame_.grid->step_mm * (row * frame_.grid->direction[line])(0));
      }
    }
  } else {
    // Neighbouring pieces share a knot row: the one below is this one's end.
    if (first_sample == 0) {
      PlaceKnotRow(0, low);
    } else {
      std::copy_n(high[0], 3 * at, low[0]);
    }
    PlaceKnotRow(static_cast<std::size_t>(piece) + 1, high);
    const float per_sample = 1.0F / static_cast<float>(last_sample - first_sample);
    const auto first = static_cast<float>(first_sample);
    for (std::size_t a = 0; a < 3; ++a) {
      float* start = lines + 2 * static_cast<std::ptrdiff_t>(a) * at;
      float* step = start + at;
      for (int l = 0; l < lanes_; ++l) {
        step[l] = (high[a][l] - low[a][l]) * per_sample;
        start[l] = low[a][l] - first * step[l];
      }
    }
  }
  if (frame_.lattice_from_index) TurnIntoLattice(piece);
}

void BeamPath::TurnIntoLattice(int piece) {
  const auto at = static_cast<std::ptrdiff_t>(lanes_);
  float* lines = lines_.data() + piece * FloatsPerPiece();
  const Eigen::Matrix3f turn = frame_.lattice_from_index->cast<float>();
  for (std::ptrdiff_t part = 0; part < 2; ++part) {
    const float* i = lines + part * at;
    const float* j = i + 2 * at;
    const float* k = j + 2 * at;
    for (Eigen::Index a = 0; a < 3; ++a) {
      float* out = lines + 6 * at + (2 * a + part) * at;
      const float ti = turn(a, 0);
      const float tj = turn(a, 1);
      const float tk = turn(a, 2);
      for (int l = 0; l < lanes_; ++l) out[l] = ti * i[l] + tj * j[l] + tk * k[l];
    }
  }
}

}  // namespace acus::ultrasound
