#include "acus/rig/camera/facets.h"

#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::camera {
namespace {

using testing_support::TemporaryFolder;

const std::string kTraining = std::string(ACUS_SOURCE_DIR) + "/configs/facets/training.json";

std::string FacetText(const std::string& markers, const std::string& axes = "") {
  return R"({"format": "acus-facets/1", "name": "t", "dictionary": "aruco_4x4_50", "objects": [
    {"name": "Reference", "facets": [{"name": "f", )" +
         axes + R"("markers": [)" + markers + "]}]}]}";
}

TEST(Facets, CornersAreWhereTheSheetPutsThem) {
  const TemporaryFolder folder;
  // Printed x is the object's y, printed y is its z: the paper looks along +x.
  WriteTextFile(folder / "f.json",
                FacetText(R"({"id": 3, "side_mm": 20, "centre_mm": [100, 50]})",
                          R"("origin_mm": [1, 2, 3], "x_axis": [0, 2, 0], "y_axis": [0, 0, 5], )"));
  const FacetSet set = ReadFacets(folder / "f.json");
  ASSERT_NE(set.Find("Reference"), nullptr);
  EXPECT_EQ(set.Find("Probe"), nullptr);
  const auto corners = set.Find("Reference")->markers.at(0).CornersInObjectMm();
  EXPECT_TRUE(corners[0].isApprox(Eigen::Vector3d(1, 2 + 90, 3 + 60)));
  EXPECT_TRUE(corners[1].isApprox(Eigen::Vector3d(1, 2 + 110, 3 + 60)));
  EXPECT_TRUE(corners[2].isApprox(Eigen::Vector3d(1, 2 + 110, 3 + 40)));
  EXPECT_TRUE(corners[3].isApprox(Eigen::Vector3d(1, 2 + 90, 3 + 40)));
}

TEST(Facets, RefusesWhatCannotBePrintedOrDistinguished) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& text, const std::string& words) {
    WriteTextFile(folder / "f.json", text);
    try {
      ReadFacets(folder / "f.json");
      ADD_FAILURE() << "accepted; wanted: " << words;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  refused(FacetText(R"({"id": 50, "side_mm": 20})"), "0 to 49");
  refused(FacetText(R"({"id": 5, "side_mm": 20}, {"id": 5, "side_mm": 20})"), "is also on");
  refused(FacetText(R"({"id": 5, "side_mm": 0})"), "side_mm");
  refused(FacetText(R"({"id": 5, "side_mm": 20})", R"("x_axis": [1, 0.2, 0], )"), "right angle");
  refused(FacetText(R"({"id": 5, "side_mm": 20})", R"("x_axis": [0, 0, 0], )"), "must not be 0");
}

TEST(Facets, MarkersOfTheTrainingSetLookAwayFromTheirObject) {
  const FacetSet set = ReadFacets(kTraining);
  for (const FacetObject& object : set.objects) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Marker& marker : object.markers) {
      middle +=
          marker.object_from_marker.translation() / static_cast<double>(object.markers.size());
    }
    // Roofs, not valleys: each facet's outside is away from the others.
    for (const Marker& marker : object.markers) {
      Eigen::Vector3d away = marker.object_from_marker.translation() - middle;
      const Eigen::Vector3d normal = marker.object_from_marker.linear().col(2);
      away -= away.dot(marker.object_from_marker.linear().col(1)) *
              marker.object_from_marker.linear().col(1);
      EXPECT_GT(away.dot(normal), 1.0) << object.name << " " << marker.id;
    }
  }
}

TEST(Facets, DamagedCopiesAreReadOrRefused) {
  const TemporaryFolder folder;
  const int refused =
      testing_support::ReadDamagedCopies(ReadTextFile(kTraining), folder / "damaged.json", 300,
                                         [&] { ReadFacets(folder / "damaged.json"); });
  EXPECT_GT(refused, 50);
}

TEST(MarkerBits, AreThoseOfThePublishedDictionary) {
  // The first marker of ArUco's 4 x 4: rows 1011, 0101, 0011, 0010.
  const std::vector<std::vector<bool>> bits = MarkerBits("aruco_4x4_50", 0);
  const std::vector<std::vector<bool>> wanted = {{true, false, true, true},
                                                 {false, true, false, true},
                                                 {false, false, true, true},
                                                 {false, false, true, false}};
  EXPECT_EQ(bits, wanted);
  EXPECT_THROW(MarkerBits("aruco_4x4_50", 50), InputError);
  EXPECT_THROW(MarkerBits("aruco_4x4_50", -1), InputError);
  EXPECT_THROW(MarkerBits("aruco_9x9", 0), InputError);
}

}  // namespace
}  // namespace acus::camera
