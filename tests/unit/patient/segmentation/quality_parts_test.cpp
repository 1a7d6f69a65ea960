#include "acus/patient/segmentation/quality_parts.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "support/temporary_folder.h"
#include "synthetic_body.h"

namespace acus::segmentation {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// A body with skin, bone, canal and disc in voxels of a size.
volume::LabelMap Labels(double slices_mm) {
  volume::Geometry g;
  g.size = {40, 40, 80};
  g.spacing_mm = {1.0, 1.0, slices_mm};
  volume::LabelMap labels(g, volume::LabelOf("soft_tissue"));
  for (int k = 0; k < 80; ++k) {
    for (int j = 8; j <= 32; ++j) {
      for (int i = 8; i <= 32; ++i) {
        const bool is_canal = std::max(std::abs(i - 20), std::abs(j - 20)) <= 6;
        labels.At(i, j, k) = volume::LabelOf(is_canal ? "spinal_canal" : "bone");
      }
    }
    for (int i = 0; i < 40; ++i) labels.At(i, 0, k) = volume::LabelOf("skin");
    labels.At(20, 10, k) = volume::LabelOf("disc");
  }
  return labels;
}

const PartQuality& Part(const std::vector<PartQuality>& parts, const std::string& name) {
  const auto found = std::ranges::find(parts, name, &PartQuality::name);
  if (found == parts.end()) throw std::runtime_error("no part " + name);
  return *found;
}

Vertebrae NamedFromRibs() {
  Vertebrae vertebrae;
  vertebrae.list = {{.name = "T12", .is_whole = true, .centre_mm = {1, 2, 30}, .volume_ml = 40},
                    {.name = "L1", .is_whole = true, .centre_mm = {1, 2, -4}, .volume_ml = 41}};
  vertebrae.named_from = NamedFrom::kLastRib;
  return vertebrae;
}

TEST(QualityParts, OfAGoodScanAreSure) {
  for (const PartQuality& part : PartsOf(Labels(1.0), {}, {}, {}, 1)) {
    EXPECT_TRUE(part.is_sure) << part.name;
  }
}

TEST(QualityParts, NameWhatSpeaksAgainstThemAndTheCorrection) {
  const ScanParameters noisy{.field = {}, .noise_hu = 60.0};
  const auto parts = PartsOf(Labels(5.0), noisy, NamedFromRibs(), {}, 1);
  EXPECT_THAT(Part(parts, "disc").why, HasSubstr("5.0 mm do not resolve"));
  EXPECT_THAT(Part(parts, "bone").why, HasSubstr("noise of 60 HU"));
  EXPECT_THAT(Part(parts, "names of vertebrae").why, HasSubstr("last pair of ribs"));
  EXPECT_THAT(PartsTable(parts),
              AllOf(HasSubstr("UNSURE"), HasSubstr("--vertebra NAME=1.0,2.0,-4.0"),
                    HasSubstr("preview_sagittal.png")));
}

TEST(QualityParts, ACanalThatCannotBeOneIsUnsure) {
  const volume::Label canal = volume::LabelOf("spinal_canal"), bone = volume::LabelOf("bone");
  volume::LabelMap shorter = Labels(1.0), wide = Labels(1.0), bare = Labels(1.0);
  for (int k = 0; k < 80; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) {
        if (k > 30 && shorter.At(i, j, k) == canal) shorter.At(i, j, k) = bone;
        if (bare.At(i, j, k) == bone) bare.At(i, j, k) = volume::LabelOf("fat");
      }
    }
  }
  wide.geometry.spacing_mm[0] = 8.0;
  const auto why = [](const volume::LabelMap& labels) {
    const PartQuality part = Part(PartsOf(labels, {}, {}, {}, 1), "spinal_canal");
    EXPECT_FALSE(part.is_sure);
    EXPECT_FALSE(part.certainty);  // No such case was measured.
    return part.why;
  };
  EXPECT_THAT(why(shorter), HasSubstr("only 31 mm long"));
  EXPECT_THAT(why(bare), HasSubstr("bone is only 0 %"));
  EXPECT_THAT(why(wide), HasSubstr("which no adult has"));
}

TEST(QualityParts, StateTheirCertainty) {
  const auto parts = PartsOf(Labels(1.0), {}, {}, {}, 1);
  EXPECT_GE(Part(parts, "spinal_canal").certainty.value(), kLeastCertainty);
  const auto noisy = PartsOf(Labels(1.0), {.field = {}, .noise_hu = 60.0}, {}, {}, 1);
  EXPECT_LT(Part(noisy, "spinal_canal").certainty.value(),
            Part(parts, "spinal_canal").certainty.value());
  EXPECT_FALSE(Part(parts, "skin").certainty);
  EXPECT_THAT(PartsTable(parts), AllOf(HasSubstr("certainty"), HasSubstr(" %")));
}

