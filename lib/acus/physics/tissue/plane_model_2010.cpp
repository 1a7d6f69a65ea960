#include "acus/physics/tissue/plane_model_2010.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::tissue {
namespace {

using forces::NeedleEvent;

constexpr int kMostNodes = 96;     // That the needle can touch.
constexpr int kMostSubsteps = 64;  // In one step: half a spacing each.
constexpr double kSlackMm = 0.05;
constexpr double kTremorMm = 1.0;
constexpr double kEscapeMm = 20.0;
constexpr double kLeastPathCosine = 0.2;  // Between needle and path.
constexpr int kBisections = 30;

/// The axis of the grid along which the path continues by one layer of nodes after the other.
int MajorAxis(const Eigen::Vector2d& along) {
  return std::abs(along.y()) >= std::abs(along.x()) ? 1 : 0;
}

}  // namespace

/// One valid sample, in the plane, and the place before.
struct PlaneModel2010::Motion {
  Eigen::Vector2d from_mm;
  Eigen::Vector2d to_mm;
  Eigen::Vector2d from_axis;
  Eigen::Vector2d to_axis;
  bool was_outside = false;
};

PlaneModel2010::PlaneModel2010(const PlaneSettings& settings, const PlanePlacement& placement,
                               const forces::ForceTable& forces,
                               const forces::NeedleProperties& needle,
                               const mechanics::ElasticityTable& elasticity, TissueAt tissue_at)
    : settings_(settings),
      table_(forces.ScaledTo(needle.beam.outer_diameter_mm)),
      tissue_at_(std::move(tissue_at)),
      planes_(settings, placement, table_, elasticity, 0.5 * needle.beam.outer_diameter_mm,
              tissue_at_),
      relaxation_(elasticity.relaxation) {
  ACUS_REQUIRE(settings.lateral_limit_n_per_mm > 0.0 && settings.image_fade_mm > 0.0 &&
                   settings.force_error_n > 0.0,
               "lateral_limit_n_per_mm is ", settings.lateral_limit_n_per_mm, ", image_fade_mm ",
               settings.image_fade_mm, " and force_error_n ", settings.force_error_n,
               "; allowed: above 0");
  settings_.thickness_mm = planes_.thickness_mm();
}

/// The plane follows needle and image while it holds no needle: no force can jump then.
void PlaneModel2010::Lay(PlaneState& state, const ToolSample& sample) const noexcept {
  if (settings_.num_turned == 0 || state.in_body() || !sample.probe_valid) return;
  const Eigen::Vector3d image_normal = sample.ct_from_probe.linear().col(2);
  if (!image_normal.allFinite()) return;
  state.frame = planes_.FrameFor(sample.tip_in_ct_mm, sample.axis_in_ct.normalized(), image_normal,
                                 state.frame);
  state.contact.Refer(planes_.compliance(state.frame.tissue));
  if (!state.gate.started) return;
  state.tip_in_plane_mm = state.frame.ToPlaneMm(state.tip_in_ct_mm).head<2>();
  const Eigen::Vector2d axis = state.frame.DirectionInPlane(state.axis_in_ct).head<2>();
  if (axis.norm() > 1e-6) state.axis_in_plane = axis.normalized();
}

volume::Label PlaneModel2010::LabelAt(const PlaneFrame& frame,
                                      const Eigen::Vector2d& plane_mm) const noexcept {
  return tissue_at_(frame.ToCtMm(plane_mm));
}

