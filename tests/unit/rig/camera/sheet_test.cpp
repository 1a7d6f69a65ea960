#include "acus/rig/camera/sheet.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "support/facet_views.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

using namespace testing_support;

std::string Between(const std::string& text, const std::string& from, const std::string& to) {
  const auto begin = text.find(from);
  if (begin == std::string::npos) return "";
  const auto start = begin + from.size();
  return text.substr(start, text.find(to, start) - start);
}

TEST(Sheet, MarkersOfThePrintAreAsLargeAndWhereTheFileSays) {
  const TemporaryFolder folder;
  const FacetSet set = ReadFacets(ConfigPath("facets/training.json"));
  const auto sheets = FacetSheets(set);
  ASSERT_EQ(sheets.size(), 6U);
  WriteSheets(folder.path(), "all", sheets);
  MarkerDetector detector(set.dictionary);
  constexpr double kPxPerMm = 300.0 / 25.4;
  std::size_t read = 0;
  for (const Sheet& sheet : sheets) {
    const auto seen = detector.Detect(ReadImage(folder / (sheet.name + ".png")));
    for (const DetectedMarker& marker : seen) {
      ++read;
      for (const FacetObject& object : set.objects) {
        for (const Marker& known : object.markers) {
          if (known.id != marker.id) continue;
          const Eigen::Vector2d across = marker.corners_px[1] - marker.corners_px[0];
          EXPECT_NEAR(across[0] / kPxPerMm, known.side_mm, 0.1);
          EXPECT_NEAR(across[1], 0.0, 0.5);  // The right way up.
        }
      }
    }
    // Distances between markers are those of the object.
    for (std::size_t i = 1; i < seen.size(); ++i) {
      const auto place = [&](int id) {
        for (const FacetObject& object : set.objects) {
          for (const Marker& known : object.markers) {
            if (known.id == id) return Eigen::Vector3d(known.object_from_marker.translation());
          }
        }
        return Eigen::Vector3d(1e9, 0, 0);
      };
      const double on_paper = (seen[i].corners_px[0] - seen[0].corners_px[0]).norm() / kPxPerMm;
      EXPECT_NEAR(on_paper, (place(seen[i].id) - place(seen[0].id)).norm(), 0.1) << sheet.name;
    }
  }
  EXPECT_EQ(read, 16U);
}

TEST(Sheet, PngSaysItsResolution) {
  const TemporaryFolder folder;
  WriteSheets(folder.path(), "board", {BoardSheet(ReadBoard(ConfigPath("cameras/board_a4.json")))});
  const std::string png = ReadTextFile(folder / "board.png");
  const auto at = png.find("pHYs");
  ASSERT_NE(at, std::string::npos);
  // 11811 pixels per metre.
  EXPECT_EQ(png.substr(at + 4, 9), std::string("\x00\x00\x2e\x23\x00\x00\x2e\x23\x01", 9));
}

TEST(Sheet, PdfIsOfTheSizeOfThePaperAndFindsItsObjects) {
  const CalibrationBoard board = ReadBoard(ConfigPath("cameras/board_a4.json"));
  const std::string pdf = PdfText({BoardSheet(board), BoardSheet(board)});
  EXPECT_EQ(pdf.substr(0, 8), "%PDF-1.4");
  EXPECT_EQ(Between(pdf, "/MediaBox [0 0 ", "]"), "595.2756 841.8898");  // A4 in points.
  EXPECT_EQ(Between(pdf, "/Count ", " "), "2");
  // A square of 27 mm is 76.5354 points: the black one at the top left begins with one module row.
  EXPECT_NE(pdf.find(" 76.5354 8.5039 re"), std::string::npos);
  // The table of places is right.
  const auto table = static_cast<std::size_t>(std::stoul(Between(pdf, "startxref\n", "\n")));
  EXPECT_EQ(pdf.substr(table, 6), "xref\n0");
  for (int object = 1; object <= 7; ++object) {
    const std::size_t row = pdf.find('\n', table + 5) + 1 + 20 * static_cast<std::size_t>(object);
    const auto place = static_cast<std::size_t>(std::stoul(pdf.substr(row, 10)));
    const std::string start = std::to_string(object) + " 0 obj";
    EXPECT_EQ(pdf.substr(place, start.size()), start);
  }
}

TEST(Sheet, BlackOfTheBoardIsHalfOfItAndMore) {
  const CalibrationBoard board = ReadBoard(ConfigPath("cameras/board_a4.json"));
  double area_mm2 = 0.0;
  for (const Rectangle& r : BoardSheet(board).black) area_mm2 += r.size_mm.prod();
  const double all_mm2 = board.columns * board.rows * board.square_mm * board.square_mm;
  EXPECT_GT(area_mm2, 0.55 * all_mm2);
  EXPECT_LT(area_mm2, 0.95 * all_mm2);
  EXPECT_NE(SvgText(BoardSheet(board)).find("width=\"210.0000mm\""), std::string::npos);
}

}  // namespace
}  // namespace acus::camera
