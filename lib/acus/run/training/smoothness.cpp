#include "acus/run/training/smoothness.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "acus/base/core/error.h"

namespace acus::training {
namespace {

/// Amplitudes of the padded spectrum up to the cutoff, relative to that at frequency 0.
std::vector<double> RelativeSpectrum(std::span<const double> speed, double rate_hz,
                                     const SmoothnessOptions& options, double& step_hz) {
  std::size_t length = 1;
  while (length < speed.size()) length *= 2;
  length <<= options.padding_levels;
  std::vector<double> padded(length, 0.0);
  std::ranges::copy(speed, padded.begin());
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double> fft;
  fft.fwd(spectrum, padded);
  step_hz = rate_hz / static_cast<double>(length);
  std::vector<double> relative;
  double largest = 0.0;
  for (std::size_t i = 0; i <= length / 2; ++i) {
    largest = std::max(largest, std::abs(spectrum[i]));
  }
  if (!(largest > 0.0)) return relative;
  for (std::size_t i = 0; i <= length / 2; ++i) {
    if (static_cast<double>(i) * step_hz > options.cutoff_hz) break;
    relative.push_back(std::abs(spectrum[i]) / largest);
  }
  return relative;
}

}  // namespace

double SpectralArcLength(std::span<const double> speed, double rate_hz,
                         const SmoothnessOptions& options) {
  ACUS_ASSERT(speed.size() >= 2 && rate_hz > 0.0);
  double step_hz = 0.0;
  std::vector<double> spectrum = RelativeSpectrum(speed, rate_hz, options, step_hz);
  const auto last = std::find_if(spectrum.rbegin(), spectrum.rend(),
                                 [&](double value) { return value >= options.amplitude; });
  spectrum.erase(last.base(), spectrum.end());
  if (spectrum.size() < 2) return 0.0;
  const double df = 1.0 / static_cast<double>(spectrum.size() - 1);
  double length = 0.0;
  for (std::size_t i = 1; i < spectrum.size(); ++i) {
    length += std::hypot(df, spectrum[i] - spectrum[i - 1]);
  }
  return -length;
}

double LogDimensionlessJerk(std::span<const double> speed, double rate_hz) {
  ACUS_ASSERT(speed.size() >= 3 && rate_hz > 0.0);
  double peak = 0.0;
  for (const double v : speed) peak = std::max(peak, std::abs(v));
  double squares = 0.0;
  for (std::size_t i = 2; i < speed.size(); ++i) {
    const double jerk = (speed[i] - 2.0 * speed[i - 1] + speed[i - 2]) * rate_hz * rate_hz;
    squares += jerk * jerk / rate_hz;
  }
  if (!(squares > 0.0)) return 0.0;
  const double duration_s = static_cast<double>(speed.size()) / rate_hz;
  return -std::log(duration_s * duration_s * duration_s / (peak * peak) * squares);
}

std::vector<double> SpeedProfile(const session::PoseStream& stream, std::int64_t from_ns,
                                 std::int64_t to_ns, double rate_hz) {
  session::PoseStream valid;
  for (const session::PoseSample& sample : stream) {
    if (sample.valid) valid.push_back(sample);
  }
  std::vector<double> speed;
  if (valid.size() < 2 || to_ns <= from_ns) return speed;
  const double step_ns = 1e9 / rate_hz;
  const auto steps = static_cast<std::int64_t>(static_cast<double>(to_ns - from_ns) / step_ns);
  if (steps < 3) return speed;
  std::size_t next = 0;  // First sample at or after the time.
  Eigen::Vector3d before_mm = Eigen::Vector3d::Zero();
  for (std::int64_t i = 0; i <= steps; ++i) {
    const auto time_ns =
        from_ns + static_cast<std::int64_t>(std::llround(static_cast<double>(i) * step_ns));
    while (next < valid.size() && valid[next].time_ns < time_ns) ++next;
    const session::PoseSample& b = valid[std::min(next, valid.size() - 1)];
    const session::PoseSample& a = valid[next == 0 ? 0 : std::min(next, valid.size()) - 1];
    const double span = static_cast<double>(b.time_ns - a.time_ns);
    const double share =
        span > 0.0 ? std::clamp(static_cast<double>(time_ns - a.time_ns) / span, 0.0, 1.0) : 0.0;
    const Eigen::Vector3d now_mm = (1.0 - share) * a.reference_from_tool.translation() +
                                   share * b.reference_from_tool.translation();
    if (i > 0) speed.push_back((now_mm - before_mm).norm() * rate_hz);
    before_mm = now_mm;
  }
  return speed;
}

}  // namespace acus::training
