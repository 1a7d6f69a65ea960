// What the motion of a patient can be made from, on disk.
#pragma once

#include <filesystem>
#include <optional>

#include "acus/patient/breathing_registration/capture.h"

namespace acus::breathing_registration {

/// One of `phases`, `fields` and `single` is given, the others are empty.
struct CaptureInputs {
  std::filesystem::path phases;     ///< Folder of images: see FindPhases.
  std::filesystem::path fields;     ///< Folder of displacement fields, found in the same way.
  std::filesystem::path single;     ///< A CT at end expiration.
  std::filesystem::path ct;         ///< On which `fields` must lie; may be empty.
  std::filesystem::path labels;     ///< Of the reference, or of `single`; empty: they are found.
  std::filesystem::path landmarks;  ///< Empty: landmarks.csv beside the phases, if it is there.
  std::filesystem::path signal;     ///< Recorded surrogate: levels of phases, period; may be empty.
  std::string column;               ///< Of the signal's file.
  double diaphragm_mm = 20.0;       ///< Way of the diaphragm in a breath made for `single`.
  bool sliding = true;              ///< Organs slide along the wall of the cavity.
};

/// Reads and captures. @throws InputError as CaptureMotion, CaptureFields, CaptureSingle, and for
///     files that cannot be read.
Capture CaptureFrom(const CaptureInputs& inputs, const CaptureSettings& settings,
                    RunContext& context);

}  // namespace acus::breathing_registration
