// The record of one step of a live session.
#pragma once

#include <array>

#include "acus/data/session/session.h"
#include "acus/scene/simulation/simulation.h"

namespace acus::live {

/// A plain value of fixed size, so that the real-time thread can pass it on.
struct StepRecord {
  static constexpr int kMaxCommands = 4;

  std::int64_t time_ns = 0;    ///< Session time.
  session::PoseSample needle;  ///< The exact input of the step.
  session::PoseSample probe;
  session::BreathSample breath;
  simulation::StepOutput output;
  std::array<session::Command, kMaxCommands> command{};  ///< Carried out in this step.
  int num_commands = 0;
};

}  // namespace acus::live
