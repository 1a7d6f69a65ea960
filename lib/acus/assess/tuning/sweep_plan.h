// The plan of a sweep: one parameter at a time, or all combinations.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acus/assess/tuning/case_run.h"
#include "acus/assess/tuning/knob.h"
#include "acus/base/core/run_context.h"

namespace acus::tuning {

/// Largest number of combinations that are run; of more, a seeded subset is used.
constexpr int kMostCombinations = 200;

/// The user's request.
struct SweepRequest {
  SweptScene scene;
  std::vector<std::string>
      knobs;  ///< "needle_nodes" or "needle_nodes=15,50"; empty: all that exist.
  bool jointly = false;
  int repetitions = 3;
  std::uint64_t seed = 0;  ///< Repetition r has the seed `seed` + r, for every setting.
  int most_combinations = kMostCombinations;
};

/// One run. Cases of the same reference and repetition are compared with the same series.
struct Case {
  std::string name;  ///< Base name of its file: "needle_nodes-15-r0".
  std::string knob;  ///< The parameter of the sweep; "jointly".
  Setting setting;
  int repetition = 0;
  bool is_reference = false;   ///< It makes the reference.
  std::string reference;       ///< Name of the reference's file.
  std::string reference_case;  ///< Name of the case that makes it.
  Setting reference_setting;
};

/// A value that this scene does not allow.
struct LeftOut {
  std::string knob;
  std::string value;
  std::string why;
};

struct SweepPlan {
  SweepRequest request;
  std::vector<Knob> knobs;  ///< Swept parameters, with the values that are run, cheap to expensive.
  std::vector<Case> cases;  ///< References before the cases that are compared with them.
  std::vector<LeftOut> left_out;
  bool is_subset = false;     ///< Not all combinations.
  double combinations = 0.0;  ///< Number of all joint combinations.
  bool one_reference = true;  ///< One for all repetitions: nothing in the scene is random.

  // Data of scenario and session.
  std::string scenario_name;
  double seconds = 0.0;
  double step_period_ms = 0.0;
  double image_period_ms = 0.0;  ///< 0: the scene has no images.
};

/// Reads scenario and session, and plans. Values that the scene does not allow (another effect is
/// missing, or an input) are omitted; if the user named them, that is an error.
/// @throws InputError for an unknown parameter or value, or if no parameter remains.
SweepPlan MakePlan(const SweepRequest& request, const RunContext& context);

/// One run of a joint setting, by the index of each parameter of the plan, compared with the most
/// expensive of all.
Case JointCase(const SweepPlan& plan, const std::vector<int>& indices, int repetition);

/// The identity of the sweep: scenario with its changes, session by its hash, parameters, and the
/// build of the program. Two plans with the same identity have the same cases, except for the
/// number of repetitions, which may differ.
nlohmann::json IdentityOf(const SweepPlan& plan);

/// `count` combinations of values (sizes[k] of knob k), each a list of indices: every index
/// of a knob as often as any other, by a seeded Latin hypercube (McKay, Beckman & Conover 1979), no
/// combination twice. @pre count is at most the number of combinations.
std::vector<std::vector<int>> SpreadCombinations(const std::vector<int>& sizes, int count,
                                                 std::uint64_t seed);

}  // namespace acus::tuning