volume::Label PlaneModel2010::LabelOnPath(const PlaneState& state, double at_mm) const noexcept {
  const Eigen::Vector2d on_path_mm = state.entry_mm + at_mm * state.along;
  if (settings_.num_turned == 0) return LabelAt(state.frame, on_path_mm);
  // Where the needle is in the tissue at rest: tissue that went along with it across the path has
  // its place, and a hand that has torn it or left the plane meets what is there.
  double across_mm = AcrossMm(state, at_mm);
  for (int q = 0; q < state.num_nodes; ++q) {
    across_mm -= Hat(state, q, at_mm) * state.contact.DisplacementMm(2 * q + 1);
  }
  const double off_mm = state.out_of_plane_mm + (at_mm - state.device_mm) * state.out_slope;
  const Eigen::Vector2d across(-state.along.y(), state.along.x());
  return tissue_at_(state.frame.ToCtMm(on_path_mm + across_mm * across) +
                    off_mm * state.frame.ct_from_plane.col(2));
}

PlaneModel2010 PlaneModel2010::WithUpdate(PlaneUpdate update) const {
  PlaneModel2010 other = *this;
  other.settings_.update = update;
  if (update == PlaneUpdate::kFull) {
    other.settings_.num_turned = 0;
    other.planes_ = planes_.OnlyPlanned();
  }
  return other;
}

PlaneState PlaneModel2010::NewState() const {
  PlaneState state;
  const int capacity = std::min(kMostNodes, std::max(planes_.grid().rows, planes_.grid().columns));
  state.contact = PlaneContact(planes_.compliance(), 2 * capacity, settings_.update, relaxation_);
  state.node.resize(capacity);
  state.frame = planes_.planned();
  return state;
}

forces::NeedleForce PlaneModel2010::Step(PlaneState& state,
                                         const ToolSample& sample) const noexcept {
  const auto verdict = state.gate.Judge(sample);
  if (verdict != SampleGate::Verdict::kStep) {
    return state.gate.ForceInstead(verdict, table_.settings);
  }
  const bool started = state.gate.started;
  const double dt_s = started ? sample.time_s - state.gate.valid_time_s : 1.0;
  state.contact.Pass(dt_s);
  Lay(state, sample);
  const Eigen::Vector3d tip_mm = state.frame.ToPlaneMm(sample.tip_in_ct_mm);
  state.tip_in_ct_mm = sample.tip_in_ct_mm;
  state.axis_in_ct = sample.axis_in_ct.normalized();
  const Eigen::Vector3d axis = state.frame.DirectionInPlane(state.axis_in_ct);
  state.out_of_plane_mm = tip_mm.z();
  state.out_of_plane_rad = std::asin(std::clamp(axis.z(), -1.0, 1.0));
  if (settings_.num_turned > 0) {
    state.out_slope = axis.z() / std::max(kLeastPathCosine, axis.head<2>().norm());
  }
  Motion motion;
  motion.to_mm = tip_mm.head<2>();
  const double in_plane = axis.head<2>().norm();
  // A needle across the plane has no direction in it: the last one is kept.
  motion.to_axis =
      in_plane > 1e-6 ? Eigen::Vector2d(axis.head<2>() / in_plane) : state.axis_in_plane;
  motion.from_mm = started ? state.tip_in_plane_mm : motion.to_mm;
  motion.from_axis = started ? state.axis_in_plane : motion.to_axis;
  motion.was_outside = started && state.tissue_at_tip == 0;
  state.tip_in_plane_mm = motion.to_mm;
  state.axis_in_plane = motion.to_axis;
  state.tissue_at_tip = settings_.num_turned > 0 && state.in_body()
                            ? tissue_at_(sample.tip_in_ct_mm)
                            : LabelAt(state.frame, motion.to_mm);

  NeedleEvent event = NeedleEvent::kNone;
  if (!state.in_body() && state.tissue_at_tip != 0 && Touch(state, motion)) {
    event = NeedleEvent::kContact;
    motion.from_mm = state.entry_mm;
    motion.from_axis = motion.to_axis;
  }
  state.force = {};
  if (state.in_body()) {
    const double device_before_mm = state.device_mm;
    const double travel_mm = (motion.to_mm - motion.from_mm).norm();
    const int num = static_cast<int>(
        std::clamp(std::ceil(travel_mm / (0.5 * settings_.spacing_mm)), 1.0, 1.0 * kMostSubsteps));
    for (int i = 1; i <= num && state.in_body(); ++i) {
      const double part = static_cast<double>(i) / num;
      const Eigen::Vector2d tip = motion.from_mm + part * (motion.to_mm - motion.from_mm);
      const Eigen::Vector2d turned = motion.from_axis + part * (motion.to_axis - motion.from_axis);
      const Eigen::Vector2d direction =
          turned.norm() > 1e-6 ? Eigen::Vector2d(turned.normalized()) : motion.to_axis;
      event = FirstOf(event, Substep(state, tip, direction, dt_s / num));
    }
    if (state.in_body()) Forces(state, (state.device_mm - device_before_mm) / dt_s);
  }
  LimitTo(state.force, table_.settings.largest_force_n);
  state.force.event = event;
  state.gate.Accept(sample, state.force);
  return state.force;
}

