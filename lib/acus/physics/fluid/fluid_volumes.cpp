// The accounts of a step: every volume that leaves one enters another.
#include <algorithm>

#include "acus/physics/fluid/fluid_model.h"
#include "acus/physics/fluid/lumen_content.h"

namespace acus::fluid {
namespace {

/// Takes `volume_ml` out of a tissue.
Passage TakeFrom(const FluidTissue& row, bool is_outside, TissueFluid& fluid,
                 double volume_ml) noexcept {
  Passage out;
  if (is_outside) {
    out.gas_volume_ml = out.air_ml = volume_ml;
  } else if (row.returns == Return::kContent) {
    out.liquid_ml = volume_ml;
  } else {
    const double liquid_ml = std::max(0.0, fluid.liquid_ml);
    const double air_ml = std::max(0.0, fluid.air_ml);
    const double sum_ml = liquid_ml + air_ml;
    out.liquid_ml = sum_ml > 0.0 ? volume_ml * liquid_ml / sum_ml : volume_ml;
    out.gas_volume_ml = volume_ml - out.liquid_ml;
    out.air_ml = out.gas_volume_ml;
  }
  fluid.liquid_ml -= out.liquid_ml;
  fluid.air_ml -= out.air_ml;
  return out;
}

void Add(Passage& sum, const Passage& part) noexcept {
  sum.liquid_ml += part.liquid_ml;
  sum.gas_volume_ml += part.gas_volume_ml;
  sum.air_ml += part.air_ml;
}

/// Removes a share and returns it; 1 removes all.
Passage TakeShare(Passage& pool, double share) noexcept {
  const Passage out{share * pool.liquid_ml, share * pool.gas_volume_ml, share * pool.air_ml};
  pool = share >= 1.0 ? Passage{}
                      : Passage{pool.liquid_ml - out.liquid_ml,
                                pool.gas_volume_ml - out.gas_volume_ml, pool.air_ml - out.air_ml};
  return out;
}

void GiveTo(TissueFluid& fluid, const std::array<double, 3>& tip_mm, const Passage& part) noexcept {
  const double added_ml = part.liquid_ml + part.air_ml;
  const double before_ml = std::max(0.0, fluid.liquid_ml) + std::max(0.0, fluid.air_ml);
  const double sum_ml = before_ml + added_ml;
  if (added_ml > 0.0 && sum_ml > 0.0) {
    for (std::size_t i = 0; i < 3; ++i) {
      fluid.centre_mm[i] += added_ml / sum_ml * (tip_mm[i] - fluid.centre_mm[i]);
    }
  }
  fluid.liquid_ml += part.liquid_ml;
  fluid.air_ml += part.air_ml;
}

}  // namespace

Passage FluidModel::TakeFromHub(FluidState& state, double volume_ml,
                                double syringe_kpa) const noexcept {
  if (state.hub == Hub::kOpen) {
    state.hub_air_ml += volume_ml;
    return {0.0, volume_ml, volume_ml};
  }
  Passage out;
  out.liquid_ml = std::min(volume_ml, state.liquid_ml);
  out.gas_volume_ml = volume_ml - out.liquid_ml;
  out.air_ml =
      std::min(state.air_ml, out.gas_volume_ml * (kAtmosphericKpa + syringe_kpa) / kAtmosphericKpa);
  state.liquid_ml -= out.liquid_ml;
  state.air_ml -= out.air_ml;
  return out;
}

void FluidModel::MoveFluid(FluidState& state, const BevelFlow& flow, double volume_ml,
                           double syringe_kpa, double dt_s, FluidOutput& output) const noexcept {
  LumenContent lumen{lumen_ml_, state.lumen_liquid_ml, state.lumen_air_ml};
  Passage pool;  // At the bevel.
  const auto lose_drawn = [&state](double liquid_ml) {
    const double wet_ml = state.liquid_ml + state.lumen_liquid_ml;
    if (wet_ml > 0.0) state.drawn_ml -= state.drawn_ml * std::min(1.0, liquid_ml / wet_ml);
  };
  if (volume_ml > 0.0) {
    const Passage leaving = lumen.Push(TakeFromHub(state, volume_ml, syringe_kpa));
    lose_drawn(leaving.liquid_ml);
    Add(pool, leaving);
  }
  double content_ml = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    const double out_ml = -flow.branch_ml_per_s[i] * dt_s;
    if (!(out_ml > 0.0)) continue;
    const int tissue = state.spread_tissue[i];
    const auto at = static_cast<std::size_t>(tissue);
    const FluidTissue& row = table_.tissues[at];
    const Passage part = TakeFrom(row, tissue == 0, state.tissue[at], out_ml);
    state.available_ml[i] = std::max(0.0, state.available_ml[i] - out_ml);
    if (row.returns == Return::kContent && tissue != 0) {
      content_ml += part.liquid_ml;
      if (volume_ml < 0.0) state.drawn_from = tissue;
    }
    Add(pool, part);
  }
  double wanted = std::max(0.0, -volume_ml);
  for (const double rate : flow.branch_ml_per_s) wanted += std::max(0.0, rate) * dt_s;
  for (std::size_t i = 0; i < 2; ++i) {
    const double in_ml = flow.branch_ml_per_s[i] * dt_s;
    if (!(in_ml > 0.0)) continue;
    const Passage part = TakeShare(pool, std::min(1.0, in_ml / wanted));
    wanted -= in_ml;
    GiveTo(state.tissue[static_cast<std::size_t>(state.spread_tissue[i])], state.tip_mm, part);
    state.available_ml[i] += part.liquid_ml + part.air_ml;
  }
  if (volume_ml < 0.0) {
    const Passage leaving = lumen.Push(pool);
    if (state.hub == Hub::kOpen) {
      lose_drawn(leaving.liquid_ml);
      state.hub_ml += leaving.liquid_ml;
      state.hub_air_ml -= leaving.air_ml;
      output.hub_ml_per_s = leaving.liquid_ml / dt_s;
    } else {
      state.liquid_ml += leaving.liquid_ml;
      state.air_ml += leaving.air_ml;
    }
    state.drawn_ml += std::min(content_ml, pool.liquid_ml);
  }
  state.lumen_liquid_ml = lumen.liquid_ml;
  state.lumen_air_ml = lumen.air_ml;
}

