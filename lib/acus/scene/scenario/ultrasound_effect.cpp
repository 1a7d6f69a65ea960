#include "acus/scene/scenario/ultrasound_effect.h"

#include <map>
#include <string>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::scenario {

UltrasoundEffect ReadUltrasoundEffect(const nlohmann::json& effect,
                                      const std::filesystem::path& folder) {
  static const std::map<std::string, UltrasoundModel> kModels = {
      {"vidal_2008", UltrasoundModel::kVidal2008},
      {"alamilla_2021", UltrasoundModel::kAlamilla2021},
      {"columns_2010", UltrasoundModel::kColumns2010},
      {"beams", UltrasoundModel::kBeams},
      {"aperture", UltrasoundModel::kAperture}};
  static const std::map<std::string, BeamVolume> kVolumes = {
      {"labels", BeamVolume::kLabels}, {"ct", BeamVolume::kCt}, {"both", BeamVolume::kBoth}};
  const std::string model = effect.at("model");
  UltrasoundEffect out;
  out.model = kModels.at(model);
  out.needle = effect.at("needle");
  out.scan_lines = effect.value("scan_lines", 0);
  out.samples_per_line = effect.value("samples_per_line", 0);
  out.seed = effect.at("seed");
  // The 2010 model is the oldest one: its acoustics are beside the key `model`.
  const nlohmann::json& settings =
      out.model == UltrasoundModel::kColumns2010 ? effect : effect.at(model);
  const std::string display = effect.at("display");
  if (!display.empty()) {
    ACUS_REQUIRE(out.InBeamSpace(), "/effects/ultrasound/display: \"", display,
                 "\" with the model ", model,
                 "; displays are for the models beams and aperture: choose one of them, or no "
                 "display");
    out.display = config::FindConfig(display, folder);
  }
  out.acoustics = config::FindConfig(settings.at("acoustics").get<std::string>(), folder);
  out.from_triangles = out.model == UltrasoundModel::kAlamilla2021 &&
                       settings.at("labels_from").get<std::string>() == "triangles";
  out.displaces_pixels = out.model == UltrasoundModel::kAlamilla2021 &&
                         settings.at("deformation").get<std::string>() == "pixels";
  if (out.InBeamSpace()) {
    out.beams = settings;
    out.volume = kVolumes.at(settings.at("volume").get<std::string>());
  }
  return out;
}

}  // namespace acus::scenario
