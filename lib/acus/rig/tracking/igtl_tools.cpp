#include "acus/rig/tracking/igtl_tools.h"

#include <algorithm>
#include <cctype>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"

namespace acus::tracking {
namespace {

/// Names as they fit into a message.
std::string OnTheWire(const std::string& name) {
  return name.substr(0, kIgtlNameBytes);
}

constexpr double kRigidTolerance = 1e-3;
constexpr std::size_t kMaxOtherNames = 32;

}  // namespace

IgtlTools::IgtlTools(const std::vector<IgtlTool>& tools, std::int64_t lost_after_ns,
                     PoseBoard& board)
    : lost_after_ns_(lost_after_ns), board_(board) {
  for (const IgtlTool& tool : tools) {
    ACUS_REQUIRE(!tool.device.empty(), "tool '", tool.tool,
                 "': device is empty; it is the name of a transform, such as ProbeToReference");
    ACUS_REQUIRE(tool.relative_to != tool.device, "tool '", tool.tool, "': relative_to '",
                 tool.relative_to, "' is the device itself");
    ACUS_REQUIRE(math::IsRigid(tool.marker_from_tool.matrix()), "tool '", tool.tool,
                 "': its calibration is not a rigid transform");
    // In this order, since both may add to the transforms.
    const std::size_t device = FindOrAdd(tool.device);
    const std::size_t relative_to = tool.relative_to.empty() ? kNone : FindOrAdd(tool.relative_to);
    tools_.push_back({.device = device,
                      .relative_to = relative_to,
                      .marker_from_tool = tool.marker_from_tool,
                      .last_source_ns = 0,
                      .last_news_ns = 0,
                      .is_lost = true});
  }
}

std::size_t IgtlTools::Find(std::string_view device) const {
  const auto found = std::find_if(transforms_.begin(), transforms_.end(),
                                  [&](const Transform& t) { return t.device == device; });
  return found == transforms_.end() ? kNone : static_cast<std::size_t>(found - transforms_.begin());
}

std::size_t IgtlTools::FindOrAdd(const std::string& device) {
  const std::string name = OnTheWire(device);
  if (const std::size_t found = Find(name); found != kNone) return found;
  transforms_.push_back({.device = name});
  return transforms_.size() - 1;
}

void IgtlTools::CountOther(std::string_view device) {
  ++counts_.other_tools;
  const std::string name(device);
  if (other_names_.size() < kMaxOtherNames &&
      std::find(other_names_.begin(), other_names_.end(), name) == other_names_.end()) {
    other_names_.push_back(name);
  }
}

void IgtlTools::ObserveClock(const MessageTimes& times) {
  last_arrival_ns_ = times.arrival_ns;
  if (times.source_ns == 0) return;
  clock_.Observe(times.source_ns, times.arrival_ns);
  last_delay_ns_ = times.arrival_ns - clock_.OursNs(times.source_ns, times.arrival_ns);
  max_delay_ns_ = std::max(max_delay_ns_, last_delay_ns_);
}

void IgtlTools::Update(Transform& transform, const Eigen::Matrix4d& matrix, bool seen,
                       const MessageTimes& times) {
  transform.times = times;
  transform.is_seen = seen;
  transform.is_good = seen && math::IsRigid(matrix, kRigidTolerance);
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  transform.off_rigid =
      (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  transform.is_finite = matrix.allFinite();
  transform.is_mirrored = rotation.determinant() < 0.0;
  if (transform.is_good) transform.frame_from_marker.matrix() = matrix;
}

void IgtlTools::Take(std::string_view device, const Eigen::Matrix4d& matrix, bool seen,
                     const MessageTimes& times) {
  ObserveClock(times);
  const std::size_t found = Find(device);
  if (found == kNone) return CountOther(device);
  Update(transforms_[found], matrix, seen, times);
  PublishToolsOf(found);
}

void IgtlTools::TakeAll(const std::string& list, const std::vector<ToolMatrix>& tools,
                        const MessageTimes& times) {
  ObserveClock(times);
  ++lists_;
  const std::string name = list.empty() ? "?" : list;
  // All of an instant first, so that a tool and what it is relative to go together.
  for (const ToolMatrix& tool : tools) {
    const std::size_t found = Find(tool.name);
    if (found == kNone) {
      CountOther(tool.name);
      continue;
    }
    Update(transforms_[found], tool.matrix, true, times);
    transforms_[found].list = name;
    transforms_[found].list_number = lists_;
  }
  for (Transform& transform : transforms_) {
    if (transform.list != name || transform.list_number == lists_) continue;
    Update(transform, Eigen::Matrix4d::Identity(), false, times);
  }
  for (std::size_t i = 0; i < transforms_.size(); ++i) {
    if (transforms_[i].list == name) PublishToolsOf(i);
  }
}

void IgtlTools::PublishToolsOf(std::size_t device) {
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    if (tools_[i].device == device) Publish(i);
  }
}

void IgtlTools::Publish(std::size_t index) {
  Tool& tool = tools_[index];
  const Transform& own = transforms_[tool.device];
  bool is_seen = own.is_seen, is_good = own.is_good;
  Eigen::Isometry3d reference_from_tool = own.frame_from_marker * tool.marker_from_tool;
  if (tool.relative_to != kNone) {
    const Transform& base = transforms_[tool.relative_to];
    const bool is_fresh = own.times.arrival_ns - base.times.arrival_ns <= lost_after_ns_;
    is_seen = is_seen && base.is_seen && is_fresh;
    is_good = is_good && base.is_good && is_fresh;
    reference_from_tool = base.frame_from_marker.inverse() * reference_from_tool;
  }
  ++counts_.readings;
  if (!is_seen) ++counts_.not_seen;
  if (is_seen && !is_good) ++counts_.bad_poses;
  const MessageTimes& times = own.times;
  if (times.source_ns != 0 && times.source_ns < tool.last_source_ns) ++counts_.out_of_order;
  if (times.source_ns != 0 && times.source_ns == tool.last_source_ns) ++counts_.repeated;
  tool.last_source_ns = times.source_ns;
  tool.last_news_ns = times.arrival_ns;
  tool.is_lost = !is_good;
  TrackedPose reading{.time_ns = times.arrival_ns,
                      .source_time_ns = times.source_ns,
                      .measured_ns = times.arrival_ns,
                      .reference_from_tool = {},
                      .valid = is_good,
                      .number = 0};
  if (times.source_ns != 0) {
    reading.measured_ns = clock_.OursNs(times.source_ns, times.arrival_ns);
  }
  if (is_good) reading.reference_from_tool = reference_from_tool;
  board_.Publish(index, reading);
}

void IgtlTools::PublishSilent(std::int64_t now_ns) {
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    Tool& tool = tools_[i];
    if (tool.is_lost || now_ns - tool.last_news_ns < lost_after_ns_) continue;
    tool.is_lost = true;
    ++counts_.fell_silent;
    board_.Publish(i, {.time_ns = now_ns,
                       .source_time_ns = 0,
                       .measured_ns = now_ns,
                       .reference_from_tool = {},
                       .valid = false,
                       .number = 0});
  }
}

