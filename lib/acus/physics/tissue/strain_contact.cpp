#include "acus/physics/tissue/strain_contact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::tissue {
namespace {

constexpr double kLeastMixing = 1e-3;
constexpr double kLongestStepMm = 1.0;  // Of any node, in one iteration.
constexpr double kFreshMixing = 0.1;
constexpr double kLostMm = 1.0;   // Displacements that are out by more may be better found again.
constexpr double kGrowth = 1.25;  // Of the mixing after a good iteration.
constexpr double kRidge = 1e-10;  // Of the secants' least squares.

double Product(const std::vector<double>& a, const std::vector<double>& b) noexcept {
  return Eigen::Map<const Eigen::VectorXd>(a.data(), static_cast<Eigen::Index>(a.size()))
      .dot(Eigen::Map<const Eigen::VectorXd>(b.data(), static_cast<Eigen::Index>(b.size())));
}

void AddTimes(double factor, const std::vector<double>& x, std::vector<double>& y) noexcept {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += factor * x[i];
}

void Subtract(const std::vector<double>& a, const std::vector<double>& b,
              std::vector<double>& out) noexcept {
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] - b[i];
}

}  // namespace

StrainContact::StrainContact(const mesh::TetraMesh& mesh, const mechanics::ElasticityTable& table,
                             const mechanics::Compliance& compliance,
                             const StrainSettings& settings)
    : settings_(settings),
      region_(std::make_shared<const mechanics::StrainRegion>(
          mesh, table, settings.element, compliance, settings.corridor, settings.max_nodes)),
      size_(3 * region_->num_nodes()),
      stride_((size_ + 15) / 16 * 16),
      num_dofs_(3 * compliance.num_nodes()) {
  ACUS_REQUIRE(settings.max_nodes >= 4 && settings.max_nodes <= StrainSettings::kMostNodes,
               "the region of finite strain may have 4 to ", StrainSettings::kMostNodes,
               " nodes, got ", settings.max_nodes);
  ACUS_REQUIRE(settings.iterations >= 1 && settings.iterations <= 50,
               "iterations per step must be 1 to 50, got ", settings.iterations);
  ACUS_REQUIRE(settings.tolerance_mm > 0.0 && std::isfinite(settings.tolerance_mm),
               "the tolerance must be more than 0 mm, got ", settings.tolerance_mm);
  ACUS_REQUIRE(region_->num_nodes() > 0, "no tissue within ", settings.corridor.radius_mm,
               " mm of the corridor is in the compliance as a whole and has at most ",
               settings.max_nodes, " nodes, so that none can stiffen; condense a wider corridor ",
               "with acus-mesh, allow more strain_nodes, or choose the law \"linear\"");
  std::vector<float> columns(static_cast<std::size_t>(stride_) * num_dofs_, 0.0f);
  for (int dof = 0; dof < num_dofs_; ++dof) {
    float* row = columns.data() + static_cast<std::ptrdiff_t>(dof) * stride_;
    for (int i = 0; i < size_; ++i) {
      row[i] = static_cast<float>(compliance.At(3 * region_->rows()[i / 3] + i % 3, dof));
    }
  }
  std::vector<Eigen::Vector3d> node_mm;
  for (const int row : region_->rows()) {
    node_mm.push_back(mesh.nodes_mm.col(compliance.nodes()[static_cast<std::size_t>(row)]));
  }
  node_mm_ = std::make_shared<const std::vector<Eigen::Vector3d>>(std::move(node_mm));
  columns_ = std::make_shared<const std::vector<float>>(std::move(columns));
}

StrainState StrainContact::NewState() const {
  StrainState state;
  const auto make = [&](StrainState::Iterate& it) {
    for (auto* v : {&it.force_n, &it.moved_mm, &it.residual_n, &it.residual_mm}) {
      v->assign(static_cast<std::size_t>(stride_), 0.0);
    }
  };
  make(state.best);
  make(state.next);
  state.secants.resize(StrainState::kMostSecants);
  for (StrainState::Iterate& secant : state.secants) make(secant);
  state.u_mm = Eigen::Matrix3Xd::Zero(3, region_->num_nodes() + 1);
  state.target_n = Eigen::Matrix3Xd::Zero(3, region_->num_nodes() + 1);
  state.scratch = region_->NewScratch();
  state.lateral_mm.resize(1000, 0.0);
  state.demand_mm.resize(1000, 0.0);
  state.tool_n.resize(static_cast<std::size_t>(num_dofs_), 0.0);
  state.loaded.reserve(static_cast<std::size_t>(num_dofs_ / 3));
  return state;
}

