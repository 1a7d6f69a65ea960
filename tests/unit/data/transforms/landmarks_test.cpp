#include "acus/data/transforms/landmarks.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::transforms {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

/// Removed when the tests end.
std::filesystem::path Scratch() {
  static const testing_support::TemporaryFolder folder;
  return folder.path();
}

std::filesystem::path FileWith(const char* name, std::string_view text) {
  const auto path = Scratch() / name;
  WriteTextFile(path, text);
  return path;
}

auto Reading(const char* name, std::string text) {
  return [name, text] { return ReadLandmarks(FileWith(name, text)); };
}

std::string Markups(const std::string& system, const std::string& more = "") {
  return R"({"markups": [{"type": "Fiducial", )" +
         (system.empty() ? "" : R"("coordinateSystem": )" + system + ", ") + more +
         R"("controlPoints": [
    {"label": "nose", "position": [1.5, -2, 3], "positionStatus": "defined"},
    {"label": "later", "position": null, "positionStatus": "undefined"},
    {"label": "ear", "position": [4, 5, 6]}]}]})";
}

TEST(ReadLandmarks, ReadsCsvWithAndWithoutNames) {
  const Landmarks named =
      ReadLandmarks(FileWith("a.csv", "name,x_mm,y_mm,z_mm\nA,1,2,3\nB,-1e1,0,0.5\n"));
  EXPECT_THAT(named.names, ElementsAre("A", "B"));
  EXPECT_EQ(named.points_mm.col(1), Eigen::Vector3d(-10, 0, 0.5));
  EXPECT_THAT(ReadLandmarks(FileWith("b.csv", "x_mm,y_mm,z_mm\n1,2,3\n")).names, ElementsAre(""));
  EXPECT_THAT(ReadLandmarks(FileWith("a.tsv", "name\tx_mm\ty_mm\tz_mm\nA\t1\t2\t3\n")).names,
              ElementsAre("A"));
  EXPECT_THAT(ReadLandmarks(FileWith("a.txt", "name x_mm y_mm z_mm\nA 1 2 3\n")).names,
              ElementsAre("A"));
  // A column that is called like one of Slicer's does not make it Slicer's.
  EXPECT_EQ(ReadLandmarks(FileWith("c.csv", "r,s,x_mm,y_mm,z_mm\n7,8,1,2,3\n")).points_mm.col(0),
            Eigen::Vector3d(1, 2, 3));
}

TEST(ReadLandmarks, DeviationsOfOneAxisNeedThoseOfTheOthers) {
  for (const auto& [given, lacking] :
       {std::pair("sd_x_mm", "sd_y_mm"), {"sd_y_mm", "sd_x_mm"}, {"sd_z_mm", "sd_x_mm"}}) {
    EXPECT_THAT(Reading("a.csv", Message("x_mm,y_mm,z_mm,", given, "\n1,2,3,0.5\n")),
                ThrowsMessage<InputError>(HasSubstr(lacking)));
  }
}

TEST(ReadLandmarks, TurnsEverySlicerFrameIntoLps) {
  const Eigen::Vector3d as_written(1.5, -2, 3);
  const Eigen::Vector3d turned(-1.5, 2, 3);
  for (const char* lps : {"\"LPS\"", "\"1\"", "1", ""}) {
    const Landmarks read = ReadLandmarks(FileWith("a.mrk.json", Markups(lps)));
    EXPECT_THAT(read.names, ElementsAre("nose", "ear"));
    EXPECT_EQ(read.points_mm.col(0), as_written) << lps;
  }
  for (const char* ras : {"\"RAS\"", "\"0\"", "0"}) {
    EXPECT_EQ(ReadLandmarks(FileWith("a.mrk.json", Markups(ras))).points_mm.col(0), turned) << ras;
  }
  EXPECT_EQ(ReadLandmarks(FileWith("t.csv", "label,r,a,s\nnose,1.5,-2,3\n")).points_mm.col(0),
            turned);
  EXPECT_EQ(ReadLandmarks(FileWith("t.csv", "label,l,p,s\nnose,1.5,-2,3\n")).points_mm.col(0),
            as_written);
  const std::string row = "0,1.5,-2,3,0,0,0,1,1,1,0,nose,,\n";
  EXPECT_EQ(ReadLandmarks(FileWith("f.fcsv", "# CoordinateSystem = LPS\n" + row)).points_mm.col(0),
            as_written);
  EXPECT_EQ(ReadLandmarks(FileWith("f.fcsv", "# CoordinateSystem = 0\n" + row)).points_mm.col(0),
            turned);
  // As 3D Slicer writes it, with lines of other keys.
  const std::string header =
      "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n"
      "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";
  EXPECT_EQ(ReadLandmarks(FileWith("f.fcsv", header + row)).points_mm.col(0), as_written);
}

