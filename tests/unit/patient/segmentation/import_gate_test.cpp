#include "acus/patient/segmentation/import/import_gate.h"

#include <gmock/gmock.h>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/import/lay_imports.h"
#include "acus/patient/segmentation/segmenters/other_bones.h"
#include "support/nifti_writer.h"
#include "support/temporary_folder.h"

namespace acus::segmentation {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

/// A box of soft tissue (50 HU) in air, 8 mm voxels, x from -160, y from -120, z from -200 mm, and
/// organs as boxes in it.
class BoxPatient {
 public:
  BoxPatient()
      : ct(Grid(), -1000),
        found(Grid()),
        import{.file = "map.nii.gz",
               .values = volume::Grid<std::int32_t>(Grid()),
               .mapping = {},
               .named_by = "by its header",
               .own_names = {},
               .names = LabelNames(ACUS_SOURCE_DIR "/configs/label_maps/names.json"),
               .structures = {}} {
    Fill({0, 0, 0}, {130, 90, 190}, [&](std::size_t n) {
      ct.voxels[n] = 50;
      found.voxels[n] = volume::LabelOf("soft_tissue");
    });
  }

  void Add(const std::string& name, const Eigen::Vector3d& centre, const Eigen::Vector3d& half,
           int hu = 60) {
    const auto value = static_cast<std::int32_t>(import.structures.size() + 1);
    const auto what = import.names.Find({.text = name, .codes = {}});
    ASSERT_TRUE(what) << name;
    import.structures.emplace(value, *what);
    import.mapping.tissue[value] = what->structure.tissue;
    import.mapping.name[value] = name;
    Fill(centre, half, [&](std::size_t n) {
      import.values.voxels[n] = value;
      ct.voxels[n] = static_cast<std::int16_t>(hu);
    });
  }

  ImportFindings Check() const { return CheckImport(import, ct, found); }

  volume::CtVolume ct;
  volume::LabelMap found;
  ImportedLabels import;

 private:
  static volume::Geometry Grid() {
    volume::Geometry grid;
    grid.size = {41, 31, 51};
    grid.spacing_mm.setConstant(8.0);
    grid.origin_mm = {-160, -120, -200};
    return grid;
  }

  template <typename Use>
  void Fill(const Eigen::Vector3d& centre, const Eigen::Vector3d& half, const Use& use) {
    const volume::Geometry grid = Grid();
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const Eigen::Vector3d at = grid.ct_from_index() * Eigen::Vector3d(i, j, k);
          if (((at - centre).cwiseAbs() - half).maxCoeff() <= 0.0) use(grid.Index(i, j, k));
        }
      }
    }
  }
};

/// With `mirror` -1 everything is on the wrong side, with `flip` -1 upside down.
BoxPatient Abdomen(double mirror = 1.0, double flip = 1.0) {
  BoxPatient patient;
  patient.Add("liver", {-70 * mirror, 0, 100 * flip}, {50, 50, 50}, 110);
  patient.Add("spleen", {90 * mirror, 40, 100 * flip}, {25, 25, 40}, 110);
  patient.Add("kidney_left", {60 * mirror, 50, 20 * flip}, {20, 20, 45}, 150);
  patient.Add("kidney_right", {-60 * mirror, 50, 20 * flip}, {20, 20, 45}, 150);
  patient.Add("urinary_bladder", {0, -40, -150 * flip}, {30, 30, 25}, 10);
  patient.Add("vertebrae_L2", {0, 70, 32 * flip}, {20, 16, 12}, 250);
  patient.Add("vertebrae_L3", {0, 70, 0}, {20, 16, 12}, 250);
  patient.Add("vertebrae_L4", {0, 70, -32 * flip}, {20, 16, 12}, 250);
  return patient;
}

TEST(ImportGate, HasNothingAgainstAPatient) {
  const ImportFindings findings = Abdomen().Check();
  EXPECT_THAT(findings.impossible, IsEmpty());
  EXPECT_THAT(findings.unusual, IsEmpty());
}

TEST(ImportGate, NamesAnOrganThatIsTooLarge) {
  BoxPatient patient;
  patient.Add("spleen", {0, 0, 0}, {130, 90, 190}, 50);
  EXPECT_THAT(patient.Check().impossible,
              Contains(AllOf(HasSubstr("'spleen' has 18265 ml"), HasSubstr("at most 4000 ml"))));
}

TEST(ImportGate, WarnsOfAnOrganThatIsTooSmallUnlessTheBorderCutsIt) {
  BoxPatient patient;
  patient.Add("liver", {-70, 0, 100}, {20, 20, 20}, 60);
  EXPECT_THAT(patient.Check().unusual, ElementsAre(HasSubstr("'liver' has only 77 ml")));
  BoxPatient cut;
  cut.found.voxels.assign(cut.found.voxels.size(), volume::LabelOf("soft_tissue"));
  cut.Add("liver", {-70, 0, 200}, {20, 20, 20}, 60);
  EXPECT_THAT(cut.Check().unusual, IsEmpty());
}

TEST(ImportGate, SaysThatSidesAreSwapped) {
  const auto findings = Abdomen(-1.0).Check().impossible;
  ASSERT_THAT(findings, ElementsAre(HasSubstr("left and right are swapped: liver, spleen")));
  // Only one pair: its names are shuffled.
  BoxPatient patient;
  patient.Add("liver", {-70, 0, 100}, {50, 50, 50}, 110);
  patient.Add("kidney_right", {60, 50, 20}, {20, 20, 45}, 150);
  patient.Add("kidney_left", {-60, 50, 20}, {20, 20, 45}, 150);
  EXPECT_THAT(patient.Check().impossible,
              ElementsAre(HasSubstr("kidney_right, kidney_left lie on the other side of the "
                                    "patient, but not liver")));
}

