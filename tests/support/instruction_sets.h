// Code that exists once for each instruction set (Highway).
#pragma once

#include <cstdint>
#include <hwy/highway.h>

namespace acus::testing_support {

/// Calls `body` with the name of each instruction set that this machine has, which is then in use.
template <typename Body>
void OnEveryInstructionSet(const Body& body) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    body(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace acus::testing_support
