#include "acus/physics/forces/models/measured_forces.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::forces {
namespace {

using nlohmann::json;

constexpr double kOfOneRecording = 0.95;

ResistanceProfile ProfileFrom(const json& block, const std::string& where) {
  ResistanceProfile profile{block.at("depth_mm").get<std::vector<double>>(),
                            block.at("force_n").get<std::vector<double>>()};
  ACUS_REQUIRE(profile.depth_mm.size() == profile.force_n.size(), where, ": has ",
               profile.depth_mm.size(), " depths and ", profile.force_n.size(),
               " forces; as many of both are needed");
  for (std::size_t k = 1; k < profile.depth_mm.size(); ++k) {
    ACUS_REQUIRE(profile.depth_mm[k] > profile.depth_mm[k - 1], where, "/depth_mm/", k, ": is ",
                 profile.depth_mm[k], " after ", profile.depth_mm[k - 1], "; depths must increase");
  }
  return profile;
}

void ReadRelaxation(const json& block, const std::string& where, MechanicalModel& law) {
  const auto share = block.at("relaxing_share").get<std::vector<double>>();
  const auto time_s = block.at("relaxation_s").get<std::vector<double>>();
  ACUS_REQUIRE(share.size() == time_s.size(), where, ": relaxing_share has ", share.size(),
               " values and relaxation_s ", time_s.size(), "; as many of both are needed");
  double sum = 0.0;
  for (std::size_t k = 0; k < share.size(); ++k) {
    law.relaxing_share[k] = share[k];
    law.relaxation_s[k] = time_s[k];
    sum += share[k];
  }
  ACUS_REQUIRE(sum <= 1.0 + 1e-9, where, "/relaxing_share: the sum is ", sum, "; allowed: up to 1");
}

MechanicalModel LawFrom(const json& block, const std::string& where) {
  MechanicalModel law;
  law.in = ProfileFrom(block.at("in"), where + "/in");
  law.out = ProfileFrom(block.at("out"), where + "/out");
  law.surface_mm = 0.0;
  law.buildup_in_mm = block.at("buildup_in_mm");
  law.buildup_out_mm = block.at("buildup_out_mm");
  law.reference_mm_per_s = block.at("reference_mm_per_s");
  ReadRelaxation(block, where, law);
  for (const json& p : block.at("punctures")) {
    law.punctures.push_back({p.at("contact_mm"), p.at("puncture_mm"), p.at("a1_n_per_mm"),
                             p.at("a2_n_per_mm2"), p.at("recovery_mm"), p.at("step_n")});
  }
  for (const json& r : block.at("releases")) {
    law.releases.push_back({r.at("at_mm"), r.at("width_mm"), r.at("step_n")});
  }
  for (const json& slip : block.at("slips")) {
    law.slips.push_back({slip.at("after_s"), slip.at("share")});
  }
  return law;
}

json MovedProfileJson(const ResistanceProfile& profile, double origin_mm) {
  std::vector<double> depth_mm = profile.depth_mm;
  for (double& depth : depth_mm) depth -= origin_mm;
  return {{"depth_mm", depth_mm}, {"force_n", profile.force_n}};
}

/// base += factor (added - removed) at the base's knots.
void AddDeviation(double factor, const ResistanceProfile& profile,
                  const std::vector<double>& mean_n, ResistanceProfile& base) {
  for (std::size_t i = 0; i < base.depth_mm.size(); ++i) {
    base.force_n[i] += factor * (profile.ForceN(base.depth_mm[i]) - mean_n[i]);
  }
}

/// The recordings' mean profile at its own knots, in or out.
std::vector<double> MeanN(const std::vector<RecordedLaw>& recordings,
                          ResistanceProfile MechanicalModel::*side,
                          const std::vector<double>& depth_mm) {
  std::vector<double> mean_n(depth_mm.size(), 0.0);
  for (const RecordedLaw& r : recordings) {
    for (std::size_t i = 0; i < mean_n.size(); ++i) {
      mean_n[i] += (r.law.*side).ForceN(depth_mm[i]) / static_cast<double>(recordings.size());
    }
  }
  return mean_n;
}

}  // namespace

const MechanicalModel& MeasuredForces::Law(const std::string& name) const {
  if (name == "mean") return mean;
  std::string names = "mean";
  for (const RecordedLaw& r : recordings) {
    if (r.name == name) return r.law;
    names += ", " + r.name;
  }
  throw InputError(Message("no recording is named '", name, "'; there are: ", names));
}