TEST(ImportGate, SaysThatUpAndDownAreSwapped) {
  const auto findings = Abdomen(1.0, -1.0).Check().impossible;
  EXPECT_THAT(findings,
              ElementsAre(HasSubstr("up and down are swapped: liver below urinary_bladder"),
                          HasSubstr("vertebrae are not in order: vertebrae_L2 below "
                                    "vertebrae_L3, vertebrae_L3 below vertebrae_L4")));
}

TEST(ImportGate, NoticesVertebraeOutOfOrder) {
  BoxPatient patient;
  patient.Add("vertebrae_L2", {0, 70, 0}, {20, 16, 12}, 250);
  patient.Add("vertebrae_L3", {0, 70, 32}, {20, 16, 12}, 250);
  patient.Add("sacrum", {0, 70, -60}, {20, 16, 12}, 250);
  EXPECT_THAT(patient.Check().impossible,
              ElementsAre(HasSubstr("not in order: vertebrae_L2 below vertebrae_L3")));
}

TEST(ImportGate, NoticesAnotherPatientByAirOrFatInOrgansAndSoftBone) {
  BoxPatient patient = Abdomen();
  // The CT is another one: lung where the liver is said to be, no bone at all.
  for (std::size_t n = 0; n < patient.ct.voxels.size(); ++n) {
    const std::int32_t value = patient.import.values.voxels[n];
    if (value == 1) patient.ct.voxels[n] = -800;
    if (value >= 6) patient.ct.voxels[n] = -110;
  }
  EXPECT_THAT(patient.Check().impossible,
              AllOf(Contains(AllOf(HasSubstr("'liver' has 100 % of its voxels outside"),
                                   HasSubstr("(air: 100 %)"))),
                    Contains(HasSubstr("and 0 % of its bone is above 100 HU"))));
  EXPECT_THAT(patient.Check().unusual, Contains(HasSubstr("'vertebrae_L3' has 100 %")));
}

TEST(ImportGate, WarnsOfBoneWithoutCalciumButDoesNotRefuseIt) {
  BoxPatient patient = Abdomen();
  for (std::size_t n = 0; n < patient.ct.voxels.size(); ++n) {
    if (patient.import.values.voxels[n] >= 6) patient.ct.voxels[n] = n % 3 == 0 ? 200 : 80;
  }
  EXPECT_THAT(patient.Check().impossible, IsEmpty());
  EXPECT_THAT(patient.Check().unusual, ElementsAre(HasSubstr("of its bone is above 100 HU")));
}

TEST(ImportGate, NoticesLabelsOutsideTheBody) {
  BoxPatient patient;
  patient.Add("muscle", {100, 0, 0}, {60, 60, 60}, 60);
  EXPECT_THAT(patient.Check().impossible,
              ElementsAre(HasSubstr("of its labels lie outside the body")));
}

TEST(ImportGate, NoticesThatFileAndTableDiffer) {
  BoxPatient patient;
  patient.Add("spleen", {90, 0, 100}, {25, 25, 40}, 60);
  patient.import.own_names[1] = {.text = "lien", .codes = {}};  // Another word for it.
  EXPECT_THAT(patient.Check().impossible, IsEmpty());
  patient.import.own_names[1] = {.text = "stomach", .codes = {}};
  EXPECT_THAT(patient.Check().impossible,
              ElementsAre("value 1 is 'stomach' for the file, but 'spleen' for the table"));
}

TEST(ImportGate, RefusesWithAdviceOrOnlyWarns) {
  const BoxPatient patient = Abdomen(-1.0);
  const ImportFindings findings = patient.Check();
  RunContext context;
  std::string warning;
  context.on_warning = [&](std::string_view text) { warning = text; };
  EXPECT_THAT(
      [&] { RequirePlausible(findings, patient.import, false, context); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("map.nii.gz: cannot be labels"),
                                      HasSubstr("by its header"), HasSubstr("swapped"),
                                      HasSubstr("--mapping"), HasSubstr("--accept-implausible"))));
  EXPECT_EQ(warning, "");
  RequirePlausible(findings, patient.import, true, context);
  EXPECT_THAT(warning, HasSubstr("swapped"));
}

TEST(OtherBones, BecomeSoftTissueWithinReachOfTheImport) {
  volume::Geometry grid;
  grid.size = {30, 3, 3};
  grid.spacing_mm.setConstant(10.0);
  volume::LabelMap labels(grid, volume::LabelOf("muscle"));
  volume::LabelMap import(grid);
  const volume::Label bone = volume::LabelOf("bone");
  labels.At(2, 1, 1) = labels.At(3, 1, 1) = labels.At(5, 1, 1) = labels.At(20, 1, 1) = bone;
  import.At(2, 1, 1) = bone;
  import.At(5, 1, 1) = volume::LabelOf("vessel");
  EXPECT_EQ(DropOtherBones(import, labels, 1), 2U);
  EXPECT_EQ(labels.At(2, 1, 1), bone);                            // Bone of the import.
  EXPECT_EQ(labels.At(3, 1, 1), volume::LabelOf("soft_tissue"));  // Its edge.
  EXPECT_EQ(labels.At(5, 1, 1), volume::LabelOf("soft_tissue"));  // Contrast agent.
  EXPECT_EQ(labels.At(20, 1, 1), bone);                           // 150 mm away.
  EXPECT_EQ(labels.names.at(volume::LabelOf("soft_tissue")), "soft_tissue");
}

}  // namespace
}  // namespace acus::segmentation
