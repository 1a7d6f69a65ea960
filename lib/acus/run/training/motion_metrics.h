// Metrics of a training session: times, paths and the damage by the needle.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "acus/data/session/session.h"

namespace acus::training {

/// True if a point, in the session's reference frame (mm), lies in tissue.
using InsideTissue = std::function<bool(const Eigen::Vector3d& point_in_reference_mm)>;

/// Selects the samples over which paths and damage are summed. At 1 kHz the sum over all samples is
/// mostly tremor and the tracker's noise: it grows with the rate. Recordings at up to 10 Hz, as
/// Perk Tutor's, are used whole; of faster ones a sample is used once 0.1 s have passed.
class PathPacer {
 public:
  /// 0.1 s less the jitter of stamps.
  static constexpr std::int64_t kPeriodNs = 99'000'000;
  bool Takes(std::int64_t time_ns) {
    if (taken_ns_ && time_ns - *taken_ns_ < kPeriodNs) return false;
    taken_ns_ = time_ns;
    return true;
  }
  void Restart() { taken_ns_.reset(); }

 private:
  std::optional<std::int64_t> taken_ns_;
};

/// The path of a tool's origin, of valid samples as they come.
class PathMeter {
 public:
  void Add(const session::PoseSample& sample);
  void Restart();  ///< The tool has changed hands: no motion is counted up to the next sample.
  double length_mm() const;  ///< Up to the newest sample.

 private:
  PathPacer pacer_;
  std::optional<Eigen::Vector3d> taken_mm_;
  Eigen::Vector3d newest_mm_ = Eigen::Vector3d::Zero();
  double length_mm_ = 0.0;
};

/// Metrics of the motion of one tool's origin (for a needle: its tip). Invalid samples are
/// omitted: the motion is taken as straight from the valid sample before to the one after.
struct MotionMetrics {
  double elapsed_time_s = 0.0;  ///< From the first to the last valid sample.
  double path_length_mm = 0.0;
  double mean_speed_mm_per_s = 0.0;  ///< Path length over time.
  /// Largest distance covered within MetricOptions::speed_window_s, over that time.
  double max_speed_mm_per_s = 0.0;
};

/// Metrics of a needle in tissue. As Perk Tutor defines them, so that results can be compared: each
/// step counts as in tissue if its end is; damage is summed over steps that begin and end in
/// tissue. Path and damage are summed over the samples of PathPacer, time over all.
struct TissueMetrics {
  double time_in_tissue_s = 0.0;
  double path_in_tissue_mm = 0.0;
  int num_insertions = 0;  ///< Entries of the tip into tissue, tremor at the surface not counted.
  /// Area that the part of the shaft in tissue sweeps: per step the two triangles between the tips
  /// and the points where the shaft, along -z from the tip, leaves the tissue.
  double tissue_damage_mm2 = 0.0;
};

struct MetricOptions {
  double speed_window_s = 0.1;    ///< > 0. Shorter windows measure the jitter of the tracker.
  double needle_length_mm = 300;  ///< > 0. Search length for the tissue's surface along the shaft.
  /// An entry is counted if since the last exit the tip was at least this far from the point of the
  /// exit: a distance, not a path length, which tremor and the sampling rate increase. >= 0.
  double withdrawal_mm = 5.0;
};

/// @param swaps_ns  Ascending times at which the tool changed hands: no motion is counted from the
///     sample before to the first one at or after it.
/// @throws InputError if an option is out of its range. All zero if fewer than two samples are
///     valid.
MotionMetrics ComputeMotionMetrics(const session::PoseStream& stream,
                                   const MetricOptions& options = {},
                                   std::span<const std::int64_t> swaps_ns = {});

/// TissueMetrics of samples as they arrive. Sums have the bits of ComputeTissueMetrics.
class TissueMeter {
 public:
  /// @throws InputError if an option is out of its range.
  TissueMeter(InsideTissue inside, const MetricOptions& options);

  /// Samples that are not valid are ignored.
  void Add(const session::PoseSample& sample);
  /// The tool has changed hands: no motion is counted up to the next sample.
  void Restart();
  TissueMetrics metrics() const;  ///< Up to the newest sample.

 private:
  /// The needle as it is in tissue.
  struct Shaft {
    Eigen::Vector3d tip_mm, exit_mm;
    bool is_inside = false;
  };
  Shaft ShaftOf(const session::PoseSample& sample, bool is_inside) const;
  static void AddStep(const Shaft& from, const Shaft& to, TissueMetrics& metrics);

  InsideTissue inside_;
  MetricOptions options_;
  TissueMetrics metrics_;
  bool was_inside_ = false;
  Eigen::Vector3d left_mm_ = Eigen::Vector3d::Zero();         ///< Last tip position in tissue.
  double away_mm_ = std::numeric_limits<double>::infinity();  ///< Largest distance from it since.
  std::optional<session::PoseSample> last_;
  PathPacer pacer_;
  std::optional<Shaft> taken_;
};

/// @throws InputError as above.
TissueMetrics ComputeTissueMetrics(const session::PoseStream& needle, const InsideTissue& inside,
                                   const MetricOptions& options = {},
                                   std::span<const std::int64_t> swaps_ns = {});

/// The times of a session at which needle and probe changed hands, ascending.
std::vector<std::int64_t> SwapTimesNs(const session::Session& session);

/// Called with each sample time of a stream in order: whether the tools have changed hands since
/// the previous one.
class SwapWatch {
 public:
  /// @param swaps_ns  Ascending; must outlive this.
  explicit SwapWatch(std::span<const std::int64_t> swaps_ns) : swaps_ns_(swaps_ns) {}
  bool Passes(std::int64_t time_ns) {
    bool passes = false;
    for (; !swaps_ns_.empty() && swaps_ns_.front() <= time_ns; swaps_ns_ = swaps_ns_.subspan(1)) {
      passes = true;
    }
    return passes;
  }

 private:
  std::span<const std::int64_t> swaps_ns_;
};

/// The point where the shaft leaves the tissue, from a tip in tissue along the needle's -z: exact
/// to 1e-6 mm, but tissue or gaps thinner than 0.5 mm may be missed. The far end of the shaft if it
/// does not leave the tissue within `length_mm`.
Eigen::Vector3d ShaftExit(const Eigen::Isometry3d& reference_from_needle,
                          const InsideTissue& inside, double length_mm);

}  // namespace acus::training