MechanicalModel MeasuredForces::Drawn(std::uint64_t seed) const {
  if (seed == 0 || recordings.size() < 2) return mean;
  const auto n = static_cast<double>(recordings.size());
  RandomStream random(seed, "measured force");
  const double spread = std::sqrt(1.0 - kOfOneRecording * kOfOneRecording) / std::sqrt(n - 1.0);
  std::vector<double> weight(recordings.size());
  for (double& value : weight) value = spread * random.Normal();
  const auto pick = std::min(static_cast<std::size_t>(random.Uniform() * n), recordings.size() - 1);
  // The scatter of a picked recording about their mean is that of n, not of n - 1.
  weight[pick] += kOfOneRecording * std::sqrt(n / (n - 1.0));
  MechanicalModel drawn = recordings[pick].law;
  for (const auto side : {&MechanicalModel::in, &MechanicalModel::out}) {
    ResistanceProfile profile{(mean.*side).depth_mm, {}};
    const std::vector<double> mean_n = MeanN(recordings, side, profile.depth_mm);
    profile.force_n = mean_n;
    for (std::size_t k = 0; k < weight.size(); ++k) {
      AddDeviation(weight[k], recordings[k].law.*side, mean_n, profile);
    }
    for (double& force : profile.force_n) force = std::max(0.0, force);
    drawn.*side = std::move(profile);
  }
  for (const auto travel : {&MechanicalModel::buildup_in_mm, &MechanicalModel::buildup_out_mm}) {
    double mean_log = 0.0;
    for (const RecordedLaw& r : recordings) mean_log += std::log(r.law.*travel) / n;
    double log_travel = mean_log;
    for (std::size_t k = 0; k < weight.size(); ++k) {
      log_travel += weight[k] * (std::log(recordings[k].law.*travel) - mean_log);
    }
    drawn.*travel = std::exp(log_travel);
  }
  return drawn;
}

MeasuredForces MeasuredForcesFromJson(json document, const std::string& label) {
  document = config::CheckedConfig(std::move(document), "acus-measured-force", label);
  MeasuredForces forces;
  forces.description = document.at("description");
  forces.needle_diameter_mm = document.at("needle_diameter_mm");
  forces.mean = LawFrom(document.at("mean"), label + ": /mean");
  const json& rows = document.at("recordings");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string where = Message(label, ": /recordings/", i);
    forces.recordings.push_back({rows[i].at("name"), LawFrom(rows[i].at("law"), where + "/law")});
  }
  return forces;
}

MeasuredForces ReadMeasuredForces(const std::filesystem::path& path) {
  return MeasuredForcesFromJson(config::ReadJson(path), path.string());
}

json LawJson(const MechanicalModel& law) {
  const double origin_mm = law.in.depth_mm.front();
  json punctures = json::array();
  for (const InternalPuncture& p : law.punctures) {
    punctures.push_back({{"contact_mm", p.contact_mm - origin_mm},
                         {"puncture_mm", p.puncture_mm},
                         {"a1_n_per_mm", p.a1_n_per_mm},
                         {"a2_n_per_mm2", p.a2_n_per_mm2},
                         {"recovery_mm", p.recovery_mm},
                         {"step_n", p.step_n}});
  }
  json releases = json::array();
  for (const Release& r : law.releases) {
    releases.push_back(
        {{"at_mm", r.at_mm - origin_mm}, {"width_mm", r.width_mm}, {"step_n", r.step_n}});
  }
  json slips = json::array();
  for (const Slip& slip : law.slips) {
    slips.push_back({{"after_s", slip.after_s}, {"share", slip.share}});
  }
  json share = json::array();
  json time_s = json::array();
  for (std::size_t k = 0; k < MechanicalModel::kMostBranches; ++k) {
    if (!(law.relaxing_share[k] > 0.0)) continue;
    share.push_back(law.relaxing_share[k]);
    time_s.push_back(law.relaxation_s[k]);
  }
  return {{"in", MovedProfileJson(law.in, origin_mm)},
          {"out", MovedProfileJson(law.out, origin_mm)},
          {"buildup_in_mm", law.buildup_in_mm},
          {"buildup_out_mm", law.buildup_out_mm},
          {"reference_mm_per_s", law.reference_mm_per_s},
          {"relaxing_share", share},
          {"relaxation_s", time_s},
          {"punctures", punctures},
          {"releases", releases},
          {"slips", slips}};
}

}  // namespace acus::forces
