#include "acus/rig/camera/facets.h"

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {
namespace {

using nlohmann::json;

Eigen::Vector3d Vector(const json& values) {
  return {values.at(0).get<double>(), values.at(1).get<double>(), values.at(2).get<double>()};
}

/// Where the sheet is: origin in its middle, x to the right, y up as printed.
Eigen::Isometry3d ObjectFromFacet(const json& facet, const std::string& where) {
  const Eigen::Vector3d x = Vector(facet.at("x_axis"));
  const Eigen::Vector3d y = Vector(facet.at("y_axis"));
  ACUS_REQUIRE(x.norm() > 1e-6 && y.norm() > 1e-6, where, ": x_axis and y_axis must not be 0");
  const double cosine = x.normalized().dot(y.normalized());
  ACUS_REQUIRE(std::abs(cosine) < 1e-3, where, ": x_axis and y_axis are not at a right angle (",
               std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi, " degrees)");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = x.normalized();
  pose.linear().col(2) = x.cross(y).normalized();
  pose.linear().col(1) = pose.linear().col(2).cross(pose.linear().col(0));
  pose.translation() = Vector(facet.at("origin_mm"));
  return pose;
}

Marker MarkerFrom(const json& entry, const Eigen::Isometry3d& object_from_facet,
                  const std::string& facet) {
  const json& centre = entry.at("centre_mm");
  Marker marker;
  marker.id = entry.at("id");
  marker.side_mm = entry.at("side_mm");
  marker.object_from_marker =
      object_from_facet *
      Eigen::Translation3d(centre.at(0).get<double>(), centre.at(1).get<double>(), 0.0);
  marker.facet = facet;
  return marker;
}

}  // namespace

std::array<Eigen::Vector3d, 4> Marker::CornersInObjectMm() const {
  const double h = 0.5 * side_mm;
  return {object_from_marker * Eigen::Vector3d(-h, h, 0),
          object_from_marker * Eigen::Vector3d(h, h, 0),
          object_from_marker * Eigen::Vector3d(h, -h, 0),
          object_from_marker * Eigen::Vector3d(-h, -h, 0)};
}

const FacetObject* FacetSet::Find(const std::string& object_name) const {
  for (const FacetObject& object : objects) {
    if (object.name == object_name) return &object;
  }
  return nullptr;
}

FacetSet ReadFacets(const std::filesystem::path& path) {
  const json document = config::ReadConfig(path, "acus-facets");
  FacetSet set;
  set.name = document.at("name");
  set.dictionary = document.at("dictionary");
  const int size = DictionarySize(set.dictionary);
  std::map<int, std::string> owner;
  std::set<std::string> names;
  for (const json& entry : document.at("objects")) {
    FacetObject object{.name = entry.at("name"), .markers = {}};
    ACUS_REQUIRE(names.insert(object.name).second, path.string(), ": two objects are named '",
                 object.name, "'; give each its own name");
    for (const json& facet : entry.at("facets")) {
      const std::string name = facet.at("name");
      const std::string where = path.string() + ": facet '" + name + "'";
      const Eigen::Isometry3d pose = ObjectFromFacet(facet, where);
      for (const json& row : facet.at("markers")) {
        const Marker marker = MarkerFrom(row, pose, name);
        ACUS_REQUIRE(marker.id < size, where, ": marker ", marker.id, " is not in ", set.dictionary,
                     ", which has 0 to ", size - 1);
        const auto [found, is_new] = owner.emplace(marker.id, object.name + ", " + name);
        ACUS_REQUIRE(is_new, where, ": marker ", marker.id, " is also on ", found->second,
                     "; every marker must be there once");
        object.markers.push_back(marker);
      }
    }
    set.objects.push_back(std::move(object));
  }
  return set;
}

}  // namespace acus::camera
