// Simulates an exercise by a virtual trainee: a closed loop of eye, hand and simulated tissue.
#pragma once

#include <string>

#include "acus/assess/trials/planned_path.h"
#include "acus/assess/trials/trainee.h"

namespace acus::trials {

struct SimulatedTrial {
  session::Session session;
  int num_corrections = 0;
  int num_bone_contacts = 0;  ///< Contacts after which the needle was withdrawn.
};

/// An empty session with the streams of trainees: needle and probe.
session::Session LikeTrainees();

/// One trial. In order: the probe searches; the needle is aimed and advanced in stretches with
/// stops; at a stop the person perceives, with a delay of `delay_s`, the distance between the
/// needle's line and the assumed target, and if that exceeds `notice_mm`, withdraws, rotates the
/// needle about the entry and advances again; the simulated resistance of bone also causes a
/// withdrawal. The needle stops at the assumed depth of the target. Tremor and drift are added to
/// both hands; tissue halves those of the needle. At most three minutes.
///
/// The same inputs give the same bits. @param trial  From 1 on; with `code` and `seed` the key of
/// all draws.
SimulatedTrial SimulateTrial(const TrialScene& scene, const PlannedPath& path,
                             const TraineeSkill& grade, const std::string& code, int trial,
                             std::uint64_t seed, double rate_hz);

}  // namespace acus::trials
