#include "acus/base/config/json_from_child.h"

#include "acus/base/core/error.h"

namespace acus::config {
namespace {

#ifdef ACUS_FUZZING
constexpr bool kIsFuzzed = true;  // The fuzzer has limits of its own, and follows branches.
#else
constexpr bool kIsFuzzed = false;
#endif

nlohmann::json JsonFromHere(const std::function<nlohmann::json()>& work) {
  try {
    return work();
  } catch (const std::exception& error) {
    throw InputError(error.what());
  }
}

}  // namespace

nlohmann::json JsonFromChild(const core::ChildLimits& limits, const std::string& failure,
                             const std::function<nlohmann::json()>& work) {
  if (kIsFuzzed) return JsonFromHere(work);
  const core::ChildResult result = core::RunInChild([&] { return work().dump(); }, limits);
  if (result.end == core::ChildResult::End::kThrew) throw InputError(result.problem);
  ACUS_REQUIRE(result.end == core::ChildResult::End::kDone, failure, " (", result.problem, ")");
  return nlohmann::json::parse(result.bytes);
}

}  // namespace acus::config
