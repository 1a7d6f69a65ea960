// Vessels, ducts and a lesion put into the liver of a real CT, whose own vessels and tumour stay.
#include <gtest/gtest.h>
#include <iostream>

#include "acus/data/volume/volume_io.h"
#include "support/liver_ducts_checks.h"
#include "support/shared_data.h"

namespace acus::phantom {
namespace {

using testing_support::SharedData;

TEST(LiverDuctsInARealCt, StayInTheLiver) {
  const auto scan = SharedData("ct/ircadb01_dicom");
  const auto map = SharedData("ct/ircadb01_labels.vti");
  if (!scan || !map) GTEST_SKIP() << "test data ct/ircadb01 is not here";
  const volume::CtVolume ct = volume::ReadCt(*scan, "", {});
  const auto values = volume::ReadIntegerVolume(*map);
  volume::LabelMap labels(ct.geometry, volume::LabelOf("soft_tissue"));
  ASSERT_EQ(values.voxels.size(), labels.voxels.size());
  for (std::size_t n = 0; n < values.voxels.size(); ++n) {
    if (values.voxels[n] == 449) labels.voxels[n] = volume::LabelOf("liver");
  }
  labels.names = {{volume::LabelOf("soft_tissue"), "soft_tissue"},
                  {volume::LabelOf("liver"), "liver"}};
  RunContext context;
  context.seed = 1;
  const LiverDuctSettings settings;
  const LiverDucts made = PutDuctsIntoLiver(ct, labels, settings, context);
  std::cout << LiverDuctsText(made);
  EXPECT_GT(made.vessels.size(), 30U);
  EXPECT_GT(made.ducts.size(), 15U);
  testing_support::CheckLiverDucts(ct, labels, settings, made);
}

}  // namespace
}  // namespace acus::phantom
