#include "acus/physics/fluid/plunger_equation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace acus::fluid {
namespace {

/// The ends of the barrel, as springs: stiff against any thumb.
constexpr double kStopNPerMm = 2000.0;
/// Below it, liquid boils: vapour fills the barrel at almost constant pressure.
constexpr double kVapourKpa = 2.3 - kAtmosphericKpa;
/// Least absolute pressure of Boyle's law; below, its tangent.
constexpr double kLeastAbsoluteKpa = 0.5;
/// Remainder of the forces, relative to their size.
constexpr double kTolerance = 1e-11;

struct ValueAndSlope {
  double value = 0.0;
  double slope = 0.0;
};

/// Volume of air and vapour in the barrel.
ValueAndSlope GasMl(double air_ml, double capacity_ml, double kpa) noexcept {
  const double amount = air_ml * kAtmosphericKpa;
  const double absolute_kpa = kAtmosphericKpa + kpa;
  ValueAndSlope out;
  if (absolute_kpa > kLeastAbsoluteKpa) {
    out.value = amount / absolute_kpa;
    out.slope = -out.value / absolute_kpa;
  } else {
    out.slope = -amount / (kLeastAbsoluteKpa * kLeastAbsoluteKpa);
    out.value = amount / kLeastAbsoluteKpa + out.slope * (absolute_kpa - kLeastAbsoluteKpa);
  }
  if (kpa < kVapourKpa) {
    out.value += capacity_ml * (kVapourKpa - kpa);  // The whole barrel within 1 kPa.
    out.slope -= capacity_ml;
  }
  return out;
}

ValueAndSlope StopN(const Syringe& syringe, double plunger_mm) noexcept {
  const double beyond_mm = plunger_mm - syringe.StrokeMm();
  if (beyond_mm > 0.0) return {kStopNPerMm * beyond_mm, kStopNPerMm};
  if (plunger_mm < 0.0) return {kStopNPerMm * plunger_mm, kStopNPerMm};
  return {};
}

}  // namespace

PlungerEquation::Point PlungerEquation::At(double bevel_kpa) const noexcept {
  Point out;
  out.flow = law.FlowAt(bevel_kpa);
  const double share = out.flow.ml_per_s > 0.0 ? 1.0 / expansion : 1.0;
  const double q = share * out.flow.ml_per_s;
  const double q_slope = share * out.flow.slope_ml_per_kpa_s;
  out.needle_ml_per_s = q;
  out.syringe_kpa = bevel_kpa + lumen.PressureKpa(q);
  const double kpa_slope =
      1.0 +
      (lumen.linear_kpa_s_per_ml + 2.0 * lumen.quadratic_kpa_s2_per_ml2 * std::abs(q)) * q_slope;
  if (syringe == nullptr) {
    out.residual = out.syringe_kpa;
    out.slope = kpa_slope;
    out.scale = 1.0 + std::abs(bevel_kpa);
    return out;
  }
  const double area = syringe->AreaMlPerMm();
  const ValueAndSlope gas = GasMl(air_ml, syringe->capacity_ml, out.syringe_kpa);
  // Room = liquid + gas, at the end of the step.
  out.plunger_mm =
      (syringe->capacity_ml + syringe->dead_space_ml +
       syringe->compliance_ml_per_kpa * out.syringe_kpa + dt_s * q - liquid_ml - gas.value) /
      area;
  const double mm_slope =
      ((syringe->compliance_ml_per_kpa - gas.slope) * kpa_slope + dt_s * q_slope) / area;
  const double travel_mm = out.plunger_mm - start_mm;
  const double speed_mm_per_s = travel_mm / dt_s;

  const double elastic_n = syringe->stick_n_per_mm * (stick_mm + travel_mm);
  // Passive: beyond the yield the force is the yield, and the spring stores no more than that.
  const double sticking_n = elastic_n + stick_n_s_per_mm * speed_mm_per_s;
  const double friction_n = std::clamp(sticking_n, -yield_n, yield_n);
  const bool is_stuck = friction_n == sticking_n;
  out.stick_mm = std::clamp(elastic_n, -yield_n, yield_n) / syringe->stick_n_per_mm;
  const ValueAndSlope stop = StopN(*syringe, out.plunger_mm);
  const double viscous_n = syringe->viscous_n_s_per_mm * speed_mm_per_s;
  out.resisting_n = area * out.syringe_kpa + friction_n + viscous_n + stop.value;
  const double mass_n = 1e-3 * syringe->plunger_mass_kg * (speed_mm_per_s - start_mm_per_s) / dt_s;
  const double hand = hand_n - hand_n_per_mm * travel_mm - hand_n_s_per_mm * speed_mm_per_s;
  out.residual = mass_n + out.resisting_n - hand;
  const double n_per_mm = 1e-3 * syringe->plunger_mass_kg / (dt_s * dt_s) +
                          (syringe->viscous_n_s_per_mm + hand_n_s_per_mm) / dt_s + hand_n_per_mm +
                          stop.slope +
                          (is_stuck ? syringe->stick_n_per_mm + stick_n_s_per_mm / dt_s : 0.0);
  out.slope = n_per_mm * mm_slope + area * kpa_slope;
  out.scale = 1.0 + std::abs(hand_n) + std::abs(hand_n_per_mm * travel_mm) +
              std::abs(area * out.syringe_kpa) + std::abs(mass_n);
  return out;
}

PlungerEquation::Root PlungerEquation::Solve(double guess_kpa, int max_iterations) const noexcept {
  Root root;
  root.bevel_kpa = guess_kpa;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  double last = std::numeric_limits<double>::infinity();
  while (true) {
    root.point = At(root.bevel_kpa);
    ++root.iterations;
    const Point& point = root.point;
    if (std::abs(point.residual) <= kTolerance * point.scale) break;
    if (root.iterations >= max_iterations) break;
    (point.residual > 0.0 ? high : low) = root.bevel_kpa;
    const bool is_slow = std::abs(point.residual) > 0.5 * last;
    last = std::abs(point.residual);
    double next = root.bevel_kpa - point.residual / point.slope;
    const bool is_bracketed = std::isfinite(low) && std::isfinite(high);
    if (is_bracketed && (is_slow || !(next > low && next < high))) next = 0.5 * (low + high);
    if (next == root.bevel_kpa || next == low || next == high) break;
    root.bevel_kpa = next;
  }
  return root;
}

}  // namespace acus::fluid
