// A real CT breathes with a known motion, and registration finds it: two phases, as a short form of
// developer/breathing-accuracy.
#include <gmock/gmock.h>
#include <optional>

#include "acus/base/math/statistics.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/breathing_registration/patient_tissue.h"
#include "acus/patient/breathing_registration/phase_registration.h"
#include "acus/patient/phantom/anatomy/cavity.h"
#include "acus/patient/phantom/breath/breathing_scan.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "support/shared_data.h"
#include "support/temporary_folder.h"

namespace acus::breathing_registration {
namespace {

struct Errors {
  std::vector<double> all_mm, near_wall_mm;
};

/// A CT that breathes, with 300 points in lung and liver; registered with the default settings.
class BreathingCt {
 public:
  explicit BreathingCt(const std::filesystem::path& folder) : ct_(volume::ReadCt(folder, "", {})) {
    context_.num_threads = 2;
    const auto config = segmentation::ReadSegmentationConfig(
        std::filesystem::path(ACUS_SOURCE_DIR) / "configs/segmentation/default.json");
    const auto labels = segmentation::SegmentPatient(ct_, config, context_).labels;
    const testing_support::TemporaryFolder temporary;
    volume::WriteLabelMap(temporary / "labels.seg.nrrd", labels);
    motion_.emplace(phantom::FindCavity(labels, context_), phantom::BreathingSettings{});
    const Tissue tissue = TissueOf(ct_, temporary / "labels.seg.nrrd", true, context_);
    registration_.emplace(ct_, tissue, RegistrationSettings{}, context_);
    landmarks_ = phantom::RandomLandmarks(labels, *motion_, {.level = 1.0}, 300, context_);
  }

  volume::CtVolume PhaseAt(const breathing::Breath& breath) const {
    return phantom::ScanAt(ct_, *motion_, breath, {}, context_);
  }
  PhaseField Register(const volume::CtVolume& phase, const PhaseField* start) const {
    return registration_->Register(phase, start, context_);
  }
  Errors ErrorsOf(const PhaseField& field, const breathing::Breath& breath) const {
    Errors errors;
    for (const auto& landmark : landmarks_) {
      const Eigen::Vector3d& p = landmark.rest_mm;
      const Side side = motion_->InCavity(p) ? Side::kCavity : Side::kWall;
      const double error = (p + field.DisplacementMm(p, side) - motion_->WorldMm(p, breath)).norm();
      errors.all_mm.push_back(error);
      if (landmark.wall_mm < 10.0) errors.near_wall_mm.push_back(error);
    }
    return errors;
  }

 private:
  RunContext context_;
  volume::CtVolume ct_;
  std::optional<phantom::BreathingMotion> motion_;
  std::optional<PhaseRegistration> registration_;
  std::vector<phantom::TissueLandmark> landmarks_;
};

class RealCt : public testing::TestWithParam<const char*> {};

TEST_P(RealCt, IsRegisteredFromAnyStart) {
  const auto folder = testing_support::SharedData(GetParam());
  if (!folder) GTEST_SKIP() << "test data " << GetParam() << " is not here";
  const BreathingCt patient(*folder);
  const breathing::Breath half_way{.cycle = 0.75, .level = 0.5, .level_per_s = 0.78};
  const PhaseField half = patient.Register(patient.PhaseAt(half_way), nullptr);
  const Errors at_half = patient.ErrorsOf(half, half_way);
  RecordProperty("half_way_mean_mm", std::to_string(math::Mean(at_half.all_mm)));
  EXPECT_LT(math::Mean(at_half.all_mm), 1.0);
  EXPECT_LT(math::Quantile(at_half.all_mm, 0.95), 2.5);

  const breathing::Breath inspiration{.cycle = 0.0, .level = 1.0, .level_per_s = 0.0};
  const auto full = patient.PhaseAt(inspiration);
  const Errors from_half = patient.ErrorsOf(patient.Register(full, &half), inspiration);
  const Errors from_rest = patient.ErrorsOf(patient.Register(full, nullptr), inspiration);
  RecordProperty("inspiration_mean_mm", std::to_string(math::Mean(from_half.all_mm)));
  RecordProperty("inspiration_p95_mm", std::to_string(math::Quantile(from_half.all_mm, 0.95)));
  RecordProperty("near_wall_mean_mm", std::to_string(math::Mean(from_half.near_wall_mm)));
  EXPECT_LT(math::Mean(from_half.all_mm), 1.0);
  EXPECT_LT(math::Quantile(from_half.all_mm, 0.95), 2.5);
  // Where it ends does not depend on where it begins.
  EXPECT_NEAR(math::Mean(from_rest.all_mm), math::Mean(from_half.all_mm), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Data, RealCt, testing::Values("ct/thorax_dicom", "ct/ircadb01_dicom"));

}  // namespace
}  // namespace acus::breathing_registration
