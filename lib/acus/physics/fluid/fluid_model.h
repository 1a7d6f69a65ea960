// A syringe on a needle in tissue: pressures, flow and the force on the plunger, step by step.
//
// Volume balance of the syringe, Hagen-Poiseuille in the needle, an opening pressure and Darcy's
// spread in the tissue, and the plunger's momentum are one monotone equation for the pressure at
// the bevel, which backward Euler solves to rounding: stable and passive for any stiffness,
// compliance and step. Volumes are conserved exactly, as flow moves them from one account to
// another. Equations, sources, limits: docs/models/fluid.md. Units: see syringe.h.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "acus/physics/fluid/bevel_flow.h"
#include "acus/physics/fluid/fluid_table.h"
#include "acus/physics/fluid/lumen.h"
#include "acus/physics/fluid/lumen_content.h"
#include "acus/physics/fluid/syringe.h"
#include "acus/physics/fluid/tissue_spread.h"

namespace acus::fluid {

/// What is at the needle's hub.
enum class Hub : std::uint8_t { kStylet, kOpen, kSyringe };

/// How the hand moves the plunger.
enum class Drive : std::uint8_t { kForce, kPosition };

/// A part of the bevel's opening in one tissue.
struct BevelContact {
  int tissue = 0;      ///< Row of the table; 0: outside.
  double share = 0.0;  ///< Of the opening, 0 to 1.
};

struct FluidInput {
  Hub hub = Hub::kSyringe;
  Drive drive = Drive::kForce;
  double hand_n = 0.0;         ///< kForce: + pushes the plunger in.
  double hand_mm = 0.0;        ///< kPosition: where the hand holds the plunger, 0 to the stroke.
  double hand_mm_per_s = 0.0;  ///< Travel of hand_mm in this step over its time.
  double coupling_n_per_mm = 5.0;  ///< kPosition: between the hand and the plunger; > 0.
  /// >= 0. kPosition: beside the spring, see CouplingDampingNSPerMm. kForce: what the thumb loses
  /// with the plunger's speed, as no thumb follows with the same force; hand_n / this is its
  /// highest speed.
  double coupling_n_s_per_mm = 0.0;
  /// The tissues at the opening; two while it passes from one into the next.
  std::array<BevelContact, 2> bevel = {{{0, 1.0}, {0, 0.0}}};
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  ///< In CT space: for depots.
  double heart_cycles = 0.0;  ///< Heart beats since the start; whole numbers at end diastole.
  double breath_level = 0.0;  ///< 0 end expiration, 1 end inspiration.
};

/// Fluid in one tissue.
struct TissueFluid {
  double liquid_ml = 0.0;  ///< Injected less returned and absorbed; < 0 where content was drawn.
  double air_ml = 0.0;     ///< At atmospheric pressure.
  double absorbed_ml = 0.0;
  std::array<double, 3> centre_mm = {};  ///< Of what was injected.
};

/// All that changes. A plain value.
struct FluidState {
  double plunger_mm = 0.0;  ///< 0 at the mark of the capacity, + in.
  double plunger_mm_per_s = 0.0;
  PlungerFriction friction;
  double liquid_ml = 0.0;        ///< In the syringe.
  double air_ml = 0.0;           ///< In the syringe, at atmospheric pressure.
  double lumen_liquid_ml = 0.0;  ///< The rest of the lumen holds air.
  double lumen_air_ml = 0.0;     ///< At atmospheric pressure.
  double syringe_kpa = 0.0;
  double bevel_kpa = 0.0;
  double drawn_ml = 0.0;    ///< Of the liquid in syringe and lumen: content of a tissue.
  int drawn_from = 0;       ///< The last tissue whose content was drawn; 0: none.
  double hub_ml = 0.0;      ///< Liquid that left an open hub.
  double hub_air_ml = 0.0;  ///< Air that entered there, less what left.
  Hub hub = Hub::kSyringe;
  std::array<int, 2> spread_tissue = {};  ///< Tissue of each spread below; 0: none.
  std::array<TissueSpread::State, 2> spread = {};
  std::array<double, 2> available_ml = {};  ///< That may return, at the present place.
  std::array<double, 3> tip_mm = {};
  bool has_tip = false;
  std::array<TissueFluid, kMaxTissues> tissue = {};
};

struct FluidOutput {
  double plunger_mm = 0.0;
  double reaction_n = 0.0;     ///< On the hand at the plunger; + pushes the plunger out.
  double barrel_n = 0.0;       ///< On barrel and needle along the axis; + pushes them in.
  double flow_ml_per_s = 0.0;  ///< Through the needle; + into the tissue.
  double syringe_kpa = 0.0;
  double bevel_kpa = 0.0;
  double resting_kpa = 0.0;        ///< Of the tissue that most of the bevel is in, now.
  double hub_ml_per_s = 0.0;       ///< Liquid that leaves an open hub; >= 0.
  double air_in_syringe_ml = 0.0;  ///< At the present pressure.
  double drawn_share = 0.0;  ///< Of the liquid in syringe and lumen: content of state.drawn_from.
  int iterations = 0;        ///< Of the solver.
};

struct FluidOptions {
  int num_shells = 8;       ///< Of the spread, 2 to kMaxShells.
  int max_iterations = 80;  ///< Newton and bisection together.
};

/// What makes up for the force of the coupling that acts a step late on a sampled device: a spring
/// of K that is late by 1.5 T needs a damping of 1.5 K T; this is twice that.
inline double CouplingDampingNSPerMm(double coupling_n_per_mm, double step_s) noexcept {
  return 3.0 * coupling_n_per_mm * step_s;
}

/// Drops of 0.05 ml: 20 per ml, as infusion sets count them.
inline constexpr double kDropMl = 0.05;

class FluidModel {
 public:
  /// @throws InputError if values are out of range, with the name of what they belong to.
  FluidModel(FluidTable table, Syringe syringe, Filling filling, Lumen lumen,
             FluidOptions options = {});

