#include "acus/imaging/ultrasound/beams/refraction.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/parallel.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/speckle/binomial_window.h"

namespace acus::ultrasound {
namespace {

constexpr double kKnotMm = 0.8;
constexpr double kKnotRowMm = 1.0;
/// Binomial windows over the places of knots: a standard deviation of 1.7 knots.
constexpr int kBeamPasses = 3;
/// The raster continues beside the outermost lines, for rays that leave them.
constexpr double kMarginMm = 6.0;
constexpr int kRasterRowsPerPiece = 16;
/// (c / c0)^2 of the fastest soft tissue and of bone, and what bone takes of the energy per mm, one
/// way: 40 dB two-way.
constexpr float kSoft = 1.5F;
constexpr float kBone = 4.0F;
constexpr float kBoneNepersPerMm = 4.6F;
constexpr float kDark = 0.01F;
constexpr std::size_t kMostDirections = 32;

/// Columns of a raster over everything that the lines of a grid see.
acoustics::ScanGrid RasterColumns(const acoustics::ScanGrid& rows,
                                  const volume::Geometry& geometry) {
  constexpr double kFinestMm = 0.6;
  constexpr double kCoarsestMm = 1.0;
  acoustics::ScanGrid columns;
  columns.step_mm = std::clamp(geometry.spacing_mm.minCoeff(), kFinestMm, kCoarsestMm);
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9);
  Eigen::Array2d high = -low;
  for (std::size_t l = 0; l < rows.start_mm.size(); ++l) {
    const Eigen::Vector2d& start = rows.start_mm[l];
    const Eigen::Vector2d end = start + rows.samples * rows.step_mm * rows.direction[l];
    low = low.min(start.array()).min(end.array());
    high = high.max(start.array()).max(end.array());
  }
  low -= kMarginMm;
  high += kMarginMm;
  const Eigen::Array2i size = ((high - low) / columns.step_mm).ceil().cast<int>() + 1;
  columns.samples = size.y();
  for (int i = 0; i < size.x(); ++i) {
    columns.start_mm.emplace_back(low.x() + i * columns.step_mm, low.y());
    columns.direction.emplace_back(0.0, 1.0);
  }
  return columns;
}

int KnotLines(const acoustics::ScanGrid& rows) {
  const double face_mm = (rows.start_mm.back() - rows.start_mm.front()).norm();
  const double deep_mm = rows.LateralSpacingMm(rows.samples - 1) * (rows.lines() - 1);
  const double length_mm = std::max(face_mm, 0.4 * deep_mm);
  return std::clamp(static_cast<int>(length_mm / kKnotMm) + 2, 2, std::max(2, rows.lines()));
}

/// exp(-x) for x >= 0, as in the kernels: within 2e-6.
float ExpMinus(float x) {
  const float y = std::min(x, 16.0F) * -0.0625F;
  float e = 1.0F + y * (1.0F + y * (0.5F + y * (1.0F / 6.0F + y * (1.0F / 24.0F))));
  e *= e;
  e *= e;
  e *= e;
  return e * e;
}

/// Rays that meet at one place of the image.
struct Bundle {
  std::size_t count = 0;
  std::array<float, kMostDirections> weight{};  ///< Of energy.
  std::array<float, kMostDirections> across{};  ///< Over twice sigma.
  std::array<float, kMostDirections> overlap{};
  std::array<Eigen::Array2f, kMostDirections> bend_mm;

  /// overlap[d] = sum over e of weight[e] exp(-(across[d] - across[e])^2).
  void FindOverlaps() {
    const auto [low, high] = std::minmax_element(across.begin(), across.begin() + count);
    constexpr float kSame = 0.02F;
    std::fill_n(overlap.begin(), count, *high - *low < kSame ? 1.0F : 0.0F);
    if (*high - *low < kSame) return;
    for (std::size_t e = 0; e < count; ++e) {
      for (std::size_t d = 0; d < count; ++d) {
        const float apart = across[d] - across[e];
        overlap[d] += weight[e] * ExpMinus(apart * apart);
      }
    }
  }
};

}  // namespace

