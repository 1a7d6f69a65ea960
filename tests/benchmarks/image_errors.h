// Images of the scene of the sweeps: how long one takes, and how far it is from another.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "acus/base/core/cpu_time.h"
#include "acus/base/math/statistics.h"
#include "benchmarks/image_scene.h"
#include "benchmarks/sweep.h"

namespace acus::benchmarks {

/// A linear probe of 512 x 512 pixels, 40 x 45 mm, with a display of 60 dB.
acoustics::Probe ImageProbe(int lines, int samples);

struct TimedImage {
  image::GrayImage image;
  double median_us = 0.0;  ///< CPU time of one thread.
  double most_us = 0.0;
};

/// How the motion of the tissue is inverted at each place of an image.
struct Warp {
  int iterations = 8;
  double spacing_mm = 2.0;
};

/// The same image `rounds` times, at least two; the first is not timed.
template <typename Renderer>
TimedImage TimedRender(const ImageScene& scene, Renderer& renderer, const Warp& warp, int rounds) {
  TimedImage out;
  std::vector<double> times_us;
  for (int n = 0; n < rounds; ++n) {
    const PressedTissue rest(scene.needle.tip_in_ct_mm, warp.iterations, warp.spacing_mm);
    const double begin_s = ThreadCpuSeconds();
    renderer.Render(scene.ct_from_probe, scene.needle, out.image, 1, &rest);
    if (n > 0) times_us.push_back(1e6 * (ThreadCpuSeconds() - begin_s));
  }
  out.median_us = math::Median(times_us);
  out.most_us = std::ranges::max(times_us);
  return out;
}

/// A row with the time of an image.
Row TimedRow(const std::string& model, const std::string& knob, const std::string& value,
             const TimedImage& image);

/// What an effect does is no error: it has a unit of its own.
enum class ImageChange { kError, kEffect };

/// Adds two rows: RMS of pixels and of means over 1.5 mm, in which speckle averages out, both in dB
/// of the display.
void AddImageErrors(Row row, const image::GrayImage& image, const image::GrayImage& reference,
                    ImageChange change, std::vector<Row>& rows);

}  // namespace acus::benchmarks