TEST(ReadLandmarks, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(
      Reading("a.csv", "name,x_mm,y_mm,z_mm\nA,1,2,3\nA,1,2,4\n"),
      ThrowsMessage<InputError>(AllOf(HasSubstr("a.csv:3"), HasSubstr("'A' appears twice"))));
  EXPECT_THAT(Reading("a.csv", "name,x_mm,y_mm,z_mm\nA,1,2,1e7\n"),
              ThrowsMessage<InputError>(HasSubstr("a.csv:2: point 'A'")));
  EXPECT_THAT(Reading("a.csv", "name,x_mm,y_mm,z_mm\n"),
              ThrowsMessage<InputError>(HasSubstr("holds no point")));
  EXPECT_THAT(Reading("a.csv", "name,x_mm,y_mm,z_mm\nA,1,2,3\n,3,4,5\n"),
              ThrowsMessage<InputError>(HasSubstr("some have none")));
  EXPECT_THAT(Reading("a.csv", "name,x,y,z\nA,1,2,3\n"),
              ThrowsMessage<InputError>(HasSubstr("'x' does not say its unit; name it 'x_mm'")));
  EXPECT_THAT(Reading("a.mrk.json", Markups("\"LAS\"")),
              ThrowsMessage<InputError>(HasSubstr("/markups/0/coordinateSystem: is \"LAS\"")));
  EXPECT_THAT(Reading("a.mrk.json", Markups("\"LPS\"", R"("coordinateUnits": "voxel", )")),
              ThrowsMessage<InputError>(HasSubstr("units of length")));
  EXPECT_THAT(Reading("a.mrk.json", R"({"markups": [{"controlPoints": [{"position": [1, 2]}]}]})"),
              ThrowsMessage<InputError>(HasSubstr("/markups/0/controlPoints/0/position")));
  EXPECT_THAT(Reading("a.mrk.json", "[]"), ThrowsMessage<InputError>(HasSubstr("/markups")));
  EXPECT_THAT(Reading("a.xlsx", "x"), ThrowsMessage<InputError>(HasSubstr("unknown kind")));
}

TEST(WriteLandmarks, ComesBackBitForBit) {
  Landmarks landmarks;
  landmarks.names = {"A", "B"};
  landmarks.points_mm.resize(3, 2);
  landmarks.points_mm << 0.1, 1.0 / 3, -1e-7, 12345.678901, 2, 3;
  for (const char* name : {"w.csv", "w.mrk.json"}) {
    const auto path = Scratch() / name;
    WriteLandmarks(path, landmarks);
    const Landmarks read = ReadLandmarks(path);
    EXPECT_EQ(read.names, landmarks.names);
    EXPECT_EQ(read.points_mm, landmarks.points_mm);
  }
  landmarks.names[0] = "a,b";
  EXPECT_THAT([&] { WriteLandmarks(Scratch() / "w.csv", landmarks); },
              ThrowsMessage<InputError>(HasSubstr("'a,b'")));
}

TEST(ReadLandmarks, SurvivesBrokenFiles) {
  const auto refusals = [](const char* name, const std::string& valid) {
    const auto path = Scratch() / name;
    return testing_support::ReadDamagedCopies(valid, path, 400, [&] { ReadLandmarks(path); });
  };
  EXPECT_GT(refusals("broken.csv", "name,x_mm,y_mm,z_mm\nA,1,2,3\nB,4.25,5,6\nC,7,8,-9\n"), 100);
  EXPECT_GT(refusals("broken.mrk.json", Markups("\"LPS\"")), 100);
  EXPECT_GT(refusals("broken.fcsv",
                     "# CoordinateSystem = LPS\n0,1.5,-2,3,0,0,0,1,1,1,0,nose,,\n"
                     "1,2,3,4,0,0,0,1,1,1,0,ear,,\n"),
            100);
  EXPECT_GT(refusals("errors.csv",
                     "name,x_mm,y_mm,z_mm,sd_x_mm,sd_y_mm,sd_z_mm\nA,1,2,3,0.1,0.1,0.4\n"
                     "B,4.25,5,6,0.1,0.2,0.4\nC,7,8,-9,0.1,0.1,0.3\n"),
            100);
  EXPECT_GT(refusals("phantom.xml",
                     "<PlusConfiguration><PhantomDefinition><Geometry><Landmarks>\n"
                     "<Landmark Name=\"#1\" Position=\"104.3 5.0 20.0\"/>\n"
                     "<Landmark Name=\"#2\" Position=\"104.3 45.0 20.0\"/>\n"
                     "</Landmarks></Geometry></PhantomDefinition></PlusConfiguration>\n"),
            100);
}

