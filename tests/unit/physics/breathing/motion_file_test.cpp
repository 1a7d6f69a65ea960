#include "acus/physics/breathing/motion_file.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/physics/breathing/model_building.h"
#include "support/breathing_box.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::breathing {
namespace {

PatientMotion Motion(MotionKind kind) {
  return {.name = "box",
          .model = BuildModel(kind, testing_support::TruePhases(8)),
          .inspiration_level = 1.0,
          .expiration_level = -0.2,
          .period_s = 3.5};
}

class MotionFile : public testing::Test {
 protected:
  const std::filesystem::path& folder() const { return folder_.path(); }
  std::string Refusal() const {
    try {
      ReadPatientMotion(folder());
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(MotionFile, ReadsBackTheSameBitsForEveryModel) {
  for (const MotionKind kind : {MotionKind::kSinusoid, MotionKind::kFullCycle,
                                MotionKind::kHalfCycle, MotionKind::kSurrogate}) {
    const PatientMotion written = Motion(kind);
    WritePatientMotion(folder(), written);
    const PatientMotion read = ReadPatientMotion(folder() / "motion.json");
    EXPECT_EQ(read.model.kind(), kind);
    EXPECT_EQ(read.period_s, 3.5);
    for (const double share : {0.0, 0.13, 0.5, 0.77}) {
      const Breath breath = testing_support::RegularBreath(share, 1.3);
      const Eigen::Vector3d place(11, -7, 50);
      EXPECT_EQ(read.model.field().DisplacementMm(read.model.WeightsAt(breath), place),
                written.model.field().DisplacementMm(written.model.WeightsAt(breath), place))
          << NameOf(kind) << " at " << share;
    }
  }
}

TEST_F(MotionFile, ReadsBackTheBound) {
  PatientMotion written = Motion(MotionKind::kSurrogate);
  const volume::Geometry& nodes = written.model.field().nodes();
  std::vector<float> mm(nodes.num_voxels(), 2.0F);
  mm[0] = 0.0F;  // No tissue.
  written.bound.emplace(nodes, mm);
  WritePatientMotion(folder(), written);
  const PatientMotion read = ReadPatientMotion(folder());
  ASSERT_TRUE(read.bound);
  EXPECT_EQ(read.bound->at_nodes_mm(), mm);
  const Eigen::Vector3d first = nodes.origin_mm;
  EXPECT_EQ(read.bound->Mm(first, 1.0), 0.0);
  // Beside the node without tissue only the others count.
  const Eigen::Vector3d beside = nodes.ct_from_index() * Eigen::Vector3d(0.5, 0.5, 0.5);
  EXPECT_NEAR(read.bound->Mm(beside, 1.0), 2.0, 1e-9);
  EXPECT_NEAR(read.bound->Mm(beside, 0.5), 1.0, 1e-9);
  EXPECT_NEAR(read.bound->Mm(beside, 0.0), 0.4, 1e-9);
  EXPECT_EQ(read.bound->Mm(first - Eigen::Vector3d(0, 0, 1e4), 1.0), 0.0);
  EXPECT_THAT(ReadTextFile(folder() / "bound.nhdr"), testing::HasSubstr("data file: bound.raw"));
}

TEST(MotionBound, IsLinearBetweenItsNodes) {
  volume::Geometry nodes;
  nodes.size = {4, 5, 6};
  nodes.spacing_mm = {2.0, 3.0, 4.0};
  const auto at = [](const Eigen::Vector3d& index) {
    return 1.0 + index.dot(Eigen::Vector3d(0.5, 0.25, 2.0));
  };
  std::vector<float> mm(nodes.num_voxels());
  for (int k = 0; k < 6; ++k) {
    for (int j = 0; j < 5; ++j) {
      for (int i = 0; i < 4; ++i)
        mm[nodes.Index(i, j, k)] = static_cast<float>(at({1.0 * i, 1.0 * j, 1.0 * k}));
    }
  }
  const MotionBound bound(nodes, mm);
  for (const Eigen::Vector3d& index :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(3, 4, 5), Eigen::Vector3d(1.25, 2.5, 4.75),
        Eigen::Vector3d(2.5, 0.5, 1.0), Eigen::Vector3d(0.5, 3.75, 2.25)}) {
    EXPECT_NEAR(bound.Mm(nodes.ct_from_index() * index, 1.0), at(index), 1e-6) << index;
  }
}

TEST_F(MotionFile, SaysWhatIsWrongWithTheBound) {
  PatientMotion written = Motion(MotionKind::kSurrogate);
  const volume::Geometry& nodes = written.model.field().nodes();
  EXPECT_THROW(MotionBound(nodes, {1.0F}), InputError);
  EXPECT_THROW(MotionBound(nodes, std::vector<float>(nodes.num_voxels(), -1.0F)), InputError);
  written.bound.emplace(nodes, std::vector<float>(nodes.num_voxels(), 2.0F));
  WritePatientMotion(folder(), written);
  std::filesystem::resize_file(folder() / "bound.raw", 4);
  EXPECT_THAT(Refusal(),
              testing::AllOf(testing::HasSubstr("bound.raw"), testing::HasSubstr("copied whole")));
  std::filesystem::remove(folder() / "bound.raw");
  EXPECT_THAT(Refusal(), testing::HasSubstr("beside motion.json"));
}

TEST_F(MotionFile, PutsNormalBreathIntoTheTermsOfTheSignal) {
  const Breath breath = Motion(MotionKind::kSurrogate)
                            .InTermsOfSignal({.cycle = 0.25, .level = 0.5, .level_per_s = -2.0});
  EXPECT_EQ(breath.cycle, 0.25);
  EXPECT_NEAR(breath.level, 0.4, 1e-12);
  EXPECT_NEAR(breath.level_per_s, -2.4, 1e-12);
}

TEST_F(MotionFile, SaysWhatIsMissingOrDoesNotFit) {
  WritePatientMotion(folder(), Motion(MotionKind::kSurrogate));
  const auto fields = folder() / "fields.raw";
  std::filesystem::resize_file(fields, std::filesystem::file_size(fields) - 2);
  EXPECT_THAT(Refusal(), testing::HasSubstr("copied whole"));
  std::filesystem::remove(fields);
  EXPECT_THAT(Refusal(), testing::HasSubstr("belongs beside motion.json"));
  std::filesystem::remove(folder() / "motion.json");
  EXPECT_THAT(Refusal(), testing::HasSubstr("motion.json"));
}

TEST_F(MotionFile, SurvivesDamage) {
  WritePatientMotion(folder(), Motion(MotionKind::kHalfCycle));
  const auto path = folder() / "motion.json";
  const int refused = testing_support::ReadDamagedCopies(ReadTextFile(path), path, 400,
                                                         [&] { ReadPatientMotion(folder()); });
  EXPECT_GT(refused, 200);
}

}  // namespace
}  // namespace acus::breathing
