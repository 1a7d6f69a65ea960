#include "acus/patient/atlas/atlas_organs.h"

#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/anatomy/imaging.h"
#include "acus/patient/phantom/anatomy/phantom_config.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "acus/patient/segmentation/voxels/metrics.h"
#include "support/temporary_folder.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using testing_support::TemporaryFolder;
using volume::LabelMap;

RunContext TwoThreads() {
  RunContext context;
  context.num_threads = 2;
  return context;
}

segmentation::TissueOptions Tissues() {
  return segmentation::ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json")
      .tissues;
}

/// A synthetic abdomen whose parts vary in size by the seed. @param shift_hu  Of solid organs.
phantom::Scan Abdomen(std::uint64_t seed, int shift_hu) {
  auto config = phantom::ReadPhantomConfig(ACUS_SOURCE_DIR "/testdata/small_liver.json");
  config.body.variation_percent = 8.0;
  RunContext context = TwoThreads();
  context.seed = seed;
  phantom::Scan scan = phantom::RenderScan(phantom::Anatomy(config.body, seed), config.grid,
                                           config.scanner, context);
  for (std::size_t n = 0; n < scan.ct.voxels.size(); ++n) {
    for (const char* name : {"liver", "kidney", "spleen"}) {
      if (scan.labels.voxels[n] != volume::LabelOf(name)) continue;
      scan.ct.voxels[n] = static_cast<std::int16_t>(scan.ct.voxels[n] - shift_hu);
    }
  }
  return scan;
}

/// An atlas of one patient in a folder.
void WriteAtlas(const std::filesystem::path& folder, const phantom::Scan& scan) {
  volume::WriteCt(folder / "ct.nrrd", scan.ct);
  volume::WriteLabelMap(folder / "labels.seg.nrrd", scan.labels);
  WriteTextFile(folder / "atlas.json", R"({"format": "acus-atlas/1", "patients": [{"name": "one",
    "ct": "ct.nrrd", "labels": "labels.seg.nrrd"}]})");
}

struct Organs {
  LabelMap labels;
  std::vector<segmentation::OrganEvidence> evidence;
};

Organs Found(const phantom::Scan& patient, const std::filesystem::path& atlas, RunContext context) {
  Organs found{segmentation::FindTissues(patient.ct, Tissues(), context).labels, {}};
  found.evidence =
      AddAtlasOrgans(patient.ct, ReadAtlas({atlas}, context), Tissues(), found.labels, context);
  return found;
}

double DiceOf(const char* name, const LabelMap& a, const LabelMap& b) {
  const auto mask = [&](const LabelMap& map) {
    Mask out(map.geometry);
    for (std::size_t n = 0; n < out.voxels.size(); ++n) {
      out.voxels[n] = map.voxels[n] == volume::LabelOf(name);
    }
    return out;
  };
  return segmentation::Dice(mask(a), mask(b));
}

// The atlas was scanned without the patient's contrast agent, and its organs have other sizes.
TEST(AtlasOrgans, AreFoundInAPatientOfOtherSizesAndContrast) {
  const TemporaryFolder folder;
  WriteAtlas(folder.path(), Abdomen(2, 50));
  const phantom::Scan patient = Abdomen(1, 0);
  const Organs found = Found(patient, folder.path(), TwoThreads());
  EXPECT_GT(DiceOf("liver", found.labels, patient.labels), 0.85);
  EXPECT_GT(DiceOf("spleen", found.labels, patient.labels), 0.8);
  EXPECT_GT(DiceOf("kidney", found.labels, patient.labels), 0.8);
  ASSERT_GE(found.evidence.size(), 3U);
  for (const auto& organ : found.evidence) {
    EXPECT_GT(organ.edge_share, 0.5) << organ.name;
    EXPECT_FALSE(organ.self_check) << "the atlas has one patient";
  }
}

TEST(AtlasOrgans, WhatIsKnownStays) {
  const TemporaryFolder folder;
  const phantom::Scan patient = Abdomen(1, 0);
  WriteAtlas(folder.path(), patient);
  RunContext context = TwoThreads();
  LabelMap labels = patient.labels;
  AddAtlasOrgans(patient.ct, ReadAtlas({folder.path()}, context), Tissues(), labels, context);
  EXPECT_EQ(labels.voxels, patient.labels.voxels);
}

}  // namespace
}  // namespace acus::atlas