bool PlaneModel2010::Touch(PlaneState& state, const Motion& motion) const noexcept {
  Eigen::Vector2d skin_mm = motion.to_mm;
  if (motion.was_outside) {
    Eigen::Vector2d outside_mm = motion.from_mm;
    for (int i = 0; i < kBisections; ++i) {
      const Eigen::Vector2d middle = 0.5 * (outside_mm + skin_mm);
      (LabelAt(state.frame, middle) == 0 ? outside_mm : skin_mm) = middle;
    }
  }
  const volume::Label tissue = LabelAt(state.frame, skin_mm);
  state.device_mm = state.needle_mm = state.aside_mm = state.slope = 0.0;
  state.pace = {};
  state.pace_logs = {};
  state.slid_mm = 0.0;
  StartPath(state, motion.to_axis, skin_mm);
  if (!AppendNode(state, 0.0)) return false;  // Outside the region: nothing to deform there.
  state.tip_rest_mm = state.channel_mm = 0.0;
  state.cut_tissue = state.membrane_of = tissue;
  state.on_bone = table_.tissue[tissue].impenetrable;
  state.bone_at_mm = 0.0;
  state.pressing = !state.on_bone && table_.HasMembrane(0, tissue);
  const bool is_soft = !state.pressing && !state.on_bone;
  state.phase = is_soft ? NeedlePhase::kInside : NeedlePhase::kOnSkin;
  state.engaged = is_soft;
  state.node[0].reference_mm.x() = 0.0;  // It is the skin that is touched, at 0.
  return true;
}

void PlaneModel2010::StartPath(PlaneState& state, const Eigen::Vector2d& along,
                               const Eigen::Vector2d& entry_mm) const noexcept {
  state.along = along;
  state.entry_mm = entry_mm;
  state.contact.Clear();
  state.num_nodes = 0;
  const int major = MajorAxis(along);
  const double h = settings_.spacing_mm;
  // The node of the skin may be up to three quarters of a layer above it.
  const double first_mm = entry_mm[major] - (along[major] > 0 ? 0.75 : -0.75) * h;
  state.next_layer =
      static_cast<int>(along[major] > 0 ? std::ceil(first_mm / h) : std::floor(first_mm / h));
}

/// The node nearest to the path in a row (or column, if the path is flat) of the grid; -1 beyond
/// the region.
int PlaneModel2010::NodeOfLayer(const PlaneState& state, int layer) const noexcept {
  const int major = MajorAxis(state.along);
  const int layers = major == 1 ? planes_.grid().rows : planes_.grid().columns;
  const int across = major == 1 ? planes_.grid().columns : planes_.grid().rows;
  if (layer < 0 || layer >= layers) return -1;
  const double h = settings_.spacing_mm;
  const double at_mm = (layer * h - state.entry_mm[major]) / state.along[major];
  const double place = (state.entry_mm[1 - major] + at_mm * state.along[1 - major]) / h;
  if (!(place > -0.5 && place < across - 0.5)) return -1;
  const int index = std::clamp(static_cast<int>(std::lround(place)), 0, across - 1);
  return major == 1 ? planes_.grid().Node(index, layer) : planes_.grid().Node(layer, index);
}

