// The settings of the force on the needle in a scenario.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace acus::scenario {

enum class NeedleForceModelKind { kLayered, kAlamilla, kVidal, kMeasured, kTissue };

/// The model that holds the needle on its line.
enum class GuidanceKind { kOwn, kNone, kVidal, kVirtualFixture };

struct NeedleForceEffect {
  NeedleForceModelKind model = NeedleForceModelKind::kLayered;
  GuidanceKind guidance = GuidanceKind::kOwn;
  bool direct_method = false;  ///< The method of kAlamilla without its tracking wall.
  std::filesystem::path table;
  std::filesystem::path measured;    ///< kMeasured only: output of acus-measured-force.
  std::string recording = "mean";    ///< Name of a recording in that file.
  std::uint64_t seed = 0;            ///< Not 0: a random draw from the variation of its recordings.
  double skin_nick_radius_mm = 0.0;  ///< Around the corridor's entry; 0: no nick.
};

/// @param effect  /effects/needle_force, checked against the schema.
/// @param folder  The base of relative paths. @param file  Names the scenario in messages.
/// @throws InputError if settings contradict each other.
NeedleForceEffect ReadNeedleForce(const nlohmann::json& effect, const std::filesystem::path& folder,
                                  const std::string& file);

}  // namespace acus::scenario
