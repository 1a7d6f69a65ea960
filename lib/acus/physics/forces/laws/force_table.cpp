#include "acus/physics/forces/laws/force_table.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/between_patients.h"

namespace acus::forces {
namespace {

using nlohmann::json;

constexpr double kMostRelaxed = 0.95;
constexpr double kLeastFriction = 0.1;

ForceRelaxation RelaxationFrom(const json& terms, const std::string& where) {
  ForceRelaxation relaxation;
  for (const json& term : terms) {  // Their number is the schema's.
    relaxation.share[relaxation.num_terms] = term.at("share");
    relaxation.time_s[relaxation.num_terms] = term.at("time_s");
    ++relaxation.num_terms;
  }
  const double sum = 1.0 - relaxation.ElasticShare();
  ACUS_REQUIRE(sum <= kMostRelaxed, where, "/relaxation: the shares sum to ", sum,
               "; allowed: up to ", kMostRelaxed, ", since tissue that holds nothing is a fluid");
  return relaxation;
}

FrictionTime FrictionTimeFrom(const json& block) {
  return {.reference_mm_per_s = block.at("reference_mm_per_s"),
          .least_mm_per_s = block.at("least_mm_per_s"),
          .least_dwell_s = block.at("least_dwell_s"),
          .slip_mm = block.at("slip_mm")};
}

/// What remains of friction at the least speed, on a contact of no age.
void RequireFriction(const TissueTime& time, const FrictionTime& settings,
                     const std::string& where) {
  const double least = 1.0 + time.friction_rate * settings.RateLog(0.0) +
                       time.friction_dwell * settings.DwellLog(0.0);
  ACUS_REQUIRE(least >= kLeastFriction, where, ": friction_rate ", time.friction_rate,
               " and friction_dwell ", time.friction_dwell, " leave ", least,
               " of the friction at the least speed without any rest; allowed: at least ",
               kLeastFriction, "; lower them or raise least_mm_per_s or least_dwell_s");
}

/// The different times of the rows.
void CollectTimes(ForceTable& table, const std::string& label) {
  for (std::size_t i = 1; i < table.tissue.size(); ++i) {
    const TissueTime& time = table.tissue[i].time;
    const auto end = table.times.begin() + table.num_times;
    const auto known = std::find(table.times.begin(), end, time);
    table.time_of[i] = static_cast<std::uint8_t>(known - table.times.begin());
    if (known != end) continue;
    ACUS_REQUIRE(table.num_times < ForceTable::kMostTimes, label, ": /tissues: have more than ",
                 ForceTable::kMostTimes - 1,
                 " different combinations of relaxation, friction_rate and friction_dwell; give "
                 "similar tissues the same");
    table.times[static_cast<std::size_t>(table.num_times++)] = time;
  }
}

TissueForce Tissue(const json& row, const std::string& where) {
  TissueForce tissue;
  tissue.membrane = {row.at("a1_n_per_mm"), row.at("a2_n_per_mm2"), row.at("puncture_n")};
  tissue.cutting_n = row.at("cutting_n");
  tissue.friction_n_per_mm = row.at("friction_n_per_mm");
  tissue.withdrawal_friction_n_per_mm =
      row.value("withdrawal_friction_n_per_mm", tissue.friction_n_per_mm);
  tissue.withdrawal_tip_n = row.at("withdrawal_tip_n");
  tissue.cutting_stiffness_n_per_mm = row.at("cutting_stiffness_n_per_mm");
  tissue.cutting_a1_n_per_mm = row.at("cutting_a1_n_per_mm");
  tissue.cutting_a2_n_per_mm2 = row.at("cutting_a2_n_per_mm2");
  tissue.shaft_n_per_mm2 = row.at("shaft_n_per_mm2");
  tissue.impenetrable = row.at("impenetrable");
  if (row.contains("between_patients")) {
    tissue.between_patients_gsd = row.at("between_patients").at("gsd");
  }
  tissue.time = {.relaxation = RelaxationFrom(row.at("relaxation"), where),
                 .friction_rate = row.at("friction_rate"),
                 .friction_dwell = row.at("friction_dwell")};
  for (const json& name : row.at("no_membrane_from")) {
    tissue.no_membrane_from.set(TissueLabelAt(name, where + "/no_membrane_from"));
  }
  const PuncturePolynomial& membrane = tissue.membrane;
  ACUS_REQUIRE(membrane.puncture_n == 0.0 || membrane.a1_n_per_mm + membrane.a2_n_per_mm2 > 0.0,
               where, ": puncture_n is ", membrane.puncture_n,
               " but a1_n_per_mm and a2_n_per_mm2 are both 0, so that it is never reached");
  return tissue;
}

ForceSettings Settings(const json& document) {
  const json& bone = document.at("bone");
  const json& lost = document.at("tracking_loss");
  ForceSettings settings;
  settings.cutting_stiffness_n_per_mm = document.at("cutting_stiffness_n_per_mm");
  settings.friction_buildup_mm = document.at("friction_buildup_mm");
  settings.interface_hysteresis_mm = document.at("interface_hysteresis_mm");
  settings.lateral_limit_n = document.at("lateral_limit_n");
  settings.tissue_lateral_stiffness_n_per_mm2 = document.at("tissue_lateral_stiffness_n_per_mm2");
  settings.redirect_depth_mm = document.at("redirect_depth_mm");
  settings.bone = {bone.at("stiffness_n_per_mm"), bone.at("damping_n_s_per_mm"),
                   bone.at("largest_n")};
  settings.invalid_hold_s = lost.at("hold_ms").get<double>() * 1e-3;
  settings.invalid_ramp_s = lost.at("ramp_ms").get<double>() * 1e-3;
  settings.largest_force_n = document.at("largest_force_n");
  return settings;
}

}  // namespace

ForceTable ForceTableFromJson(json document, const std::string& label) {
  document = config::CheckedConfig(std::move(document), "acus-forces", label);
  ForceTable table;
  table.description = document.at("description");
  table.reference_diameter_mm = document.at("reference_diameter_mm");
  table.settings = Settings(document);
  table.alamilla = AlamillaFromJson(document.at("alamilla"));
  table.vidal = VidalFromJson(document.at("vidal"), label + ": /vidal");
  table.multi_proxy = MultiProxyFromJson(document.at("multi_proxy"), label + ": /multi_proxy");
  table.hu_tissues = HuTissuesFromJson(document.at("hu_tissues"), label + ": /hu_tissues");
  table.hu_springs = HuSpringsFromJson(document.at("hu_springs"), label + ": /hu_springs");
  table.friction_time = FrictionTimeFrom(document.at("friction_time"));
  const json& rows = document.at("tissues");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string where = Message(label, ": /tissues/", i);
    const volume::Label tissue = TissueLabelAt(rows[i].at("tissue"), where + "/tissue");
    ACUS_REQUIRE(tissue != 0, where, "/tissue: 'outside' is free space and has no row");
    ACUS_REQUIRE(!table.named.test(tissue), where, "/tissue: ", rows[i].at("tissue").dump(),
                 " has a row already; remove one of the two");
    table.tissue[tissue] = Tissue(rows[i], where);
    RequireFriction(table.tissue[tissue].time, table.friction_time, where);
    table.named.set(tissue);
  }
  const volume::Label fallback = volume::LabelOf("soft_tissue");
  ACUS_REQUIRE(table.named.test(fallback), label,
               ": /tissues: has no row for \"soft_tissue\", which stands for every tissue that is "
               "not named; add one");
  for (std::size_t i = 1; i < table.tissue.size(); ++i) {
    if (!table.named.test(i)) table.tissue[i] = table.tissue[fallback];
  }
  CollectTimes(table, label);
  return table;
}