Refraction::Refraction(SpeedVolume speed, const volume::Geometry& geometry,
                       const acoustics::Probe& probe, const acoustics::ScanGrid& rows,
                       const ApertureRays& rays)
    : speed_(std::move(speed)),
      rows_(rows),
      rays_(rays),
      fan_(probe.kind != acoustics::ProbeKind::kLinear),
      radius_mm_(probe.radius_mm),
      line_(fan_ ? probe.field_of_view_rad / std::max(1, rows.lines() - 1)
                 : rows.LateralSpacingMm(0)),
      columns_(RasterColumns(rows, geometry)),
      raster_path_(
          {.grid = &columns_, .index_from_ct = geometry.index_from_ct(), .elevation_mm = {}}),
      raster_first_mm_(columns_.start_mm.front().cast<float>()),
      raster_mm_(static_cast<float>(columns_.step_mm)),
      raster_x_(columns_.lines()),
      raster_y_(columns_.samples),
      knot_lines_(KnotLines(rows)),
      rows_per_knot_(std::max(1, static_cast<int>(std::lround(kKnotRowMm / rows.step_mm)))),
      lines_per_knot_(static_cast<double>(rows.lines() - 1) / (knot_lines_ - 1)) {
  knot_rows_ = (rows.samples - 1) / rows_per_knot_ + 1;
  for (int j = 0; j < knot_rows_; ++j) {
    sigma_mm_.push_back(
        acoustics::SigmaOfFwhm(acoustics::LateralFwhmMm(probe, j * rows_per_knot_ * rows.step_mm)));
  }
  index_.resize(static_cast<std::size_t>(raster_x_) * static_cast<std::size_t>(raster_y_));
  raster_.resize(index_.size());
  const auto knots = static_cast<std::size_t>(knot_lines_) * static_cast<std::size_t>(knot_rows_);
  shift_mm_.assign(knots, Eigen::Array2f::Zero());
  component_mm_.resize(knots);
  gain_.assign(knots, 1.0F);
  bend_mm_.assign(knots * static_cast<std::size_t>(rays.directions()), Eigen::Array2f::Zero());
  left_.assign(bend_mm_.size(), 1.0F);
}

void Refraction::FillRaster(int num_threads) {
  const int pieces = (raster_y_ + kRasterRowsPerPiece - 1) / kRasterRowsPerPiece;
  const auto rows_of = [&](int piece, const auto& body) {
    const int first = piece * kRasterRowsPerPiece;
    for (int j = first; j < std::min(raster_y_, first + kRasterRowsPerPiece); ++j) body(j);
  };
  ParallelFor(pieces, num_threads, [&](int piece) {
    rows_of(piece, [&](int j) {
      speed_.SampleRow(raster_path_.Voxels(raster_path_.PieceAt(j), 0), static_cast<float>(j),
                       raster_x_, index_.data() + static_cast<std::ptrdiff_t>(j) * raster_x_);
    });
  });
  SmoothSlice(index_, raster_x_, raster_y_, smooth_);
  ParallelFor(pieces, num_threads, [&](int piece) {
    rows_of(piece, [&](int j) {
      const auto row = [&](int y) {
        return index_.data() +
               static_cast<std::ptrdiff_t>(std::clamp(y, 0, raster_y_ - 1)) * raster_x_;
      };
      const float* here = row(j);
      const float* above = row(j - 1);
      const float* below = row(j + 1);
      const float per_mm = 0.5F / raster_mm_;
      Eigen::Array4f* out = raster_.data() + static_cast<std::ptrdiff_t>(j) * raster_x_;
      for (int i = 0; i < raster_x_; ++i) {
        const float n = here[i];
        const float dx = here[std::min(i + 1, raster_x_ - 1)] - here[std::max(i - 1, 0)];
        const float dy = below[i] - above[i];
        out[i] = Eigen::Array4f(1.0F / (n * n), dx * per_mm / n, dy * per_mm / n, 0.0F);
      }
    });
  });
}

