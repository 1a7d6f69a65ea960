#include <bit>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/imaging/rf/matlab_file.h"
#include "acus/imaging/rf/numpy_file.h"
#include "acus/imaging/rf/rf_lines.h"
#include "support/temporary_folder.h"

namespace acus::rf {
namespace {

ChannelData Numbered() {
  ChannelData data{20, 3, 2, 25.0, 1.5, {}};
  data.Allocate();
  for (std::size_t i = 0; i < data.values.size(); ++i)
    data.values[i] = 0.25F * static_cast<float>(i) - 7.0F;
  return data;
}

class RfFiles : public ::testing::Test {
 protected:
  testing_support::TemporaryFolder folder_;
};

TEST_F(RfFiles, MatlabGivesTheSameBitsBack) {
  const ChannelData data = Numbered();
  WriteMatlab(folder_.path() / "a.mat", data);
  for (const char* name : {"", "rf"}) {
    const ChannelData back = ReadMatlab(folder_.path() / "a.mat", name);
    EXPECT_EQ(back.samples, 20);
    EXPECT_EQ(back.elements, 3);
    EXPECT_EQ(back.transmits, 2);
    EXPECT_EQ(back.values, data.values);
  }
}

TEST_F(RfFiles, MatlabVariablesAreNamedInMessages) {
  WriteMatlab(folder_.path() / "a.mat", Numbered());
  try {
    ReadMatlab(folder_.path() / "a.mat", "RF1");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'RF1'; it has rf, fs_hz, t0_s"), std::string::npos)
        << error.what();
  }
}

TEST_F(RfFiles, TruncatedMatlabIsRefused) {
  WriteMatlab(folder_.path() / "a.mat", Numbered());
  const std::string bytes = ReadTextFile(folder_.path() / "a.mat");
  const auto cut = folder_.path() / "cut.mat";
  for (std::size_t size = 0; size + 200 < bytes.size(); size += 7) {
    WriteTextFile(cut, bytes.substr(0, size));
    EXPECT_THROW(ReadMatlab(cut, "rf"), InputError) << size;
  }
}

TEST_F(RfFiles, FlippedMatlabGivesNumbersOrAMessage) {
  WriteMatlab(folder_.path() / "a.mat", Numbered());
  const std::string bytes = ReadTextFile(folder_.path() / "a.mat");
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0xFF);
    WriteTextFile(folder_.path() / "b.mat", damaged);
    try {
      EXPECT_FALSE(ReadMatlab(folder_.path() / "b.mat", "").values.empty());
    } catch (const InputError&) {
      continue;
    }
  }
}

TEST_F(RfFiles, NumpyIsAsItsFormatSays) {
  WriteNumpy(folder_.path() / "a.npy", Numbered());
  const std::string bytes = ReadTextFile(folder_.path() / "a.npy");
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  const std::size_t header =
      static_cast<unsigned char>(bytes[8]) + 256U * static_cast<unsigned char>(bytes[9]);
  EXPECT_EQ((10 + header) % 64, 0U);
  EXPECT_EQ(bytes.substr(10, 61), "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 20),");
  ASSERT_EQ(bytes.size(), 10 + header + 4 * 120);
  float second = 0.0F;
  std::memcpy(&second, bytes.data() + 10 + header + 4, 4);
  EXPECT_EQ(second, -6.75F);
}

TEST_F(RfFiles, RfLinesAreScaledToSixteenBits) {
  IqImage image{{{0, 0}, {0.1, 0.05}, 2, 3}, {1.0F, 2.0F, -4.0F, 0.5F, 0.0F, 3.0F}};
  WriteRfLines(folder_.path() / "a.mha", image);
  const std::string text = ReadTextFile(folder_.path() / "a.mha");
  EXPECT_NE(text.find("DimSize = 3 2 1\n"), std::string::npos);
  EXPECT_NE(text.find("UltrasoundImageType = RF_REAL\n"), std::string::npos);
  ASSERT_GE(text.size(), 12U);
  std::int16_t lines[6];
  std::memcpy(lines, text.data() + text.size() - 12, 12);
  EXPECT_EQ(lines[1], -32767);  // Column 0, row 1.
  EXPECT_EQ(lines[3], 16384);   // Column 1, row 0: half of the largest.
}

}  // namespace
}  // namespace acus::rf