TEST(QualityParts, StateExpectedDiceAndCertaintyOfOrgansFromAnAtlas) {
  const OrganCheck held{.name = "liver",
                        .volume_ml = 1400,
                        .least_ml = 594,
                        .most_ml = 2250,
                        .doubts = {},
                        .expected_dice = 0.91};
  OrganCheck free = held, imported = held;
  free.name = "spleen";
  free.doubts = {"only 60 % of its surface lies at an edge of the CT"};
  free.expected_dice = 0.7;
  imported.name = "kidney_left";
  imported.expected_dice.reset();
  const auto parts = PartsOf(Labels(1.0), {}, {}, {held, free, imported}, 1);
  EXPECT_TRUE(Part(parts, "liver").is_sure);
  EXPECT_GE(Part(parts, "liver").certainty.value(), kLeastCertainty);
  EXPECT_THAT(Part(parts, "liver").why, HasSubstr("expected Dice 0.91"));
  EXPECT_FALSE(Part(parts, "spleen").is_sure);
  EXPECT_LT(Part(parts, "spleen").certainty.value(), kLeastCertainty);
  EXPECT_FALSE(Part(parts, "kidney_left").certainty) << "only organs of an atlas were measured";
  const testing_support::TemporaryFolder folder;
  WriteQuality(folder / "quality.json", {}, {}, parts, {});
  EXPECT_THAT(ReadTextFile(folder / "quality.json"), HasSubstr("\"expected_dice\": 0.91"));
  EXPECT_THAT(UnsurePartsBeside(folder / "labels.seg.nrrd"),
              testing::Contains(AllOf(HasSubstr("spleen (only 60 %"), HasSubstr("certainty"))));
}

TEST(QualityParts, AMissingSpineAndSkinAreUnsure) {
  volume::LabelMap labels = Labels(1.0);
  for (auto& label : labels.voxels) {
    if (label != volume::LabelOf("bone")) label = volume::LabelOf("soft_tissue");
  }
  const auto parts = PartsOf(labels, {}, {}, {}, 1);
  EXPECT_FALSE(Part(parts, "spinal_canal").is_sure);
  EXPECT_THAT(Part(parts, "skin").why, HasSubstr("no skin"));
}

TEST(QualityParts, AreReadFromTheFolderOfTheLabels) {
  const testing_support::TemporaryFolder folder;
  const auto labels = folder / "labels.seg.nrrd";
  EXPECT_THAT(UnsurePartsBeside(labels), IsEmpty());
  WriteQuality(folder / "quality.json", {}, {}, PartsOf(Labels(5.0), {}, NamedFromRibs(), {}, 1),
               {});
  // Names of vertebrae are no labels.
  EXPECT_THAT(UnsurePartsBeside(labels), testing::ElementsAre(HasSubstr("disc (voxels of 5.0 mm")));
  WriteTextFile(folder / "quality.json", "{}");  // Of another program.
  EXPECT_THAT(UnsurePartsBeside(labels), IsEmpty());
}

TEST(QualityPage, HasTheTableTheImagesAndTheVolumes) {
  const testing_support::TemporaryFolder folder;
  const SyntheticBody body = MakeSyntheticBody({.noise_hu = 60.0});
  const auto config = ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
  const RunContext context;
  TissuesFound found = SegmentPatient(body.ct, config, context);
  found.scan.enhanced = true;
  // A kidney, as if from an atlas.
  const Eigen::Array3i middle = found.labels.geometry.size / 2;
  for (int n = 0; n < 5; ++n) {
    found.labels.At(middle[0] + n, middle[1], middle[2]) = volume::LabelOf("kidney");
  }
  found.labels.names[volume::LabelOf("kidney")] = "kidney";
  Examination examination;
  for (const char* name : {"kidney", "kidney_left", "kidney_right"}) {
    examination.organs.push_back({.name = name, .edge_share = 0.95, .covered_share = 1.0});
  }
  const auto patient = Examine(body.ct, config, std::move(found), examination, context);
  WritePatientFolder(folder / "out", body.ct, patient, config, context);
  const std::string page = acus::ReadTextFile(folder / "out" / "report.html");
  EXPECT_THAT(page,
              AllOf(HasSubstr("What is sure, what is not"), HasSubstr("acus-segment --import"),
                    HasSubstr("sagittal plane"), HasSubstr("as seen from behind"),
                    HasSubstr("of adults, ml"), HasSubstr("with contrast agent, edges within it"),
                    HasSubstr("expected Dice 0.95")));
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "view_back.png"));
}

}  // namespace
}  // namespace acus::segmentation
