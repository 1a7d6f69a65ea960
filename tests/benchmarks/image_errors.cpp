#include "benchmarks/image_errors.h"

#include <cmath>
#include <utility>

namespace acus::benchmarks {
namespace {

constexpr double kDynamicRangeDb = 60.0;

/// Means over squares of 16 pixels, some 1.5 mm: what is left when speckle is averaged.
std::vector<double> LocalMeans(const image::GrayImage& image) {
  constexpr int kSide = 16;
  std::vector<double> means;
  for (int r = 0; r + kSide <= image.height; r += kSide) {
    for (int c = 0; c + kSide <= image.width; c += kSide) {
      double sum = 0.0;
      for (int n = 0; n < kSide * kSide; ++n) sum += image.At(c + n % kSide, r + n / kSide);
      means.push_back(sum / (kSide * kSide));
    }
  }
  return means;
}

template <typename Values>
double RmsDifference(const Values& a, const Values& b) {
  double sum = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    const double off = static_cast<double>(a[n]) - static_cast<double>(b[n]);
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace

acoustics::Probe ImageProbe(int lines, int samples) {
  acoustics::Probe probe = acoustics::DefaultProbe();
  probe.kind = acoustics::ProbeKind::kLinear;
  probe.frequency_mhz = 7.5;
  probe.width_mm = 40.0;
  probe.depth_mm = 45.0;
  probe.focus_mm = 28.0;
  probe.scan_lines = lines;
  probe.samples_per_line = samples;
  probe.image_width_px = probe.image_height_px = 512;
  probe.slice_thickness_mm = 3.0;
  probe.pulse_length_mm = 0.5;
  probe.beam_width_mm = 0.8;
  probe.dynamic_range_db = kDynamicRangeDb;
  probe.gain_db = 25.0;
  probe.tgc_db_per_cm = 7.0;
  return probe;
}

Row TimedRow(const std::string& model, const std::string& knob, const std::string& value,
             const TimedImage& image) {
  Row row;
  row.knob = knob;
  row.value = value;
  row.model = model;
  row.step_us_median = image.median_us;
  row.step_us_p999 = image.most_us;
  return row;
}

void AddImageErrors(Row row, const image::GrayImage& image, const image::GrayImage& reference,
                    ImageChange change, std::vector<Row>& rows) {
  constexpr double kDbPerGrey = kDynamicRangeDb / 255.0;
  const bool is_effect = change == ImageChange::kEffect;
  row.error = kDbPerGrey * RmsDifference(image.pixels, reference.pixels);
  row.error_unit = is_effect ? "dB of change, pixels" : "dB, pixels";
  rows.push_back(row);
  row.error = kDbPerGrey * RmsDifference(LocalMeans(image), LocalMeans(reference));
  row.error_unit = is_effect ? "dB of change, means over 1.5 mm" : "dB, means over 1.5 mm";
  rows.push_back(std::move(row));
}

}  // namespace acus::benchmarks
