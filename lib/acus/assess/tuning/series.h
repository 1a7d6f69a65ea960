// What a run made, to be compared with that of another setting: forces at common moments, images.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "acus/assess/tuning/measured.h"

namespace acus::tuning {

/// Forces are held against each other at moments that all step rates have in common.
constexpr double kCommonStepMs = 1.0;

/// What one run made.
struct Series {
  /// On needle and probe, CT axes, N: x y z of the needle, x y z of the probe. One every
  /// kCommonStepMs: what a device would hold then. Empty if the scene has no forces.
  std::vector<std::array<double, 6>> force_n;
  double first_s = 0.0;         ///< Of the first of them, since the session began.
  std::vector<double> event_s;  ///< When a force jumped: punctures, contact with bone.
  int width = 0;                ///< Of the images, pixels.
  int height = 0;
  std::vector<std::uint8_t> pixels;  ///< Of all images, one after the other, row by row.

  int num_images() const;
};

/// Writes errors of `run` against `reference` into `out`, and what was felt: root mean square and
/// largest difference of forces, grey levels and mean structural similarity of images. Moments
/// within `around_event_s` of an event of the reference do not count: where a force jumps, a coarse
/// sample comes a step later. @throws InputError if the two are not of the same moments and size.
void Compare(const Series& run, const Series& reference, double around_event_s, Measured& out);

/// Writes a series, whole or not at all, with a check sum.
void WriteSeries(const std::filesystem::path& path, const Series& series);

/// Nothing if there is no such file, or a damaged one.
std::optional<Series> ReadSeries(const std::filesystem::path& path);

}  // namespace acus::tuning
