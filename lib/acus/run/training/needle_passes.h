// Attempts, passes and redirections: how often the needle was turned round on its way.
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
  std::int64_t begin_ns = 0;  ///< The entry, or where the needle was drawn back to.
  std::int64_t end_ns = 0;    ///< The deepest point.
  int attempt = 0;            ///< Insertions through the skin, from 0.
  double advance_mm = 0.0;    ///< Along the shaft.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();   ///< Of the needle at its deepest point.
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  ///< Of the tip there; frame of the stream.
  /// It follows another pass of the same attempt, in another direction.
  bool redirected = false;
};

struct PassOptions {
  /// A way forward or back along the shaft counts as such from this length on: shorter ones are
  /// tremor and feeling one's way. > 0.
  double turn_mm = 5.0;
  double redirection_rad = 0.0523598775598299;  ///< Smallest change of direction, 3 degrees. > 0.
  double withdrawal_mm = 5.0;  ///< As MetricOptions::withdrawal_mm: what ends an attempt. >= 0.
};

/// All passes of a needle stream, in order of time. The way along the shaft is the sum of the tip's
/// motions projected on the needle's axis, so that a sideways sweep is not a pass.
/// @param inside  Whether a point, in the stream's frame, lies in tissue.
/// @throws InputError if an option is out of its range.
/// @param swaps_ns  As ComputeMotionMetrics has them: an attempt ends when the needle changes
/// hands.
std::vector<NeedlePass> FindPasses(const session::PoseStream& needle, const InsideTissue& inside,
                                   const PassOptions& options = {},
                                   std::span<const std::int64_t> swaps_ns = {});

/// The same of samples as they come.
class PassMeter {
 public:
  /// @throws InputError if an option is out of its range.
  PassMeter(InsideTissue inside, const PassOptions& options);

  /// Samples that are not valid are passed over.
  void Add(const session::PoseSample& sample);
  void Restart();  ///< The needle has changed hands.
  /// As if the session ended now: with the pass that is under way, if it is long enough for one.
  std::vector<NeedlePass> passes() const;
  /// Those without a pass included.
  int num_attempts() const { return num_attempts_; }
  bool in_attempt() const { return turns_.has_value(); }

 private:
  struct Turn {
    double way_mm = 0.0;
    session::PoseSample sample;
  };
  /// Follows the way along the shaft within one attempt and finds where it turns.
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
    Turn begin_;    ///< Where this way forward or back began.
    Turn extreme_;  ///< The farthest that it went.
  };
  void Keep(std::vector<NeedlePass>& passes, const std::optional<NeedlePass>& pass) const;

  InsideTissue inside_;
  PassOptions options_;
  std::vector<NeedlePass> ended_;
  std::optional<TurnFinder> turns_;  ///< While an attempt lasts.
  int num_attempts_ = 0;
  Eigen::Vector3d left_mm_ = Eigen::Vector3d::Zero();  ///< Where the tip was last in tissue.
  std::optional<Eigen::Vector3d> last_mm_;
};

}  // namespace acus::training
