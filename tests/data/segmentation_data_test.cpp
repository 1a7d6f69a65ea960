// The judged numbers, on real CTs.
#include <gmock/gmock.h>

#include "acus/data/volume/labels.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/atlas_organs.h"
#include "acus/patient/segmentation/import/import_gate.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "acus/patient/segmentation/segmenters/organ_vessels.h"
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

TEST(RealPatients, IrcadWithContrastAgent) {
  ACUS_DATA(ct, "ct/ircadb01_dicom");
  ACUS_DATA(reference, "ct/ircadb01_labels.vti");
  const auto all = CompareWithReference(
      Segmented(*ct), {*reference, ACUS_SOURCE_DIR "/configs/label_maps/ircadb.json"},
      TwoThreads());
  EXPECT_GE(Of(all, "body").dice, 0.98);
  EXPECT_GE(Of(all, "bone").dice, 0.85);
  EXPECT_GE(Of(all, "lung").dice, 0.95);
  EXPECT_LE(Of(all, "body").surface_distance95_mm, 3.5);
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
  ACUS_DATA(ircad, "ct/ircadb01_dicom");
  ACUS_DATA(ircad_labels, "ct/ircadb01_labels.vti");
  const ImportOfData by_names(*total, *total_labels, {});
  EXPECT_EQ(by_names.import.named_by, "by the label table in its header");
  EXPECT_EQ(by_names.import.structures.size(), 61U);
  EXPECT_TRUE(by_names.import.mapping.all_bones);
  EXPECT_THAT(by_names.Check().impossible, IsEmpty());
  EXPECT_THAT(by_names.Check().unusual, IsEmpty());
  const ImportOfData by_values(*ircad, *ircad_labels,
                               ACUS_SOURCE_DIR "/configs/label_maps/ircadb.json");
  EXPECT_THAT(by_values.Check().impossible, IsEmpty());
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

TEST(ImportedMaps, ElevenLitresOfSpleenAreRefused) {
  ACUS_DATA(ircad, "ct/ircadb01_dicom");
  ACUS_DATA(ircad_labels, "ct/ircadb01_labels.vti");
  ImportOfData patient(*ircad, *ircad_labels, ACUS_SOURCE_DIR "/configs/label_maps/ircadb.json");
  // Value 1 is the body there, and the spleen in the table of TotalSegmentator.
  patient.import.structures[1] = *patient.import.names.Find({.text = "spleen", .codes = {}});
  patient.import.mapping.tissue[1] = volume::LabelOf("spleen");
  patient.import.mapping.name[1] = "spleen";
  EXPECT_THAT(patient.Check().impossible, Contains(HasSubstr("at most 4000 ml are possible")));
}

/// Agreement of organs in one CT, found from the labels of the other.
std::vector<Agreement> FromAtlas(const fs::path& ct, const ForeignLabels& reference,
                                 const atlas::AtlasPatient& other) {
  const auto config = ReadSegmentationConfig(ACUS_SOURCE_DIR "/configs/segmentation/default.json");
  const auto image = volume::ReadCt(ct, "", TwoThreads());
  auto labels = SegmentPatient(image, config, TwoThreads()).labels;
  atlas::AddAtlasOrgans(image, {other}, config.tissues, labels, TwoThreads());
  return CompareWithReference(labels, reference, TwoThreads());
}

TEST(RealPatients, OrgansOfOnePatientAreFoundInTheOther) {
  ACUS_DATA(ircad, "ct/ircadb01_dicom");
  ACUS_DATA(ircad_labels, "ct/ircadb01_labels.vti");
  ACUS_DATA(total, "ct/totalseg/example_ct.nii.gz");
  ACUS_DATA(total_labels, "ct/totalseg/example_seg_fast_force_split.nii.gz");
  const fs::path ircad_mapping = ACUS_SOURCE_DIR "/configs/label_maps/ircadb.json";
  const fs::path total_mapping = ACUS_SOURCE_DIR "/configs/label_maps/totalsegmentator.json";
  const auto in_ircad = FromAtlas(*ircad, {*ircad_labels, ircad_mapping},
                                  {"totalseg", *total, "", {*total_labels, total_mapping}});
  EXPECT_GE(Of(in_ircad, "liver").dice, 0.85);
  EXPECT_GE(Of(in_ircad, "spleen").dice, 0.80);
  EXPECT_GE(Of(in_ircad, "kidney").dice, 0.80);
  const auto in_total = FromAtlas(*total, {*total_labels, total_mapping},
                                  {"ircadb01", *ircad, "", {*ircad_labels, ircad_mapping}});
  EXPECT_GE(Of(in_total, "liver").dice, 0.85);
  EXPECT_GE(Of(in_total, "spleen").dice, 0.80);
  EXPECT_GE(Of(in_total, "kidney").dice, 0.80);
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