  /// Syringe filled, and the lumen too where it is attached; else the lumen holds stylet or air.
  FluidState NewState(Hub hub = Hub::kSyringe) const noexcept;

  /// One step of `dt_s`, which is held within 1 us and 10 s. Inputs that are not finite are taken
  /// as those of a hand at rest.
  FluidOutput Step(FluidState& state, const FluidInput& input, double dt_s) const noexcept;

  /// Resting pressure of a tissue with pulse and breath.
  double RestingKpa(int tissue, double heart_cycles, double breath_level) const noexcept;

  /// Volume of air in the syringe at a pressure, by Boyle.
  static double AirVolumeMl(double air_ml, double kpa) noexcept {
    return air_ml * kAtmosphericKpa / (kAtmosphericKpa + kpa);
  }

  const FluidTable& table() const noexcept { return table_; }
  const Syringe& syringe() const noexcept { return syringe_; }
  const Lumen& lumen() const noexcept { return lumen_; }

 private:
  void ChangeHub(FluidState& state, Hub hub) const noexcept;
  void FollowTip(FluidState& state, const FluidInput& input) const noexcept;
  BevelLaw LawAt(const FluidState& state, const FluidInput& input, double dt_s) const noexcept;
  LumenResistance ResistanceNow(const FluidState& state) const noexcept;
  bool PushesAir(const FluidState& state) const noexcept;
  /// Removes what enters the needle at the hub.
  Passage TakeFromHub(FluidState& state, double volume_ml, double syringe_kpa) const noexcept;
  /// @param volume_ml  Through the needle, + outwards.
  void MoveFluid(FluidState& state, const BevelFlow& flow, double volume_ml, double syringe_kpa,
                 double dt_s, FluidOutput& output) const noexcept;
  void AdvanceTissues(FluidState& state, const BevelFlow& flow, double dt_s) const noexcept;

  FluidTable table_;
  Syringe syringe_;
  Filling filling_;
  Lumen lumen_;
  FluidOptions options_;
  LumenResistance liquid_resistance_;
  LumenResistance air_resistance_;
  double lumen_ml_ = 0.0;
  std::vector<TissueSpread> spreads_;  ///< One for each tissue.
};

/// All liquid, and all air, of the system and of what it exchanged fluid with: constant to
/// rounding.
double TotalLiquidMl(const FluidState& state) noexcept;
double TotalAirMl(const FluidState& state) noexcept;

}  // namespace acus::fluid
