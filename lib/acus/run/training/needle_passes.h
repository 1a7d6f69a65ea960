// Attempts, passes and redirections: the changes of direction of the needle.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "acus/run/training/motion_metrics.h"

namespace acus::training {

/// One advance of the needle in tissue, from a turning point to the next.
struct NeedlePass {
  std::int64_t begin_ns = 0;  ///< Time of the entry, or of the end of the withdrawal before.
  std::int64_t end_ns = 0;    ///< Time of the deepest point.
  int attempt = 0;            ///< Number of the insertion through the skin, from 0.
  double advance_mm = 0.0;    ///< Along the shaft.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< Axis of the needle at its deepest point.
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  ///< The tip there; frame of the stream.
  /// True after another pass of the same attempt, in another direction.
  bool redirected = false;
};

struct PassOptions {
  /// Smallest length of a motion forward or back along the shaft: shorter ones are tremor and
  /// probing. > 0.
  double turn_mm = 5.0;
  double redirection_rad = 0.0523598775598299;  ///< Smallest change of direction, 3 degrees. > 0.
  double withdrawal_mm = 5.0;  ///< As MetricOptions::withdrawal_mm: ends an attempt. >= 0.
};

/// All passes of a needle stream, in order of time. The depth along the shaft is the sum of the
/// tip's motions projected on the needle's axis, so that a sideways sweep is not a pass.
/// @param inside  Whether a point, in the stream's frame, lies in tissue.
/// @param swaps_ns  As for ComputeMotionMetrics: an attempt ends when the needle changes hands.
/// @throws InputError if an option is out of its range.
std::vector<NeedlePass> FindPasses(const session::PoseStream& needle, const InsideTissue& inside,
                                   const PassOptions& options = {},
                                   std::span<const std::int64_t> swaps_ns = {});

/// The passes of samples as they arrive.
class PassMeter {
 public:
  /// @throws InputError if an option is out of its range.
  PassMeter(InsideTissue inside, const PassOptions& options);

  /// Samples that are not valid are ignored.
  void Add(const session::PoseSample& sample);
  void Restart();  ///< The needle has changed hands.
  /// As if the session ended now: with the current pass, if it is long enough for one.
  std::vector<NeedlePass> passes() const;
  /// Including attempts without a pass.
  int num_attempts() const { return num_attempts_; }
  bool in_attempt() const { return turns_.has_value(); }

 private:
  struct Turn {
    double way_mm = 0.0;
    session::PoseSample sample;
  };
  /// Follows the depth along the shaft within one attempt and finds where it turns.
  class TurnFinder {
   public:
    TurnFinder(double turn_mm, int attempt, const session::PoseSample& entry);
    /// The pass that ends because the needle has been withdrawn, if it has.
    std::optional<NeedlePass> Add(double step_mm, const session::PoseSample& sample);
    /// The pass that ends at the deepest point so far, if it is long enough for one.
    std::optional<NeedlePass> Ended() const;

   private:
    double turn_mm_;
    int attempt_;
    bool advancing_ = true;
    double way_mm_ = 0.0;
    Turn begin_;    ///< Start of this motion forward or back.
    Turn extreme_;  ///< Its farthest point.
  };
  void Keep(std::vector<NeedlePass>& passes, const std::optional<NeedlePass>& pass) const;

  InsideTissue inside_;
  PassOptions options_;
  std::vector<NeedlePass> ended_;
  std::optional<TurnFinder> turns_;  ///< During an attempt.
  int num_attempts_ = 0;
  Eigen::Vector3d left_mm_ = Eigen::Vector3d::Zero();  ///< The last position of the tip in tissue.
  std::optional<Eigen::Vector3d> last_mm_;
};

}  // namespace acus::training
