#include <bzlib.h>
#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/input_file.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/volume_io.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::volume {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

CtVolume SmallCt() {
  Geometry geometry;
  geometry.size = {7, 5, 4};
  CtVolume ct(geometry);
  for (std::size_t i = 0; i < ct.voxels.size(); ++i)
    ct.voxels[i] = static_cast<std::int16_t>(9 * i);
  return ct;
}

std::string Bzip2(std::string text) {
  std::string out(text.size() + text.size() / 100 + 600, '\0');
  auto size = static_cast<unsigned>(out.size());
  EXPECT_EQ(BZ2_bzBuffToBuffCompress(out.data(), &size, text.data(),
                                     static_cast<unsigned>(text.size()), 9, 0, 0),
            BZ_OK);
  out.resize(size);
  return out;
}

class PackedNifti : public ::testing::Test {
 protected:
  std::string Written(const char* name) {
    WriteCt(folder_ / name, SmallCt());
    return ReadTextFile(folder_ / name);
  }
  std::vector<std::int16_t> Read(const std::string& name, const std::string& bytes) {
    WriteTextFile(folder_ / name, bytes);
    return ReadCt(folder_ / name, "", RunContext{}).voxels;
  }
  const testing_support::TemporaryFolder folder_;
};

TEST_F(PackedNifti, IsReadInWhateverItIsPacked) {
  const std::string plain = Written("plain.nii");
  const std::string gzip = Written("packed.nii.gz");
  const auto expected = SmallCt().voxels;
  EXPECT_EQ(Read("a.nii.bz2", Bzip2(plain)), expected);
  EXPECT_EQ(Read("two.nii.bz2", Bzip2(plain.substr(0, 400)) + Bzip2(plain.substr(400))), expected);
  EXPECT_EQ(Read("plain.nii.bz2", plain), expected);
  EXPECT_EQ(Read("gzip.nii", gzip), expected);
  EXPECT_EQ(Read("plain.nii.gz", plain), expected);
  EXPECT_EQ(VolumeStem("liver.nii.bz2"), "liver");
}

TEST_F(PackedNifti, IsRefusedByItsOwnNameIfItIsDamaged) {
  const std::string packed = Bzip2(Written("plain.nii"));
  EXPECT_THAT([&] { Read("a.nii.bz2", packed.substr(0, packed.size() / 2)); },
              ThrowsMessage<InputError>(HasSubstr("a.nii.bz2: its bzip2 data end early")));
  EXPECT_THAT([&] { Read("a.nii.bz2", Bzip2(std::string(2000, 'x'))); },
              ThrowsMessage<InputError>(HasSubstr("a.nii.bz2: is not a single-file NIfTI")));
  SetInputMemory(0.001);
  EXPECT_THAT([&] { Read("a.nii.bz2", Bzip2(std::string(2'000'000, '\0'))); },
              ThrowsMessage<InputError>(HasSubstr("a.nii.bz2: becomes more than 0.001 GB")));
  SetInputMemory({});
  EXPECT_GT(
      testing_support::ReadDamagedCopies(packed, folder_ / "d.nii.bz2", 300,
                                         [&] { ReadCt(folder_ / "d.nii.bz2", "", RunContext{}); }),
      200);
  EXPECT_THROW(WriteCt(folder_ / "out.nii.bz2", SmallCt()), InputError);
}

}  // namespace
}  // namespace acus::volume
