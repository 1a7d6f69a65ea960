// The judged numbers, on real CTs.
#include <gmock/gmock.h>

#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/atlas_organs.h"
#include "acus/patient/segmentation/import/import_gate.h"
#include "acus/patient/segmentation/import/label_mapping.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "acus/patient/segmentation/segmenters/organ_vessels.h"
#include "acus/patient/segmentation/voxels/metrics.h"
#include "support/shared_data.h"
#include "support/transformed_ct.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

#define ACUS_DATA(variable, name)                          \
  const auto variable = testing_support::SharedData(name); \
  if (!variable) GTEST_SKIP() << "test data " << (name) << " is not here"

RunContext TwoThreads() {
  RunContext context;
  context.num_threads = 2;
  return context;
}

volume::LabelMap Segmented(const fs::path& ct) {
  const auto config = ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
  return SegmentPatient(volume::ReadCt(ct, "", TwoThreads()), config, TwoThreads()).labels;
}

Agreement Of(const std::vector<Agreement>& all, const std::string& tissue) {
  for (const Agreement& one : all) {
    if (one.tissue == tissue) return one;
  }
  ADD_FAILURE() << tissue << " was not compared";
  return {};
}

double VolumeMl(const volume::LabelMap& labels, const char* name) {
  const auto count = std::ranges::count(labels.voxels, volume::LabelOf(name));
  return static_cast<double>(count) * labels.geometry.voxel_volume_mm3() / 1000.0;
}

TEST(RealPatients, TheEdgeOfTheScannersFieldIsFound) {
  // Both are reconstructed in the circle that just fits their slices; the first is cut by it.
  ACUS_DATA(ircad, "ct/ircadb01_dicom");
  ACUS_DATA(thorax, "ct/thorax_dicom");
  for (const auto& path : {*ircad, *thorax}) {
    const auto ct = volume::ReadCt(path, "", TwoThreads());
    const ScanField field = FindScanField(ct);
    ASSERT_TRUE(field.circle) << path;
    const double half_mm = 0.5 * ct.geometry.size[0] * ct.geometry.spacing_mm[0];
    EXPECT_NEAR(field.circle->radius_mm, half_mm, 0.01 * half_mm);
  }
}

