// The ultrasound of a scenario: which level makes the image, and with what settings.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace acus::scenario {

/// From the cheapest to the dearest.
enum class UltrasoundModel { kVidal2008, kAlamilla2021, kColumns2010 };

struct UltrasoundEffect {
  UltrasoundModel model = UltrasoundModel::kColumns2010;
  std::filesystem::path acoustics;  ///< What the level makes of tissue, in its own format.
  bool needle = true;

  /// What the level reads of the patient.
  bool ReadsCt() const { return model != UltrasoundModel::kAlamilla2021; }
  bool ReadsLabels() const { return model == UltrasoundModel::kAlamilla2021; }
};

/// @param effect  /effects/ultrasound, checked against the schema.
/// @param folder  What paths are relative to.
UltrasoundEffect ReadUltrasoundEffect(const nlohmann::json& effect,
                                      const std::filesystem::path& folder);

}  // namespace acus::scenario
