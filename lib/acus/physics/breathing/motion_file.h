// A motion folder: motion.json (acus-motion/1), the fields in fields.raw (16 bits, little endian,
// x y z of each node, i fastest, one field after the other), and fields.nhdr, by which other
// programs read them as one NRRD; with a bound on its error, also that (MotionBound).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "acus/physics/breathing/motion_bound.h"
#include "acus/physics/breathing/motion_model.h"

namespace acus::breathing {

/// A model with the breath that it was made from.
struct PatientMotion {
  std::string name;
  MotionModel model;
  double inspiration_level = 1.0;  ///< Of the signal, in a normal breath.
  double expiration_level = 0.0;
  double period_s = 4.0;
  std::optional<MotionBound> bound = {};  ///< On the model's nodes, if it is known.

  /// Breath whose levels run from 0 to 1, in the terms of the model's signal.
  Breath InTermsOfSignal(const Breath& normal) const noexcept;
  /// The other way round. A signal that does not distinguish the two levels gives 1, at rest.
  Breath Normal(const Breath& of_signal) const noexcept;
};

/// Writes the files into a folder that is there; not atomically: for use inside an AtomicFolder.
/// @throws InputError if writing fails.
void WritePatientMotion(const std::filesystem::path& folder, const PatientMotion& motion);

/// @param path  The folder, or its motion.json.
/// @throws InputError if a file is missing, does not fit the schema, or fields.raw or bound.raw has
///     another size than motion.json says.
PatientMotion ReadPatientMotion(const std::filesystem::path& path);

}  // namespace acus::breathing
