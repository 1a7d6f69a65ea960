// The windows of practice: from where a needle and a probe approach a structure.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/patient/phantom/anatomy/patient_field.h"
#include "acus/patient/phantom/planning/body_frame.h"

namespace acus::phantom {

/// One direction of approach and the image plane that goes with it. CT frame, LPS.
struct Approach {
  Eigen::Vector3d direction;   ///< From the target towards the entry, unit.
  Eigen::Vector3d image_axis;  ///< In the image plane beside the needle; 0: the skin's normal.
  double cone_rad;             ///< Greatest angle between path and `direction`.
};

/// A place on the skin through which a path would go. CT frame, LPS.
struct WindowPlace {
  Eigen::Vector3d entry_ct_mm;
  Eigen::Vector3d skin_normal;  ///< Outwards.
  Eigen::Vector3d direction;    ///< Into the body.
};

struct ApproachWindow {
  std::string_view name;
  std::string_view what;       ///< For people.
  std::string_view structure;  ///< Target if none is requested; empty: one must be given.
  bool is_spinal = false;      ///< A first attempt touches bone, and lumbar heights come first.
  std::vector<Approach> (*approaches)(double side);

  /// Whether the path lies in the window; if so, `image_axis` may be set to one that only the place
  /// itself gives (between two ribs: theirs).
  bool (*accepts)(const PatientField& field, const BodyFrame& frame, const WindowPlace& place,
                  Eigen::Vector3d& image_axis);
};

/// All windows; the last, "shortest", takes paths from any side.
std::span<const ApproachWindow> ApproachWindows();

std::vector<std::string> WindowNames();

/// @throws InputError naming the nearest known one.
const ApproachWindow& WindowNamed(const std::string& name);

/// Those through which a structure is reached in practice, the usual one first, "shortest" last.
/// `organ` is the organ around a lesion or vessel, or empty.
std::vector<const ApproachWindow*> UsualWindows(const std::string& structure,
                                                const std::string& organ);

}  // namespace acus::phantom
