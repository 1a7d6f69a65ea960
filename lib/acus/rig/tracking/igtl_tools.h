// From named transforms in messages to readings of our tools.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <string_view>
#include <vector>

#include "acus/rig/tracking/clock_estimate.h"
#include "acus/rig/tracking/igtl_source.h"
#include "acus/rig/tracking/igtl_wire.h"
#include "acus/rig/tracking/pose_board.h"

namespace acus::tracking {

/// When a message was stamped, by its sender, and when it came. ns.
struct MessageTimes {
  std::int64_t source_ns = 0;  ///< 0 if there is no stamp.
  std::int64_t arrival_ns = 0;
};

/// Assigns the transforms in the messages to tools, composes, checks, publishes and
/// counts. Used by one thread.
class IgtlTools {
 public:
  /// @throws InputError as IgtlSource does.
  IgtlTools(const std::vector<IgtlTool>& tools, std::int64_t lost_after_ns, PoseBoard& board);

  /// One transform (TRANSFORM, POSITION). `seen` is what the sender says of it.
  void Take(std::string_view device, const Eigen::Matrix4d& matrix, bool seen,
            const MessageTimes& times);
  /// All tools that a tracker sees at an instant (TDATA, QTDATA): one that the same `list` had
  /// before and omits now is not seen.
  void TakeAll(const std::string& list, const std::vector<ToolMatrix>& tools,
               const MessageTimes& times);
  /// Publishes as not seen what was silent for too long. Call about 50 times a second.
  void PublishSilent(std::int64_t now_ns);
  /// Publishes all tools as not seen, and forgets the clock of the peer.
  void LinkLost(std::int64_t now_ns);

  const SourceCounts& counts() const { return counts_; }
  const std::vector<std::string>& other_names() const { return other_names_; }
  ClockStatus clock() const;
  /// Why each tool is not seen, in the order of the tools; empty where it is.
  std::vector<std::string> WhyNotSeen() const;

 private:
  /// A transform as it last came.
  struct Transform {
    std::string device;
    Eigen::Isometry3d frame_from_marker = Eigen::Isometry3d::Identity();
    bool is_good = false;  ///< Seen, finite and rigid.
    bool is_seen = false;
    bool is_finite = true;
    bool is_mirrored = false;
    double off_rigid = 0.0;         ///< Largest element of R^T R - I.
    std::string list = {};          ///< Name of the TDATA that had it; empty if none had.
    std::uint64_t list_number = 0;  ///< Which of them.
    MessageTimes times = {};
  };
  struct Tool {
    std::size_t device;
    std::size_t relative_to;  ///< kNone if not.
    Eigen::Isometry3d marker_from_tool;
    std::int64_t last_source_ns = 0;
    std::int64_t last_news_ns = 0;
    bool is_lost = true;  ///< Nothing good was published since it was lost.
  };
  static constexpr std::size_t kNone = SIZE_MAX;

  std::string TroubleOf(const Transform& transform) const;
  std::size_t FindOrAdd(const std::string& device);
  std::size_t Find(std::string_view device) const;
  void Update(Transform& transform, const Eigen::Matrix4d& matrix, bool seen,
              const MessageTimes& times);
  void PublishToolsOf(std::size_t device);
  void Publish(std::size_t tool);
  void CountOther(std::string_view device);
  void ObserveClock(const MessageTimes& times);

  std::int64_t lost_after_ns_;
  PoseBoard& board_;
  std::vector<Transform> transforms_;
  std::vector<Tool> tools_;
  SourceCounts counts_;
  std::vector<std::string> other_names_;
  std::uint64_t lists_ = 0;
  ClockEstimate clock_;
  std::int64_t last_delay_ns_ = 0, max_delay_ns_ = 0, last_arrival_ns_ = 0;
};

}  // namespace acus::tracking
