// A virtual trainee does an exercise: a closed loop of eye, hand and simulated tissue.
#pragma once

#include <string>

#include "acus/assess/trials/planned_path.h"
#include "acus/assess/trials/trainee.h"

namespace acus::trials {

struct SimulatedTrial {
  session::Session session;
  int num_corrections = 0;
  int num_bone_contacts = 0;  ///< After which the needle was withdrawn.
};

/// A session with needle and probe, as trainees make them: which streams there are.
session::Session LikeTrainees();

/// One trial. In order: the probe searches; the needle is aimed and advanced in stretches with
/// stops; at a stop the person sees, by `delay_s` late, by how much the line of the needle misses
/// where he takes the target to be, and if that is more than `notice_mm`, withdraws, turns the
/// needle about the entry and advances again; resistance of bone, as the simulation gives it, makes
/// him withdraw too. The needle is stopped at the depth where he takes the target to be. Tremor and
/// drift are added to both hands; tissue halves those of the needle. At most three minutes.
///
/// The same inputs give the same bits. @param trial  From 1 on; with `code` and `seed` it keys all
/// draws.
SimulatedTrial SimulateTrial(const TrialScene& scene, const PlannedPath& path,
                             const TraineeSkill& grade, const std::string& code, int trial,
                             std::uint64_t seed, double rate_hz);

}  // namespace acus::trials
