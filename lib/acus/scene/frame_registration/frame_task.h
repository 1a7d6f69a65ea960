// The subcommand `image` of acus-register: the probe's pose from a recorded ultrasound frame.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/registration/command_line.h"
#include "acus/scene/frame_registration/pose_search.h"

namespace acus::frame_registration {

struct FrameTask {
  std::filesystem::path frame = {};     ///< PNG or another image, in the geometry of the probe's.
  std::filesystem::path scenario = {};  ///< Patient, probe and ultrasound.
  std::filesystem::path start = {};     ///< ct_from_probe.tfm
  std::filesystem::path ct = {};        ///< Replaces the scenario's, as do the next two.
  std::filesystem::path labels = {};
  std::filesystem::path surfaces = {};
  std::string background = {};  ///< Tissue of unlabelled voxels; empty: outside the body.
  SearchSettings settings = {};
};

/// Adds the subcommand and its options to the program.
registration::Command AddFrameTask(CLI::App& app);

/// Writes `folder` (whole or not at all): ct_from_probe.tfm, registration.json, overlay.png,
/// provenance.json. Returns a text for the terminal.
/// @throws InputError, NoAnswerError as the search does.
std::string Run(const FrameTask& task, const std::filesystem::path& folder, RunContext& context);

}  // namespace acus::frame_registration