ForceTable ReadForceTable(const std::filesystem::path& path) {
  return ForceTableFromJson(config::ReadJson(path), path.string());
}

void TissueForce::Scale(double ratio) noexcept {
  membrane.a1_n_per_mm *= ratio;
  membrane.a2_n_per_mm2 *= ratio;
  membrane.puncture_n *= ratio;
  cutting_n *= ratio;
  cutting_a1_n_per_mm *= ratio;
  cutting_a2_n_per_mm2 *= ratio;
  shaft_n_per_mm2 *= ratio;
  friction_n_per_mm *= ratio;
  withdrawal_friction_n_per_mm *= ratio;
  withdrawal_tip_n *= ratio;
}

void ForceTable::ScaleLawsByHu(double ratio) {
  hu_springs.Scale(ratio);
  vidal.resistance_n_s_per_mm = vidal.resistance_n_s_per_mm * ratio;
  vidal.withdrawal_n_s_per_mm *= ratio;
  vidal.skin_n_per_mm *= ratio;
  vidal.puncture_n *= ratio;
}

ForceTable ForceTable::ScaledTo(double outer_diameter_mm) const {
  const double ratio = outer_diameter_mm / reference_diameter_mm;
  ForceTable scaled = *this;
  scaled.reference_diameter_mm = outer_diameter_mm;
  for (TissueForce& row : scaled.tissue) row.Scale(ratio);
  scaled.ScaleLawsByHu(ratio);
  return scaled;
}

ForceTable ForceTable::OfPatient(std::uint64_t seed) const {
  const volume::Label fallback = volume::LabelOf("soft_tissue");
  const auto factor = [&](volume::Label label) {
    const volume::Label row = named.test(label) ? label : fallback;
    return math::PatientFactor(tissue[row].between_patients_gsd, seed, row);
  };
  const auto scale = [](MultiProxySettings::Repulsion& repulsion, double ratio) {
    repulsion.a1_n_per_mm *= ratio;
    repulsion.a2_n_per_mm2 *= ratio;
  };
  ForceTable drawn = *this;
  for (std::size_t i = 1; i < drawn.tissue.size(); ++i) {
    drawn.tissue[i].Scale(factor(static_cast<volume::Label>(i)));
  }
  scale(drawn.multi_proxy.skin, factor(volume::LabelOf("skin")));
  for (MultiProxySettings::Structure& structure : drawn.multi_proxy.structures) {
    scale(structure.repulsion, factor(structure.tissue));
  }
  drawn.ScaleLawsByHu(factor(fallback));
  return drawn;
}

bool ForceTable::VariesBetweenPatients() const noexcept {
  return std::ranges::any_of(tissue,
                             [](const TissueForce& row) { return row.between_patients_gsd > 1.0; });
}

}  // namespace acus::forces
