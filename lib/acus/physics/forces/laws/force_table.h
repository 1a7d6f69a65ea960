// What each tissue does to a needle: configs/forces.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "acus/data/volume/labels.h"
#include "acus/physics/forces/laws/force_laws.h"
#include "acus/physics/forces/laws/hu_springs.h"
#include "acus/physics/forces/laws/tissue_time.h"
#include "acus/physics/forces/models/model_settings.h"
#include "acus/physics/forces/path/skin_nick.h"
#include "acus/physics/needle/needle_preset.h"

namespace acus::forces {

/// One tissue, for the table's reference needle.
struct TissueForce {
  PuncturePolynomial membrane;     ///< Met on entering the tissue; puncture_n = 0: none.
  double cutting_n = 0.0;          ///< At the tip while it advances through fresh tissue.
  double friction_n_per_mm = 0.0;  ///< Per mm of shaft in the tissue while it slides in.
  double withdrawal_friction_n_per_mm = 0.0;  ///< The same while it slides out.
  double withdrawal_tip_n = 0.0;              ///< What holds the tip while it is withdrawn.
  double cutting_stiffness_n_per_mm = 0.0;    ///< K_t of the model alamilla; 0: the table's.
  /// a1 and a2 inside the tissue, where the springs cut: a2 x^2 + a1 x of what the device is ahead
  /// of the tip holds it until that is cutting_n (Fortmeier-2016 eq. 4). Both 0: a1 is the cutting
  /// stiffness of the table.
  double cutting_a1_n_per_mm = 0.0;
  double cutting_a2_n_per_mm2 = 0.0;
  double shaft_n_per_mm2 = 0.0;       ///< k per mm of the springs along a shaft; 0: by elasticity.
  bool impenetrable = false;          ///< Bone: the tip stops at the surface.
  TissueTime time;                    ///< Which models read what: see needle_forces.md.
  std::bitset<256> no_membrane_from;  ///< Labels from which this tissue is entered without one.
  /// Geometric standard deviation of its forces between patients; 1: all have the same.
  double between_patients_gsd = 1.0;

  /// All forces and stiffnesses times `ratio`; depths of punctures, K_t and times stay.
  void Scale(double ratio) noexcept;
};

/// Everything else that the force law needs. Defaults are those of the schema acus-forces.
struct ForceSettings {
  double cutting_stiffness_n_per_mm = 0.0;
  double friction_buildup_mm = 0.0;
  double interface_hysteresis_mm = 0.0;
  double lateral_limit_n = 0.0;
  double tissue_lateral_stiffness_n_per_mm2 = 0.0;
  double redirect_depth_mm = 0.0;
  BoneSpring bone;
  double invalid_hold_s = 0.0;
  double invalid_ramp_s = 0.0;
  double largest_force_n = 0.0;
};

/// Forces by label. Labels that the file does not name behave as its "soft_tissue"; label 0
/// ("outside") is free space.
struct ForceTable {
  static constexpr int kMostTimes = 16;

  std::string description;
  double reference_diameter_mm = 1.0;  ///< Outer diameter of the needle that the rows are for.
  ForceSettings settings;
  std::array<TissueForce, 256> tissue{};
  AlamillaSettings alamilla;
  VidalSettings vidal;
  MultiProxySettings multi_proxy;
  HuTissues hu_tissues;
  HuSprings hu_springs;
  FrictionTime friction_time;
  SkinNick nick;                               ///< Not of the file: of the scene.
  std::bitset<256> named;                      ///< Labels that the file has a row for.
  std::array<TissueTime, kMostTimes> times{};  ///< The different ones of the rows; first: none.
  int num_times = 1;
  std::array<std::uint8_t, 256> time_of{};  ///< Of `times`, by label.

  /// True if any tissue's force depends on time.
  bool HasTime() const noexcept { return num_times > 1; }

  /// True if a tip that comes from one tissue meets a membrane where the other begins.
  bool HasMembrane(volume::Label from, volume::Label to) const noexcept {
    return tissue[to].membrane.puncture_n > 0.0 && !tissue[to].no_membrane_from.test(from);
  }

  /// The table for a needle of another outer diameter: all soft-tissue forces scale with it, as
  /// both the cut's length and the shaft's circumference do. Puncture depths stay.
  ForceTable ScaledTo(double outer_diameter_mm) const;

  /// The table of one patient: the forces of each tissue times math::PatientFactor of its
  /// between_patients_gsd; laws by HU have the factor of soft_tissue, the skin under a probe that
  /// of skin. Seed 0: the table itself.
  ForceTable OfPatient(std::uint64_t seed) const;

  /// True if OfPatient changes anything.
  bool VariesBetweenPatients() const noexcept;

 private:
  void ScaleLawsByHu(double ratio);
};

/// Reads configs/forces/*.json (format acus-forces/1). @throws InputError listing all problems.
ForceTable ReadForceTable(const std::filesystem::path& path);

/// The same for a document in memory; `label` stands for the file name in messages.
ForceTable ForceTableFromJson(nlohmann::json document, const std::string& label);

using needle::NeedleProperties;
using needle::ReadNeedle;

}  // namespace acus::forces
