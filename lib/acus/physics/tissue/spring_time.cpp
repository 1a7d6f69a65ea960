// SpringModel: relaxing branches beside the springs of path and tip, and friction by rate and
// dwell. Equations: docs/models/tissue_functions_and_springs.md, "Time".
#include <algorithm>
#include <cmath>

#include "acus/physics/tissue/spring_model.h"

namespace acus::tissue {
namespace {

using forces::ForceRelaxation;

/// Travel in which a spring is built up to all that friction can hold; 0: it holds nothing.
double BuildupMm(const PathNode& node) {
  return node.axial_n_per_mm > 0.0 ? node.friction_n / node.axial_n_per_mm : 0.0;
}

}  // namespace

void SpringModel::DragInTime(SpringState& state, double travel_mm, double dt_s) const noexcept {
  const forces::FrictionTime& settings = table_.friction_time;
  const double moved_mm = forces::MovedMm(state.pace, travel_mm);
  const int pieces = forces::PiecesOf(settings, moved_mm, dt_s);
  const double piece_s = dt_s / pieces;
  const double piece_mm = travel_mm / pieces;
  for (int piece = 0; piece < pieces; ++piece) {
    const forces::PaceLogs logs =
        forces::AdvancePace(state.pace, settings, {moved_mm / pieces, state.slid_mm, piece_s});
    double slid_mm = 0.0;
    for (int i = 1; i < state.num_nodes; ++i) {
      const double before_mm = state.node[i].offset_mm;
      DragNode(state.node[i], logs, piece_mm, piece_s);
      slid_mm += piece_mm - (state.node[i].offset_mm - before_mm);
    }
    state.slid_mm = slid_mm / std::max(1, state.num_nodes - 1);
  }
}

void SpringModel::DragNode(PathNode& node, const forces::PaceLogs& logs, double travel_mm,
                           double dt_s) const noexcept {
  const double buildup_mm = BuildupMm(node);
  if (!(buildup_mm > 0.0)) {
    node.offset_mm = 0.0;
    node.relaxing_mm.fill(0.0);
    return;
  }
  const forces::TissueTime& time = table_.tissue[node.tissue].time;
  const double limit = forces::FrictionShare(time, logs);
  const auto drag = [&](double& offset_mm, double decay) {
    offset_mm = buildup_mm *
                forces::StrainAfter(offset_mm / buildup_mm, travel_mm / buildup_mm, decay, limit);
  };
  drag(node.offset_mm, 0.0);
  for (int k = 0; k < time.relaxation.num_terms; ++k) {
    drag(node.relaxing_mm[k], dt_s / time.relaxation.time_s[k]);
  }
}

double SpringModel::HeldOffsetMm(const PathNode& node) const noexcept {
  const ForceRelaxation& relaxation = table_.tissue[node.tissue].time.relaxation;
  if (relaxation.num_terms == 0) return node.offset_mm;
  const double buildup_mm = BuildupMm(node);
  if (!(buildup_mm > 0.0)) return 0.0;
  const double built_up_per_s = table_.friction_time.reference_mm_per_s / buildup_mm;
  double sum_mm = relaxation.ElasticShare() * node.offset_mm;
  double steady = relaxation.ElasticShare();
  for (int k = 0; k < relaxation.num_terms; ++k) {
    sum_mm += relaxation.share[k] * node.relaxing_mm[k];
    steady += relaxation.share[k] * std::min(1.0, built_up_per_s * relaxation.time_s[k]);
  }
  return sum_mm / steady;
}

/// Branches of the same mean length hold as much in the other tissue and store no more.
void SpringModel::TakeMeanOffset(PathNode& node, volume::Label tissue) const noexcept {
  if (table_.time_of[node.tissue] == table_.time_of[tissue]) return;
  const ForceRelaxation& relaxation = table_.tissue[node.tissue].time.relaxation;
  double mean_mm = relaxation.ElasticShare() * node.offset_mm;
  for (int k = 0; k < relaxation.num_terms; ++k) {
    mean_mm += relaxation.share[k] * node.relaxing_mm[k];
  }
  node.offset_mm = mean_mm;
  node.relaxing_mm.fill(mean_mm);
}

const ForceRelaxation& SpringModel::TipRelaxation(const SpringState& state) const noexcept {
  const volume::Label tissue =
      state.pressing ? state.membrane_of : state.node[state.num_nodes - 1].tissue;
  return table_.tissue[tissue].time.relaxation;
}

/// The branches ahead of the tip take over what they hold together from those of another tissue,
/// none longer than the elastic one.
void SpringModel::TakeTipOver(SpringState& state, const ForceRelaxation& before) const noexcept {
  const ForceRelaxation& now = TipRelaxation(state);
  if (now == before) return;
  const double ahead_mm = std::max(0.0, state.ahead_mm);
  double mean_mm = before.ElasticShare() * ahead_mm;
  for (int k = 0; k < before.num_terms; ++k) {
    mean_mm += before.share[k] * std::max(0.0, ahead_mm - state.rest_mm[k]);
  }
  const double elastic = now.ElasticShare();
  const double length_mm =
      elastic < 1.0 ? std::clamp((mean_mm - elastic * ahead_mm) / (1.0 - elastic), 0.0, ahead_mm)
                    : ahead_mm;
  state.rest_mm.fill(ahead_mm - length_mm);
}

void SpringModel::CreepTip(SpringState& state, double from_mm, double dt_s) const noexcept {
  const PathNode& tip = state.node[state.num_nodes - 1];
  const double to_mm = (state.device_in_ct_mm - tip.rest_in_ct_mm).dot(state.tip_direction_in_ct);
  const ForceRelaxation& relaxation = TipRelaxation(state);
  for (int k = 0; k < relaxation.num_terms; ++k) {
    state.rest_mm[k] =
        forces::CreptMm(state.rest_mm[k], {from_mm, to_mm, dt_s}, 0.0, relaxation.time_s[k]);
  }
}

void SpringModel::AdvanceRests(SpringState& state, double step_mm) const noexcept {
  for (double& rest_mm : state.rest_mm) rest_mm = std::max(0.0, rest_mm - step_mm);
}

}  // namespace acus::tissue