/// moved += what a force on a node of the compliance does to the region. Three products are summed
/// in float, which is no worse than the storage, and all of them in double.
void StrainContact::AddMoved(int row, const double* force_n, double* moved_mm) const noexcept {
  const float* a = columns_->data() + 3 * static_cast<std::ptrdiff_t>(row) * stride_;
  const float* b = a + stride_;
  const float* c = b + stride_;
  const float x = static_cast<float>(force_n[0]);
  const float y = static_cast<float>(force_n[1]);
  const float z = static_cast<float>(force_n[2]);
  for (int j = 0; j < stride_; ++j) {
    moved_mm[j] += static_cast<double>(x * a[j] + y * b[j] + z * c[j]);
  }
}

Eigen::Vector3d StrainContact::NodeMovedMm(const StrainState::Iterate& at, int row) const noexcept {
  const int index = region_->IndexOf(row);
  if (index >= 0) return Eigen::Map<const Eigen::Vector3d>(at.moved_mm.data() + 3 * index);
  Eigen::Vector3d moved;
  for (int axis = 0; axis < 3; ++axis) {
    const float* values =
        columns_->data() + (3 * static_cast<std::ptrdiff_t>(row) + axis) * stride_;
    moved[axis] = Eigen::Map<const Eigen::VectorXf>(values, stride_)
                      .cast<double>()
                      .dot(Eigen::Map<const Eigen::VectorXd>(at.force_n.data(), stride_));
  }
  return moved;
}

Eigen::Vector3d StrainContact::PlaceMovedMm(const StrainState::Iterate& at,
                                            const ContactPlace& place) const noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int r = 0; r < place.num_rows; ++r) sum += place.weight[r] * NodeMovedMm(at, place.row[r]);
  return sum;
}

Eigen::Vector3d StrainContact::MovedMm(const StrainState& state,
                                       const ContactPlace& place) const noexcept {
  return PlaceMovedMm(state.best, place);
}

void StrainContact::Forget(StrainState& state) const noexcept {
  std::ranges::fill(state.best.force_n, 0.0);
  std::ranges::fill(state.best.moved_mm, 0.0);
  state.num_secants = state.oldest = 0;
}

/// The contact for demands less what the region's forces do.
void StrainContact::SolveTools(const ContactSystem& system, ContactState& contact,
                               StrainState& state, const StrainState::Iterate& at) const noexcept {
  const int points = contact.num_points();
  const int slots = contact.num_slots();
  for (int k = 0; k < 2 * points; ++k) state.lateral_mm[k] = contact.LateralMm(k);
  for (int k = 0; k < slots + points; ++k) state.demand_mm[k] = contact.DemandMm(k);
  const auto ask = [&](int column, double demand_mm) { contact.SetDemand(column, demand_mm); };
  for (int s = 0; s < slots; ++s) {
    if (!contact.slot_in_use(s)) continue;
    const double moved = contact.slot_direction(s).dot(PlaceMovedMm(at, contact.slot_place(s)));
    ask(s, state.demand_mm[s] - moved);
  }
  for (int p = 0; p < points; ++p) {
    const Eigen::Vector3d moved =
        contact.frame().transpose() * PlaceMovedMm(at, contact.point_place(p));
    contact.SetLateral(p, state.lateral_mm[2 * p] - moved[0],
                       state.lateral_mm[2 * p + 1] - moved[1]);
    ask(slots + p, state.demand_mm[slots + p] - moved[2]);
  }
  system.Solve(contact);
  for (int p = 0; p < points; ++p) {
    contact.SetLateral(p, state.lateral_mm[2 * p], state.lateral_mm[2 * p + 1]);
  }
  for (int k = 0; k < slots + points; ++k) ask(k, state.demand_mm[k]);
}

