#include "acus/data/volume/displacement_file.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/scalar_file.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

DisplacementField SmallField() {
  DisplacementField field;
  field.geometry.size = {4, 5, 6};
  field.geometry.spacing_mm = {2.0, 3.0, 4.0};
  field.geometry.origin_mm = {-10.0, 20.0, 30.5};
  for (std::size_t n = 0; n < 3 * field.geometry.num_voxels(); ++n) {
    field.displacement_in_ct_mm.push_back(0.25F * static_cast<float>(n));
  }
  return field;
}

TEST(DisplacementFile, ComesBackInEveryFormat) {
  const testing_support::TemporaryFolder folder;
  const DisplacementField field = SmallField();
  for (const char* name : {"u.nrrd", "u.mha", "u.nii.gz"}) {
    WriteDisplacementField(folder / name, field);
    const DisplacementField back = ReadDisplacementField(folder / name);
    EXPECT_TRUE(back.geometry.Matches(field.geometry)) << name;
    EXPECT_EQ(back.displacement_in_ct_mm, field.displacement_in_ct_mm) << name;
    EXPECT_THROW(ReadScalarFile(folder / name), InputError) << name;
  }
}

TEST(DisplacementFile, VectorsMayBeTheFourthDimension) {
  const testing_support::TemporaryFolder folder;
  WriteDisplacementField(folder / "u.nii", SmallField());
  std::string bytes = ReadTextFile(folder / "u.nii");
  bytes[40] = 4;  // dim[0]; then dim[4] = 3, dim[5] = 1, and no intent.
  bytes[48] = 3;
  bytes[50] = 1;
  bytes[68] = bytes[69] = 0;
  WriteTextFile(folder / "four.nii", bytes);
  const DisplacementField back = ReadDisplacementField(folder / "four.nii");
  EXPECT_TRUE(back.geometry.Matches(SmallField().geometry));
  EXPECT_EQ(back.displacement_in_ct_mm, SmallField().displacement_in_ct_mm);
  EXPECT_THAT(back.notes, testing::ElementsAre(testing::HasSubstr("LPS")));
}

TEST(DisplacementFile, RefusesWhatIsNone) {
  const testing_support::TemporaryFolder folder;
  DisplacementField field = SmallField();
  ScalarFile scalar;
  scalar.geometry = field.geometry;
  scalar.type = ScalarType::kFloat32;
  scalar.bytes.resize(4 * field.geometry.num_voxels());
  WriteScalarFile(folder / "s.nrrd", scalar);
  EXPECT_THROW(ReadDisplacementField(folder / "s.nrrd"), InputError);
  field.displacement_in_ct_mm[7] = std::numeric_limits<float>::quiet_NaN();
  WriteDisplacementField(folder / "nan.nrrd", field);
  EXPECT_THROW(ReadDisplacementField(folder / "nan.nrrd"), InputError);
  field.displacement_in_ct_mm.pop_back();
  EXPECT_THROW(WriteDisplacementField(folder / "short.nrrd", field), InputError);
}

TEST(DisplacementFile, DamagedFilesAreReadOrRefused) {
  const testing_support::TemporaryFolder folder;
  for (const char* name : {"u.nrrd", "u.mha", "u.nii.gz"}) {
    WriteDisplacementField(folder / name, SmallField());
    const std::string valid = ReadTextFile(folder / name);
    const auto path = folder / Message("damaged_", name);
    const int refused =
        testing_support::ReadDamagedCopies(valid, path, 200, [&] { ReadDisplacementField(path); });
    EXPECT_GT(refused, 100) << name;
  }
}

}  // namespace
}  // namespace acus::volume
