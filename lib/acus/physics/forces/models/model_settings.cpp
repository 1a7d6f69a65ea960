#include "acus/physics/forces/models/model_settings.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"

namespace acus::forces {
namespace {

using nlohmann::json;

double Seconds(const json& block, const char* key) {
  return block.at(key).get<double>() * 1e-3;
}

MultiProxySettings::Repulsion RepulsionOf(const json& row) {
  return {row.at("a1_n_per_mm"), row.at("a2_n_per_mm2"), row.at("friction")};
}

}  // namespace

volume::Label TissueLabelAt(const json& name, const std::string& where) {
  try {
    return volume::LabelOf(name.get<std::string>());
  } catch (const InputError& error) {
    throw InputError(Message(where, ": ", error.what()));
  }
}

volume::Label HuTissues::At(double hu) const noexcept {
  volume::Label tissue = 0;
  for (const Row& row : rows) {
    if (hu >= row.from_hu) tissue = row.tissue;
  }
  return tissue;
}

AlamillaSettings AlamillaFromJson(const json& block) {
  const json& friction = block.at("lugre");
  const json& clamping = block.at("clamping");
  const json& knock = block.at("hard_contact");
  AlamillaSettings settings;
  settings.only_bone_on_bone = block.at("form") == "printed";
  settings.withdrawal_share = block.at("withdrawal_share");
  settings.friction = {.sigma0_per_mm = friction.at("sigma0_per_mm"),
                       .sigma1_s_per_mm = friction.at("sigma1_s_per_mm"),
                       .sigma2_s_per_mm = friction.at("sigma2_s_per_mm"),
                       .mu_coulomb = friction.at("mu_coulomb"),
                       .mu_static = friction.at("mu_static"),
                       .beta_s_per_mm = friction.at("beta_s_per_mm"),
                       .speed_filter_s = Seconds(friction, "speed_filter_ms")};
  settings.clamping = {.angular_n_mm_per_rad = clamping.at("stiffness_n_mm_per_rad"),
                       .angular_damping_n_mm_s_per_rad = clamping.at("damping_n_mm_s_per_rad"),
                       .torque_limit_n_mm = clamping.at("torque_limit_n_mm"),
                       .lateral_n_per_mm = clamping.at("lateral_n_per_mm"),
                       .lateral_damping_n_s_per_mm = clamping.at("lateral_damping_n_s_per_mm"),
                       .force_limit_n = clamping.at("force_limit_n"),
                       .redefine_mm = clamping.at("redefine_mm")};
  settings.hard_contact = {
      .amplitude_n_s_per_mm = knock.at("amplitude_n_s_per_m").get<double>() * 1e-3,
      .duration_s = Seconds(knock, "duration_ms"),
      .frequency_hz = knock.at("frequency_hz"),
      .without_account = settings.only_bone_on_bone};
  return settings;
}

VidalSettings VidalFromJson(const json& block, const std::string& where) {
  const json& resistance = block.at("resistance");
  const json& skin = block.at("skin");
  const json& guidance = block.at("guidance");
  const json& probe = block.at("probe");
  VidalSettings settings;
  settings.resistance_n_s_per_mm =
      CubicBSpline(resistance.at("hu").get<std::vector<double>>(),
                   resistance.at("n_s_per_mm").get<std::vector<double>>(), where + "/resistance");
  settings.edge_factor = block.at("edge_factor");
  settings.edge_hu_per_mm = block.at("edge_hu_per_mm");
  settings.withdrawal_n_s_per_mm = block.at("withdrawal_n_s_per_mm");
  settings.averaging_s = Seconds(block, "averaging_ms");
  settings.passive_average = block.at("passive_average");
  settings.largest_n_per_mm = block.at("largest_stiffness_n_per_mm");
  settings.skin = {skin.at("hu"), skin.at("friction"), 0.0};
  settings.skin_n_per_mm = skin.at("stiffness_n_per_mm");
  settings.puncture_n = skin.at("puncture_n");
  settings.bone_hu = block.at("bone_hu");
  ACUS_REQUIRE(settings.bone_hu > settings.skin.hu, where, "/bone_hu: is ", settings.bone_hu,
               "; bone must be above the skin's ", settings.skin.hu, " HU");
  settings.guidance_n_per_mm = guidance.at("stiffness_n_per_mm");
  settings.guidance_averaging_s = Seconds(guidance, "averaging_ms");
  settings.guidance_clamp_n = guidance.at("clamp_n");
  settings.orientation_depth_mm = block.at("orientation_depth_mm");
  const auto gravity = block.at("gravity_in_ct_n").get<std::vector<double>>();
  settings.gravity_in_ct_n = Eigen::Vector3d(gravity.at(0), gravity.at(1), gravity.at(2));
  const double face_mm = probe.at("face_mm");
  settings.probe = {.skin = {settings.skin.hu, probe.at("friction"), face_mm},
                    .skin_n_per_mm = probe.at("skin_n_per_mm"),
                    .bone = {settings.bone_hu, probe.at("friction"), 0.5 * face_mm},
                    .bone_n_per_mm = probe.at("bone_n_per_mm"),
                    .damping_n_s_per_mm = probe.at("damping_n_s_per_mm"),
                    .smoothing_s = Seconds(probe, "smoothing_ms"),
                    .largest_force_n = probe.at("largest_force_n"),
                    .moves_proxy = probe.at("form") == "printed"};
  return settings;
}

MultiProxySettings MultiProxyFromJson(const json& block, const std::string& where) {
  const json& rows = block.at("structures");
  MultiProxySettings settings;
  settings.skin_hu = block.at("skin").at("hu");
  settings.skin = RepulsionOf(block.at("skin"));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string place = Message(where, "/structures/", i);
    MultiProxySettings::Structure structure;
    structure.tissue = TissueLabelAt(rows[i].at("tissue"), place + "/tissue");
    ACUS_REQUIRE(structure.tissue != 0, place, "/tissue: 'outside' is free space");
    if (rows[i].contains("from_hu")) {
      structure.from_hu = rows[i].at("from_hu").get<double>();
      ACUS_REQUIRE(*structure.from_hu > settings.skin_hu, place, "/from_hu: is ",
                   *structure.from_hu, "; what is under the skin must be above the skin's ",
                   settings.skin_hu, " HU (", where, "/skin/hu)");
    }
    structure.repulsion = RepulsionOf(rows[i]);
    settings.structures.push_back(structure);
  }
  settings.damping_n_s_per_mm = block.at("damping_n_s_per_mm");
  settings.face_mm = block.at("face_mm");
  settings.smoothing_s = Seconds(block, "smoothing_ms");
  settings.largest_force_n = block.at("largest_force_n");
  return settings;
}

HuTissues HuTissuesFromJson(const json& rows, const std::string& where) {
  HuTissues tissues;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string place = Message(where, "/", i);
    HuTissues::Row row;
    row.from_hu = rows[i].at("from_hu");
    row.tissue = TissueLabelAt(rows[i].at("tissue"), place + "/tissue");
    ACUS_REQUIRE(tissues.rows.empty() || row.from_hu > tissues.rows.back().from_hu, place,
                 "/from_hu: is ", row.from_hu, "; it must be above the row before, ",
                 tissues.rows.back().from_hu);
    tissues.rows.push_back(row);
  }
  return tissues;
}

}  // namespace acus::forces
