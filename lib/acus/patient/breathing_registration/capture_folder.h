// The folder that acus-breathing writes.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/breathing_registration/capture.h"

namespace acus::breathing_registration {

/// Writes the motion (motion.json, fields.raw, fields.nhdr), phases.csv, models.csv,
/// landmark_errors.csv (if landmarks are known), report.html, difference.png and provenance.json
/// into a new folder, whole or not at all.
void WriteCapture(const std::filesystem::path& folder, const Capture& capture,
                  const RunContext& context);

/// A table for people: errors of every model; and of the landmarks, if there are any.
std::string CaptureText(const Capture& capture);

}  // namespace acus::breathing_registration
