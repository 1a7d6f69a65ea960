#include "acus/physics/needle/rod_sweeps.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <tuple>

namespace acus::needle {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// [a]x M, column by column.
Matrix3d CrossLeft(const Vector3d& a, const Matrix3d& m) noexcept {
  Matrix3d out;
  for (int j = 0; j < 3; ++j) out.col(j) = a.cross(Vector3d(m.col(j)));
  return out;
}

/// M [a]x, row by row.
Matrix3d CrossRight(const Matrix3d& m, const Vector3d& a) noexcept {
  Matrix3d out;
  out.col(0) = a.z() * m.col(1) - a.y() * m.col(2);
  out.col(1) = a.x() * m.col(2) - a.z() * m.col(0);
  out.col(2) = a.y() * m.col(0) - a.x() * m.col(1);
  return out;
}

/// The spring's force is along all but its free axis.
Vector3d AcrossAxis(const RodAction& action, const Vector3d& v) noexcept {
  return v - action.free_axis.dot(v) * action.free_axis;
}

/// Puts the action at its place on `point`; returns its energy.
double PlaceAction(const RodPoint& point, const Vector3d& w_per_mm, RodAction& action) noexcept {
  action.part = ArcTermsOf(action.part.length_mm, w_per_mm);
  action.chord_mm = ArcChord(action.part, point.tangent);
  const Vector3d place_mm = point.position_mm + action.chord_mm;
  if (action.stiffness_n_per_mm == 0.0) {
    action.gradient_n = -action.load_n;
    return -action.load_n.dot(place_mm);
  }
  const Vector3d off_mm = AcrossAxis(action, place_mm - action.anchor_mm);
  action.gradient_n = action.stiffness_n_per_mm * off_mm;
  return 0.5 * action.gradient_n.dot(off_mm);
}

double BendingEnergy(const RodModel& model, const Vector3d& curvature_per_mm) noexcept {
  const Vector3d off = curvature_per_mm - model.properties().rest_curvature_per_mm;
  return 0.5 * model.spacing_mm() *
         (model.properties().bending_n_mm2 * (off.x() * off.x() + off.y() * off.y()) +
          model.properties().twist_n_mm2 * off.z() * off.z());
}

/// The element from `point` to `next`, whose curvature is set; `action` is the first one in it.
double LayElement(const RodModel& model, int element, RodPoint& point, RodPoint& next,
                  std::vector<RodAction>& actions, int num_actions, int& action) noexcept {
  const Vector3d w_per_mm = point.orientation * point.curvature_per_mm;
  point.arc = ArcTermsOf(model.spacing_mm(), w_per_mm);
  point.chord_mm = ArcChord(point.arc, point.tangent);
  double energy = BendingEnergy(model, point.curvature_per_mm);
  for (; action < num_actions && actions[action].element == element; ++action) {
    energy += PlaceAction(point, w_per_mm, actions[action]);
  }
  next.position_mm = point.position_mm + point.chord_mm;
  next.orientation = TurnQuaternion(point.arc.turn_rad) * point.orientation;
  next.tangent = TangentOf(next.orientation);
  return energy;
}

void Begin(const RodStart& start, RodPoint& first) noexcept {
  first.position_mm = start.position_mm;
  first.orientation = start.orientation;
  first.tangent = TangentOf(start.orientation);
}

bool IsUsable(const RodContact& contact) noexcept {
  return std::isfinite(contact.arc_mm) && IsNear(contact.anchor_mm) &&
         contact.free_axis.allFinite() && contact.stiffness_n_per_mm >= 0.0 &&
         contact.stiffness_n_per_mm <= kStiffest;
}

/// A total order that depends on what an action is, not on where it stood in its list.
bool IsBefore(const RodAction& a, const RodAction& b) noexcept {
  const auto key = [](const RodAction& c) {
    return std::tie(c.arc_mm, c.stiffness_n_per_mm, c.anchor_mm.x(), c.anchor_mm.y(),
                    c.anchor_mm.z(), c.load_n.x(), c.load_n.y(), c.load_n.z(), c.free_axis.x(),
                    c.free_axis.y(), c.free_axis.z());
  };
  return key(a) < key(b);
}

/// Keeps the list in order: short, and nearly ordered when it comes.
void Insert(const RodModel& model, RodAction action, std::vector<RodAction>& list,
            int& count) noexcept {
  action.arc_mm = std::clamp(action.arc_mm, 0.0, model.properties().length_mm);
  action.element =
      std::min(static_cast<int>(action.arc_mm / model.spacing_mm()), model.num_elements() - 1);
  action.part.length_mm = action.arc_mm - action.element * model.spacing_mm();
  int at = count++;
  for (; at > 0 && IsBefore(action, list[at - 1]); --at) list[at] = list[at - 1];
  list[at] = action;
}

/// What the tip's side of an element adds up to: second derivatives and gradient of what remains of
/// the energy when its curvatures are at their best, by position x and rotation f of its start.
struct Value {
  Matrix3d xx = Matrix3d::Zero(), xf = Matrix3d::Zero(), ff = Matrix3d::Zero();
  Vector3d x = Vector3d::Zero(), f = Vector3d::Zero();
};

/// The same with the element's own curvature u still free.
struct Quadratic {
  Value start;
  Matrix3d xu, fu, uu;
  Vector3d u;
};

/// Half n d^T + d n^T, less n.d: second derivative of n . exp([f]x) d.
Matrix3d RotationCurvature(const Vector3d& n, const Vector3d& d) noexcept {
  Matrix3d m = (0.5 * n) * d.transpose() + (0.5 * d) * n.transpose();
  m.diagonal().array() -= n.dot(d);
  return m;
}

/// Second derivative of n . chord by curvature, at curvature 0; what is omitted is of the order of
/// the turn of one element, and slows Newton's last digits only.
Matrix3d ChordCurvature(double length_mm, const Vector3d& n, const Vector3d& t) noexcept {
  Matrix3d m = n * t.transpose() + t * n.transpose();
  m.diagonal().array() -= 2.0 * n.dot(t);
  return (length_mm * length_mm * length_mm / 6.0) * m;
}

void AddAction(const RodAction& action, const Vector3d& tangent, bool curved,
               Quadratic& q) noexcept {
  const Matrix3d slope = ChordSlope(action.part, tangent);
  const Vector3d& d = action.chord_mm;
  if (action.stiffness_n_per_mm > 0.0) {
    // [I, -[d]x, slope]: rows of the place's movement, without those along the free axis.
    Matrix3d k = -(action.stiffness_n_per_mm * action.free_axis) * action.free_axis.transpose();
    k.diagonal().array() += action.stiffness_n_per_mm;
    const Matrix3d by_rotation = -CrossRight(k, d);
    const Matrix3d by_curvature = k * slope;
    q.start.xx += k;
    q.start.xf += by_rotation;
    q.start.ff += CrossLeft(d, by_rotation);
    q.xu += by_curvature;
    q.fu += CrossLeft(d, by_curvature);
    q.uu += slope.transpose() * by_curvature;
  }
  if (curved) {
    const Vector3d& g = action.gradient_n;
    q.start.ff += RotationCurvature(g, d);
    q.fu -= CrossLeft(g, slope);
    q.uu += ChordCurvature(action.part.length_mm, g, tangent);
  }
}

Quadratic ElementQuadratic(const RodModel& model, const RodPoint& point, const RodSweep& sweep,
                           const Value& tip_side, bool curved) noexcept {
  const Vector3d& d = point.chord_mm;
  const Matrix3d slope = ChordSlope(point.arc, point.tangent);
  const Matrix3d turn = TurnSlope(point.arc);
  const Matrix3d x_part = tip_side.xx * slope + tip_side.xf * turn;
  const Matrix3d f_part = tip_side.xf.transpose() * slope + tip_side.ff * turn;
  Quadratic q;
  q.start.xx = tip_side.xx;
  q.start.xf = tip_side.xf - CrossRight(tip_side.xx, d);
  q.start.ff = tip_side.ff + CrossLeft(d, q.start.xf) - CrossRight(tip_side.xf.transpose(), d);
  q.start.x = tip_side.x;
  q.start.f = tip_side.f + d.cross(tip_side.x);
  q.xu = x_part;
  q.fu = f_part + CrossLeft(d, x_part);
  q.uu = slope.transpose() * x_part + turn.transpose() * f_part;
  q.u = sweep.gradient + slope.transpose() * tip_side.x + turn.transpose() * tip_side.f;
  const double bending = model.spacing_mm() * model.properties().bending_n_mm2;
  const double twist = model.spacing_mm() * model.properties().twist_n_mm2;
  q.uu.diagonal().array() += bending;
  q.uu += ((twist - bending) * point.tangent) * point.tangent.transpose();
  if (curved) {
    q.start.ff += RotationCurvature(sweep.force_n, d);
    q.fu -= CrossLeft(sweep.force_n, slope) + CrossLeft(0.5 * sweep.moment_n_mm, turn);
    q.uu += ChordCurvature(model.spacing_mm(), sweep.force_n, point.tangent);
  }
  return q;
}

/// Inverse of a symmetric positive definite matrix. False if it is not that, by a margin.
bool InvertPositive(const Matrix3d& a, double least_pivot, Matrix3d& inverse) noexcept {
  const double d0 = a(0, 0);
  if (!(d0 > least_pivot)) return false;
  const double l10 = a(1, 0) / d0;
  const double l20 = a(2, 0) / d0;
  const double d1 = a(1, 1) - l10 * a(1, 0);
  if (!(d1 > least_pivot)) return false;
  const double b21 = a(2, 1) - l20 * a(1, 0);
  const double l21 = b21 / d1;
  const double d2 = a(2, 2) - l20 * a(2, 0) - l21 * b21;
  if (!(d2 > least_pivot)) return false;
  const double i2 = 1.0 / d2;
  const double i1 = 1.0 / d1;
  const double m20 = l10 * l21 - l20;  // Of the inverse of the unit lower factor.
  inverse(0, 0) = 1.0 / d0 + l10 * l10 * i1 + m20 * m20 * i2;
  inverse(1, 0) = inverse(0, 1) = -l10 * i1 - m20 * l21 * i2;
  inverse(2, 0) = inverse(0, 2) = m20 * i2;
  inverse(1, 1) = i1 + l21 * l21 * i2;
  inverse(2, 1) = inverse(1, 2) = -l21 * i2;
  inverse(2, 2) = i2;
  return true;
}

/// The inverse with every eigenvalue made positive: a direction in which the energy falls where the
/// element would buckle.
Matrix3d InvertRepaired(const Matrix3d& a, double least) noexcept {
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(0.5 * (a + a.transpose()));
  const Vector3d inverse = eigen.eigenvalues().cwiseAbs().cwiseMax(least).cwiseInverse();
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

bool TakeActions(const RodModel& model, const RodInput& input, RodState& state) noexcept {
  if (input.contacts.size() + input.loads.size() > static_cast<std::size_t>(model.max_actions())) {
    return false;
  }
  for (const RodContact& contact : input.contacts) {
    if (!IsUsable(contact)) return false;
  }
  for (const RodLoad& load : input.loads) {
    if (!std::isfinite(load.arc_mm) || !load.force_n.allFinite() ||
        load.force_n.cwiseAbs().maxCoeff() > kLargestN) {
      return false;
    }
  }
  int count = 0;
  for (const RodContact& contact : input.contacts) {
    if (contact.stiffness_n_per_mm == 0.0) continue;
    RodAction action;
    action.arc_mm = contact.arc_mm;
    action.stiffness_n_per_mm = contact.stiffness_n_per_mm;
    action.anchor_mm = contact.anchor_mm;
    if (!contact.free_axis.isZero(0.0)) action.free_axis = contact.free_axis.stableNormalized();
    Insert(model, action, state.action, count);
  }
  for (const RodLoad& load : input.loads) {
    RodAction action;
    action.arc_mm = load.arc_mm;
    action.load_n = load.force_n;
    Insert(model, action, state.action, count);
  }
  state.num_actions = count;
  std::copy_n(state.action.begin(), count, state.trial_action.begin());
  return true;
}

double LayOut(const RodModel& model, const RodStart& start, const std::vector<RodPoint>& from,
              RodState& state) noexcept {
  std::vector<RodPoint>& to = state.trial;
  Begin(start, to[0]);
  double energy = 0.0;
  int action = 0;
  for (int i = 0; i < model.num_elements(); ++i) {
    to[i].curvature_per_mm = from[i].curvature_per_mm;
    energy += LayElement(model, i, to[i], to[i + 1], state.trial_action, state.num_actions, action);
  }
  return energy;
}

double LayOutStep(const RodModel& model, const RodStart& start, double fraction,
                  RodState& state) noexcept {
  std::vector<RodPoint>& to = state.trial;
  Begin(start, to[0]);
  double energy = 0.0;
  int action = 0;
  for (int i = 0; i < model.num_elements(); ++i) {
    const RodPoint& from = state.point[i];
    const RodSweep& sweep = state.sweep[i];
    const Eigen::Quaterniond turned = to[i].orientation * from.orientation.conjugate();
    const Vector3d rotation_rad = std::copysign(2.0, turned.w()) * turned.vec();
    const Vector3d step = fraction * sweep.step_per_mm +
                          sweep.by_position * (to[i].position_mm - from.position_mm) +
                          sweep.by_rotation * rotation_rad;
    to[i].curvature_per_mm = from.curvature_per_mm + from.orientation.conjugate() * step;
    energy += LayElement(model, i, to[i], to[i + 1], state.trial_action, state.num_actions, action);
  }
  return energy;
}

double Place(const RodModel& model, RodState& state) noexcept {
  double energy = 0.0;
  for (int i = 0; i < model.num_elements(); ++i) {
    energy += BendingEnergy(model, state.point[i].curvature_per_mm);
  }
  const double per_mm = 1.0 / model.spacing_mm();
  for (int a = 0; a < state.num_actions; ++a) {
    const RodPoint& point = state.point[state.action[a].element];
    energy += PlaceAction(point, per_mm * point.arc.turn_rad, state.action[a]);
  }
  return energy;
}

double Balance(const RodModel& model, RodState& state) noexcept {
  Vector3d n = Vector3d::Zero();
  Vector3d m = Vector3d::Zero();
  const RodProperties& rod = model.properties();
  double worst2 = 0.0;
  int action = state.num_actions - 1;
  for (int i = model.num_elements() - 1; i >= 0; --i) {
    const RodPoint& point = state.point[i];
    RodSweep& sweep = state.sweep[i];
    sweep.force_n = n;
    sweep.moment_n_mm = m;
    Vector3d strain = point.curvature_per_mm - rod.rest_curvature_per_mm;
    strain.head<2>() *= rod.bending_n_mm2;
    strain.z() *= rod.twist_n_mm2;
    sweep.gradient = model.spacing_mm() * (point.orientation * strain) +
                     ChordAdjoint(point.arc, point.tangent, n) + TurnAdjoint(point.arc, m);
    m += point.chord_mm.cross(n);
    for (; action >= 0 && state.action[action].element == i; --action) {
      const RodAction& here = state.action[action];
      sweep.gradient += ChordAdjoint(here.part, point.tangent, here.gradient_n);
      n += here.gradient_n;
      m += here.chord_mm.cross(here.gradient_n);
    }
    worst2 = std::max(worst2, sweep.gradient.squaredNorm());
  }
  return std::sqrt(worst2) / model.spacing_mm();
}

BaseGradient GradientAtBase(const RodState& state) noexcept {
  const RodPoint& point = state.point[0];
  BaseGradient base{state.sweep[0].force_n, state.sweep[0].moment_n_mm};
  base.moment_n_mm += point.chord_mm.cross(base.force_n);
  for (int a = 0; a < state.num_actions && state.action[a].element == 0; ++a) {
    base.force_n += state.action[a].gradient_n;
    base.moment_n_mm += state.action[a].chord_mm.cross(state.action[a].gradient_n);
  }
  return base;
}

BaseModel TipToBase(const RodModel& model, bool curved, RodState& state) noexcept {
  const double stiff = model.spacing_mm() *
                       std::min(model.properties().bending_n_mm2, model.properties().twist_n_mm2);
  BaseModel base;
  Value value;
  int action = state.num_actions - 1;
  for (int i = model.num_elements() - 1; i >= 0; --i) {
    const RodPoint& point = state.point[i];
    RodSweep& sweep = state.sweep[i];
    Quadratic q = ElementQuadratic(model, point, sweep, value, curved);
    for (; action >= 0 && state.action[action].element == i; --action) {
      AddAction(state.action[action], point.tangent, curved, q);
    }
    Matrix3d inverse;
    if (!InvertPositive(q.uu, 1e-6 * stiff, inverse)) {
      inverse = InvertRepaired(q.uu, 0.1 * stiff);
      base.repaired = true;
    }
    sweep.by_position = -inverse * q.xu.transpose();
    sweep.by_rotation = -inverse * q.fu.transpose();
    sweep.step_per_mm = -inverse * q.u;
    value.xx = q.start.xx + q.xu * sweep.by_position;
    value.xf = q.start.xf + q.xu * sweep.by_rotation;
    value.ff = q.start.ff + q.fu * sweep.by_rotation;
    value.x = q.start.x + q.xu * sweep.step_per_mm;
    value.f = q.start.f + q.fu * sweep.step_per_mm;
  }
  base.hessian << value.xx, value.xf, value.xf.transpose(), value.ff;
  base.gradient << value.x, value.f;
  return base;
}

}  // namespace acus::needle
