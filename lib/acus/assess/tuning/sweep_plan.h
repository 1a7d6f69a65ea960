// What is to be run: one knob at a time, or all combinations.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acus/assess/tuning/case_run.h"
#include "acus/assess/tuning/knob.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// Combinations that are run at most; of more, a seeded subset is.
constexpr int kMostCombinations = 200;

/// What the user asked for.
struct SweepRequest {
  SweptScene scene;
  std::vector<std::string>
      knobs;  ///< "needle_nodes" or "needle_nodes=15,50"; empty: all there are.
  bool jointly = false;
  int repetitions = 3;
  std::uint64_t seed = 0;  ///< Repetition r has the seed `seed` + r, for every setting.
  int most_combinations = kMostCombinations;
};

/// One run. Cases of the same reference and repetition are compared with the same series.
struct Case {
  std::string name;  ///< Of its file: "needle_nodes-15-r0".
  std::string knob;  ///< Whose sweep; "jointly".
  Setting setting;
  int repetition = 0;
  bool is_reference = false;   ///< It makes the reference.
  std::string reference;       ///< Name of the reference's file.
  std::string reference_case;  ///< Name of the case that makes it.
  Setting reference_setting;
};

/// A value that this scene cannot take.
struct LeftOut {
  std::string knob;
  std::string value;
  std::string why;
};

struct SweepPlan {
  SweepRequest request;
  std::vector<Knob> knobs;  ///< Those swept, with the values that are run, cheap to expensive.
  std::vector<Case> cases;  ///< References before what is compared with them.
  std::vector<LeftOut> left_out;
  bool is_subset = false;     ///< Not all combinations.
  double combinations = 0.0;  ///< Of all values, jointly.
  bool one_reference = true;  ///< All repetitions have the same: nothing in the scene is random.

  // Of scenario and session.
  std::string scenario_name;
  double seconds = 0.0;
  double step_period_ms = 0.0;
  double image_period_ms = 0.0;  ///< 0: the scene has no images.
};

/// Reads scenario and session, and plans. ValueIndices that the scene cannot take (another effect
/// is missing, or an input) are left out; if the user named them, that is an error.
/// @throws InputError for a knob or value that is not there, or if nothing is left to turn.
SweepPlan MakePlan(const SweepRequest& request, const RunContext& context);

/// One run of a joint setting, by the index of each knob of the plan, against the most expensive of
/// all.
Case JointCase(const SweepPlan& plan, const std::vector<int>& indices, int repetition);

/// What identifies the sweep: scenario with its changes, session by its hash, knobs, and the build
/// of the program. Two plans with the same identity have the same cases, but for the number of
/// repetitions: there may be more another time.
nlohmann::json IdentityOf(const SweepPlan& plan);

/// `count` combinations of values (sizes[k] of knob k), each a list of indices: every index
/// of a knob as often as any other, by a seeded Latin hypercube (McKay, Beckman & Conover 1979), no
/// combination twice. @pre count is at most the number of combinations.
std::vector<std::vector<int>> SpreadCombinations(const std::vector<int>& sizes, int count,
                                                 std::uint64_t seed);

}  // namespace acus::tuning