/// Residual at `at`, whose force_n and moved_mm are set.
void StrainContact::Evaluate(const ContactSystem& system, ContactState& contact, StrainState& state,
                             StrainState::Iterate& at) const noexcept {
  SolveTools(system, contact, state, at);
  state.loaded.clear();
  const auto load = [&](const ContactPlace& place, const Eigen::Vector3d& force_n) {
    if (force_n.isZero(0.0)) return;
    for (int r = 0; r < place.num_rows; ++r) {
      const int row = place.row[r];
      double* sum = state.tool_n.data() + 3 * row;
      if (sum[0] == 0.0 && sum[1] == 0.0 && sum[2] == 0.0) state.loaded.push_back(row);
      for (int axis = 0; axis < 3; ++axis) sum[axis] += place.weight[r] * force_n[axis];
    }
  };
  for (int s = 0; s < contact.num_slots(); ++s) {
    if (!contact.slot_in_use(s)) continue;
    load(contact.slot_place(s), contact.ElasticSlotN(s) * contact.slot_direction(s));
  }
  for (int p = 0; p < contact.num_points(); ++p) {
    load(contact.point_place(p), contact.frame() * contact.ElasticPointN(p));
  }
  double* u = at.residual_mm.data();  // Free until the residual is there.
  std::copy(at.moved_mm.begin(), at.moved_mm.end(), u);
  for (const int row : state.loaded) {
    AddMoved(row, state.tool_n.data() + 3 * row, u);
  }
  for (const int row : state.loaded) {
    for (int axis = 0; axis < 3; ++axis) state.tool_n[3 * row + axis] = 0.0;
  }
  std::copy_n(u, size_, state.u_mm.data());
  region_->MissingForces(state.u_mm, state.scratch, state.target_n);
  for (int i = 0; i < size_; ++i) at.residual_n[i] = state.target_n.data()[i] - at.force_n[i];
  std::ranges::fill(at.residual_mm, 0.0);
  for (int n = 0; n < region_->num_nodes(); ++n) {
    AddMoved(region_->rows()[n], at.residual_n.data() + 3 * n, at.residual_mm.data());
  }
  at.error2 = Product(at.residual_n, at.residual_mm);
}

/// Keeps the difference between the two iterates, which have equal demands.
void StrainContact::Remember(StrainState& state) const noexcept {
  int slot = state.oldest;
  if (state.num_secants < StrainState::kMostSecants) {
    slot = state.num_secants++;
  } else {
    state.oldest = (state.oldest + 1) % StrainState::kMostSecants;
  }
  StrainState::Iterate& secant = state.secants[static_cast<std::size_t>(slot)];
  Subtract(state.next.force_n, state.best.force_n, secant.force_n);
  Subtract(state.next.moved_mm, state.best.moved_mm, secant.moved_mm);
  Subtract(state.next.residual_n, state.best.residual_n, secant.residual_n);
  Subtract(state.next.residual_mm, state.best.residual_mm, secant.residual_mm);
  secant.error2 = Product(secant.residual_n, secant.residual_mm);
}

