// The force on the needle, as a scenario calls for it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace acus::scenario {

enum class NeedleForceModelKind { kLayered, kAlamilla, kVidal, kMeasured, kTissue };

/// What holds the needle on its line.
enum class GuidanceKind { kOwn, kNone, kVidal, kVirtualFixture };

struct NeedleForceEffect {
  NeedleForceModelKind model = NeedleForceModelKind::kLayered;
  GuidanceKind guidance = GuidanceKind::kOwn;
  bool direct_method = false;  ///< Of kAlamilla, in place of its tracking wall.
  std::filesystem::path table;
  std::filesystem::path measured;    ///< Only kMeasured: acus-measured-force.
  std::string recording = "mean";    ///< Of that file.
  std::uint64_t seed = 0;            ///< Not 0: a draw from how its recordings vary.
  double skin_nick_radius_mm = 0.0;  ///< Around the corridor's entry; 0: no nick.
};

/// @param effect  /effects/needle_force, checked against the schema.
/// @param folder  What paths are relative to. @param file  Names the scenario in messages.
/// @throws InputError if settings contradict each other.
NeedleForceEffect ReadNeedleForce(const nlohmann::json& effect, const std::filesystem::path& folder,
                                  const std::string& file);

}  // namespace acus::scenario
