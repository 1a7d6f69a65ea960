#include <algorithm>
#include <cmath>
#include <set>

#include "acus/assess/trials/what_if.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/angles.h"

namespace acus::trials {
namespace {

constexpr double kSmallestMm = 0.5;
constexpr double kSmallestDeg = 0.5;

void Append(std::string& text, const std::string& part) {
  text += (text.empty() ? "" : ", ") + part;
}

std::string Degrees(double rad) {
  return FixedText(std::abs(rad) / math::kRadPerDegree, 0) +
         (std::abs(rad) < 1.5 * math::kRadPerDegree ? " degree" : " degrees");
}

/// Near the normal, a change is a tilt; otherwise the needle becomes steeper or flatter.
std::string SteeperText(const TrialLine& line, double steeper_rad) {
  constexpr double kUpright = 0.94;  // Cosine of 20 degrees.
  if (line.axis_in_ct.dot(line.inward_in_ct) < kUpright) {
    return Degrees(steeper_rad) + (steeper_rad > 0.0 ? " steeper" : " flatter");
  }
  const double sign = steeper_rad > 0.0 ? -1.0 : 1.0;
  return "tip turned " + Degrees(steeper_rad) + " towards " +
         PatientDirection(sign * line.along_in_ct);
}

std::set<std::string> AvoidedOf(const training::Assessment& assessment,
                                const std::vector<std::string>& avoid) {
  std::set<std::string> entered;
  for (const training::NamedStructure& s : assessment.structures) {
    if (s.entered.num_entries > 0 && std::ranges::find(avoid, s.name) != avoid.end()) {
      entered.insert(s.name);
    }
  }
  return entered;
}

std::string AndList(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " and ") + name;
  return text;
}

std::set<std::string> Without(const std::set<std::string>& names,
                              const std::set<std::string>& others) {
  std::set<std::string> rest;
  std::ranges::set_difference(names, others, std::inserter(rest, rest.end()));
  return rest;
}

}  // namespace

std::string ChangeText(const TrialLine& line, const InsertionChange& change) {
  std::string text;
  const Eigen::Vector3d moved_mm =
      change.along_mm * line.along_in_ct + change.across_mm * line.across_in_ct;
  if (moved_mm.norm() >= kSmallestMm) {
    Append(text, Message("entry ", FixedText(moved_mm.norm(), 0), " mm towards ",
                         PatientDirection(moved_mm)));
  }
  if (std::abs(change.steeper_rad) >= kSmallestDeg * math::kRadPerDegree) {
    Append(text, SteeperText(line, change.steeper_rad));
  }
  if (std::abs(change.sideways_rad) >= kSmallestDeg * math::kRadPerDegree) {
    const double sign = change.sideways_rad > 0.0 ? 1.0 : -1.0;
    Append(text, "tip turned " + Degrees(change.sideways_rad) + " towards " +
                     PatientDirection(sign * line.across_in_ct));
  }
  if (std::abs(change.depth_mm) >= kSmallestMm) {
    Append(text, Message(FixedText(std::abs(change.depth_mm), 0), " mm ",
                         change.depth_mm > 0.0 ? "deeper" : "less deep"));
  }
  if (std::abs(std::log(change.speed_factor)) >= 0.1) {
    Append(text, Message(FixedText(change.speed_factor, 1), " times as fast"));
  }
  if (change.breath_cycles > 0.05) {
    Append(text, Message(FixedText(change.breath_cycles, 2), " of a breath later"));
  }
  return text.empty() ? "as in the trial" : text;
}

std::string OutcomeText(const WhatIf& what_if, const Outcome& outcome,
                        const std::vector<std::string>& avoid) {
  const training::Assessment& before = what_if.outcomes.front().result.assessment;
  const training::Assessment& now = outcome.result.assessment;
  const auto entered = AvoidedOf(now, avoid);
  const auto entered_before = AvoidedOf(before, avoid);
  std::string text;
  if (const auto missed = Without(entered_before, entered); !missed.empty()) {
    Append(text, "misses " + AndList(missed));
  }
  if (!entered.empty()) Append(text, "enters " + AndList(entered));
  const auto distance_mm = ValueOf(now, "tip to target at the end");
  const auto before_mm = ValueOf(before, "tip to target at the end");
  if (distance_mm && before_mm) {
    Append(text, Message("ends ", FixedText(*distance_mm, 1), " mm from the target (",
                         FixedText(*before_mm, 1), " mm)"));
  }
  Append(text, Message(now.NumMet(), " of ", now.goals.size(), " goals met"));
  return text;
}

}  // namespace acus::trials