TEST(RealPatients, TotalSegmentatorExampleAtThreeMillimetres) {
  ACUS_DATA(ct, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(reference, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const auto labels = Segmented(*ct);
  const auto all = CompareWithReference(
      labels, {*reference, ACUS_SOURCE_DIR "/configs/label_maps/totalsegmentator.json"},
      TwoThreads());
  EXPECT_GE(Of(all, "bone").dice, 0.90);
  EXPECT_GE(Of(all, "lung").dice, 0.93);
  // The reference has no body, but all of it lies in one.
  const auto values = volume::ReadIntegerVolume(*reference);
  std::size_t inside = 0;
  std::size_t total = 0;
  for (std::size_t i = 0; i < values.voxels.size(); ++i) {
    if (values.voxels[i] == 0) continue;
    ++total;
    inside += labels.voxels[i] != 0 ? 1U : 0U;
  }
  EXPECT_GE(static_cast<double>(inside), 0.999 * static_cast<double>(total));
}

TEST(RealPatients, VertebraeArePartedAndNamedFromTheSacrum) {
  ACUS_DATA(ct, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(reference, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const auto labels = Segmented(*ct);
  const Vertebrae found =
      FindVertebrae(volume::ReadCt(*ct, "", TwoThreads()), labels, std::nullopt);
  EXPECT_EQ(found.named_from, NamedFrom::kSacrumAndLastRib);
  const auto values = volume::ReadIntegerVolume(*reference);
  const std::map<std::string, std::int32_t> value_of = {{"L5", 27}, {"L4", 28}, {"L3", 29},
                                                        {"L2", 30}, {"L1", 31}, {"T12", 32}};
  for (const auto& [label, name] : found.labels.names) {
    const auto value = value_of.find(name);
    if (value == value_of.end()) continue;
    std::size_t both = 0, sum = 0;
    for (std::size_t i = 0; i < values.voxels.size(); ++i) {
      const bool ours = found.labels.voxels[i] == label;
      const bool theirs = values.voxels[i] == value->second;
      both += ours && theirs ? 1U : 0U;
      sum += (ours ? 1U : 0U) + (theirs ? 1U : 0U);
    }
    const double dice = 2.0 * static_cast<double>(both) / static_cast<double>(sum);
    std::cout << name << ": Dice " << dice << '\n';
    // The bone as a whole agrees with Dice 0.88 only.
    EXPECT_GT(dice, 0.75) << name;
  }
  EXPECT_EQ(found.list.size(), 7U);
}

/// Numbers of the names that are right, wrong and missing, by the values of the reference.
struct NamesFound {
  int right = 0, wrong = 0, unnamed = 0;
};

NamesFound NamesIn(const testing_support::LabelledCt& copy) {
  const auto config = ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
  const auto labels = FindTissues(copy.ct, config.tissues, TwoThreads()).labels;
  const Vertebrae found = FindVertebrae(copy.ct, labels, std::nullopt);
  NamesFound names;
  for (std::size_t n = 0; n < found.list.size(); ++n) {
    const auto number = NumberOfVertebra(found.list[n].name);
    if (!number) {
      ++names.unnamed;
      continue;
    }
    std::map<int, int> votes;  // TotalSegmentator counts from the sacrum (25) and S1 (26) upwards.
    for (std::size_t at = 0; at < copy.labels.voxels.size(); ++at) {
      const int value = copy.labels.voxels[at];
      if (found.labels.voxels[at] != n + 1 || value < 25 || value > 50) continue;
      ++votes[24 - std::max(value - 26, 0)];
    }
    const auto most = std::ranges::max_element(votes, {}, [](const auto& v) { return v.second; });
    ++(most != votes.end() && most->first == *number ? names.right : names.wrong);
  }
  std::cout << names.right << " right, " << names.wrong << " wrong, " << names.unnamed
            << " unnamed\n";
  return names;
}

TEST(RealPatients, NoVertebraOfATransformedCopyHasAWrongName) {
  ACUS_DATA(ct, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(reference, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const testing_support::LabelledCt whole{volume::ReadCt(*ct, "", TwoThreads()),
                                          volume::ReadIntegerVolume(*reference)};
  const Eigen::Array3i last = whole.ct.geometry.size - 1;
  const auto from = [&](double share) {
    return testing_support::CutTo(whole, {0, 0, static_cast<int>(share * (last[2] + 1))}, last);
  };
  const auto up_to = [&](double share) {
    return testing_support::CutTo(whole, Eigen::Array3i::Zero(),
                                  {last[0], last[1], static_cast<int>(share * (last[2] + 1))});
  };
  constexpr double kRad = M_PI / 180.0;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  EXPECT_EQ(NamesIn(whole).right, 7);
  for (const auto& copy :
       {from(0.15), from(0.25), from(0.4), up_to(0.8), up_to(0.5),
        testing_support::Turned(whole, x, 10 * kRad), testing_support::Turned(whole, x, -10 * kRad),
        testing_support::Turned(whole, y, 8 * kRad), testing_support::Turned(whole, y, -8 * kRad),
        testing_support::Noisy(whole, 20.0), testing_support::Noisy(whole, 45.0),
        testing_support::Thickened(whole, 2)}) {
    EXPECT_EQ(NamesIn(copy).wrong, 0);
  }
}

TEST(RealPatients, ThoraxHasTwoLungsOfALivingPersonAndABody) {
  ACUS_DATA(ct, "ct/thorax_dicom");
  const auto labels = Segmented(*ct);
  EXPECT_GT(VolumeMl(labels, "lung"), 2500.0);
  EXPECT_LT(VolumeMl(labels, "lung"), 7500.0);
  EXPECT_GT(VolumeMl(labels, "bone"), 500.0);
  EXPECT_LT(VolumeMl(labels, "bone"), 2500.0);
}

/// A CT with the labels of a map made elsewhere, and what speaks against these.
struct ImportOfData {
  ImportOfData(const fs::path& ct_path, const fs::path& map_path, const fs::path& mapping)
      : ct(volume::ReadCt(ct_path, "", TwoThreads())),
        found(SegmentPatient(
                  ct, ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json"),
                  TwoThreads())
                  .labels),
        import(ReadImportedLabels({map_path, mapping}, ct.geometry, TwoThreads())) {}
  ImportFindings Check() const { return CheckImport(import, ct, found); }

  volume::CtVolume ct;
  volume::LabelMap found;
  ImportedLabels import;
};

/// The example's map with every value that occurs given the name of another, as where the table of
/// another version is used.
void ShuffleNames(ImportedLabels& import) {
  std::vector<NamedStructure> structures;
  for (const auto& [value, what] : import.structures) structures.push_back(what);
  std::ranges::rotate(structures, structures.begin() + 5);
  std::size_t next = 0;
  for (auto& [value, what] : import.structures) {
    what = structures[next++];
    import.mapping.tissue[value] = what.structure.tissue;
    import.mapping.name[value] = what.structure.name;
  }
  import.own_names.clear();
}

/// Moves all values by voxels along each axis.
void ShiftValues(volume::Grid<std::int32_t>& values, const Eigen::Array3i& by) {
  const volume::Grid<std::int32_t> from = values;
  for (int k = 0; k < values.geometry.size[2]; ++k) {
    for (int j = 0; j < values.geometry.size[1]; ++j) {
      for (int i = 0; i < values.geometry.size[0]; ++i) {
        const Eigen::Array3i at = Eigen::Array3i(i, j, k) - by;
        values.At(i, j, k) =
            from.geometry.Contains(at[0], at[1], at[2]) ? from.At(at[0], at[1], at[2]) : 0;
      }
    }
  }
}

TEST(ImportedMaps, OfTheSamePatientAreAcceptedByTheirOwnNames) {
  ACUS_DATA(total, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(total_labels, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const ImportOfData by_names(*total, *total_labels, {});
  EXPECT_EQ(by_names.import.named_by, "by the label table in its header");
  EXPECT_EQ(by_names.import.structures.size(), 61U);
  EXPECT_TRUE(by_names.import.mapping.all_bones);
  EXPECT_THAT(by_names.Check().impossible, IsEmpty());
  EXPECT_THAT(by_names.Check().unusual, IsEmpty());
}

TEST(ImportedMaps, ThatAreShuffledMirroredOrShiftedAreRefused) {
  ACUS_DATA(total, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(total_labels, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const ImportOfData right(*total, *total_labels, {});
  ImportOfData shuffled = right;
  ShuffleNames(shuffled.import);
  EXPECT_THAT(shuffled.Check().impossible, Contains(HasSubstr("are possible")));
  ImportOfData mirrored = right;
  for (std::size_t row = 0; row < mirrored.import.values.voxels.size(); row += 122) {
    std::reverse(&mirrored.import.values.voxels[row], &mirrored.import.values.voxels[row] + 122);
  }
  EXPECT_THAT(mirrored.Check().impossible, Contains(HasSubstr("left and right are swapped")));
  for (const Eigen::Array3i& by : {Eigen::Array3i(5, 0, 0), Eigen::Array3i(0, 5, 0),
                                   Eigen::Array3i(0, 0, 5), Eigen::Array3i(0, 0, -10)}) {
    ImportOfData shifted = right;
    ShiftValues(shifted.import.values, by);
    EXPECT_THAT(shifted.Check().impossible, Contains(HasSubstr("a map that is shifted")))
        << by.transpose();
  }
}

TEST(ImportedMaps, OfAnotherPatientOnTheSameGridAreRefused) {
  ACUS_DATA(ircad, "ct/ircadb01_dicom");
  ACUS_DATA(total_labels, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  ACUS_DATA(total, "ct/totalseg/example_ct.nii.gz");
  ImportOfData patient(*total, *total_labels, {});
  // The CT of ircadb01, laid so that the centres of the two fields meet.
  volume::CtVolume other = volume::ReadCt(*ircad, "", TwoThreads());
  const auto centre = [](const volume::Geometry& grid) -> Eigen::Vector3d {
    return grid.ct_from_index() * (0.5 * (grid.size - 1).cast<double>()).matrix();
  };
  other.geometry.origin_mm += centre(patient.ct.geometry) - centre(other.geometry);
  volume::Grid<std::int32_t> hu(other.geometry);
  constexpr int kShift = 2000;  // So that 0 remains where there is no CT.
  std::ranges::transform(other.voxels, hu.voxels.begin(), [](int value) { return value + kShift; });
  const auto resampled = ValuesOnGrid(hu, patient.ct.geometry, *ircad, TwoThreads());
  std::ranges::transform(resampled.voxels, patient.ct.voxels.begin(), [](std::int32_t value) {
    return value == 0 ? volume::kPaddingHu : static_cast<std::int16_t>(value - kShift);
  });
  EXPECT_THAT(patient.Check().impossible, Contains(HasSubstr("another patient")));
}

// One test, since the CT takes half a minute.
TEST(RealPatients, IrcadWithContrastAgentAndItsImportedMap) {
  ACUS_DATA(ircad, "ct/ircadb01_dicom");
  ACUS_DATA(ircad_labels, "ct/ircadb01_labels.vti");
  const fs::path mapping = ACUS_SOURCE_DIR "/configs/label_maps/ircadb.json";
  ImportOfData patient(*ircad, *ircad_labels, mapping);
  const auto all = CompareWithReference(patient.found, {*ircad_labels, mapping}, TwoThreads());
  EXPECT_GE(Of(all, "body").dice, 0.98);
  EXPECT_GE(Of(all, "bone").dice, 0.85);
  EXPECT_GE(Of(all, "lung").dice, 0.95);
  EXPECT_LE(Of(all, "body").surface_distance95_mm, 3.5);
  EXPECT_THAT(patient.Check().impossible, IsEmpty());
  // Value 1 is the body there, and the spleen in the table of TotalSegmentator: eleven litres.
  patient.import.structures[1] = *patient.import.names.Find({.text = "spleen", .codes = {}});
  patient.import.mapping.tissue[1] = volume::LabelOf("spleen");
  patient.import.mapping.name[1] = "spleen";
  EXPECT_THAT(patient.Check().impossible, Contains(HasSubstr("at most 4000 ml are possible")));
}

/// A patient with labels, on a grid that takes seconds.
struct LabelledData {
  LabelledData(const fs::path& ct, const fs::path& labels, const char* mapping, int coarser) {
    testing_support::LabelledCt whole{volume::ReadCt(ct, "", TwoThreads()),
                                      volume::ReadIntegerVolume(labels)};
    if (coarser > 1) whole = testing_support::Coarsened(whole, coarser);
    const LabelMapping table =
        ReadLabelMapping(fs::path(ACUS_SOURCE_DIR "/configs/label_maps") / mapping);
    patient.organs = volume::LabelMap(whole.ct.geometry);
    for (std::size_t n = 0; n < whole.labels.voxels.size(); ++n) {
      const auto tissue = table.tissue.find(whole.labels.voxels[n]);
      if (tissue != table.tissue.end()) patient.organs.voxels[n] = tissue->second;
    }
    patient.ct = std::move(whole.ct);
    const auto config =
        ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
    patient.tissues = SegmentPatient(patient.ct, config, TwoThreads()).labels;
  }
  /// Dice of the organs that another patient's labels find, and that these are stated to be right.
  void ExpectOrgansFrom(const LabelledData& other) const {
    volume::LabelMap labels = patient.tissues;
    const auto evidence = atlas::AddAtlasOrgans(patient.ct, {other.patient}, labels, TwoThreads());
    const auto middle = MiddleXMm(labels);
    const auto checks = CheckOrgans(labels, evidence);
    const auto mask = [](const volume::LabelMap& map, const char* organ) {
      return MaskOf(map, volume::LabelOf(organ));
    };
    for (const auto& [organ, least] :
         {std::pair("liver", 0.85), {"spleen", 0.8}, {"kidney", 0.8}}) {
      EXPECT_GE(Dice(mask(labels, organ), mask(patient.organs, organ)), least) << organ;
      const auto theirs = OrganParts(organ, mask(patient.organs, organ), middle);
      for (const auto& [name, part] : OrganParts(organ, mask(labels, organ), middle)) {
        const auto check = std::ranges::find(checks, name, &OrganCheck::name);
        const auto reference =
            std::ranges::find(theirs, name, [](const auto& p) { return p.first; });
        ASSERT_TRUE(check != checks.end() && reference != theirs.end()) << name;
        const double dice = Dice(part, reference->second);
        std::cout << name << ": Dice " << dice << ", expected " << check->expected_dice.value()
                  << (check->is_sure() ? "" : ", unsure: " + check->doubts.front()) << '\n';
        EXPECT_TRUE(dice >= kRightOrganDice || !check->is_sure()) << name << " passes as sure";
      }
    }
  }
  atlas::LabelledPatient patient;
};

TEST(RealPatients, OrgansOfOnePatientAreFoundInTheOther) {
  ACUS_DATA(ircad, "ct/ircadb01_dicom");
  ACUS_DATA(ircad_labels, "ct/ircadb01_labels.vti");
  ACUS_DATA(total, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(total_labels, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const LabelledData in_ircad(*ircad, *ircad_labels, "ircadb.json", 2);
  const LabelledData in_total(*total, *total_labels, "totalsegmentator.json", 1);
  in_ircad.ExpectOrgansFrom(in_total);
  in_total.ExpectOrgansFrom(in_ircad);
}

/// Voxels whose value is one of some.
Mask MaskOfValues(const volume::Grid<std::int32_t>& values, std::initializer_list<int> those) {
  Mask mask(values.geometry);
  for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
    mask.voxels[n] = std::ranges::find(those, values.voxels[n]) != those.end() ? 1 : 0;
  }
  return mask;
}

/// How found vessels agree with a reference on one side of a plane.
struct VesselAgreement {
  double dice = 0.0;
  double sensitivity = 0.0;  ///< Part of the reference within 2 mm of what was found.
  double precision = 0.0;    ///< Part of what was found within 2 mm of the reference.
};

VesselAgreement AgreeBeside(const Mask& found, const Mask& reference, int column, bool beyond) {
  const auto to_found = DistanceMm(found, 2), to_reference = DistanceMm(reference, 2);
  const auto row = static_cast<std::size_t>(found.geometry.size[0]);
  double ours = 0, theirs = 0, both = 0, theirs_near = 0, ours_near = 0;
  for (std::size_t n = 0; n < found.voxels.size(); ++n) {
    if ((n % row >= static_cast<std::size_t>(column)) != beyond) continue;
    const bool is_found = found.voxels[n] != 0, is_true = reference.voxels[n] != 0;
    ours += is_found;
    theirs += is_true;
    both += is_found && is_true;
    theirs_near += is_true && to_found.voxels[n] <= 2.0F;
    ours_near += is_found && to_reference.voxels[n] <= 2.0F;
  }
  const VesselAgreement agreement{2.0 * both / (ours + theirs), theirs_near / theirs,
                                  ours_near / ours};
  std::cout << (beyond ? "left" : "right") << ": Dice " << agreement.dice << ", sensitivity "
            << agreement.sensitivity << " and precision " << agreement.precision
            << " within 2 mm\n";
  return agreement;
}

TEST(RealPatients, VesselsOfALiverWithContrastAgentAreFound) {
  ACUS_DATA(ct, "ct/ircadb01_dicom");
  ACUS_DATA(reference, "ct/ircadb01_labels.vti");
  const auto values = volume::ReadIntegerVolume(*reference);
  const Mask vessels = MaskOfValues(values, {465, 481});
  const auto image = volume::ReadCt(*ct, "", TwoThreads());
  // Half of the reference lies on each side of column 164. The right side was used for development.
  for (const bool has_tumours : {false, true}) {
    const Mask organ = has_tumours ? MaskOfValues(values, {449, 465, 481, 451, 453})
                                   : MaskOfValues(values, {449, 465, 481});
    const OrganVessels found = FindVesselsIn(image, organ, 2);
    ASSERT_TRUE(found.is_found) << found.reason;
    const VesselAgreement right = AgreeBeside(found.vessels, vessels, 164, false);
    EXPECT_GT(right.dice, 0.65);
    EXPECT_GT(right.sensitivity, 0.85);
    EXPECT_GT(right.precision, 0.82);
    const VesselAgreement left = AgreeBeside(found.vessels, vessels, 164, true);
    EXPECT_GT(left.dice, 0.58);
    EXPECT_GT(left.sensitivity, 0.80);
    EXPECT_GT(left.precision, 0.70);
  }
}

TEST(RealPatients, ALiverWithoutContrastAgentHasNoVessels) {
  ACUS_DATA(ct, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(reference, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const Mask liver = MaskOfValues(volume::ReadIntegerVolume(*reference), {5});
  const OrganVessels found = FindVesselsIn(volume::ReadCt(*ct, "", TwoThreads()), liver, 2);
  EXPECT_NEAR(found.organ_hu, 46.0, 2.0);
  EXPECT_FALSE(found.is_found);
  EXPECT_THAT(found.reason, HasSubstr("a scan without contrast agent"));
}

}  // namespace
}  // namespace acus::segmentation
