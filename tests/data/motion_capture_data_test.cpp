// A real CT breathes with a known motion, and registration finds it: one phase, as a short form of
// docs/models/breathing_registration.md.
#include <gmock/gmock.h>

#include "math/statistics.h"
#include "motion_capture/patient_tissue.h"
#include "motion_capture/phase_registration.h"
#include "phantom/breathing_scan.h"
#include "phantom/cavity.h"
#include "segmentation/patient_segmentation.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"
#include "volume/volume_io.h"

namespace acus::motion_capture {
namespace {

struct Errors {
  std::vector<double> all_mm, near_wall_mm;
};

/// Half way in, on a grid of 3 mm, without a neighbour in time to start from.
Errors RegisterOnePhase(const std::filesystem::path& folder) {
  RunContext context;
  context.num_threads = 2;
  const auto ct = volume::ReadCt(folder, "", context);
  const auto config = segmentation::ReadSegmentationConfig(std::filesystem::path(ACUS_SOURCE_DIR) /
                                                           "configs/segmentation/default.json");
  const auto labels = segmentation::SegmentPatient(ct, config, {}, context);
  const testing_support::TemporaryFolder temporary;
  volume::WriteLabelMap(temporary / "labels.seg.nrrd", labels);
  const phantom::BreathingMotion motion(phantom::FindCavity(labels, context), {});
  const breathing::Breath breath{.cycle = 0.75, .level = 0.5, .level_per_s = 0.78};
  const auto phase = phantom::ScanAt(ct, motion, breath, {}, context);
  const Tissue tissue = TissueOf(ct, temporary / "labels.seg.nrrd", true, context);
  const PhaseRegistration registration(ct, tissue, {.spacing_mm = 3.0}, context);
  const PhaseField field = registration.Register(phase, nullptr, context);
  Errors errors;
  for (const auto& landmark : phantom::RandomLandmarks(labels, motion, breath, 300, context)) {
    const Eigen::Vector3d& p = landmark.rest_mm;
    const Side side = motion.InCavity(p) ? Side::kCavity : Side::kWall;
    const double error = (p + field.DisplacementMm(p, side) - motion.WorldMm(p, breath)).norm();
    errors.all_mm.push_back(error);
    if (landmark.wall_mm < 10.0) errors.near_wall_mm.push_back(error);
  }
  return errors;
}

class RealCt : public testing::TestWithParam<const char*> {};

TEST_P(RealCt, IsRegisteredToAMillimetre) {
  const auto folder = testing_support::SharedData(GetParam());
  if (!folder) GTEST_SKIP() << "test data " << GetParam() << " is not here";
  const Errors errors = RegisterOnePhase(*folder);
  RecordProperty("mean_mm", std::to_string(math::Mean(errors.all_mm)));
  RecordProperty("near_wall_mean_mm", std::to_string(math::Mean(errors.near_wall_mm)));
  EXPECT_LT(math::Mean(errors.all_mm), 1.0);
  EXPECT_LT(math::Quantile(errors.all_mm, 0.95), 2.5);
}

INSTANTIATE_TEST_SUITE_P(Data, RealCt, testing::Values("ct/thorax_dicom", "ct/ircadb01_dicom"));

}  // namespace
}  // namespace acus::motion_capture
