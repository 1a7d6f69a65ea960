#include "acus/base/core/input_file.h"

#include <fstream>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "acus/base/core/error.h"
#include "acus/base/core/machine.h"

namespace acus {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class InputFile : public ::testing::Test {
 protected:
  InputFile() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    std::ofstream(folder_ / "file") << "12345";
  }
  ~InputFile() override {
    SetInputMemory({});
    fs::remove_all(folder_);
  }
  std::string Refusal(const fs::path& path) const {
    try {
      RequireInputFile(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  fs::path folder_ =
      fs::temp_directory_path() / Message("acus_input_file_", static_cast<int>(::getpid()));
};

std::string RefusedMemory(double declared_bytes, double file_bytes) {
  try {
    RequireMemory(declared_bytes, file_bytes, "ct.nrrd");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string RefusedDepth(const std::string& text) {
  try {
    RequireJsonDepth(text, "a.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST_F(InputFile, IsARegularFileOrALinkToOne) {
  EXPECT_EQ(RequireInputFile(folder_ / "file"), 5U);
  fs::create_symlink("file", folder_ / "link");
  EXPECT_EQ(RequireInputFile(folder_ / "link"), 5U);
  EXPECT_EQ(RequireInputFile(folder_ / "file", 5), 5U);
  EXPECT_THROW(RequireInputFile(folder_ / "file", 4), InputError);
}

TEST_F(InputFile, IsNothingThatAReaderWouldWaitFor) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", folder_ / "zero");
  fs::create_symlink("b", folder_ / "a");
  fs::create_symlink("a", folder_ / "b");
  EXPECT_THAT(Refusal(folder_ / "pipe"), AllOf(HasSubstr("pipe:"), HasSubstr("named pipe")));
  EXPECT_THAT(Refusal(folder_ / "zero"), HasSubstr("is a device"));
  EXPECT_THAT(Refusal(folder_), HasSubstr("is a folder"));
  EXPECT_THAT(Refusal(folder_ / "a"), HasSubstr("symbolic links"));
  EXPECT_THAT(Refusal(folder_ / "none"), HasSubstr("no such file"));
}

TEST_F(InputFile, DeclaresNoMoreMemoryThanIsFree) {
  const double free_bytes = AvailableMemoryBytes();
  EXPECT_GT(free_bytes, 1e7);
  EXPECT_EQ(RefusedMemory(1e6, 1e6), "accepted");
  EXPECT_THAT(
      RefusedMemory(free_bytes, free_bytes),
      AllOf(HasSubstr("ct.nrrd"), HasSubstr("half of the free memory"), HasSubstr("--memory-gb")));
}

TEST_F(InputFile, DeclaresNoHundredTimesItsSizeUnlessTheUserSaysSo) {
  if (AvailableMemoryBytes() < 6e9) GTEST_SKIP() << "less than 6 GB of memory are free";
  EXPECT_EQ(RefusedMemory(1.9e9, 1e6), "accepted");
  EXPECT_EQ(RefusedMemory(2.5e9, 2.6e7), "accepted");
  EXPECT_THAT(RefusedMemory(2.5e9, 1e6),
              AllOf(HasSubstr("2500 times"), HasSubstr("--memory-gb 2.5")));
}

TEST_F(InputFile, TakesWhatTheUserAllows) {
  SetInputMemory(1e4);
  EXPECT_EQ(RefusedMemory(9e12, 1e6), "accepted");
  SetInputMemory(0.5);
  EXPECT_THAT(RefusedMemory(6e8, 6e8),
              HasSubstr("0.5 GB are allowed for one input file (--memory"));
}

TEST_F(InputFile, HasItsDataBesideIt) {
  EXPECT_EQ(RequireDataBeside("a/ct.mhd", "ct.raw"), fs::path("a/ct.raw"));
  EXPECT_EQ(RequireDataBeside("ct.mhd", "raw/ct.raw"), fs::path("raw/ct.raw"));
  for (const char* outside : {"/etc/passwd", "../ct.raw", "raw/../../ct.raw", ""}) {
    EXPECT_THROW(RequireDataBeside("a/ct.mhd", outside), InputError) << outside;
  }
}

TEST(JsonDepth, IsBounded) {
  const std::string deep(100, '[');
  EXPECT_EQ(RefusedDepth(deep), "accepted");
  EXPECT_THAT(RefusedDepth(deep + "["), AllOf(HasSubstr("a.json"), HasSubstr("100 deep")));
  std::string objects;
  for (int i = 0; i < 101; ++i) objects += R"({"a":)";
  EXPECT_NE(RefusedDepth(objects), "accepted");
}

TEST(JsonDepth, DoesNotCountStringsAndComments) {
  const std::string deep(200, '[');
  EXPECT_EQ(RefusedDepth("{\"a\": \"" + deep + "\\\"" + deep + "\"}"), "accepted");
  EXPECT_EQ(RefusedDepth("{ // " + deep + "\n /* " + deep + " */ }"), "accepted");
  EXPECT_NE(RefusedDepth("{ // comment \n \"a\": " + deep), "accepted");
  std::string flat;
  for (int i = 0; i < 200; ++i) flat += "[]";
  EXPECT_EQ(RefusedDepth(flat), "accepted");
  EXPECT_EQ(RefusedDepth("\"never closed [[["), "accepted");
  EXPECT_EQ(RefusedDepth("/* never closed"), "accepted");
}

}  // namespace
}  // namespace acus
