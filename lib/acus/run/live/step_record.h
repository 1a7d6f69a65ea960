// What one step of a live session leaves behind.
#pragma once

#include <array>

#include "acus/data/session/session.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::live {

/// A plain value of fixed size, so that the real-time thread can hand it over.
struct StepRecord {
  static constexpr int kMaxCommands = 4;

  std::int64_t time_ns = 0;    ///< Session time.
  session::PoseSample needle;  ///< Exactly as the step got it.
  session::PoseSample probe;
  session::BreathSample breath;
  simulation::StepOutput output;
  std::array<session::Command, kMaxCommands> command{};  ///< Carried out in this step.
  int num_commands = 0;
};

}  // namespace acus::live
