#include "acus/patient/breathing_registration/capture.h"

#include <fstream>
#include <functional>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/data/volume/displacement_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/breathing_registration/capture_folder.h"
#include "acus/patient/breathing_registration/capture_inputs.h"
#include "acus/patient/breathing_registration/patient_tissue.h"
#include "acus/patient/phantom/breath/breathing_scan.h"
#include "support/synthetic_trunk.h"
#include "support/temporary_folder.h"

namespace acus::breathing_registration {
namespace {

using testing::HasSubstr;
using testing_support::TemporaryFolder;

const CaptureSettings kSmall{.registration = {},
                             .kind = breathing::MotionKind::kSurrogate,
                             .resolution = 16,
                             .num_modes = 0,
                             .judged_at = 16};

/// The message of the InputError that `call` ends with; empty if there is none.
std::string Refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

volume::DisplacementField UniformField(double z_mm) {
  volume::DisplacementField field;
  field.geometry.size = {8, 8, 8};
  field.geometry.spacing_mm = Eigen::Array3d::Constant(10.0);
  for (std::size_t n = 0; n < field.geometry.num_voxels(); ++n) {
    field.displacement_in_ct_mm.insert(field.displacement_in_ct_mm.end(),
                                       {0.0F, 0.0F, static_cast<float>(z_mm)});
  }
  return field;
}

/// Eight fields of a body that moves as a whole, 10 mm down at full inspiration, with hysteresis.
void WriteFields(const std::filesystem::path& folder) {
  const double z_mm[] = {-10.0, -9.0, -5.0, -2.0, 0.0, -1.0, -4.0, -8.0};
  for (std::size_t n = 0; n < std::size(z_mm); ++n) {
    volume::WriteDisplacementField(folder / Message("u", n, ".mha"), UniformField(z_mm[n]));
  }
}

Capture FromFields(const std::filesystem::path& folder, const volume::Geometry* ct = nullptr) {
  return CaptureFields(FindPhases(folder, {}), ct, kSmall, {});
}

TEST(CaptureFields, MakesAndJudgesEveryModel) {
  const TemporaryFolder folder;
  WriteFields(folder.path());
  const Capture capture = FromFields(folder.path());
  ASSERT_EQ(capture.models.size(), 4);
  for (const ModelRow& row : capture.models) {
    EXPECT_LT(row.in_sample.mean_mm, 1.5) << breathing::NameOf(row.kind);
    ASSERT_TRUE(row.leave_one_out) << breathing::NameOf(row.kind);
    EXPECT_GE(row.leave_one_out->mean_mm, row.in_sample.mean_mm);
    EXPECT_FALSE(row.deeper);
    EXPECT_FALSE(row.landmarks);
  }
  // Key frames over the whole cycle repeat what they were made from.
  EXPECT_LT(capture.models[1].in_sample.mean_mm, 0.01);
  EXPECT_EQ(capture.reference, "the field that is 0 everywhere");
}

TEST(CaptureFields, RefusesFieldsThatDoNotBelongTogether) {
  const TemporaryFolder folder;
  WriteFields(folder.path());
  auto other = UniformField(-3.0);
  other.geometry.origin_mm.x() += 5.0;
  volume::WriteDisplacementField(folder / "u3.mha", other);
  EXPECT_THAT(Refusal([&] { FromFields(folder.path()); }),
              testing::AllOf(HasSubstr("u3.mha"), HasSubstr("same grid")));
  volume::WriteDisplacementField(folder / "u3.mha", UniformField(900.0));
  EXPECT_THAT(Refusal([&] { FromFields(folder.path()); }),
              testing::AllOf(HasSubstr("u3.mha"), HasSubstr("900")));
}

TEST(CaptureFields, RefusesFieldsBesideTheCt) {
  const TemporaryFolder folder;
  WriteFields(folder.path());
  volume::Geometry ct;
  ct.size = {40, 40, 40};
  ct.spacing_mm = Eigen::Array3d::Constant(2.0);
  EXPECT_EQ(Refusal([&] { FromFields(folder.path(), &ct); }), "");
  ct.origin_mm = {-80.0, -80.0, 0.0};  // As if x and y had their other sign.
  EXPECT_THAT(Refusal([&] { FromFields(folder.path(), &ct); }), HasSubstr("another space"));
}

TEST(CaptureFrom, TakesThePeriodFromTheSignal) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "fields");
  WriteFields(folder / "fields");
  std::string signal = "time_s,level\n";
  for (int n = 0; n < 600; ++n) {
    signal += Message(NumberText(0.05 * n), ",",
                      NumberText(std::cos(0.05 * n * 2.0 * 3.14159265 / 5.0)), "\n");
  }
  WriteTextFile(folder / "signal.csv", signal);
  CaptureInputs inputs;
  inputs.fields = folder / "fields";
  RunContext context;
  EXPECT_NEAR(CaptureFrom(inputs, kSmall, context).motion.period_s, 4.0, 1e-9);
  inputs.signal = folder / "signal.csv";
  const Capture capture = CaptureFrom(inputs, kSmall, context);
  EXPECT_NEAR(capture.motion.period_s, 5.0, 0.05);
  WriteCapture(folder / "motion", capture, context);
  EXPECT_NEAR(breathing::ReadPatientMotion(folder / "motion").period_s, capture.motion.period_s,
              1e-6);
  // No landmarks are known, so none are judged.
  EXPECT_FALSE(std::filesystem::exists(folder / "motion" / "landmark_errors.csv"));
}

