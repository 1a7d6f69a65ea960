#include "acus/rig/tracking/simulators/faults.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/data/session/pose_csv.h"

namespace acus::simulators {
namespace {

constexpr std::pair<std::string_view, FaultKind> kKinds[] = {
    {"drop", FaultKind::kDrop}, {"freeze", FaultKind::kFreeze}, {"occlude", FaultKind::kOcclude},
    {"nan", FaultKind::kNan},   {"jump", FaultKind::kJump},     {"garbage", FaultKind::kGarbage}};

}  // namespace

Fault ParseFault(std::string_view text) {
  const auto at = text.find('@');
  const auto colon = text.find(':');
  const std::string_view name = text.substr(0, at);
  const auto kind = std::find_if(std::begin(kKinds), std::end(kKinds),
                                 [&](const auto& row) { return row.first == name; });
  std::optional<std::int64_t> begin_ns, length_ns = 1'000'000'000;
  if (at != std::string_view::npos) {
    const auto end = colon == std::string_view::npos ? text.size() : colon;
    begin_ns = session::NanosecondsFromText(text.substr(at + 1, end - at - 1));
    if (colon != std::string_view::npos) {
      length_ns = session::NanosecondsFromText(text.substr(colon + 1));
    }
  }
  const bool is_good =
      kind != std::end(kKinds) && begin_ns && *begin_ns >= 0 && length_ns && *length_ns > 0;
  ACUS_REQUIRE(is_good, "fault '", text,
               "' is not understood; write drop, freeze, occlude, nan, jump or garbage, when it "
               "begins and how long it lasts in seconds, as in occlude@5:2");
  return {.kind = kind->second, .begin_ns = *begin_ns, .end_ns = *begin_ns + *length_ns};
}

std::string FaultProblem(const std::string& text) {
  try {
    ParseFault(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool IsOn(const std::vector<Fault>& faults, FaultKind kind, std::int64_t time_ns) {
  return std::any_of(faults.begin(), faults.end(), [&](const Fault& fault) {
    return fault.kind == kind && time_ns >= fault.begin_ns && time_ns < fault.end_ns;
  });
}

}  // namespace acus::simulators
