#include "acus/scene/simulation/beam_settings.h"

#include <bitset>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/imaging/ultrasound/columns/fibre_field.h"

namespace acus::simulation {
namespace {

ultrasound::BeamOptions OptionsFrom(const nlohmann::json& json) {
  ultrasound::BeamOptions options;
  options.interfaces = json.at("reflection");
  options.angle = json.at("angle");
  options.attenuation = json.at("attenuation");
  options.shadow = json.at("shadow");
  options.comet_tail = json.at("comet_tail");
  options.speckle = json.at("speckle");
  options.fibre_texture = json.at("fibre_texture");
  options.point_spread = json.at("point_spread");
  options.needle_shadow = json.at("needle_shadow");
  options.refraction = json.at("refraction");
  options.time_of_flight = json.at("time_of_flight");
  options.multiple_reflections = json.at("multiple_reflections");
  options.elevation_planes = json.at("elevation_planes");
  options.coupling_gap_mm = json.at("coupling_gap_mm");
  return options;
}

ultrasound::ApertureOptions ApertureOptionsFrom(const nlohmann::json& json) {
  ultrasound::ApertureOptions options;
  options.interfaces = json.at("reflection");
  options.angle = json.at("angle");
  options.attenuation = json.at("attenuation");
  options.shadow = json.at("shadow");
  options.comet_tail = json.at("reverberation");
  options.speckle = json.at("speckle");
  options.texture = json.at("texture");
  options.point_spread = json.at("point_spread");
  options.needle_shadow = json.at("needle_shadow");
  options.clutter = json.at("clutter");
  options.noise = json.at("noise");
  options.ring_down = json.at("ring_down");
  options.fibre_texture = json.at("fibre_texture");
  options.refraction = json.at("refraction");
  options.side_lobes = json.at("side_lobes");
  const std::string apodisation = json.at("apodisation");
  options.apodisation = apodisation == "hann"     ? ultrasound::Apodisation::kHann
                        : apodisation == "cosine" ? ultrasound::Apodisation::kCosine
                                                  : ultrasound::Apodisation::kRectangular;
  options.aperture_rays = json.at("aperture_rays");
  options.elevation_planes = json.at("elevation_planes");
  options.coupling_gap_mm = json.at("coupling_gap_mm");
  options.strong_loss_db_per_mm = json.at("strong_loss_db_per_mm");
  options.clutter_db = json.at("clutter_db");
  options.noise_db = json.at("noise_db");
  options.organ_structure = json.at("organ_structure");
  options.tgc_limit_db = json.at("tgc_limit_db");
  return options;
}

/// Tissues of the map whose fibres change the echo or the attenuation.
std::bitset<256> FibrousLabels(const BeamSettings& settings, const volume::LabelMap& labels) {
  std::bitset<256> fibrous;
  for (const auto& [label, name] : labels.names) {
    const auto found = settings.acoustics.tissues.find(name);
    if (found == settings.acoustics.tissues.end() || settings.fibres_in_ct.contains(name)) continue;
    const acoustics::TissueAcoustics& tissue = found->second;
    const bool attenuates =
        settings.options.attenuation &&
        tissue.attenuation_along_fibres_db_per_cm_mhz != tissue.attenuation_db_per_cm_mhz;
    const bool shows =
        settings.options.speckle && settings.options.fibre_texture && tissue.fibre_ratio > 1.0;
    fibrous[label] = attenuates || shows;
  }
  return fibrous;
}

using Fibres = std::map<std::string, Eigen::Vector3d>;

Fibres GivenFibres(const nlohmann::json& json, const std::string& place) {
  Fibres fibres;
  for (const auto& [tissue, direction] : json.at("fibres").items()) {
    const Eigen::Vector3d in_ct(direction[0], direction[1], direction[2]);
    ACUS_REQUIRE(in_ct.norm() > 1e-6, place, tissue,
                 ": has no direction; give a vector in CT space (LPS)");
    fibres[tissue] = in_ct.normalized();
  }
  return fibres;
}

void AddFibresOfSurfaces(const volume::LabelMap& labels, const std::bitset<256>& fibrous,
                         Fibres& fibres) {
  if (fibrous.none()) return;
  const ultrasound::FibreField field(labels, fibrous);
  for (const auto& [label, name] : labels.names) {
    const Eigen::Vector3f main = field.MainDirection(label);
    if (fibrous[label] && main.norm() > 0.5F) fibres[name] = main.cast<double>();
  }
}

}  // namespace

ApertureSettings ReadApertureSettings(const scenario::UltrasoundEffect& effect,
                                      const volume::LabelMap* labels) {
  ApertureSettings settings;
  settings.options = ApertureOptionsFrom(effect.beams);
  settings.options.display = ultrasound::ReadDisplayOptions(effect.display);
  settings.options.seed = effect.seed;
  settings.acoustics = acoustics::ReadTissueAcoustics(effect.acoustics);
  settings.from_ct = effect.ReadsCt();
  settings.from_labels = effect.ReadsLabels();
  if (!settings.options.fibre_texture || !settings.from_labels) return settings;
  settings.fibres_in_ct = GivenFibres(effect.beams, "/effects/ultrasound/aperture/fibres/");
  if (labels == nullptr || !effect.beams.at("fibres_from_surfaces")) return settings;
  std::bitset<256> fibrous;
  for (const auto& [label, name] : labels->names) {
    const auto found = settings.acoustics.tissues.find(name);
    fibrous[label] = found != settings.acoustics.tissues.end() && found->second.fibre_ratio > 1.0 &&
                     !settings.fibres_in_ct.contains(name);
  }
  AddFibresOfSurfaces(*labels, fibrous, settings.fibres_in_ct);
  return settings;
}

BeamSettings ReadBeamSettings(const scenario::UltrasoundEffect& effect,
                              const volume::LabelMap* labels) {
  const nlohmann::json& json = effect.beams;
  BeamSettings settings;
  settings.options = OptionsFrom(json);
  settings.options.display = ultrasound::ReadDisplayOptions(effect.display);
  settings.options.seed = effect.seed;
  settings.acoustics = acoustics::ReadTissueAcoustics(effect.acoustics);
  settings.from_ct = effect.ReadsCt();
  settings.from_labels = effect.ReadsLabels();
  settings.fibres_in_ct = GivenFibres(json, "/effects/ultrasound/beams/fibres/");
  if (labels == nullptr || !settings.from_labels || !json.at("fibres_from_surfaces")) {
    return settings;
  }
  AddFibresOfSurfaces(*labels, FibrousLabels(settings, *labels), settings.fibres_in_ct);
  return settings;
}

}  // namespace acus::simulation
