#include "acus/patient/registration/wire_phantom.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::registration {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kWireHeader =
    "pattern,wire,front_x_mm,front_y_mm,front_z_mm,back_x_mm,back_y_mm,back_z_mm\n";
constexpr const char* kWireRows =
    "1,a,20,0,10,20,40,10\n1,b,40,0,10,25,40,10\n1,c,45,0,10,45,40,10\n";

std::string PlusPhantom(const std::string& wires, const std::string& transform = "") {
  return "<PlusConfiguration version=\"2.1\"><CoordinateDefinitions>" + transform +
         "</CoordinateDefinitions><PhantomDefinition><Geometry><Pattern Type=\"NWire\">" + wires +
         "</Pattern><Pattern Type=\"CoplanarParallelWires\"><Wire Name=\"x\"/></Pattern>"
         "</Geometry></PhantomDefinition></PlusConfiguration>";
}

constexpr const char* kPlusWires =
    "<Wire Name=\"a\" EndPointFront=\"20.0 0.0 10.0\" EndPointBack=\"20.0 40.0 10.0\" />"
    "<Wire Name=\"b\" EndPointFront=\"40.0 0.0 10.0\" EndPointBack=\"25.0 40.0 10.0\" />"
    "<Wire Name=\"c\" EndPointFront=\"45.0 0.0 10.0\" EndPointBack=\"45.0 40.0 10.0\" />";

class WirePhantomFile : public ::testing::Test {
 protected:
  WirePhantom Read(const std::string& name, const std::string& text) {
    WriteTextFile(folder_.path() / name, text);
    return ReadWirePhantom(folder_.path() / name);
  }
  testing_support::TemporaryFolder folder_;
};

TEST_F(WirePhantomFile, TableAndPlusConfigurationAreTheSame) {
  const WirePhantom table = Read("a.csv", std::string(kWireHeader) + kWireRows);
  const WirePhantom plus =
      Read("a.xml", PlusPhantom(kPlusWires,
                                "<Transform From=\"Phantom\" To=\"Reference\" "
                                "Matrix=\"1 0 0 7 0 0 -1 8 0 1 0 9 0 0 0 1\" />"));
  ASSERT_EQ(table.patterns.size(), 1U);
  ASSERT_EQ(plus.patterns.size(), 1U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(table.WireAt(i).name, plus.WireAt(i).name);
    EXPECT_EQ(table.WireAt(i).front_mm, plus.WireAt(i).front_mm);
    EXPECT_EQ(table.WireAt(i).back_mm, plus.WireAt(i).back_mm);
  }
  EXPECT_FALSE(table.reference_from_phantom);
  ASSERT_TRUE(plus.reference_from_phantom);
  EXPECT_LT(
      (*plus.reference_from_phantom * Eigen::Vector3d(1, 2, 3) - Eigen::Vector3d(8, 5, 11)).norm(),
      1e-12);
  EXPECT_EQ(plus.IndexOf("c"), 2U);
  EXPECT_FALSE(plus.IndexOf("d"));
}

TEST_F(WirePhantomFile, WhatIsNoNIsRefused) {
  const auto message = [&](const std::string& rows) {
    try {
      Read("a.csv", kWireHeader + rows);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(message("1,b,40,0,10,25,40,10\n1,a,20,0,10,20,40,10\n1,c,45,0,10,45,40,10\n"),
              HasSubstr("deg from parallel"));
  EXPECT_THAT(message("1,a,20,0,10,20,40,10\n1,b,40,0,10,39,40,10\n1,c,45,0,10,45,40,10\n"),
              HasSubstr("the middle wire 'b' is only 1.4"));
  EXPECT_THAT(message("1,a,20,0,10,20,40,10\n1,b,40,0,10,40,40,20\n1,c,45,0,10,45,40,10\n"),
              HasSubstr("crosses only 0 %"));
  EXPECT_THAT(message("1,a,20,0,10,20,40,10\n1,b,40,0,10,25,40,10\n"),
              HasSubstr("pattern '1' has not three rows"));
  EXPECT_THAT(message("1,a,20,0,10,20,40,10\n1,a,40,0,10,25,40,10\n1,c,45,0,10,45,40,10\n"),
              HasSubstr("two wires have the name 'a'"));
  EXPECT_THAT(message("1,a,20,0,10,20,0,10\n1,b,40,0,10,25,40,10\n1,c,45,0,10,45,40,10\n"),
              HasSubstr("wire 'a' has no length"));
  EXPECT_THAT(message("1,a,20,0,10,20,40,10\n1,b,40,0,10,25,40,10\n1,c,20,50,10,20,90,10\n"),
              HasSubstr("less than 1 mm apart"));
  EXPECT_THAT(message("1,a,2e4,0,1e4,2e4,4e4,1e4\n1,b,4e4,0,1e4,2.5e4,4e4,1e4\n"
                      "1,c,4.5e4,0,1e4,4.5e4,4e4,1e4\n"),
              HasSubstr("is the unit mm?"));
  EXPECT_THAT(message("1,a,20,0,10,20,40,x\n1,b,40,0,10,25,40,10\n1,c,45,0,10,45,40,10\n"),
              HasSubstr("a.csv:2"));
}

TEST_F(WirePhantomFile, BrokenPlusConfigurationsAreRefused) {
  EXPECT_THAT([&] { Read("a.xml", "<PlusConfiguration />"); },
              ThrowsMessage<InputError>(HasSubstr("has no N of wires")));
  EXPECT_THAT([&] { Read("a.xml", PlusPhantom("<Wire Name=\"a\" EndPointFront=\"1 2\" />")); },
              ThrowsMessage<InputError>(HasSubstr("EndPointFront is not three numbers")));
  EXPECT_THAT(
      [&] {
        Read("a.xml", PlusPhantom(kPlusWires,
                                  "<Transform From=\"Phantom\" To=\"Reference\" "
                                  "Matrix=\"2 0 0 7 0 2 0 8 0 0 2 9 0 0 0 1\" />"));
      },
      ThrowsMessage<InputError>(HasSubstr("PhantomToReference is not rigid")));
}

TEST_F(WirePhantomFile, TruncatedFilesAreRefused) {
  const std::string text = PlusPhantom(kPlusWires);
  for (std::size_t size = 0; size + 1 < text.size(); size += 5) {
    EXPECT_THROW(Read("cut.xml", text.substr(0, size)), InputError) << size;
  }
}

TEST(MiddleWirePoint, FollowsFromSimilarTriangles) {
  const NWire pattern = {Wire{"a", {20, 0, 10}, {20, 40, 10}}, Wire{"b", {40, 0, 10}, {25, 40, 10}},
                         Wire{"c", {45, 0, 10}, {45, 40, 10}}};
  // A cut along y = 16 + 0.2 (x - 20): the middle wire is met where x = 40 - 15 y / 40.
  const double x = (40.0 - 15.0 / 40.0 * 12.0) / (1.0 + 0.2 * 15.0 / 40.0);
  const Eigen::Vector3d expected(x, 16.0 + 0.2 * (x - 20.0), 10.0);
  const auto pixel = [](double at) {  // Any affine scale along the line.
    return Eigen::Vector2d(300.0 - 7.0 * at, 100.0 + 2.0 * at);
  };
  const auto point = MiddleWirePoint(pattern, {pixel(20.0), pixel(x), pixel(45.0)});
  EXPECT_LT((point - expected).norm(), 1e-10);
}

}  // namespace
}  // namespace acus::registration