void FluidModel::AdvanceTissues(FluidState& state, const BevelFlow& flow,
                                double dt_s) const noexcept {
  for (std::size_t i = 0; i < 2; ++i) {
    const auto at = static_cast<std::size_t>(state.spread_tissue[i]);
    spreads_[at].Advance(state.spread[i], flow.branch_ml_per_s[i], dt_s);
  }
  for (std::size_t at = 0; at < table_.tissues.size(); ++at) {
    const double time_s = table_.tissues[at].absorption_s;
    TissueFluid& fluid = state.tissue[at];
    if (!(time_s > 0.0) || !(fluid.liquid_ml > 0.0)) continue;
    const double absorbed_ml = fluid.liquid_ml * dt_s / (time_s + dt_s);
    fluid.liquid_ml -= absorbed_ml;
    fluid.absorbed_ml += absorbed_ml;
  }
}

double TotalLiquidMl(const FluidState& state) noexcept {
  double sum_ml = state.liquid_ml + state.lumen_liquid_ml + state.hub_ml;
  for (const TissueFluid& fluid : state.tissue) sum_ml += fluid.liquid_ml + fluid.absorbed_ml;
  return sum_ml;
}

double TotalAirMl(const FluidState& state) noexcept {
  double sum_ml = state.air_ml + state.lumen_air_ml - state.hub_air_ml;
  for (const TissueFluid& fluid : state.tissue) sum_ml += fluid.air_ml;
  return sum_ml;
}

}  // namespace acus::fluid