TEST(KnownLandmarks, AreReadByPointAndFile) {
  const TemporaryFolder folder;
  const std::string header = "name,tissue,wall_mm,file,x_mm,y_mm,z_mm\n";
  WriteTextFile(folder / "l.csv",
                header + "a,lung,3,p0,1,2,3\nb,liver,4,p0,4,5,6\na,lung,3,p1,7,8,9\n");
  const KnownLandmarks known = ReadKnownLandmarks(folder / "l.csv");
  ASSERT_EQ(known.points.size(), 2);
  EXPECT_EQ(known.points[0].name, "a");
  EXPECT_EQ(known.points[0].at_mm.at("p1"), Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(known.points[1].tissue, "liver");
  WriteTextFile(folder / "l.csv", header + "a,lung,3,p0,1,2,3\na,lung,3,p0,1,2,3\n");
  EXPECT_THAT(Refusal([&] { ReadKnownLandmarks(folder / "l.csv"); }), HasSubstr("twice"));
}

/// A CT of one value with the labels of a trunk beside it on disk.
struct TrunkOnDisk {
  TrunkOnDisk() : labels(testing_support::SyntheticTrunk()), ct(labels.geometry) {
    volume::WriteLabelMap(folder / "labels.seg.nrrd", labels);
  }
  Tissue TissueWith(bool sliding) {
    RunContext context;
    return TissueOf(ct, folder / "labels.seg.nrrd", sliding, context);
  }
  TemporaryFolder folder;
  volume::LabelMap labels;
  volume::CtVolume ct;
};

TEST(PatientTissue, IsWhatHasALabel) {
  TrunkOnDisk trunk;
  const Tissue tissue = trunk.TissueWith(true);
  EXPECT_TRUE(tissue.is_tissue({0, 0, 0}));
  EXPECT_FALSE(tissue.is_tissue({0, 0, 1000}));
  EXPECT_FALSE(tissue.is_tissue(trunk.labels.geometry.origin_mm));
  EXPECT_LT(tissue.wall_mm({0, 0, 0}), 0.0);
  EXPECT_GT(tissue.wall_mm({0, -100, 0}), 0.0);
  EXPECT_FALSE(trunk.TissueWith(false).wall_mm);
}

TEST(PatientTissue, SaysWhatIsWrongWithLabels) {
  TrunkOnDisk trunk;
  trunk.ct.geometry.origin_mm.x() += 3.0;
  EXPECT_THAT(Refusal([&] { trunk.TissueWith(true); }), HasSubstr("another grid"));
  trunk.ct.geometry = trunk.labels.geometry;
  for (auto& label : trunk.labels.voxels) {
    if (label == volume::LabelOf("lung")) label = volume::LabelOf("soft_tissue");
  }
  volume::WriteLabelMap(trunk.folder / "labels.seg.nrrd", trunk.labels);
  EXPECT_THAT(Refusal([&] { trunk.TissueWith(true); }), HasSubstr("--no-sliding"));
}

}  // namespace
}  // namespace acus::breathing_registration
