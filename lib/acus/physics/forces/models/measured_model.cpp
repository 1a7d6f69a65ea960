#include "acus/physics/forces/models/measured_model.h"

#include <algorithm>
#include <utility>

namespace acus::forces {
namespace {

/// The table without what soft tissue does to a needle along its path.
ForceTable WithoutSoftTissue(ForceTable table) {
  for (TissueForce& row : table.tissue) {
    row.membrane = {};
    row.cutting_n = row.friction_n_per_mm = row.withdrawal_friction_n_per_mm = 0.0;
    row.withdrawal_tip_n = 0.0;
  }
  return table;
}

MechanicalModel LawScaledBy(double ratio, MechanicalModel law) {
  for (ResistanceProfile* profile : {&law.in, &law.out}) {
    for (double& force : profile->force_n) force *= ratio;
  }
  for (InternalPuncture& p : law.punctures) {
    p.a1_n_per_mm *= ratio;
    p.a2_n_per_mm2 *= ratio;
    p.step_n *= ratio;
  }
  for (Release& r : law.releases) r.step_n *= ratio;
  law.offset_n = law.drift_n_per_s = 0.0;  // Of a sensor.
  return law;
}

}  // namespace

MeasuredModel::MeasuredModel(const ForceTable& table, const NeedleProperties& needle,
                             MechanicalModel law, double law_diameter_mm, GuidanceKind guidance)
    : layered_(WithoutSoftTissue(table), needle, guidance),
      law_(LawScaledBy(needle.beam.outer_diameter_mm / law_diameter_mm, std::move(law))) {}

bool MeasuredModel::PassesPuncture(double from_mm, double to_mm) const noexcept {
  for (const InternalPuncture& p : law_.punctures) {
    const double at_mm = p.contact_mm + p.puncture_mm;
    if (from_mm <= at_mm && at_mm < to_mm) return true;
  }
  return false;
}

NeedleForce MeasuredModel::Step(MeasuredState& state, const NeedleInput& input) const noexcept {
  SampleGate gate = state;
  if (gate.Judge(input) != SampleGate::Verdict::kStep) return layered_.Step(state, input);
  const bool was_in_body = state.in_body;
  const double previous_s = state.started ? state.valid_time_s : input.time_s;
  NeedleForce out = layered_.Step(state, input);
  if (!state.in_body) return out;
  MechanicalState& contact = state.contact;
  if (!was_in_body) {  // It came from the skin during the step, unstrained.
    contact = {};
    contact.Advance(law_, previous_s, 0.0);
  }
  // A needle that was withdrawn and turned has fresh tissue ahead: its channel is cut off.
  contact.deepest_mm = std::min(contact.deepest_mm, std::max(state.channel_mm, contact.depth_mm));
  const double deepest_mm = contact.deepest_mm;
  const ContactStrain strain = contact.Advance(law_, input.time_s, state.depth_mm);
  const double force_n = contact.ForceN(law_, strain, state.depth_mm);
  if (strain.in > 0.0 && !law_.punctures.empty()) {
    const double plain_n = law_.in.ForceN(state.depth_mm);
    const double all_n = law_.ResistanceInN(state.depth_mm, contact.deepest_mm);
    out.puncture_n += strain.in * (all_n - plain_n);
    out.friction_n += force_n - strain.in * (all_n - plain_n);
  } else {
    out.friction_n += force_n;
  }
  if (PassesPuncture(deepest_mm, contact.deepest_mm)) {
    out.event = FirstOf(out.event, NeedleEvent::kPuncture);
  }
  out.force_in_ct_n -= force_n * state.path.direction_in_ct;
  LimitTo(out, table().settings.largest_force_n);
  state.held = out;
  return out;
}

}  // namespace acus::forces
