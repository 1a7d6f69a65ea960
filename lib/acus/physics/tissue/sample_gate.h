// What a model does with samples that it cannot step on, the same as every force model.
#pragma once

#include "acus/physics/forces/path/sample_gate.h"
#include "acus/physics/tissue/tool_sample.h"

namespace acus::tissue {

/// Part of a model's state. A plain value.
struct SampleGate : forces::SampleGate {
  Verdict Judge(const ToolSample& sample) noexcept {
    return forces::SampleGate::Judge(sample.time_s, sample.needle_valid, sample.tip_in_ct_mm,
                                     sample.axis_in_ct);
  }
  void Accept(const ToolSample& sample, const forces::NeedleForce& force) noexcept {
    forces::SampleGate::Accept(sample.time_s, force);
  }
};

using forces::FirstOf;
using forces::LimitTo;
using forces::Scale;

}  // namespace acus::tissue
