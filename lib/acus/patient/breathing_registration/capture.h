// From the phases of a 4D CT to a patient's motion: registration, models and how good they are.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acus/patient/breathing_registration/phase_files.h"
#include "acus/patient/breathing_registration/phase_registration.h"
#include "acus/physics/breathing/model_errors.h"
#include "acus/physics/breathing/motion_file.h"

namespace acus::breathing_registration {

/// Points of tissue whose places are known in every phase: landmarks.csv.
struct KnownLandmarks {
  struct Point {
    std::string name;
    std::string tissue;
    double wall_mm = 0.0;  ///< Distance to the wall along which tissue slides.
    std::map<std::string, Eigen::Vector3d> at_mm;  ///< By file of the phase; CT space.
  };
  std::vector<Point> points;
};

/// Columns name, tissue, wall_mm, file, x_mm, y_mm, z_mm. @throws InputError
KnownLandmarks ReadKnownLandmarks(const std::filesystem::path& path);

struct CaptureSettings {
  RegistrationSettings registration;
  breathing::MotionKind kind = breathing::MotionKind::kSurrogate;
  int resolution = 128;  ///< Nodes of the model along each axis.
  int num_modes = 3;     ///< Principal components over time that are kept; 0: all.
  int judged_at = 64;    ///< Nodes along each axis at which models are compared.
};

/// What registration made of one phase.
struct PhaseResult {
  PhaseFile file;
  bool deeper = false;  ///< Beyond normal breath: only to judge models by.
  Residual residual;
  double largest_mm = 0.0;  ///< Displacement.
  /// Of registered fields: SlidingGrid::SmallestDeterminant.
  std::optional<double> smallest_determinant;
  std::vector<double> landmark_error_mm;  ///< In the order of the landmarks.
  std::vector<double> landmark_bound_mm;  ///< What the error should keep to: PhaseField::BoundMm.
  double unseen_share = 0.0;              ///< Tissue whose match the phase does not show.
};

/// How well each model repeats the registered fields, mm.
struct ModelRow {
  breathing::MotionKind kind;
  breathing::ModelError in_sample;
  std::optional<breathing::ModelError> leave_one_out;
  std::optional<breathing::ModelError> deeper;
  std::optional<breathing::ModelError> landmarks;  ///< Of the model as written, over all phases.
};

/// Difference images of one phase, a coronal slice; contrast, 0 is equal.
struct DifferenceImage {
  int width = 0, height = 0;
  double pixel_mm = 0.0;
  std::vector<float> before, after;  ///< Rows from the head down.
};

/// Bound on the error in one phase, a coronal slice; mm, 0 where there is no tissue.
struct BoundImage {
  int width = 0, height = 0;
  std::vector<float> mm;  ///< Rows from the head down.
  std::string phase;
};

/// The bound of the motion as written, over the tissue.
struct BoundSummary {
  double median_mm = 0.0, p95_mm = 0.0, largest_mm = 0.0;
  double unseen_share = 0.0;  ///< In the phase of the deepest normal breath.
  /// Share of the landmarks, over all phases, where the model's error keeps to the bound.
  std::optional<double> kept_share;
};

struct Capture {
  breathing::PatientMotion motion;
  std::vector<PhaseResult> phases;  ///< Without the reference; the deeper one last.
  std::string reference;
  std::vector<ModelRow> models;
  std::vector<double> variance_of_modes;
  KnownLandmarks landmarks;
  DifferenceImage image;
  std::string shown;
  std::optional<BoundSummary> bound;  ///< If the fields were registered here.
  BoundImage bound_image;
};

/// The motion's bound is that of the phases in the upper half of normal breath, with what the model
/// adds: 95 % of its distance from the fields.
///
/// Registers all phases to the one nearest to end expiration (the lowest level), each starting from
/// its neighbour in time, filters the fields in time, and builds and judges the models.
/// @param tissue  Of the reference, whose image is `reference`.
/// @throws InputError if phases lie on different grids or do not determine the model.
Capture CaptureMotion(const PhaseFiles& files, const volume::CtVolume& reference,
                      const Tissue& tissue, const KnownLandmarks& landmarks,
                      const CaptureSettings& settings, const RunContext& context);

/// The phase to register to.
std::size_t ReferenceOf(const PhaseFiles& files);

/// The same from displacement fields that are given: all on one grid, relative to one reference
/// state, whose field is 0 everywhere or not there. @param ct  Where the patient is, or null.
/// @throws InputError if fields lie on different grids, beside the CT, or are beyond 200 mm.
Capture CaptureFields(const PhaseFiles& files, const volume::Geometry* ct,
                      const CaptureSettings& settings, const RunContext& context);

/// A synthetic motion from a single CT at end expiration: a regular breath of diaphragm, chest and
/// belly, fitted to where the labels have the diaphragm and the ribs.
Capture CaptureSingle(const volume::LabelMap& labels, double diaphragm_mm,
                      const CaptureSettings& settings, const RunContext& context);

}  // namespace acus::breathing_registration
