#include "acus/patient/phantom/planning/spinal_level.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::phantom {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

constexpr const char* kVertebrae =
    "name,whole,x_mm,y_mm,z_mm,volume_ml\n"
    "L2,1,10,-50,100,40\nL3,1,10,-52,65,40\nL4,1,10,-50,30,40\n";

TEST(SpinalLevel, IsNeitherAStructureNorAPoint) {
  EXPECT_TRUE(NamesSpinalLevel("L3-L4"));
  EXPECT_TRUE(NamesSpinalLevel("vertebra_2-vertebra_3"));
  EXPECT_FALSE(NamesSpinalLevel(""));
  EXPECT_FALSE(NamesSpinalLevel("kidney_left"));
  EXPECT_FALSE(NamesSpinalLevel("-62,-15,90"));
  EXPECT_FALSE(NamesSpinalLevel("1e-3,0,0"));
}

TEST(SpinalLevel, IsAtTheDiscAndSomewhatBelowIt) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "vertebrae.csv", kVertebrae);
  const SpinalLevel level = ReadSpinalLevel("L2-L3", folder / "vertebrae.csv");
  EXPECT_EQ(level.upper_ct_mm, Eigen::Vector3d(10, -50, 100));
  EXPECT_EQ(level.lower_ct_mm, Eigen::Vector3d(10, -52, 65));
  EXPECT_NEAR(level.ShareAt({10, -51, 82.5}), 0.5, 1e-12);
  // Farther back or to the side is the same height.
  const Eigen::Vector3d across = Eigen::Vector3d(0, 35, -2).normalized();
  EXPECT_NEAR(level.ShareAt(Eigen::Vector3d(40, -51, 82.5) + 50.0 * across), 0.5, 1e-12);
  EXPECT_TRUE(level.HasAt({10, -51, 80}));
  EXPECT_FALSE(level.HasAt({10, -50, 98}));
  EXPECT_FALSE(level.HasAt({10, -52, 66}));
}

TEST(SpinalLevel, SaysWhichVertebraeThereAre) {
  const TemporaryFolder folder;
  const auto refuses = [&](const char* target, auto message) {
    EXPECT_THAT([&] { ReadSpinalLevel(target, folder / "vertebrae.csv"); },
                ThrowsMessage<InputError>(message))
        << target;
  };
  refuses("L3-L4", AllOf(HasSubstr("vertebrae.csv"), HasSubstr("acus-segment writes it")));
  WriteTextFile(folder / "vertebrae.csv", kVertebrae);
  for (const char* target : {"L4-L5", "L2-L4", "L3-L2", "L5-S1", "-L3", "L3-"}) {
    refuses(target, AllOf(HasSubstr(target), HasSubstr("L2, L3, L4")));
  }
  WriteTextFile(folder / "vertebrae.csv", "name,x_mm,y_mm,z_mm\nL2,1,2,3\nL3,1,2,3\n");
  refuses("L2-L3", HasSubstr("same place"));
}

}  // namespace
}  // namespace acus::phantom
