// What a scanner does between the receiver and the screen, as a preset of the display.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "acus/imaging/acoustics/probe.h"

namespace acus::ultrasound {

/// How the level of an echo becomes grey; u is 0 at the foot of the dynamic range and 1 at white.
enum class GreyCurve {
  kLog,      ///< u: every dB is the same step.
  kPower,    ///< Echo amplitude to the power `curve_parameter`.
  kSigmoid,  ///< 1 / (1 + exp(-4 (u - 1/2) / `curve_parameter`)), stretched to 0 ... 1.
};

/// As in configs/schema/acus-display.schema.json, where the ranges, defaults and sources are. What
/// is off costs nothing and changes no bit.
struct DisplayOptions {
  std::string name;
  std::optional<double> dynamic_range_db{};  ///< Nothing: as the probe says.
  GreyCurve curve = GreyCurve::kLog;
  double curve_parameter = 1.0;
  double persistence_s = 0.0;      ///< Time constant of the mean over frames; 0: none.
  int compound_angles = 1;         ///< Odd: images of several steering angles, averaged.
  double compound_span_rad = 0.0;  ///< Between the outermost angles.
  double edge_strength = 0.0;      ///< Of the detail that is added; 0: none.
  double edge_sigma_mm = 0.5;      ///< Detail is what is finer than this along the lines.
  bool second_harmonic = false;
  double harmonic_db = -20.0;          ///< Amplitude at the focus, relative to the fundamental.
  double harmonic_clutter_db = -10.0;  ///< Haze, relative to that of the fundamental.
};

/// Reads configs/displays/<name>.json (format acus-display/1). An empty path: the defaults, that
/// is, nothing but the logarithm.
/// @throws InputError listing all problems.
DisplayOptions ReadDisplayOptions(const std::filesystem::path& path);

/// Steering angle of image `look` of compound_angles: the first is not steered, the others follow
/// in pairs, nearest first.
double SteeringRad(const DisplayOptions& display, int look);

/// The probe with what the display changes of it. @pre 0 <= look < compound_angles.
/// @throws InputError if a phased probe would have to compound: it steers already.
acoustics::Probe ProbeOfLook(const acoustics::Probe& probe, const DisplayOptions& display,
                             int look);

}  // namespace acus::ultrasound
