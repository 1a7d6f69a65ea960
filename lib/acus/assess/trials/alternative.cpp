#include "acus/assess/trials/alternative.h"

#include <algorithm>
#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/random.h"
#include "acus/base/math/angles.h"

namespace acus::trials {
namespace {

using math::kRadPerDegree;

constexpr double kLeastDepthMm = 5.0;
/// A needle at a smaller angle to the skin (sine) is no insertion.
constexpr double kLeastInward = 0.2;
constexpr int kDraws = 50;

/// The angle of the axis in the plane of along and inward.
double SteepnessRad(const TrialLine& line, const Eigen::Vector3d& axis) {
  return std::atan2(axis.dot(line.inward_in_ct), axis.dot(line.along_in_ct));
}

double SidewaysRad(const TrialLine& line, const Eigen::Vector3d& axis) {
  return std::asin(std::clamp(axis.dot(line.across_in_ct), -1.0, 1.0));
}

Eigen::Vector3d AxisAt(const TrialLine& line, double steepness_rad, double sideways_rad) {
  const Eigen::Vector3d leaning =
      std::cos(steepness_rad) * line.along_in_ct + std::sin(steepness_rad) * line.inward_in_ct;
  return std::cos(sideways_rad) * leaning + std::sin(sideways_rad) * line.across_in_ct;
}

bool IsUnchanged(const InsertionChange& change) {
  return change.along_mm == 0.0 && change.across_mm == 0.0 && change.steeper_rad == 0.0 &&
         change.sideways_rad == 0.0;
}

/// One value at a time: half and full range in both directions.
std::vector<InsertionChange> SingleChanges(const WhatIfSettings& settings, bool breathes) {
  std::vector<InsertionChange> changes(1);
  const double tilt_rad = settings.tilt_deg * kRadPerDegree;
  for (const double part : {-1.0, -2.0 / 3.0, -1.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0, 1.0}) {
    changes.push_back({.along_mm = part * settings.entry_mm});
    changes.push_back({.across_mm = part * settings.entry_mm});
    changes.push_back({.steeper_rad = part * tilt_rad});
    changes.push_back({.sideways_rad = part * tilt_rad});
    changes.push_back({.depth_mm = part * settings.depth_mm});
    changes.push_back({.speed_factor = std::pow(settings.speed_factor, part)});
  }
  if (breathes) {
    for (const double cycles : {0.25, 0.5, 0.75}) changes.push_back({.breath_cycles = cycles});
  }
  return changes;
}

InsertionChange RandomChange(const WhatIfSettings& settings, bool breathes, RandomStream& random) {
  const auto within = [&random](double most) { return random.Uniform(-most, most); };
  InsertionChange change;
  change.along_mm = within(settings.entry_mm);
  change.across_mm = within(settings.entry_mm);
  change.steeper_rad = within(settings.tilt_deg * kRadPerDegree);
  change.sideways_rad = within(settings.tilt_deg * kRadPerDegree);
  change.depth_mm = within(settings.depth_mm);
  change.speed_factor = std::pow(settings.speed_factor, within(1.0));
  const double cycles = random.Uniform();
  if (breathes) change.breath_cycles = cycles;
  return change;
}

/// The same entry, speed and breath, pointed at the target.
std::optional<Alternative> Aimed(const TrialScene& scene, const TrialLine& line,
                                 InsertionChange change, const WhatIfSettings& settings,
                                 RandomStream& random) {
  const Eigen::Vector3d from_mm =
      line.entry_ct_mm + change.along_mm * line.along_in_ct + change.across_mm * line.across_in_ct;
  const Eigen::Vector3d to_target = (*scene.target_ct_mm - from_mm).normalized();
  const double jitter_rad = settings.aim_jitter_deg * kRadPerDegree;
  change.steeper_rad = SteepnessRad(line, to_target) - SteepnessRad(line, line.axis_in_ct) +
                       jitter_rad * random.Normal();
  change.sideways_rad = SidewaysRad(line, to_target) - SidewaysRad(line, line.axis_in_ct) +
                        jitter_rad * random.Normal();
  change.depth_mm = 0.0;
  const auto at_skin = ChangedInsertion(scene, line, change, settings);
  if (!at_skin) return std::nullopt;
  change.depth_mm = (*scene.target_ct_mm - at_skin->entry_ct_mm).norm() - line.depth_mm +
                    settings.aim_jitter_mm * random.Normal();
  auto aimed = ChangedInsertion(scene, line, change, settings);
  if (aimed) aimed->aimed = true;
  return aimed;
}

Alternative Drawn(const TrialScene& scene, const TrialLine& line, const WhatIfSettings& settings,
                  bool breathes, RandomStream& random) {
  const bool aims = random.Uniform() < settings.aimed_share && scene.target_ct_mm.has_value();
  for (int draw = 0; draw < kDraws; ++draw) {
    const InsertionChange change = RandomChange(settings, breathes, random);
    const auto alternative = aims ? Aimed(scene, line, change, settings, random)
                                  : ChangedInsertion(scene, line, change, settings);
    if (alternative) return *alternative;
  }
  throw InputError(Message("no insertion within the ranges meets the skin in ", kDraws,
                           " draws; make entry_mm and tilt_deg smaller"));
}

/// The phase of the breath in its cycle; nothing without breath.
std::optional<double> CycleAt(const TrialScene& scene, const session::Session& trial,
                              std::int64_t time_ns) {
  if (!scene.scene.breathing) return std::nullopt;
  if (scene.scene.breathing->from_session) return session::BreathAt(trial.breath, time_ns).cycle;
  return scene.scene.breathing->NormalAt(1e-9 * static_cast<double>(time_ns - trial.start_ns()))
      .cycle;
}

/// The first time from `time_ns` on at which the breath is later in its cycle by `cycles`;
/// `time_ns` itself if there is none within half a minute, such as in a patient who holds the
/// breath.
std::int64_t LaterInBreath(const TrialScene& scene, const session::Session& trial,
                           std::int64_t time_ns, double cycles) {
  const auto begin = CycleAt(scene, trial, time_ns);
  if (!begin || cycles <= 0.0) return time_ns;
  constexpr std::int64_t kLookNs = 10'000'000;
  constexpr int kLooks = 3000;
  for (int i = 1; i <= kLooks; ++i) {
    const std::int64_t later_ns = time_ns + kLookNs * i;
    const double gone = *CycleAt(scene, trial, later_ns) - *begin;
    if (gone - std::floor(gone) >= cycles) return later_ns;
  }
  return time_ns;
}

}  // namespace

WhatIfSettings ReadWhatIfSettings(const std::filesystem::path& path) {
  const nlohmann::json file = config::ReadConfig(path, "acus-what-if");
  const nlohmann::json& ranges = file.at("ranges");
  const nlohmann::json& aimed = file.at("aimed");
  const nlohmann::json& motion = file.at("motion");
  WhatIfSettings settings;
  settings.count = file.at("count");
  settings.best = file.at("best");
  settings.entry_mm = ranges.at("entry_mm");
  settings.tilt_deg = ranges.at("tilt_deg");
  settings.depth_mm = ranges.at("depth_mm");
  settings.speed_factor = ranges.at("speed_factor");
  settings.breath = ranges.at("breath");
  settings.aimed_share = aimed.at("share");
  settings.aim_jitter_deg = aimed.at("jitter_deg");
  settings.aim_jitter_mm = aimed.at("jitter_mm");
  settings.lead_mm = motion.at("lead_mm");
  settings.slowest_mm_per_s = motion.at("slowest_mm_per_s");
  settings.fastest_mm_per_s = motion.at("fastest_mm_per_s");
  ACUS_REQUIRE(settings.slowest_mm_per_s <= settings.fastest_mm_per_s, path.string(),
               ": /motion: slowest_mm_per_s ", settings.slowest_mm_per_s,
               " lies above fastest_mm_per_s ", settings.fastest_mm_per_s);
  settings.rest_s = motion.at("rest_s");
  settings.rate_hz = motion.at("rate_hz");
  return settings;
}

std::optional<Alternative> ChangedInsertion(const TrialScene& scene, const TrialLine& line,
                                            const InsertionChange& change,
                                            const WhatIfSettings& settings) {
  Alternative alternative;
  alternative.change = change;
  alternative.depth_mm = std::max(kLeastDepthMm, line.depth_mm + change.depth_mm);
  alternative.speed_mm_per_s = std::clamp(line.speed_mm_per_s * change.speed_factor,
                                          settings.slowest_mm_per_s, settings.fastest_mm_per_s);
  alternative.entry_ct_mm = line.entry_ct_mm;
  alternative.axis_in_ct = line.axis_in_ct;
  if (IsUnchanged(change)) return alternative;  // With the same bits.
  alternative.axis_in_ct = AxisAt(line, SteepnessRad(line, line.axis_in_ct) + change.steeper_rad,
                                  SidewaysRad(line, line.axis_in_ct) + change.sideways_rad);
  if (alternative.axis_in_ct.dot(line.inward_in_ct) < kLeastInward) return std::nullopt;
  const Eigen::Vector3d moved_mm =
      line.entry_ct_mm + change.along_mm * line.along_in_ct + change.across_mm * line.across_in_ct;
  const auto entry = EntryOfLine(scene, moved_mm, alternative.axis_in_ct);
  if (!entry) return std::nullopt;
  alternative.entry_ct_mm = *entry;
  return alternative;
}

std::vector<Alternative> MakeAlternatives(const TrialScene& scene, const TrialLine& line,
                                          const WhatIfSettings& settings, bool breathes,
                                          std::uint64_t seed) {
  const bool other_breath = breathes && settings.breath;
  std::vector<Alternative> alternatives;
  for (const InsertionChange& change : SingleChanges(settings, other_breath)) {
    if (static_cast<int>(alternatives.size()) >= settings.count) break;
    const auto alternative = ChangedInsertion(scene, line, change, settings);
    if (alternative) alternatives.push_back(*alternative);
  }
  while (static_cast<int>(alternatives.size()) < settings.count) {
    RandomStream random(seed, "what-if", alternatives.size());
    alternatives.push_back(Drawn(scene, line, settings, other_breath, random));
  }
  return alternatives;
}

double DurationOf(double length_mm, double speed_mm_per_s, double ramp_s) {
  const double ramps_mm = speed_mm_per_s * ramp_s;  // Acceleration and deceleration together.
  if (length_mm >= ramps_mm) return length_mm / speed_mm_per_s + ramp_s;
  return 2.0 * std::sqrt(length_mm * ramp_s / speed_mm_per_s);
}

double DistanceAfter(double time_s, double length_mm, double speed_mm_per_s, double ramp_s) {
  const double whole_s = DurationOf(length_mm, speed_mm_per_s, ramp_s);
  const double acceleration = speed_mm_per_s / ramp_s;
  if (time_s <= 0.0) return 0.0;
  if (time_s >= whole_s) return length_mm;
  const double rise_s = std::min(ramp_s, 0.5 * whole_s);
  if (time_s <= rise_s) return 0.5 * acceleration * time_s * time_s;
  const double left_s = whole_s - time_s;
  if (left_s <= rise_s) return length_mm - 0.5 * acceleration * left_s * left_s;
  return speed_mm_per_s * (time_s - 0.5 * rise_s);
}

session::Session SessionOf(const TrialScene& scene, const session::Session& trial,
                           const TrialLine& line, const Alternative& alternative,
                           const WhatIfSettings& settings) {
  constexpr double kRampS = 0.1;
  const Eigen::Isometry3d reference_from_ct = scene.scene.ct_from_reference.inverse();
  // The needle is rotated without rolling.
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond::FromTwoVectors(line.axis_in_ct, alternative.axis_in_ct);
  const Eigen::Quaterniond rotation(reference_from_ct.linear() *
                                    (IsUnchanged(alternative.change)
                                         ? Eigen::Matrix3d(line.ct_from_tip.linear())
                                         : turn.toRotationMatrix() * line.ct_from_tip.linear()));
  const double length_mm = settings.lead_mm + alternative.depth_mm;
  const double speed = alternative.speed_mm_per_s;
  const double end_s = DurationOf(length_mm, speed, kRampS) + settings.rest_s;

  session::Session session;
  session.name = trial.name + ", changed";
  session.reference_frame = trial.reference_frame;
  session.breath = trial.breath;
  const std::int64_t start_ns = trial.start_ns();
  const auto lead_ns = static_cast<std::int64_t>(1e9 * settings.lead_mm / speed);
  const std::int64_t begin_ns = std::max(
      start_ns,
      LaterInBreath(scene, trial, line.entry_ns, alternative.change.breath_cycles) - lead_ns);
  const auto add = [&](std::int64_t time_ns, double distance_mm) {
    const Eigen::Vector3d tip_ct_mm =
        alternative.entry_ct_mm + (distance_mm - settings.lead_mm) * alternative.axis_in_ct;
    session.needle.push_back(
        {time_ns, transforms::Pose(rotation, reference_from_ct * tip_ct_mm), true});
  };
  // Breath depends on the time since the first reading: without a probe the needle defines it.
  const bool keeps_clock = scene.scene.breathing && !scene.scene.breathing->from_session;
  if (trial.probe.empty() && keeps_clock) {
    constexpr std::int64_t kWaitNs = 10'000'000;
    for (std::int64_t t_ns = start_ns; t_ns < begin_ns; t_ns += kWaitNs) add(t_ns, 0.0);
  }
  const double step_ns = 1e9 / settings.rate_hz;
  const auto count = static_cast<std::int64_t>(std::ceil(end_s * settings.rate_hz));
  for (std::int64_t i = 0; i <= count; ++i) {
    add(begin_ns + static_cast<std::int64_t>(std::llround(static_cast<double>(i) * step_ns)),
        DistanceAfter(static_cast<double>(i) / settings.rate_hz, length_mm, speed, kRampS));
  }
  if (!trial.probe.empty()) {
    session::PoseSample probe = session::PoseAt(trial.probe, line.deepest_ns);
    probe.time_ns = keeps_clock ? start_ns : begin_ns;
    session.probe.push_back(probe);
    probe.time_ns = session.needle.back().time_ns;
    session.probe.push_back(probe);
  }
  return session;
}

}  // namespace acus::trials
