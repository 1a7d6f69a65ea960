#include "acus/data/volume/labels_of_ct.h"

#include <gmock/gmock.h>

#include "acus/data/volume/labels.h"

namespace acus::volume {
namespace {

using testing::HasSubstr;

struct Patient {
  CtVolume ct;
  LabelMap labels;
};

/// A body of 40 HU with a block of bone of 300 HU and one of gas, moved by so many voxels.
Patient PatientWithBlocks(int shift, double spacing_mm = 2.0) {
  Geometry grid;
  grid.size = {60, 40, 30};
  grid.spacing_mm = Eigen::Array3d::Constant(spacing_mm);
  Patient patient{CtVolume(grid), LabelMap(grid)};
  const Label bone = LabelOf("bone"), gas = LabelOf("gas"), soft = LabelOf("soft_tissue");
  patient.labels.names = {{bone, "bone"}, {gas, "gas"}, {soft, "soft_tissue"}};
  for (int k = 0; k < 30; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 60; ++i) {
        const bool in_block = j > 10 && j < 30 && k > 5 && k < 25;
        const bool is_bone = in_block && i >= 2 + shift && i < 12 + shift;
        const bool is_gas = in_block && i >= 42 + shift && i < 52 + shift;
        patient.labels.At(i, j, k) = is_bone ? bone : is_gas ? gas : soft;
        patient.ct.At(i, j, k) = is_bone ? 300 : is_gas ? -900 : 40;
      }
    }
  }
  return patient;
}

TEST(LabelsOfCt, FitThePatientAndNoOther) {
  const Patient one = PatientWithBlocks(0), other = PatientWithBlocks(7);
  EXPECT_FALSE(WhyLabelsAreOfAnother(one.ct, one.labels));
  const auto why = WhyLabelsAreOfAnother(one.ct, other.labels);
  ASSERT_TRUE(why);
  EXPECT_THAT(*why, HasSubstr("only 30 % of its bone has 60 HU or more"));
}

TEST(LabelsOfCt, AFewMillimetresAreNotJudged) {
  EXPECT_FALSE(WhyLabelsAreOfAnother(PatientWithBlocks(0).ct, PatientWithBlocks(1).labels));
}

TEST(LabelsOfCt, GridsMayDiffer) {
  Patient one = PatientWithBlocks(0);
  // Every second voxel, at the same places.
  LabelMap coarse([&] {
    Geometry grid = one.labels.geometry;
    grid.size = {30, 20, 15};
    grid.spacing_mm *= 2.0;
    return grid;
  }());
  coarse.names = one.labels.names;
  for (int k = 0; k < 15; ++k) {
    for (int j = 0; j < 20; ++j) {
      for (int i = 0; i < 30; ++i) coarse.At(i, j, k) = one.labels.At(2 * i, 2 * j, 2 * k);
    }
  }
  EXPECT_FALSE(WhyLabelsAreOfAnother(one.ct, coarse));
}

TEST(LabelsOfCt, TooLittleBoneSaysNothing) {
  Patient one = PatientWithBlocks(0);
  for (Label& label : one.labels.voxels) label = LabelOf("soft_tissue");
  for (int i = 0; i < 60; ++i) one.labels.At(i, 0, 0) = LabelOf("bone");
  EXPECT_FALSE(WhyLabelsAreOfAnother(one.ct, one.labels));
}

}  // namespace
}  // namespace acus::volume
