// Named points that are known in two spaces, and the files they come in.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace acus::transforms {

/// Points, one column each, millimetres.
using Markers = Eigen::Matrix3Xd;

struct Landmarks {
  std::string source;              ///< The file, for messages.
  std::vector<std::string> names;  ///< One per point; all empty if the file has no names.
  Markers points_mm;               ///< 3 x n.
  /// Localisation error along the axes of the file's frame, standard deviations; empty if the file
  /// does not say.
  Markers sd_mm = {};
  std::string how_read = {};  ///< What was taken from a table in another form than the plain one.
};

/// Reads points from
///  - CSV with columns name (may be missing), x_mm, y_mm, z_mm, in the frame of whoever wrote it,
///    or as Slicer exports tables: label and l, p, s or r, a, s (columns r, a, s become LPS); with
///    the localisation error in columns fle_mm (RMS length) or sd_x_mm, sd_y_mm, sd_z_mm, if known;
///  - `.mrk.json` of 3D Slicer: all defined points of all point lists, RAS turned to LPS
///    (coordinateSystem "LPS" or 1, "RAS" or 0; LPS if it is not said);
///    coordinates in coordinateUnits (mm if it is not said);
///  - `.fcsv` of 3D Slicer, the same;
///  - `.xml` of PLUS: the landmarks of its phantom definition, in the phantom's frame.
/// @throws InputError with file and place if the file is broken, holds no point, a name twice, a
///     coordinate that is not finite or is beyond a kilometre, or a unit that is no length.
Landmarks ReadLandmarks(const std::filesystem::path& path);

/// Writes `.csv` (name, x_mm, y_mm, z_mm) or `.mrk.json` (LPS), by extension, atomically. Reading
/// it back gives the same bits. @pre for `.mrk.json` the points are in LPS.
/// @throws InputError for another extension, or a name that CSV cannot hold.
void WriteLandmarks(const std::filesystem::path& path, const Landmarks& landmarks);

/// The same points in two spaces: column i of both is the point names[i].
struct MarkerPairs {
  std::vector<std::string> names;
  Markers reference_mm;
  Markers ct_mm;
  std::vector<std::string> warnings;  ///< What was omitted, and how the rest was matched.
  Markers reference_sd_mm = {};       ///< As Landmarks::sd_mm; empty if not known.
  Markers ct_sd_mm = {};
};

/// Matches by name. Points that only one side has are omitted with a warning. If the two have no
/// name in common, or there are none, points are matched by order, with a warning.
/// @throws InputError if fewer than `least` pairs remain, or there are no common names and the
///     counts differ.
MarkerPairs MatchLandmarks(const Landmarks& reference, const Landmarks& ct, std::size_t least = 3);

/// Omits points by name. @throws InputError if there is none of that name.
MarkerPairs Without(const MarkerPairs& pairs, const std::vector<std::string>& names);

}  // namespace acus::transforms
