#include "acus/patient/registration/wire_phantom.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/xml_scan.h"
#include "acus/base/math/angles.h"
#include "acus/data/session/plus_config.h"
#include "acus/data/session/sequence_header.h"
#include "acus/data/transforms/transform_graph.h"

namespace acus::registration {
namespace {

using Eigen::Vector3d;

constexpr double kParallelDeg = 1.0;  ///< Outer wires differ by at most this.
constexpr double kObliqueDeg = 3.0;   ///< The middle wire differs by at least this.
constexpr double kSmallestPhantomMm = 5.0;
constexpr double kLargestPhantomMm = 1000.0;

Vector3d DirectionOf(const Wire& wire) {
  return (wire.back_mm - wire.front_mm).normalized();
}

double AngleDeg(const Wire& a, const Wire& b) {
  const double sine = DirectionOf(a).cross(DirectionOf(b)).norm();
  return std::asin(std::min(1.0, sine)) / math::kRadPerDegree;
}

/// Across the N: from the first wire to the third, perpendicular to the first.
Vector3d AcrossMm(const NWire& pattern) {
  const Vector3d along = DirectionOf(pattern[0]);
  const Vector3d apart_mm = pattern[2].front_mm - pattern[0].front_mm;
  return apart_mm - along.dot(apart_mm) * along;
}

/// How far a point is from the first wire towards the third, as a share of their distance.
double ShareAcross(const NWire& pattern, const Vector3d& point_mm) {
  const Vector3d across_mm = AcrossMm(pattern);
  return (point_mm - pattern[0].front_mm).dot(across_mm) / across_mm.squaredNorm();
}

void CheckPattern(const NWire& pattern, const std::string& label) {
  for (const Wire& wire : pattern) {
    ACUS_REQUIRE((wire.back_mm - wire.front_mm).norm() > 1e-3, label, ": wire '", wire.name,
                 "' has no length; its two ends must differ");
  }
  const double outer_deg = AngleDeg(pattern[0], pattern[2]);
  ACUS_REQUIRE(outer_deg <= kParallelDeg, label, ": wires '", pattern[0].name, "' and '",
               pattern[2].name, "' are ", outer_deg,
               " deg from parallel; in an N the first and the third wire are parallel and the "
               "second is oblique: correct the order of the rows or the ends of the wires");
  const double middle_deg = AngleDeg(pattern[0], pattern[1]);
  ACUS_REQUIRE(middle_deg >= kObliqueDeg, label, ": the middle wire '", pattern[1].name,
               "' is only ", middle_deg, " deg from the outer ones; at least ", kObliqueDeg,
               " are needed to find where the image cuts it");
  ACUS_REQUIRE(AcrossMm(pattern).norm() > 1.0, label, ": wires '", pattern[0].name, "' and '",
               pattern[2].name, "' are less than 1 mm apart; the outer wires of an N lie apart");
  const double crossed = std::abs(ShareAcross(pattern, pattern[1].back_mm) -
                                  ShareAcross(pattern, pattern[1].front_mm));
  ACUS_REQUIRE(crossed > 0.05, label, ": the middle wire '", pattern[1].name, "' crosses only ",
               100.0 * crossed,
               " % of the distance of the outer wires; it must run from one to "
               "the other");
}

void CheckPhantom(const WirePhantom& phantom, const std::string& label) {
  ACUS_REQUIRE(!phantom.patterns.empty(), label,
               ": has no N of wires; a PLUS phantom definition has elements Pattern of Type "
               "\"NWire\", a CSV three rows for each pattern");
  std::set<std::string> names;
  Eigen::AlignedBox3d box;
  for (const NWire& pattern : phantom.patterns) {
    CheckPattern(pattern, label);
    for (const Wire& wire : pattern) {
      ACUS_REQUIRE(!wire.name.empty() && names.insert(wire.name).second, label,
                   ": two wires have the name '", wire.name, "'; each needs a name of its own");
      box.extend(wire.front_mm).extend(wire.back_mm);
    }
  }
  const double size_mm = box.sizes().maxCoeff();
  ACUS_REQUIRE(size_mm >= kSmallestPhantomMm && size_mm <= kLargestPhantomMm, label,
               ": the wires extend over ", size_mm, " mm; a phantom has ", kSmallestPhantomMm,
               " to ", kLargestPhantomMm, " mm: is the unit mm?");
}

Vector3d EndOf(const core::XmlElement& element, const char* key, const std::string& label) {
  const auto numbers = session::NumbersOf(element.Attribute(key).value_or(""));
  ACUS_REQUIRE(numbers && numbers->size() == 3, label, ": wire '",
               element.Attribute("Name").value_or(""), "': ", key, " is not three numbers");
  return Vector3d(numbers->data());
}

WirePhantom FromPlus(const std::filesystem::path& path) {
  const std::string label = path.string();
  WirePhantom phantom;
  std::vector<std::vector<Wire>> patterns;
  bool is_n = false;
  for (const core::XmlElement& element : core::ScanXml(ReadTextFile(path), label)) {
    if (element.name == "Pattern") {
      is_n = element.Attribute("Type").value_or("") == "NWire";
      if (is_n) patterns.emplace_back();
    }
    if (element.name != "Wire" || !is_n) continue;
    patterns.back().push_back({element.Attribute("Name").value_or(""),
                               EndOf(element, "EndPointFront", label),
                               EndOf(element, "EndPointBack", label)});
  }
  for (const auto& wires : patterns) {
    ACUS_REQUIRE(wires.size() == 3, label, ": an N has ", wires.size(),
                 " wires; three are needed, the oblique one second");
    phantom.patterns.push_back({wires[0], wires[1], wires[2]});
  }
  const auto calibrations = session::ReadPlusCalibrations(path);
  const auto found = calibrations.find("PhantomToReference");
  if (found == calibrations.end()) return phantom;
  const auto pose = transforms::PoseAndScale(found->second);
  ACUS_REQUIRE(pose && (pose->scale.array() - 1.0).abs().maxCoeff() < 1e-3, label,
               ": PhantomToReference is not rigid; a rotation and a translation in mm are needed");
  phantom.reference_from_phantom = pose->pose;
  return phantom;
}

WirePhantom FromTable(const std::filesystem::path& path) {
  const CsvTable table(path);
  const auto pattern = table.Texts("pattern");
  const auto name = table.Texts("wire");
  std::vector<std::vector<double>> columns;
  for (const char* column :
       {"front_x_mm", "front_y_mm", "front_z_mm", "back_x_mm", "back_y_mm", "back_z_mm"}) {
    columns.push_back(table.Numbers(column));
  }
  WirePhantom phantom;
  for (std::size_t row = 0; row < table.num_rows(); row += 3) {
    const bool is_whole = row + 2 < table.num_rows() && pattern[row] == pattern[row + 1] &&
                          pattern[row] == pattern[row + 2] &&
                          (row + 3 == table.num_rows() || pattern[row + 3] != pattern[row]);
    ACUS_REQUIRE(is_whole, table.Where(row), ": pattern '", pattern[row],
                 "' has not three rows; an N has three wires, one below the other, the oblique one "
                 "second");
    NWire wires;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto at = [&](std::size_t c) { return columns[c][row + i]; };
      wires[i] = {name[row + i], {at(0), at(1), at(2)}, {at(3), at(4), at(5)}};
    }
    phantom.patterns.push_back(wires);
  }
  return phantom;
}

}  // namespace

std::optional<std::size_t> WirePhantom::IndexOf(const std::string& name) const {
  for (std::size_t i = 0; i < num_wires(); ++i) {
    if (WireAt(i).name == name) return i;
  }
  return {};
}

WirePhantom ReadWirePhantom(const std::filesystem::path& path) {
  WirePhantom phantom = path.extension() == ".xml" ? FromPlus(path) : FromTable(path);
  CheckPhantom(phantom, path.string());
  return phantom;
}

Vector3d MiddleWirePoint(const NWire& pattern, const std::array<Eigen::Vector2d, 3>& points_px) {
  const Eigen::Vector2d whole_px = points_px[2] - points_px[0];
  const double share = (points_px[1] - points_px[0]).dot(whole_px) / whole_px.squaredNorm();
  const double front = ShareAcross(pattern, pattern[1].front_mm);
  const double back = ShareAcross(pattern, pattern[1].back_mm);
  return pattern[1].front_mm +
         (share - front) / (back - front) * (pattern[1].back_mm - pattern[1].front_mm);
}

}  // namespace acus::registration
