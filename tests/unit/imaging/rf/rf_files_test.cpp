#include <bit>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/imaging/rf/matlab_file.h"
#include "acus/imaging/rf/numpy_file.h"
#include "acus/imaging/rf/rf_lines.h"
#include "support/temporary_folder.h"

namespace acus::rf {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

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

/// An array of version 5, not compressed.
std::string MatlabArray(std::uint32_t kind, std::uint32_t rows, const std::string& rest) {
  std::string file = "MATLAB 5.0 MAT-file";
  file.resize(124, ' ');
  file += std::string("\0\1IM", 4);
  const auto add = [](std::string& to, std::initializer_list<std::uint32_t> words) {
    for (const std::uint32_t word : words) to.append(reinterpret_cast<const char*>(&word), 4);
  };
  std::string array;
  add(array, {6, 8, kind, 0, 5, 8, rows, 2, 0x10001, 'x'});
  array += rest;
  add(file, {14, static_cast<std::uint32_t>(array.size())});
  return file + array;
}

TEST_F(RfFiles, MatlabThatDeclaresMoreThanItHasIsRefusedBeforeMemoryIsTaken) {
  const auto read = [&](const std::string& bytes) {
    WriteTextFile(folder_.path() / "c.mat", bytes);
    return ReadMatlab(folder_.path() / "c.mat", "x");
  };
  std::string values(8 + 4 * 8, '\0');
  values[0] = 9;
  values[4] = 32;
  EXPECT_EQ(read(MatlabArray(6, 2, values)).samples, 2);
  const auto refuses = [&](std::uint32_t kind, std::uint32_t rows, const std::string& rest) {
    EXPECT_THAT([&] { read(MatlabArray(kind, rows, rest)); },
                ThrowsMessage<InputError>(HasSubstr("declares more values than it has")))
        << kind;
  };
  refuses(6, 0x40000000, values);  // Numbers,
  refuses(1, 0x40000000, "");      // cells
  refuses(2, 0x40000000, "");      // and structures.
  values[5] = 1;
  EXPECT_THROW(read(MatlabArray(6, 2, values)), InputError) << "an element longer than its array";
  EXPECT_THROW(read(std::string("\1\0\0\0\0\0\0\x0f.M\1", 11)), InputError) << "version 4";
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