void IgtlTools::LinkLost(std::int64_t now_ns) {
  for (Tool& tool : tools_) {
    if (!tool.is_lost) tool.last_news_ns = now_ns - lost_after_ns_;
    tool.last_source_ns = 0;
  }
  PublishSilent(now_ns);
  for (Transform& transform : transforms_) {
    transform.is_good = transform.is_seen = false;
    transform.list.clear();
  }
  clock_ = {};
  last_delay_ns_ = max_delay_ns_ = 0;
}

std::string IgtlTools::TroubleOf(const Transform& transform) const {
  const std::string& name = transform.device;
  if (transform.times.arrival_ns == 0) {
    const auto same_letters = [](unsigned char a, unsigned char b) {
      return std::tolower(a) == std::tolower(b);
    };
    for (const std::string& other : other_names_) {
      if (std::ranges::equal(name, other, same_letters)) {
        return Message("no message is named '", name, "', but '", other,
                       "' is: names must have the same case");
      }
    }
    return Message("no message is named '", name, "'");
  }
  if (!transform.is_seen) return Message("'", name, "' says that it is not in view");
  if (transform.is_good) return {};
  if (!transform.is_finite) return Message("'", name, "' has a number that is not finite");
  if (transform.is_mirrored) return Message("the rotation of '", name, "' is mirrored");
  return Message("the rotation of '", name, "' is not rigid: R^T R differs from 1 by ",
                 transform.off_rigid, ", allowed are ", kRigidTolerance);
}

std::vector<std::string> IgtlTools::WhyNotSeen() const {
  std::vector<std::string> why;
  for (const Tool& tool : tools_) {
    std::string& text = why.emplace_back();
    if (!tool.is_lost) continue;
    text = TroubleOf(transforms_[tool.device]);
    if (text.empty() && tool.relative_to != kNone) text = TroubleOf(transforms_[tool.relative_to]);
  }
  return why;
}

ClockStatus IgtlTools::clock() const {
  if (!clock_.known()) return {};
  return {.known = true,
          .offset_ns = clock_.OffsetNs(last_arrival_ns_),
          .drift_ppm = clock_.drift_ppm(),
          .times_set = clock_.times_set(),
          .last_delay_ns = last_delay_ns_,
          .max_delay_ns = max_delay_ns_};
}

}  // namespace acus::tracking
