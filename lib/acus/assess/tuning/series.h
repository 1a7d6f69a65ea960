// Results of a run for the comparison with another setting: forces at common times, images.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/measured.h"

namespace acus::tuning {

/// Forces are compared at times that all step rates have in common.
constexpr double kCommonStepMs = 1.0;

/// The series of one run.
struct Series {
  /// On needle and probe, CT axes, N: x y z of the needle, x y z of the probe. One every
  /// kCommonStepMs: the force that a device would hold then. Empty if the scene has no forces.
  std::vector<std::array<double, 6>> force_n;
  double first_s = 0.0;         ///< Time of the first of them, since the session began.
  std::vector<double> event_s;  ///< Times of force jumps: punctures, contact with bone.
  int width = 0;                ///< Width of the images, pixels.
  int height = 0;
  std::vector<std::uint8_t> pixels;  ///< Pixels of all images, one after the other, row by row.

  int num_images() const;
};

/// Writes errors of `run` relative to `reference` into `out`, and the largest force: root mean
/// square and largest difference of forces, grey levels and mean structural similarity of images.
/// Times within `around_event_s` of an event of the reference do not count: where a force jumps, a
/// coarse sample comes a step later. @throws InputError if the two have different times or sizes.
void Compare(const Series& run, const Series& reference, double around_event_s, Measured& out);

/// Writes a series, whole or not at all, with a check sum.
void WriteSeries(const std::filesystem::path& path, const Series& series);

/// Nothing if there is no such file, or a damaged one.
std::optional<Series> ReadSeries(const std::filesystem::path& path);

}  // namespace acus::tuning
