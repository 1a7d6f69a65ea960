// What the force models of the papers need beside the rows by tissue: blocks of a force table.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acus/data/volume/labels.h"
#include "acus/physics/forces/laws/hard_contact.h"
#include "acus/physics/forces/laws/hu_resistance.h"
#include "acus/physics/forces/laws/lugre.h"
#include "acus/physics/forces/laws/virtual_fixture.h"
#include "acus/physics/forces/probe/surface_proxy.h"

namespace acus::forces {

/// The label of a tissue that a table names. @throws InputError that begins with `where`.
volume::Label TissueLabelAt(const nlohmann::json& name, const std::string& where);

/// Block "alamilla".
struct AlamillaSettings {
  /// The cutting force by the direct method in place of the tracking wall: not of the table, but of
  /// who calls for the model.
  bool direct_method = false;
  /// As printed: on bone the knock acts alone (eq. 1), without the spring of bone, and is the whole
  /// sinusoid (eq. 12). False: the spring, friction, cutting and clamping act, too.
  bool only_bone_on_bone = false;
  double withdrawal_share = 0.0;  ///< Withdrawal force as a share of the tissue's cutting force.
  LuGreParameters friction;
  FixtureSettings clamping;
  HardContactSettings hard_contact;
};

/// Block "vidal": needle and probe.
struct VidalSettings {
  CubicBSpline resistance_n_s_per_mm;  ///< By HU: the table of eq. 5.
  double edge_factor = 1.0;            ///< K_edge > 1.
  double edge_hu_per_mm = 0.0;         ///< Gradient above which the tip is at an interface.
  double withdrawal_n_s_per_mm = 0.0;
  double averaging_s = 0.0;       ///< m steps of eq. 3.
  bool passive_average = true;    ///< False: eq. 3, 7 and 8 as printed; they drive the hand.
  double largest_n_per_mm = 0.0;  ///< Stiffness that the passive mean never exceeds.

  SurfaceProxySettings skin;  ///< Before the puncture.
  double skin_n_per_mm = 0.0;
  double puncture_n = 0.0;
  double bone_hu = 0.0;

  double guidance_n_per_mm = 0.0;     ///< K3 of eq. 8.
  double guidance_averaging_s = 0.0;  ///< n steps.
  double guidance_clamp_n = 0.0;      ///< Standard deviation of the Gaussian in K2, > 0.
  double orientation_depth_mm = 0.0;
  Eigen::Vector3d gravity_in_ct_n = Eigen::Vector3d::Zero();  ///< G of eq. 1.

  struct Probe {
    SurfaceProxySettings skin;
    double skin_n_per_mm = 0.0;
    SurfaceProxySettings bone;
    double bone_n_per_mm = 0.0;  ///< Beyond the surface of bone, on top of the skin's.
    double damping_n_s_per_mm = 0.0;
    double smoothing_s = 0.0;
    double largest_force_n = 0.0;
    /// On bone the proxy is moved to where the line from the skin's proxy to the device meets it,
    /// as printed; false: a second spring from a proxy on bone.
    bool moves_proxy = false;
  } probe;
};

/// Block "multi_proxy": a probe or a fingertip on the skin.
struct MultiProxySettings {
  static constexpr std::size_t kMostStructures = 3;

  /// a1 d + a2 d^2 by depth, and a friction cone.
  struct Repulsion {
    double a1_n_per_mm = 0.0;
    double a2_n_per_mm2 = 0.0;
    double friction = 0.0;
  };
  /// A structure under the skin that adds to the force on the hand.
  struct Structure {
    volume::Label tissue = 0;
    std::optional<double> from_hu;  ///< None: only label maps have it.
    Repulsion repulsion;            ///< On top of the skin's, by the depth behind its surface.
  };
  double skin_hu = 0.0;
  Repulsion skin;
  std::vector<Structure> structures;  ///< At most kMostStructures.
  double damping_n_s_per_mm = 0.0;
  double face_mm = 0.0;
  double smoothing_s = 0.0;
  double largest_force_n = 0.0;
};

/// Tissues by HU for scenes without a label map: each from its HU up to that of the next.
struct HuTissues {
  struct Row {
    double from_hu = 0.0;
    volume::Label tissue = 0;
  };
  std::vector<Row> rows;  ///< Rising; below the first it is outside.

  volume::Label At(double hu) const noexcept;
};

/// From a checked document of format acus-forces/1. @throws InputError naming the place.
AlamillaSettings AlamillaFromJson(const nlohmann::json& block);
VidalSettings VidalFromJson(const nlohmann::json& block, const std::string& where);
MultiProxySettings MultiProxyFromJson(const nlohmann::json& block, const std::string& where);
HuTissues HuTissuesFromJson(const nlohmann::json& rows, const std::string& where);

}  // namespace acus::forces
