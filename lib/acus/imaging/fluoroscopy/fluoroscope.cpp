#include "acus/imaging/fluoroscopy/fluoroscope.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"

namespace acus::fluoroscopy {
namespace {

using kernels::RayTile;

/// Neighbouring rays read neighbouring voxels: tiles are 16 columns by 8 rows.
constexpr int kTileColumns = 16;
constexpr int kTileRows = RayTile::kRays / kTileColumns;
/// Less than this went through no patient.
constexpr double kLeastSum = 0.05;

int Tiles(int pixels, int tile) {
  return (pixels + tile - 1) / tile;
}

/// Narrows [begin, end] to where start + n * step is in [low, high].
void Clip(double start, double step, double low, double high, double& begin, double& end) {
  if (std::abs(step) < 1e-12) {
    if (start < low || start > high) end = begin - 1.0;
    return;
  }
  const double n0 = (low - start) / step;
  const double n1 = (high - start) / step;
  begin = std::max(begin, std::min(n0, n1));
  end = std::min(end, std::max(n0, n1));
}

}  // namespace

Fluoroscope::Fluoroscope(const volume::CtVolume& ct, const CArm& c_arm, const CArmPose& pose,
                         int num_threads)
    : c_arm_(c_arm),
      geometry_(c_arm, pose),
      volume_(ct, c_arm.detail, geometry_.direction_in_ct(), num_threads),
      source_(volume_.slices_from_ct() * geometry_.source_in_ct_mm()),
      stride_(Tiles(c_arm.width_px, kTileColumns) * kTileColumns) {
  const int rows = Tiles(c_arm.height_px, kTileRows) * kTileRows;
  sums_.Reserve(num_sums());
  const int columns = stride_ / kTileColumns;
  tiles_.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows / kTileRows));
  for (std::size_t t = 0; t < tiles_.size(); ++t) {
    const int tile = static_cast<int>(t);
    PlaceTile(tile % columns * kTileColumns, tile / columns * kTileRows, tiles_[t]);
  }
  low_ = c_arm.window_low;
  high_ = c_arm.window_high;
  if (low_ == 0.0 && high_ == 0.0) {
    SumAll(num_threads);
    ChooseWindow();
  }
}

void Fluoroscope::PlaceRay(const Eigen::Vector3d& pixel_mm, int number, Tile& tile) const {
  const kernels::Slices slices = volume_.slices();
  const Eigen::Vector3d ray_mm = pixel_mm - geometry_.source_in_ct_mm();
  const Eigen::Vector3d ray = volume_.slices_from_ct().linear() * ray_mm;
  for (int t = 0; t < 2; ++t) tile.rays.start[t][number] = tile.rays.step[t][number] = 0.0F;
  tile.per_value[number] = 0.0F;
  // A ray along the slices would be summed in no steps at all.
  if (std::abs(ray[2]) < 1e-6 * ray.norm()) return;
  const double per_slice = 1.0 / ray[2];
  double begin = 0.0;
  double end = volume_.num_slices() - 1.0;
  // From the source to the detector.
  Clip(-source_[2] * per_slice, per_slice, 0.0, 1.0, begin, end);
  for (int t = 0; t < 2; ++t) {
    const double step = ray[t] * per_slice;
    const double start = source_[t] - source_[2] * step;
    tile.rays.start[t][number] = static_cast<float>(start);
    tile.rays.step[t][number] = static_cast<float>(step);
    Clip(start, step, 0.0, t == 0 ? slices.last_a : slices.last_b, begin, end);
  }
  tile.per_value[number] =
      static_cast<float>(ray_mm.norm() * std::abs(per_slice) * c_arm_.water_per_mm / 1000.0);
  if (begin > end) return;
  tile.first_slice = std::min(tile.first_slice, static_cast<int>(std::ceil(begin)));
  tile.end_slice = std::max(tile.end_slice, static_cast<int>(std::floor(end)) + 1);
}