TEST(ReadLandmarks, ReadsLocalisationErrorsAndPlusPhantoms) {
  const auto path = Scratch() / "errors.csv";
  WriteTextFile(path, "name,x_mm,y_mm,z_mm,fle_mm\nA,1,2,3,0.3\nB,4,5,6,0.6\n");
  EXPECT_NEAR(ReadLandmarks(path).sd_mm(2, 1), 0.6 / std::sqrt(3.0), 1e-12);
  WriteTextFile(path,
                "name,x_mm,y_mm,z_mm,sd_x_mm,sd_y_mm,sd_z_mm\nA,1,2,3,0.1,0.2,0.3\n"
                "B,4,5,6,0.4,0.5,0.6\n");
  EXPECT_EQ(ReadLandmarks(path).sd_mm.col(0), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(ReadLandmarks(path).sd_mm.col(1), Eigen::Vector3d(0.4, 0.5, 0.6));
  WriteTextFile(path, "name,x_mm,y_mm,z_mm,fle_mm\nA,1,2,3,0\n");
  EXPECT_THAT(
      [&] { ReadLandmarks(path); },
      ThrowsMessage<InputError>(HasSubstr("errors.csv:2: the localisation error must be above 0")));
  const auto phantom = Scratch() / "phantom.xml";
  WriteTextFile(phantom,
                "<PlusConfiguration><Landmark Name=\"#1\" Position=\"104.3 5.0 20.0\"/>"
                "</PlusConfiguration>");
  EXPECT_EQ(ReadLandmarks(phantom).points_mm.col(0), Eigen::Vector3d(104.3, 5, 20));
  EXPECT_EQ(ReadLandmarks(phantom).names[0], "#1");
  WriteTextFile(phantom,
                "<PlusConfiguration><Landmark Name=\"#1\" Position=\"104.3 5.0\"/>"
                "</PlusConfiguration>");
  EXPECT_THAT([&] { ReadLandmarks(phantom); },
              ThrowsMessage<InputError>(HasSubstr("Position must be three numbers")));
}

Landmarks Points(std::vector<std::string> names) {
  Landmarks landmarks;
  landmarks.source = "file";
  landmarks.points_mm = Markers::Random(3, static_cast<Eigen::Index>(names.size()));
  landmarks.names = std::move(names);
  return landmarks;
}

TEST(MatchLandmarks, PairsByNameInWhateverOrder) {
  const Landmarks a = Points({"p", "q", "r", "only a"});
  const Landmarks b = Points({"r", "only b", "p", "q"});
  const MarkerPairs pairs = MatchLandmarks(a, b);
  EXPECT_THAT(pairs.names, ElementsAre("p", "q", "r"));
  EXPECT_EQ(pairs.reference_mm.col(2), a.points_mm.col(2));
  EXPECT_EQ(pairs.ct_mm.col(2), b.points_mm.col(0));
  EXPECT_THAT(pairs.warnings,
              ElementsAre(HasSubstr("lacks 'only a'"), HasSubstr("lacks 'only b'")));
}

TEST(MatchLandmarks, SaysHowATableWasRead) {
  Landmarks a = Points({"p", "q", "r"});
  a.source = "tracker.csv";
  a.how_read = "semicolons between cells, decimal comma";
  EXPECT_THAT(MatchLandmarks(a, Points({"p", "q", "r"})).warnings,
              ElementsAre("tracker.csv: semicolons between cells, decimal comma"));
  EXPECT_THAT(MatchLandmarks(a, Points({"1", "2", "3"})).warnings,
              ElementsAre(HasSubstr("by their order"), HasSubstr("decimal comma")));
}

TEST(MatchLandmarks, ErrorsStayWithTheirPoints) {
  Landmarks a = Points({"p", "q", "r"});
  Landmarks b = Points({"r", "p", "q"});
  a.sd_mm = a.points_mm.cwiseAbs();
  b.sd_mm = b.points_mm.cwiseAbs();
  const MarkerPairs pairs = MatchLandmarks(a, b);
  EXPECT_EQ(pairs.reference_sd_mm, pairs.reference_mm.cwiseAbs());
  EXPECT_EQ(pairs.ct_sd_mm, pairs.ct_mm.cwiseAbs());
}

TEST(MatchLandmarks, PairsByOrderOnlyWhereNothingElseIsMeant) {
  const MarkerPairs pairs = MatchLandmarks(Points({"", "", ""}), Points({"1", "2", "3"}));
  EXPECT_THAT(pairs.names, ElementsAre("#1", "#2", "#3"));
  EXPECT_THAT(pairs.warnings, ElementsAre(HasSubstr("by their order")));
  EXPECT_THAT(
      [] {
        MatchLandmarks(Points({"", "", ""}), Points({"", "", "", ""}));
      },
      ThrowsMessage<InputError>(HasSubstr("no name in common")));
  EXPECT_THAT(
      [] {
        MatchLandmarks(Points({"a", "b", "c"}), Points({"a", "b", "d"}));
      },
      ThrowsMessage<InputError>(HasSubstr("only 2 names in common")));
}

TEST(Without, LeavesOutByName) {
  const MarkerPairs pairs =
      MatchLandmarks(Points({"a", "b", "c", "d"}), Points({"a", "b", "c", "d"}));
  const MarkerPairs rest = Without(pairs, {"b"});
  EXPECT_THAT(rest.names, ElementsAre("a", "c", "d"));
  EXPECT_EQ(rest.ct_mm.col(1), pairs.ct_mm.col(2));
  EXPECT_THAT([&] { Without(pairs, {"e"}); }, ThrowsMessage<InputError>(HasSubstr("named 'e'")));
}

}  // namespace
}  // namespace acus::transforms