/// Sets `next` from `best`: the multi-secant step.
void StrainContact::Advance(StrainState& state) const noexcept {
  constexpr int kMost = StrainState::kMostSecants;
  const int count = state.num_secants;
  Eigen::Matrix<double, kMost, kMost> normal = Eigen::Matrix<double, kMost, kMost>::Identity();
  Eigen::Matrix<double, kMost, 1> share = Eigen::Matrix<double, kMost, 1>::Zero();
  Eigen::Matrix<double, kMost, 1> scale = Eigen::Matrix<double, kMost, 1>::Ones();
  for (int i = 0; i < count; ++i) {
    scale[i] = 1.0 / std::sqrt(std::max(state.secants[i].error2, 1e-300));
  }
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j <= i; ++j) {
      normal(i, j) = normal(j, i) =
          scale[i] * scale[j] * Product(state.secants[i].residual_n, state.secants[j].residual_mm);
    }
    normal(i, i) = 1.0 + kRidge;
    share[i] = scale[i] * Product(state.secants[i].residual_n, state.best.residual_mm);
  }
  if (count > 0) {
    share = Eigen::LDLT<Eigen::Matrix<double, kMost, kMost>>(normal).solve(share).eval();
    share.array() *= scale.array();
    if (!share.allFinite()) share.setZero();
  }
  StrainState::Iterate& next = state.next;
  std::ranges::copy(state.best.force_n, next.force_n.begin());
  std::ranges::copy(state.best.moved_mm, next.moved_mm.begin());
  AddTimes(state.mixing, state.best.residual_n, next.force_n);
  AddTimes(state.mixing, state.best.residual_mm, next.moved_mm);
  for (int i = 0; i < count; ++i) {
    const StrainState::Iterate& s = state.secants[static_cast<std::size_t>(i)];
    AddTimes(-share[i], s.force_n, next.force_n);
    AddTimes(-share[i], s.moved_mm, next.moved_mm);
    AddTimes(-share[i] * state.mixing, s.residual_n, next.force_n);
    AddTimes(-share[i] * state.mixing, s.residual_mm, next.moved_mm);
  }
}

/// Shortens the way from `best` to `next` where it is too long to be trusted.
void StrainContact::Shorten(StrainState& state) const noexcept {
  double longest_mm = 0.0;
  for (int i = 0; i < size_; ++i) {
    longest_mm = std::max(longest_mm, std::abs(state.next.moved_mm[i] - state.best.moved_mm[i]));
  }
  if (!(longest_mm > kLongestStepMm)) return;
  const double share = kLongestStepMm / longest_mm;
  for (int i = 0; i < size_; ++i) {
    const auto between = [&](double from, double to) { return from + share * (to - from); };
    state.next.force_n[i] = between(state.best.force_n[i], state.next.force_n[i]);
    state.next.moved_mm[i] = between(state.best.moved_mm[i], state.next.moved_mm[i]);
  }
}

/// Takes `next` if it is the better one.
bool StrainContact::Judge(StrainState& state) const noexcept {
  const bool better = state.next.error2 < state.best.error2 || !std::isfinite(state.best.error2);
  if (better) std::swap(state.best, state.next);
  return better;
}

/// After a jump the last forces can be worse than none at all.
void StrainContact::TryAnew(const ContactSystem& system, ContactState& contact,
                            StrainState& state) const noexcept {
  std::ranges::fill(state.next.force_n, 0.0);
  std::ranges::fill(state.next.moved_mm, 0.0);
  Evaluate(system, contact, state, state.next);
  if (!Judge(state)) return;
  state.num_secants = state.oldest = 0;
  state.mixing = kFreshMixing;
  ++state.num_fresh;
}

void StrainContact::Solve(const ContactSystem& system, ContactState& contact,
                          StrainState& state) const noexcept {
  const auto error_mm = [&](const StrainState::Iterate& at) {
    double largest = 0.0;
    for (const double value : at.residual_mm) largest = std::max(largest, std::abs(value));
    return std::isfinite(at.error2) ? largest : std::numeric_limits<double>::max();
  };
  Evaluate(system, contact, state, state.best);
  bool at_best = true;
  int n = 0;
  if (error_mm(state.best) > kLostMm) {
    TryAnew(system, contact, state);
    at_best = false;
    ++n;
  }
  for (; n < settings_.iterations && error_mm(state.best) > settings_.tolerance_mm; ++n) {
    Advance(state);
    Shorten(state);
    Evaluate(system, contact, state, state.next);
    if (std::isfinite(state.next.error2)) Remember(state);
    at_best = Judge(state);
    state.mixing = at_best ? std::min(1.0, kGrowth * state.mixing)
                           : std::max(kLeastMixing, 0.5 * state.mixing);
  }
  if (!at_best) SolveTools(system, contact, state, state.best);
  state.error_mm = error_mm(state.best);
  if (state.error_mm > settings_.tolerance_mm) ++state.num_unsettled;
}

}  // namespace acus::tissue
