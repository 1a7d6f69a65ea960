// Comparison of two image sequences (images.igs.mha) of the same session.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "acus/assess/regression/comparison/check.h"
#include "acus/assess/regression/comparison/tolerances.h"
#include "acus/base/core/run_context.h"

namespace acus::comparison {

struct FrameDifference {
  double time_s = 0.0;            ///< In A; the frame's number if it has no time stamp.
  std::optional<double> psnr_db;  ///< Nothing if the frames are identical.
  double ssim = 1.0;
};

struct ImageComparison {
  std::vector<Check> checks;
  std::vector<FrameDifference> frames;  ///< Frames that both runs have.
  std::size_t num_identical = 0;
  std::optional<std::size_t> worst;  ///< The frame with the smallest SSIM; the first of equals.
};

/// Compares frame by frame, in order; frames of different size cannot be compared, which is a
/// failed check. The result does not depend on context.num_threads.
/// @throws InputError if a file is broken, or its pixels are not grey with 8 bits.
ImageComparison CompareImages(const std::filesystem::path& a, const std::filesystem::path& b,
                              const ImageTolerances& tolerances, const RunContext& context);

/// One frame of both runs and their difference, side by side: A | B | |A - B|, the last stretched
/// so that its largest value is white.
struct SideBySide {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;
  int largest_difference = 0;  ///< Grey levels.
};

/// @pre CompareImages compared this frame.
SideBySide ShowFrame(const std::filesystem::path& a, const std::filesystem::path& b,
                     std::size_t frame);

}  // namespace acus::comparison
