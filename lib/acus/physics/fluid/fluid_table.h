// Pressures and resistances of tissues, bores of needles and syringes: configs/fluid/*.json.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acus/physics/fluid/lumen.h"
#include "acus/physics/fluid/syringe.h"

namespace acus::fluid {

/// What returns from a tissue into the needle when the pressure there is lower.
enum class Return {
  kNothing,   ///< Solid tissue: it closes the bevel.
  kInjected,  ///< What was injected before: potential spaces, loose tissue.
  kContent    ///< Its own fluid: cerebrospinal fluid, blood, bile, urine, effusions.
};

/// A tissue or a space as the bevel meets it, in one patient.
struct FluidTissue {
  std::string name;
  Return returns = Return::kNothing;
  double opening_kpa = 0.0;          ///< Above the resting pressure, before fluid enters; >= 0.
  double entry_kpa_s_per_ml = 0.01;  ///< Resistance at the bevel, > 0.
  double spread_kpa_s_per_ml = 0.0;  ///< Darcy resistance of the spread, steady state; >= 0.
  double spread_time_s = 1.0;        ///< a^2/D: time constant of the spread, > 0.
  double source_radius_mm = 1.0;     ///< a: of the cavity at the bevel, > 0.
  double space_compliance_ml_per_kpa = 0.0;  ///< Of a space as a whole; 0: it does not fill up.
  double resting_kpa = 0.0;                  ///< Mean over a heart beat, at end expiration.
  double pulse_kpa = 0.0;                    ///< From diastole to systole, about that.
  double breath_kpa = 0.0;    ///< Rise from end expiration to end inspiration; may be < 0.
  double content_ml = 0.0;    ///< Own fluid that can return, with Return::kContent.
  double fluid_share = 1.0;   ///< Of the volume of a depot: 1 a cavity; in (0, 1].
  double flatness = 1.0;      ///< Thickness over width of a depot: 1 a sphere; in (0, 1].
  double absorption_s = 0.0;  ///< Time constant of absorption; 0: none.
};

struct Bore {
  int gauge = 0;
  std::string needle;  ///< "regular", "spinal", "tuohy": what it is the bore of.
  double inner_diameter_mm = 0.0;
};

/// One patient's values.
struct FluidTable {
  std::string file;
  Fluid saline;
  std::vector<FluidTissue> tissues;  ///< First: "outside", free space.
  std::vector<Syringe> syringes;
  std::vector<Bore> bores;

  /// Index of a tissue's row; -1 if there is none.
  int TissueIndex(std::string_view name) const noexcept;
  /// @throws InputError listing the names that there are.
  const Syringe& SyringeNamed(std::string_view name) const;
  /// @throws InputError listing the gauges that there are.
  double BoreMm(int gauge, std::string_view needle) const;
};

/// Rows that a table may have, "outside" among them.
inline constexpr int kMaxTissues = 40;

/// Reads configs/fluid/*.json (format acus-fluid/1).
/// @param seed  Draws the patient: every value of every tissue by itself, with the typical value as
///     median, within its range. Nothing: the typical patient.
/// @throws InputError
FluidTable ReadFluidTable(const std::filesystem::path& path,
                          std::optional<std::uint64_t> seed = std::nullopt);

/// The same for a document in memory; `label` stands for the file name in messages.
FluidTable FluidTableFromJson(nlohmann::json document, const std::string& label,
                              std::optional<std::uint64_t> seed = std::nullopt);

}  // namespace acus::fluid
