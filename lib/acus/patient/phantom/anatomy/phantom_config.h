// The configuration of a synthetic patient: configs/schema/acus-phantom.schema.json.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acus/patient/phantom/anatomy/imaging.h"
#include "acus/patient/phantom/hands/markers.h"
#include "acus/patient/phantom/hands/session_script.h"
#include "acus/physics/forces/laws/force_curve.h"

namespace acus::phantom {

struct ForceCurveSettings {
  std::string name;
  int count = 1;
  double spread_percent = 0.0;  ///< Of the parameters between recordings.
  double noise_n = 0.01;
  forces::CurveParameters parameters;
  forces::DrivePlan drive;
};

struct PhantomConfig {
  volume::Geometry grid;
  BodySettings body;
  ScannerSettings scanner;
  MarkerSettings markers;
  PlanSettings insertion;
  SessionSettings session;
  std::vector<ForceCurveSettings> force_curves;
  nlohmann::json document;  ///< As read, with all defaults filled in.
};

/// @throws InputError listing all problems of the file.
PhantomConfig ReadPhantomConfig(const std::filesystem::path& path);

}  // namespace acus::phantom
