#include "acus/assess/dataset/frame_moments.h"

#include <algorithm>
#include <cmath>

namespace acus::dataset {
namespace {

/// The centres of `count` equal parts of the list; all of it if it is shorter.
void AppendSpread(const std::vector<std::int64_t>& times_ns, std::size_t count,
                  std::vector<std::int64_t>& out) {
  count = std::min(count, times_ns.size());
  for (std::size_t n = 0; n < count; ++n) {
    out.push_back(times_ns[(2 * n + 1) * times_ns.size() / (2 * count)]);
  }
}

}  // namespace

std::vector<std::int64_t> FrameMoments(
    const session::PoseStream& needle,
    const std::function<bool(const session::PoseSample&)>& inserted, int count,
    double inserted_share) {
  std::vector<std::int64_t> in_body_ns;
  std::vector<std::int64_t> outside_ns;
  for (const session::PoseSample& sample : needle) {
    (inserted(sample) ? in_body_ns : outside_ns).push_back(sample.time_ns);
  }
  const auto wanted = static_cast<std::size_t>(count);
  auto in_body = static_cast<std::size_t>(std::lround(inserted_share * count));
  in_body = std::min(in_body, in_body_ns.size());
  const std::size_t outside = std::min(wanted - in_body, outside_ns.size());
  std::vector<std::int64_t> times_ns;
  AppendSpread(in_body_ns, wanted - outside, times_ns);
  AppendSpread(outside_ns, outside, times_ns);
  std::ranges::sort(times_ns);
  return times_ns;
}

}  // namespace acus::dataset