Eigen::Array4f Refraction::At(const Eigen::Array2f& place_mm) const {
  const Eigen::Array2f at = (place_mm - raster_first_mm_) / raster_mm_;
  const float x = std::min(std::max(at.x(), 0.0F), static_cast<float>(raster_x_ - 1) - 0.001F);
  const float y = std::min(std::max(at.y(), 0.0F), static_cast<float>(raster_y_ - 1) - 0.001F);
  const int i = static_cast<int>(x);
  const int j = static_cast<int>(y);
  const Eigen::Array4f* low = raster_.data() + static_cast<std::ptrdiff_t>(j) * raster_x_ + i;
  const Eigen::Array4f* high = low + raster_x_;
  const float across = x - static_cast<float>(i);
  const Eigen::Array4f upper = low[0] + across * (low[1] - low[0]);
  const Eigen::Array4f lower = high[0] + across * (high[1] - high[0]);
  return upper + (y - static_cast<float>(j)) * (lower - upper);
}

void Refraction::FollowRays(int direction) {
  const double tangent = rays_.TanAtFace(direction);
  const double cosine = 1.0 / std::sqrt(1.0 + tangent * tangent);
  const auto plane = static_cast<std::size_t>(knot_lines_) * static_cast<std::size_t>(knot_rows_);
  Eigen::Array2f* bend = bend_mm_.data() + static_cast<std::size_t>(direction) * plane;
  float* left = left_.data() + static_cast<std::size_t>(direction) * plane;
  for (int i = 0; i < knot_lines_; ++i) {
    const double line = i * lines_per_knot_;
    const auto l =
        static_cast<std::size_t>(std::min(static_cast<int>(line), std::max(0, rows_.lines() - 2)));
    const double share = line - static_cast<double>(l);
    const Eigen::Vector2d start =
        rows_.start_mm[l] + share * (rows_.start_mm[l + 1] - rows_.start_mm[l]);
    const Eigen::Vector2d along =
        (rows_.direction[l] + share * (rows_.direction[l + 1] - rows_.direction[l])).normalized();
    const Eigen::Vector2d across(along.y(), -along.x());
    const Eigen::Array2f straight = (cosine * (along + tangent * across)).array().cast<float>();
    const Eigen::Array2f first = start.array().cast<float>();
    Eigen::Array2f place = first;
    float inverse_n2 = At(place)[0];
    Eigen::Array2f v = straight / std::sqrt(inverse_n2);
    double before_mm = 0.0;
    float energy = 1.0F;
    bend[i].setZero();
    left[i] = energy;
    for (int j = 1; j < knot_rows_ && (j - 1) * rows_per_knot_ <= rays_.LastRow(direction); ++j) {
      const int row = j * rows_per_knot_;
      const double depth_mm = row * rows_.step_mm;
      const double along_face = double{rays_.ShiftLines(direction, row)} * line_;
      const double length_mm =
          fan_ ? std::sqrt(depth_mm * depth_mm + 2.0 * radius_mm_ * (radius_mm_ + depth_mm) *
                                                     (1.0 - std::cos(along_face)))
               : std::hypot(depth_mm, along_face);
      const auto step = static_cast<float>(length_mm - before_mm);
      before_mm = length_mm;
      const Eigen::Array4f middle = At(place + 0.5F * step * inverse_n2 * v);
      const Eigen::Array2f turn = step * middle.segment<2>(1);
      inverse_n2 = middle[0];
      if (inverse_n2 > kSoft) {
        const float bone = std::min((inverse_n2 - kSoft) / (kBone - kSoft), 1.0F);
        energy *= ExpMinus(kBoneNepersPerMm * bone * step);
        if (energy < kDark) energy = 0.0F;
      }
      place += step * inverse_n2 * (v + 0.5F * turn);
      v += turn;
      const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(j) * knot_lines_ + i;
      bend[at] = place - first - static_cast<float>(length_mm) * straight;
      left[at] = energy;
    }
  }
}

