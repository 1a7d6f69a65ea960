// The settings of the ultrasound in a scenario: the model of the image, and its parameters.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace acus::scenario {

/// The models of the papers, from the cheapest to the most expensive; then those in beam space.
enum class UltrasoundModel { kVidal2008, kAlamilla2021, kColumns2010, kBeams, kAperture };

/// The volumes that models in beam space sample along their lines.
enum class BeamVolume { kLabels, kCt, kBoth };

struct UltrasoundEffect {
  UltrasoundModel model = UltrasoundModel::kColumns2010;
  std::filesystem::path acoustics;  ///< Acoustic properties of tissues, in the model's format.
  bool needle = true;
  int scan_lines = 0;                       ///< 0: as the probe preset says.
  int samples_per_line = 0;                 ///< 0: as the probe preset says.
  std::uint64_t seed = 0;                   ///< Seed of speckle and noise.
  BeamVolume volume = BeamVolume::kLabels;  ///< For models in beam space.
  bool displaces_pixels = false;            ///< alamilla_2021: deformation of the finished image.
  bool from_triangles = false;    ///< alamilla_2021: labels come from the patient's surfaces.
  nlohmann::json beams;           ///< The model's settings, checked against the schema.
  std::filesystem::path display;  ///< The processing by the scanner; empty: none.

  bool InBeamSpace() const {
    return model == UltrasoundModel::kBeams || model == UltrasoundModel::kAperture;
  }
  /// True if the model reads the patient's CT.
  bool ReadsCt() const {
    return InBeamSpace() ? volume != BeamVolume::kLabels : model != UltrasoundModel::kAlamilla2021;
  }
  bool ReadsLabels() const {
    return InBeamSpace() ? volume != BeamVolume::kCt : model == UltrasoundModel::kAlamilla2021;
  }
};

/// @param effect  /effects/ultrasound, checked against the schema.
/// @param folder  The base of relative paths.
UltrasoundEffect ReadUltrasoundEffect(const nlohmann::json& effect,
                                      const std::filesystem::path& folder);

}  // namespace acus::scenario