void Fluoroscope::PlaceTile(int first_column, int first_row, Tile& tile) const {
  tile.first_slice = volume_.num_slices();
  tile.end_slice = 0;
  for (int r = 0; r < RayTile::kRays; ++r) {
    PlaceRay(geometry_.PixelInCtMm(first_column + r % kTileColumns, first_row + r / kTileColumns),
             r, tile);
  }
}

std::size_t Fluoroscope::num_sums() const {
  const int rows = Tiles(c_arm_.height_px, kTileRows) * kTileRows;
  return static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows);
}

void Fluoroscope::SumAll(int num_threads) {
  const int columns = Tiles(c_arm_.width_px, kTileColumns);
  const kernels::Slices slices = volume_.slices();
  const auto row_of_tiles = [this, columns, &slices](int row) {
    alignas(64) float values[RayTile::kRays];
    for (int t = 0; t < columns; ++t) {
      const Tile& tile = tiles_[static_cast<std::size_t>(row * columns + t)];
      kernels::RaySums(slices, tile.rays, tile.first_slice, tile.end_slice, values);
      for (int r = 0; r < RayTile::kRays; ++r) {
        const std::ptrdiff_t at =
            static_cast<std::ptrdiff_t>(row * kTileRows + r / kTileColumns) * stride_ +
            t * kTileColumns + r % kTileColumns;
        sums_.data()[at] = values[r] * tile.per_value[r];
      }
    }
  };
  ParallelFor(Tiles(c_arm_.height_px, kTileRows), num_threads, std::ref(row_of_tiles));
}

void Fluoroscope::ChooseWindow() {
  std::vector<float> patient;
  for (int r = 0; r < c_arm_.height_px; ++r) {
    for (int c = 0; c < c_arm_.width_px; ++c) {
      if (Sum(c, r) > kLeastSum) patient.push_back(Sum(c, r));
    }
  }
  ACUS_REQUIRE(!patient.empty(),
               "fluoroscopy: no ray meets the patient; move the isocentre into the CT, or give the "
               "C-arm a window");
  std::ranges::sort(patient);
  const auto at = [&](double share) {
    return patient[static_cast<std::size_t>(share * static_cast<double>(patient.size() - 1))];
  };
  low_ = at(0.02);
  // The needle must still be darker than bone.
  high_ = std::max(low_ + 0.1, 1.15 * at(0.995));
}

void Fluoroscope::Render(const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
                         int num_threads, const slicing::RestMap* rest) {
  volume_.Deform(rest, num_threads);
  SumAll(num_threads);
  patient_.Reserve(num_sums());
  std::copy_n(sums_.data(), num_sums(), patient_.data());
  if (needle) shadow_.Add(*needle, c_arm_, geometry_, sums_.data(), stride_);
  Show(out);
}

void Fluoroscope::RenderNeedle(const std::optional<image::NeedleInImage>& needle,
                               image::GrayImage& out) {
  std::copy_n(patient_.data(), num_sums(), sums_.data());
  if (needle) shadow_.Add(*needle, c_arm_, geometry_, sums_.data(), stride_);
  Show(out);
}

void Fluoroscope::Show(image::GrayImage& out) const {
  out.Resize(c_arm_.width_px, c_arm_.height_px);
  const bool log = c_arm_.scale == FluoroscopyScale::kLog;
  const double bright = log ? low_ : std::exp(-low_);
  const double dark = log ? high_ : std::exp(-high_);
  for (int r = 0; r < c_arm_.height_px; ++r) {
    for (int c = 0; c < c_arm_.width_px; ++c) {
      const double value = log ? Sum(c, r) : std::exp(-static_cast<double>(Sum(c, r)));
      double grey = std::clamp((value - dark) / (bright - dark), 0.0, 1.0);
      if (!c_arm_.dark_bone) grey = 1.0 - grey;
      out.pixels[static_cast<std::size_t>(r) * static_cast<std::size_t>(out.width) +
                 static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(255.0 * grey + 0.5);
    }
  }
}

}  // namespace acus::fluoroscopy