void Refraction::CombineRow(int knot_row) {
  const int row = knot_row * rows_per_knot_;
  const auto plane = static_cast<std::size_t>(knot_lines_) * static_cast<std::size_t>(knot_rows_);
  const auto at_row = static_cast<std::size_t>(knot_row) * static_cast<std::size_t>(knot_lines_);
  const auto per_sigma = static_cast<float>(0.5 / sigma_mm_[static_cast<std::size_t>(knot_row)]);
  Bundle bundle;
  for (int i = 0; i < knot_lines_; ++i) {
    const double line = i * lines_per_knot_;
    const double angle = fan_ ? (line - 0.5 * (rows_.lines() - 1)) * line_ : 0.0;
    const Eigen::Array2f across(static_cast<float>(std::cos(angle)),
                                static_cast<float>(-std::sin(angle)));
    bundle.count = 0;
    float sum = 0.0F;
    for (int d = 0; d < rays_.directions(); ++d) {
      const float weight = rays_.Weight(d, row);
      const double start = (line - double{rays_.ShiftLines(d, row)}) / lines_per_knot_;
      if (weight <= 0.0F || start < 0.0 || start > knot_lines_ - 1) continue;
      const int low = std::min(static_cast<int>(start), knot_lines_ - 2);
      const auto share = static_cast<float>(start - low);
      const std::size_t at =
          static_cast<std::size_t>(d) * plane + at_row + static_cast<std::size_t>(low);
      const float first = (1.0F - share) * left_[at];
      const float second = share * left_[at + 1];
      if (first + second < kDark) continue;
      const std::size_t n = bundle.count++;
      bundle.bend_mm[n] = (first * bend_mm_[at] + second * bend_mm_[at + 1]) / (first + second);
      bundle.across[n] = (bundle.bend_mm[n] * across).sum() * per_sigma;
      bundle.weight[n] = weight * weight * (first + second);
      sum += bundle.weight[n];
    }
    const std::size_t knot = at_row + static_cast<std::size_t>(i);
    shift_mm_[knot].setZero();
    gain_[knot] = 1.0F;
    if (bundle.count == 0) continue;
    for (std::size_t n = 0; n < bundle.count; ++n) bundle.weight[n] /= sum;
    bundle.FindOverlaps();
    float left = 0.0F;
    Eigen::Array2f shift = Eigen::Array2f::Zero();
    for (std::size_t n = 0; n < bundle.count; ++n) {
      const float both = bundle.weight[n] * bundle.overlap[n];
      left += both;
      shift += both * bundle.bend_mm[n];
    }
    shift_mm_[knot] = shift / left;
    gain_[knot] = std::sqrt(std::min(left, 1.0F));
  }
}

void Refraction::Trace(const Eigen::Isometry3d& ct_from_probe, const slicing::RestMap* rest,
                       int num_threads) {
  ct_from_probe_ = ct_from_probe;
  probe_from_ct_ = ct_from_probe.inverse();
  rest_ = rest;
  raster_path_.Set(ct_from_probe, rest);
  FillRaster(num_threads);
  ParallelFor(rays_.directions(), num_threads, [this](int d) { FollowRays(d); });
  constexpr int kRows = 8;
  ParallelFor((knot_rows_ + kRows - 1) / kRows, num_threads, [this](int piece) {
    const int end = std::min(knot_rows_, (piece + 1) * kRows);
    for (int j = piece * kRows; j < end; ++j) CombineRow(j);
  });
  // A beam is some knots wide: what it sees does not jump from one to the next. One ray is no beam.
  for (int axis = 0; axis < 2 && rays_.directions() > 1; ++axis) {
    for (std::size_t n = 0; n < shift_mm_.size(); ++n) component_mm_[n] = shift_mm_[n][axis];
    for (int pass = 0; pass < kBeamPasses; ++pass) {
      SmoothSlice(component_mm_, knot_lines_, knot_rows_, smooth_);
    }
    for (std::size_t n = 0; n < shift_mm_.size(); ++n) shift_mm_[n][axis] = component_mm_[n];
  }
}

