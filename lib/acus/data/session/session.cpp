#include "acus/data/session/session.h"

#include <algorithm>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"

namespace acus::session {

PoseSample PoseAt(const PoseStream& stream, std::int64_t time_ns) {
  ACUS_ASSERT(!stream.empty());
  const auto after = std::ranges::lower_bound(stream, time_ns, {}, &PoseSample::time_ns);
  if (after == stream.end()) return stream.back();
  if (after == stream.begin() || after->time_ns == time_ns) return *after;
  const PoseSample& a = *(after - 1);
  const PoseSample& b = *after;
  const double fraction =
      static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  return {time_ns, math::Interpolate(a.reference_from_tool, b.reference_from_tool, fraction),
          a.valid && b.valid};
}

std::int64_t Session::start_ns() const {
  if (needle.empty()) return probe.empty() ? 0 : probe.front().time_ns;
  return probe.empty() ? needle.front().time_ns
                       : std::min(needle.front().time_ns, probe.front().time_ns);
}

}  // namespace acus::session
