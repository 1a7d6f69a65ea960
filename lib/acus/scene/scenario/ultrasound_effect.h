// The ultrasound of a scenario: which model makes the image, and with what settings.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

/// The papers' models, from the cheapest to the most expensive; then those in beam space.
enum class UltrasoundModel { kVidal2008, kAlamilla2021, kColumns2010, kBeams, kAperture };

/// What models in beam space follow their lines through.
enum class BeamVolume { kLabels, kCt, kBoth };

struct UltrasoundEffect {
  UltrasoundModel model = UltrasoundModel::kColumns2010;
  std::filesystem::path acoustics;  ///< What the model makes of tissue, in its own format.
  bool needle = true;
  int scan_lines = 0;                       ///< 0: as the probe preset says.
  int samples_per_line = 0;                 ///< 0: as the probe preset says.
  std::uint64_t seed = 0;                   ///< Of speckle and noise.
  BeamVolume volume = BeamVolume::kLabels;  ///< In beam space, as all that follows.
  bool from_triangles = false;    ///< Of alamilla_2021: labels come from the patient's surfaces.
  nlohmann::json beams;           ///< The model's settings, checked against the schema.
  std::filesystem::path display;  ///< What the scanner adds; empty: nothing.

  bool InBeamSpace() const {
    return model == UltrasoundModel::kBeams || model == UltrasoundModel::kAperture;
  }
  /// What the model reads of the patient.
  bool ReadsCt() const {
    return InBeamSpace() ? volume != BeamVolume::kLabels : model != UltrasoundModel::kAlamilla2021;
  }
  bool ReadsLabels() const {
    return InBeamSpace() ? volume != BeamVolume::kCt : model == UltrasoundModel::kAlamilla2021;
  }
};

/// @param effect  /effects/ultrasound, checked against the schema.
/// @param folder  What paths are relative to.
UltrasoundEffect ReadUltrasoundEffect(const nlohmann::json& effect,
                                      const std::filesystem::path& folder);

}  // namespace acus::scenario