int PlaneModel2010::LayerStep(const PlaneState& state) noexcept {
  return state.along[MajorAxis(state.along)] > 0 ? 1 : -1;
}

/// The next node of the path comes into contact, where it is: without force. The needle has reached
/// it while it made its last `travel_mm`.
bool PlaneModel2010::AppendNode(PlaneState& state, double travel_mm) const noexcept {
  if (state.contact.size() + 2 > state.contact.capacity()) return false;
  const int step = LayerStep(state);
  int layer = state.next_layer;
  int node = NodeOfLayer(state, layer);
  const std::vector<int>& dof_of = planes_.dof_of_node(state.frame.tissue);
  while (node >= 0 && dof_of[node] < 0) {
    // Air above the skin is passed over; a fixed node is the end of what can move.
    if (state.num_nodes > 0) return false;
    layer += step;
    node = NodeOfLayer(state, layer);
  }
  if (node < 0) return false;
  const Eigen::Vector2d rest_mm = planes_.grid().PositionMm(node);
  PlaneNode& added = state.node[state.num_nodes];
  added.node = node;
  added.at_mm = (rest_mm - state.entry_mm).dot(state.along);
  const volume::Label tissue = LabelAt(state.frame, rest_mm);
  added.friction_n_per_mm = table_.tissue[tissue].friction_n_per_mm;
  added.tissue = tissue;
  state.contact.Append(dof_of[node], state.along.x(), state.along.y());
  const int slot = 2 * state.num_nodes;
  added.reference_mm.x() = state.needle_mm - travel_mm - state.contact.DisplacementMm(slot);
  added.reference_mm.y() = AcrossMm(state, added.at_mm) - state.contact.DisplacementMm(slot + 1);
  ++state.num_nodes;
  state.next_layer = layer + step;
  return true;
}

void PlaneModel2010::LoadOf(const PlaneState& state, TissueLoad& out) const noexcept {
  static_assert(kMostNodes <= TissueLoad::kMaxPoints);
  out.num_points = 0;
  out.needle = {};
  if (!state.in_body()) return;
  const Eigen::Vector2d across(-state.along.y(), state.along.x());
  for (int q = 0; q < state.num_nodes; ++q) {
    const Eigen::Vector2d force_n =
        state.contact.ElasticN(2 * q) * state.along + state.contact.ElasticN(2 * q + 1) * across;
    out.point[q].rest_in_ct_mm = state.frame.ToCtMm(planes_.grid().PositionMm(state.node[q].node));
    out.point[q].force_in_ct_n = state.frame.DirectionInCt(force_n);
  }
  out.num_points = state.num_nodes;
  out.plane = state.frame;
  out.needle.in_contact = true;
  out.needle.pierced = state.pierced();
  out.needle.entry_in_ct_mm = state.frame.ToCtMm(state.entry_mm);
  out.needle.tip_in_ct_mm =
      state.frame.ToCtMm(state.entry_mm + state.needle_mm * state.along + state.aside_mm * across);
  out.needle.axis_in_ct = state.frame.DirectionInCt(state.along);
  out.needle.pre_puncture_n = state.force.puncture_n;
  out.needle.cutting_n = state.force.cutting_n;
  out.needle.friction_n = state.force.friction_n;
}

