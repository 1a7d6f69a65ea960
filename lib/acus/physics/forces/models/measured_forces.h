// Laws fitted to recordings of one tissue: files of the format acus-measured-force/1, which
// acus-fit writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/physics/forces/models/mechanical_model.h"

namespace acus::forces {

/// The law of one recording; depths are since the contact, or since the recording's begin where the
/// needle is in the tissue from the start.
struct RecordedLaw {
  std::string name;
  MechanicalModel law;
};

struct MeasuredForces {
  std::string description;
  double needle_diameter_mm = 1.27;  ///< Outer diameter of the needle that was used, > 0.
  MechanicalModel mean;              ///< What all recordings have in common.
  std::vector<RecordedLaw> recordings;

  /// The mean for "mean", else the recording of that name.
  /// @throws InputError naming those that there are.
  const MechanicalModel& Law(const std::string& name) const;

  /// A needle path as the recordings vary: 0 gives the mean, any other seed always the same draw.
  /// Smoothed bootstrap: events and relaxation are those of one recording j, each as likely, and
  ///   R = mean R + a (R_j - mean R) + b sum_k z_k (R_k - mean R) / sqrt(n - 1),
  /// z_k normal, a = 0.9, a^2 + b^2 = 1; the same for the logarithms of the build-up travels. R_k
  /// are the profiles beside the events, in and out. Profiles have the recordings' mean and
  /// covariance at any two depths, and nine tenths of their covariance with events and relaxation,
  /// so that the whole force scatters as theirs does. With fewer than two recordings: the mean.
  MechanicalModel Drawn(std::uint64_t seed) const;
};

/// @throws InputError listing all problems: depths that do not increase, shares beyond 1...
MeasuredForces ReadMeasuredForces(const std::filesystem::path& path);
MeasuredForces MeasuredForcesFromJson(nlohmann::json document, const std::string& label);

/// One law as such a file holds it; its depths are moved so that the profile begins at 0.
nlohmann::json LawJson(const MechanicalModel& law);

}  // namespace acus::forces
