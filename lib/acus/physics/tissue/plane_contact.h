// Stick and slip at the nodes of a needle by swaps of constraints on an explicit inverse: the
// numerics of the 2D model of 2010, independent of needles.
//
// Augmented-2010, section II.B and III; DiMaio and Salcudean. A degree of freedom that sticks has
// its displacement given, one that slips has its force given, at one of its bounds. Which is which
// follows from the bounds (a linear complementarity problem with a positive definite matrix), by
// principal pivots: each is one swap.
//
// Tissue that relaxes: u = C phi holds of the forces phi that would deform elastic tissue in the
// same way (correspondence principle), so bounds are carried over to phi and nothing else changes.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "acus/physics/mechanics/elements/relaxation.h"
#include "acus/physics/mechanics/sparse/swept_matrix.h"

namespace acus::tissue {

enum class PlaneUpdate {
  kRestricted,  ///< Only rows and columns of what touches the needle: O(m^2) per swap.
  kFull,        ///< All of the inverse, as in DiMaio's model: O(n^2) per swap.
};

enum class SlotStatus : std::uint8_t { kStick, kAtLow, kAtHigh };

/// A plain value: a copy continues with the same bits. Slots come in pairs, last-in-first-out: two
/// directions at one node. Only the constructors allocate. With kFull it refers to the compliance
/// that it was made of, which must outlive it.
class PlaneContact {
 public:
  PlaneContact() = default;
  /// @param compliance  of all degrees of freedom, mm/N, symmetric.
  /// @param capacity    slots, even.
  PlaneContact(const Eigen::MatrixXd& compliance, int capacity, PlaneUpdate update,
               const mechanics::Relaxation& relaxation = {});

  int size() const { return size_; }
  int capacity() const { return static_cast<int>(base_.rows()); }

  /// A node comes into contact: its directions (cosine, sine) and (-sine, cosine) in the plane. Its
  /// forces are 0 until demands are set. @pre size() + 2 <= capacity().
  /// @param dof  first of the two degrees of freedom of the node.
  void Append(int dof, double cosine, double sine) noexcept;
  /// The last node leaves. @pre size() > 0.
  void DropLast() noexcept;
  void Clear() noexcept;
  /// From now on the nodes are those of another compliance, which must outlive this. @pre size() is
  /// 0; not with kFull.
  void Refer(const Eigen::MatrixXd& compliance) noexcept { compliance_ = &compliance; }

  /// Time goes by until the end of the next Solve(), during which forces that deform the tissue
  /// change evenly: before what is demanded of it is set. Exact for that. Nothing for elastic
  /// tissue. @param duration_s  > 0.
  void Pass(double duration_s) noexcept;

  /// What a pair of slots remembers, to be carried to another.
  using Past = std::array<std::array<double, 2>, mechanics::Relaxation::kMostTerms>;
  Past PastOf(int pair) const noexcept;
  void SetPast(int pair, const Past& past_n) noexcept;

  /// What slot i shall do: keep to this displacement as long as that takes a force in [low, high].
  /// A slot with low >= high has the force low.
  void SetDemand(int i, double displacement_mm, double low_n, double high_n) noexcept {
    target_[i] = displacement_mm;
    low_[i] = low_n;
    high_[i] = high_n;
    elastic_low_[i] = ElasticOf(i, low_n);
    elastic_high_[i] = ElasticOf(i, high_n);
  }

  /// Finds who sticks, who slips, and the forces; starts from what the last solve ended with.
  /// @param force_error_n  above it the monitor starts again from the compliance.
  /// @return false if the pivots were used up: forces are within their bounds, but not in balance.
  bool Solve(double force_error_n) noexcept;

  double ForceN(int i) const {
    return relaxation_.num_terms == 0 ? force_[i] : alpha_ * force_[i] - held_[i];
  }
  /// The force that would deform elastic tissue as it is deformed now.
  double ElasticN(int i) const { return force_[i]; }
  double DisplacementMm(int i) const { return moved_[i]; }
  SlotStatus Status(int i) const { return status_[i]; }
  double LowN(int i) const { return low_[i]; }
  double HighN(int i) const { return high_[i]; }
  double TargetMm(int i) const { return target_[i]; }
  /// Compliance between two slots, mm/N.
  double Compliance(int i, int j) const { return base_(std::max(i, j), std::min(i, j)); }

  std::int64_t num_swaps() const { return num_swaps_; }
  std::int64_t num_rebuilds() const { return num_rebuilds_; }
  std::int64_t num_unresolved() const { return num_unresolved_; }
  int most_rounds() const { return most_rounds_; }

  /// For tests and benchmarks: one slot changes, and forces and displacements follow.
  void SwapForTest(int i) noexcept {
    Swap(i, status_[i] == SlotStatus::kStick ? SlotStatus::kAtLow : SlotStatus::kStick);
    Apply();
  }
  /// For tests of the monitor.
  void SpoilForTest(double factor) noexcept { spoil_ = factor; }

 private:
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  double ElasticOf(int i, double force_n) const {
    return relaxation_.num_terms == 0 ? force_n : (force_n + held_[i]) / alpha_;
  }
  void Forget(int i) noexcept;
  int RowOf(int i) const { return update_ == PlaneUpdate::kFull ? dof_[i / 2] + i % 2 : i; }
  void Swap(int i, SlotStatus to) noexcept;
  void Apply() noexcept;
  void Gather(const double* y, double* x) const noexcept;
  double ForceError() noexcept;
  void Rebuild() noexcept;
  void ResetFull() noexcept;
  bool IsWrong(int i, SlotStatus& to) const noexcept;
  bool Pivot() noexcept;

  const Eigen::MatrixXd* compliance_ = nullptr;
  PlaneUpdate update_ = PlaneUpdate::kRestricted;
  int size_ = 0;
  RowMajor base_;  ///< Compliance between slots, both triangles, not swept.
  mechanics::SweptMatrix swept_{0};
  std::vector<int> dof_;  ///< Of each pair.
  std::vector<double> cosine_, sine_;
  std::vector<SlotStatus> status_;
  Eigen::VectorXd target_, low_, high_, elastic_low_, elastic_high_, given_, found_, force_, moved_,
      residual_;
  // Relaxation. A term's force q lags behind share * phi; the tissue's force is phi - sum of q, in
  // the step alpha phi - held.
  mechanics::Relaxation relaxation_;
  double alpha_ = 1.0;
  std::array<double, mechanics::Relaxation::kMostTerms> gain_{};  ///< q by phi at the step's end.
  Eigen::VectorXd held_;                                          ///< Sum of the terms' lag_.
  RowMajor lag_;  ///< Part of q that the past has set, a row for each term.
  double spoil_ = 1.0;
  std::int64_t num_swaps_ = 0;
  std::int64_t num_rebuilds_ = 0;
  std::int64_t num_unresolved_ = 0;
  int most_rounds_ = 0;
};

}  // namespace acus::tissue
