// Rigid bodies that a camera finds: printed markers on flat facets of known geometry.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace acus::camera {

/// One square marker of a dictionary. Its frame: origin in the middle, x to the right and y up as
/// printed, z out of the paper.
struct Marker {
  int id = 0;
  double side_mm = 0.0;  ///< Of the black square.
  Eigen::Isometry3d object_from_marker = Eigen::Isometry3d::Identity();
  std::string facet;  ///< Which sheet it is printed on.

  /// In the object's frame: top left, top right, bottom right, bottom left as printed.
  std::array<Eigen::Vector3d, 4> CornersInObjectMm() const;
};

/// A tool or the mannequin.
struct FacetObject {
  std::string name;  ///< Of its frame: "Reference" is the mannequin.
  std::vector<Marker> markers;
};

struct FacetSet {
  std::string name;
  std::string dictionary;  ///< "apriltag_36h11", "aruco_4x4_50", ...; see MarkerBits.
  std::vector<FacetObject> objects;

  /// Null if there is none of that name.
  const FacetObject* Find(const std::string& object_name) const;
};

/// A file of format acus-facets/1.
/// @throws InputError as ReadConfig does, or for a marker that is not in the dictionary, a marker
///     that is there twice, two objects of one name, or axes that are not at right angles.
FacetSet ReadFacets(const std::filesystem::path& path);

/// The black and white squares of a marker without its border of one black square:
/// bits[row][column], true is white, row 0 at the top. @throws InputError for a dictionary or id
/// that does not exist.
std::vector<std::vector<bool>> MarkerBits(const std::string& dictionary, int id);

}  // namespace acus::camera
