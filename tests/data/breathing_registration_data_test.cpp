// A real CT breathes with a known motion, and registration finds it: two phases, as a short form of
// developer/breathing-accuracy.
#include <array>
#include <cstdio>
#include <gmock/gmock.h>
#include <optional>

#include "acus/base/math/statistics.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/breathing_registration/patient_tissue.h"
#include "acus/patient/breathing_registration/phase_registration.h"
#include "acus/patient/phantom/anatomy/cavity.h"
#include "acus/patient/phantom/breath/breathing_scan.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "support/lung_motion.h"
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
    labels_ = segmentation::SegmentPatient(ct_, config, context_).labels;
    const volume::LabelMap& labels = labels_;
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
  /// Lung as it moves from end expiration to end inspiration, every third voxel along each axis.
  testing_support::MovedLung MovedLung() const {
    testing_support::MovedLung lung;
    const volume::Geometry& g = ct_.geometry;
    for (int k = 0; k < g.size[2]; k += 3) {
      for (int j = 0; j < g.size[1]; j += 3) {
        for (int i = 0; i < g.size[0]; i += 3) {
          const Eigen::Vector3d p = g.ct_from_index() * Eigen::Vector3d(i, j, k);
          if (labels_.At(i, j, k) != volume::LabelOf("lung") || !motion_->InCavity(p)) continue;
          lung.Add(p, motion_->WorldMm(p, {.level = 1.0}));
        }
      }
    }
    return lung;
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
  volume::LabelMap labels_;
  std::optional<phantom::BreathingMotion> motion_;
  std::optional<PhaseRegistration> registration_;
  std::vector<phantom::TissueLandmark> landmarks_;
};

void Print(const std::string& whose, const testing_support::LungMotion& motion) {
  std::printf("  %-18s", whose.c_str());
  for (const double share : motion.by_height) std::printf(" %.2f", share);
  std::printf("; |AP| %.2f, |LR| %.2f of |SI|\n", motion.ap_share, motion.lr_share);
}

/// Of the patients whose points were not used to choose the motion.
constexpr std::array kUnusedPatients = {1, 3, 5};

void LungMovesAsInUnusedPatients(const testing_support::LungMotion& simulated) {
  std::vector<testing_support::LungMotion> measured;
  for (const int patient : kUnusedPatients) {
    const auto file =
        testing_support::SharedData(Message("breathing/dirlab/case", patient, ".csv").c_str());
    if (!file) return;
    measured.push_back(testing_support::MeasuredLungMotion(*file));
    Print(Message("patient ", patient), measured.back());
  }
  Print("simulated", simulated);
  for (std::size_t tenth = 1; tenth < 10; ++tenth) {
    std::vector<double> shares;
    for (const auto& motion : measured) shares.push_back(motion.by_height[tenth]);
    EXPECT_GT(simulated.by_height[tenth], std::ranges::min(shares) - 0.1) << tenth;
    EXPECT_LT(simulated.by_height[tenth], std::ranges::max(shares) + 0.1) << tenth;
  }
}

class RealCt : public testing::TestWithParam<const char*> {};

TEST_P(RealCt, IsRegisteredFromAnyStart) {
  const auto folder = testing_support::SharedData(GetParam());
  if (!folder) GTEST_SKIP() << "test data " << GetParam() << " is not here";
  const BreathingCt patient(*folder);
  const breathing::Breath inspiration{.cycle = 0.0, .level = 1.0, .level_per_s = 0.0};
  const auto full = patient.PhaseAt(inspiration);
  const Errors from_rest = patient.ErrorsOf(patient.Register(full, nullptr), inspiration);
  RecordProperty("inspiration_mean_mm", std::to_string(math::Mean(from_rest.all_mm)));
  RecordProperty("inspiration_p95_mm", std::to_string(math::Quantile(from_rest.all_mm, 0.95)));
  RecordProperty("near_wall_mean_mm", std::to_string(math::Mean(from_rest.near_wall_mm)));
  EXPECT_LT(math::Mean(from_rest.all_mm), 1.0);
  EXPECT_LT(math::Quantile(from_rest.all_mm, 0.95), 2.5);
  // Whole lungs, and every start; the other CT has only their bases, and one start.
  if (std::string(GetParam()) != "ct/thorax_dicom") return;
  LungMovesAsInUnusedPatients(testing_support::MotionOf(patient.MovedLung()));

  const breathing::Breath half_way{.cycle = 0.75, .level = 0.5, .level_per_s = 0.78};
  const PhaseField half = patient.Register(patient.PhaseAt(half_way), nullptr);
  const Errors at_half = patient.ErrorsOf(half, half_way);
  RecordProperty("half_way_mean_mm", std::to_string(math::Mean(at_half.all_mm)));
  EXPECT_LT(math::Mean(at_half.all_mm), 1.0);
  EXPECT_LT(math::Quantile(at_half.all_mm, 0.95), 2.5);
  // Where it ends does not depend on where it begins.
  const Errors from_half = patient.ErrorsOf(patient.Register(full, &half), inspiration);
  EXPECT_NEAR(math::Mean(from_half.all_mm), math::Mean(from_rest.all_mm), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Data, RealCt, testing::Values("ct/thorax_dicom", "ct/ircadb01_dicom"));

}  // namespace
}  // namespace acus::breathing_registration