void PlaneModel2010::Forces(PlaneState& state, double speed_mm_per_s) const noexcept {
  forces::NeedleForce& out = state.force;
  double across_n = 0.0;
  double tip_n = 0.0;
  for (int q = 0; q < state.num_nodes; ++q) {
    const double along_n = state.contact.ForceN(2 * q);
    across_n += state.contact.ForceN(2 * q + 1);
    // What is more than friction can be is at the tip.
    const double shaft_n = state.pierced() ? -state.contact.LowN(2 * q) : 0.0;
    tip_n += std::max(0.0, along_n - shaft_n);
    out.friction_n += std::min(along_n, shaft_n);
  }
  if (!state.pierced()) {
    out.puncture_n = tip_n;
  } else {
    const double cutting_n = table_.tissue[state.cut_tissue].cutting_n;
    out.cutting_n = state.pressing ? std::min(tip_n, cutting_n) : tip_n;
    out.puncture_n = tip_n - out.cutting_n;
  }
  if (state.on_bone) {
    out.bone_penetration_mm = std::max(0.0, state.device_mm - state.bone_at_mm);
    out.bone_n = table_.settings.bone.ForceN(out.bone_penetration_mm, speed_mm_per_s);
  }
  const double limit_n = table_.settings.lateral_limit_n;
  across_n = std::clamp(across_n, -limit_n, limit_n);
  out.lateral_n = std::abs(across_n);
  out.depth_mm = state.needle_mm;
  const Eigen::Vector2d across(-state.along.y(), state.along.x());
  out.force_in_ct_n = -state.frame.DirectionInCt(out.AxialN() * state.along + across_n * across);
}

bool PlaneModel2010::HasLeft(const PlaneState& state) const noexcept {
  if (state.pierced()) {
    if (state.tip_rest_mm < -kSlackMm) return true;
  } else if (state.device_mm < -kTremorMm) {
    return true;
  }
  if (state.tissue_at_tip != 0) return false;
  return std::abs(state.aside_mm) > (state.pierced() ? kEscapeMm : kTremorMm);
}

void PlaneModel2010::Leave(PlaneState& state) const noexcept {
  state.contact.Clear();
  state.num_nodes = 0;
  state.phase = NeedlePhase::kFree;
  state.pressing = state.engaged = state.cutting = false;
  state.on_bone = false;
  state.device_mm = state.needle_mm = state.tip_rest_mm = state.channel_mm = 0.0;
}

double PlaneModel2010::FrictionNPerMm(const PlaneState& state,
                                      const PlaneNode& node) const noexcept {
  if (!table_.HasTime()) return node.friction_n_per_mm;
  return node.friction_n_per_mm *
         forces::FrictionShare(table_.tissue[node.tissue].time, state.pace_logs);
}

/// The needle's distance from the path's line at a depth.
double PlaneModel2010::AcrossMm(const PlaneState& state, double at_mm) const noexcept {
  return state.aside_mm + (at_mm - state.device_mm) * state.slope;
}

NeedleEvent PlaneModel2010::Substep(PlaneState& state, const Eigen::Vector2d& tip_mm,
                                    const Eigen::Vector2d& axis, double dt_s) const noexcept {
  const Eigen::Vector2d across(-state.along.y(), state.along.x());
  const Eigen::Vector2d off_mm = tip_mm - state.entry_mm;
  const double needle_before_mm = state.needle_mm;
  state.device_mm = off_mm.dot(state.along);
  state.aside_mm = off_mm.dot(across);
  state.slope = axis.dot(across) / std::max(kLeastPathCosine, axis.dot(state.along));
  NeedleEvent event = NeedleEvent::kNone;
  if (state.on_bone && state.pierced() && !state.engaged) {
    state.on_bone = false;
    event = NeedleEvent::kBoneRelease;
  }
  state.needle_mm = state.on_bone ? std::min(state.device_mm, state.bone_at_mm) : state.device_mm;
  const double travel_mm = state.needle_mm - needle_before_mm;
  if (table_.HasTime() && state.pierced()) {
    state.pace_logs =
        forces::StepPace(state.pace, table_.friction_time, {travel_mm, state.slid_mm, dt_s});
  }
  state.slid_mm = 0.0;
  event = FirstOf(event, Balance(state, travel_mm));
  if (!HasLeft(state)) return event;
  if (state.pierced()) event = FirstOf(event, NeedleEvent::kWithdrawal);
  Leave(state);
  return event;
}

}  // namespace acus::tissue
