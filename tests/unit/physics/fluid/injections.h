// Needles, syringes and tissues for tests of fluid, with numbers that closed forms can take up.
#pragma once

#include <filesystem>
#include <string>
#include <utility>

#include "acus/physics/fluid/fluid_model.h"

namespace acus::fluid::testing_support {

inline constexpr double kKpaPerCmH2O = 0.0980665;
inline constexpr double kKpaPerMmHg = 0.133322;
inline const std::filesystem::path kDefaultTable =
    std::filesystem::path(ACUS_SOURCE_DIR) / "configs" / "fluid" / "default.json";

/// Rows of TestTable().
enum Row : int { kOutside, kBlocked, kOpenTissue, kPool, kSpace, kPorous };

inline FluidTable TestTable() {
  FluidTable table;
  table.file = "test";
  table.saline = {1.0, 1000.0};
  FluidTissue outside;
  outside.name = "outside";
  outside.returns = Return::kContent;
  outside.content_ml = 1e9;
  outside.entry_kpa_s_per_ml = 1e-3;
  FluidTissue blocked;
  blocked.name = "blocked";
  blocked.opening_kpa = 1e9;
  FluidTissue open;
  open.name = "open";
  open.entry_kpa_s_per_ml = 1e-6;
  FluidTissue pool;
  pool.name = "pool";
  pool.returns = Return::kContent;
  pool.content_ml = 1e3;
  pool.entry_kpa_s_per_ml = 1e-6;
  FluidTissue space;
  space.name = "space";
  space.returns = Return::kInjected;
  space.entry_kpa_s_per_ml = 0.1;
  space.space_compliance_ml_per_kpa = 0.5;
  FluidTissue porous;
  porous.name = "porous";
  porous.opening_kpa = 5.0;
  porous.returns = Return::kInjected;
  porous.entry_kpa_s_per_ml = 10.0;
  porous.spread_kpa_s_per_ml = 20.0;
  porous.spread_time_s = 0.3;
  table.tissues = {outside, blocked, open, pool, space, porous};
  return table;
}

/// Without friction and compliance, 15 mm.
inline Syringe IdealSyringe() {
  Syringe syringe;
  syringe.name = "ideal";
  return syringe;
}

inline Lumen Needle27G() {
  return {.inner_diameter_mm = 0.21, .length_mm = 90.0};
}
inline Lumen Tuohy16G() {
  return {.inner_diameter_mm = 1.194, .length_mm = 80.0};
}

inline FluidInput In(int tissue) {
  FluidInput input;
  input.bevel[0] = {tissue, 1.0};
  return input;
}

inline FluidInput Pressed(int tissue, double hand_n) {
  FluidInput input = In(tissue);
  input.hand_n = hand_n;
  return input;
}

inline FluidInput Held(int tissue, double hand_mm, double coupling_n_per_mm) {
  FluidInput input = In(tissue);
  input.drive = Drive::kPosition;
  input.hand_mm = hand_mm;
  input.coupling_n_per_mm = coupling_n_per_mm;
  return input;
}

}  // namespace acus::fluid::testing_support