Refraction::Cell Refraction::CellAt(double line, double row) const {
  const double i = std::clamp(line / lines_per_knot_, 0.0, static_cast<double>(knot_lines_ - 1));
  const double j = std::clamp(row / rows_per_knot_, 0.0, static_cast<double>(knot_rows_ - 1));
  const int low_line = std::min(static_cast<int>(i), knot_lines_ - 2);
  const int low_row = std::min(static_cast<int>(j), std::max(0, knot_rows_ - 2));
  const auto at = static_cast<std::size_t>(low_row) * static_cast<std::size_t>(knot_lines_) +
                  static_cast<std::size_t>(low_line);
  return {at, knot_rows_ > 1 ? at + static_cast<std::size_t>(knot_lines_) : at,
          static_cast<float>(i - low_line), static_cast<float>(j - low_row)};
}

void Refraction::GainRow(int row, float* gain) const {
  for (int l = 0; l < rows_.lines(); ++l) {
    const Cell cell = CellAt(l, row);
    const auto across = [&](std::size_t at) {
      return gain_[at] + cell.across * (gain_[at + 1] - gain_[at]);
    };
    const float upper = across(cell.at);
    gain[l] = upper + cell.along * (across(cell.below) - upper);
  }
}

Eigen::Vector2d Refraction::ShiftMm(double line, double row) const {
  const Cell cell = CellAt(line, row);
  const auto across = [&](std::size_t at) -> Eigen::Array2f {
    return shift_mm_[at] + cell.across * (shift_mm_[at + 1] - shift_mm_[at]);
  };
  const Eigen::Array2f upper = across(cell.at);
  const Eigen::Array2f shift = upper + cell.along * (across(cell.below) - upper);
  return shift.matrix().cast<double>();
}

Eigen::Array2d Refraction::LineAndRowOf(double x_mm, double y_mm) const {
  const double middle = 0.5 * (rows_.lines() - 1);
  if (!fan_) return {x_mm / line_ + middle, y_mm / rows_.step_mm};
  const double from_centre = y_mm + radius_mm_;
  return {std::atan2(x_mm, from_centre) / line_ + middle,
          (std::hypot(x_mm, from_centre) - radius_mm_) / rows_.step_mm};
}

Eigen::Vector3d Refraction::RestInCtMm(const Eigen::Vector3d& place_in_ct_mm,
                                       const Eigen::Vector3d& guess_in_ct_mm) const noexcept {
  const Eigen::Vector3d in_probe = probe_from_ct_ * place_in_ct_mm;
  const Eigen::Array2d at = LineAndRowOf(in_probe.x(), in_probe.y());
  const Eigen::Vector2d shift = ShiftMm(at.x(), at.y());
  const Eigen::Vector3d shift_in_ct =
      ct_from_probe_.linear() * Eigen::Vector3d(shift.x(), shift.y(), 0.0);
  const Eigen::Vector3d seen = place_in_ct_mm + shift_in_ct;
  return rest_ != nullptr ? rest_->RestInCtMm(seen, guess_in_ct_mm) : seen;
}

double Refraction::SpacingMm() const noexcept {
  constexpr double kSpacingMm = 2.0;
  return rest_ != nullptr ? std::min(rest_->SpacingMm(), kSpacingMm) : kSpacingMm;
}

}  // namespace acus::ultrasound
