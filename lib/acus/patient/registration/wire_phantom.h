// The wires of a phantom for the spatial calibration of an ultrasound probe.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace acus::registration {

/// A straight wire between two holes, in the phantom's frame.
struct Wire {
  std::string name;
  Eigen::Vector3d front_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d back_mm = Eigen::Vector3d::Zero();
};

/// Three wires in a plane that form an N: the first and the third are parallel, the middle one is
/// oblique.
using NWire = std::array<Wire, 3>;

struct WirePhantom {
  std::vector<NWire> patterns;
  /// PhantomToReference, where the file has it.
  std::optional<Eigen::Isometry3d> reference_from_phantom;

  std::size_t num_wires() const { return 3 * patterns.size(); }
  /// Wire `index % 3` of pattern `index / 3`.
  const Wire& WireAt(std::size_t index) const { return patterns.at(index / 3).at(index % 3); }
  /// The index of a name; nothing if there is none.
  std::optional<std::size_t> IndexOf(const std::string& name) const;
};

/// Reads the patterns of type NWire in the phantom definition of a PLUS configuration (`.xml`), or
/// a CSV with the columns pattern, wire, front_x_mm .. front_z_mm, back_x_mm .. back_z_mm: three
/// rows for each pattern, the oblique wire second.
/// @throws InputError with file and place if there is no N, a pattern has not three wires, two
/// wires
///     have one name, the outer wires are not parallel (1 degree) or the middle one is (3 degrees),
///     or the phantom is larger than 1 m or smaller than 5 mm.
WirePhantom ReadWirePhantom(const std::filesystem::path& path);

/// Where an image cuts the middle wire, in the phantom's frame: the three points lie on a line,
/// which the middle one divides as the parallel wires and the oblique one are divided by the
/// image's plane (similar triangles, as in PLUS: Lasso et al. 2014).
/// @param points_px  Of the three wires, in any affine scale; the outer two differ.
Eigen::Vector3d MiddleWirePoint(const NWire& pattern,
                                const std::array<Eigen::Vector2d, 3>& points_px);

}  // namespace acus::registration
