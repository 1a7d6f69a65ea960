#include "session/session.h"

#include <algorithm>

#include "core/error.h"
#include "math/rigid.h"

namespace acus::session {

PoseSample PoseAt(const PoseStream& stream, std::int64_t time_ns) {
  ACUS_ASSERT(!stream.empty());
  const auto after = std::ranges::lower_bound(stream, time_ns, {}, &PoseSample::time_ns);
  if (after == stream.begin()) return stream.front();
  if (after == stream.end()) return stream.back();
  const PoseSample& a = *(after - 1);
  const PoseSample& b = *after;
  const double fraction =
      static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  return {time_ns, math::Interpolate(a.reference_from_tool, b.reference_from_tool, fraction),
          a.valid && b.valid};
}

}  // namespace acus::session
