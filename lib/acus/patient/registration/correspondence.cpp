#include "acus/patient/registration/correspondence.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::registration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kTellingFactor = 0.2;
constexpr double kAlikeFactor = 1.5;
constexpr double kLeastFreMm =
    0.05;  ///< No touch is more accurate: keeps exact data from looking clear.

MatrixXd Distances(const transforms::Markers& markers_mm) {
  MatrixXd distances(markers_mm.cols(), markers_mm.cols());
  for (Index i = 0; i < markers_mm.cols(); ++i) {
    distances.col(i) = (markers_mm.colwise() - markers_mm.col(i)).colwise().norm().transpose();
  }
  return distances;
}

/// Assigns markers one after the other as long as all distances agree.
class Search {
 public:
  Search(const transforms::Markers& reference_mm, const transforms::Markers& ct_mm, double limit_mm)
      : reference_mm_(reference_mm),
        ct_mm_(ct_mm),
        limit_mm_(limit_mm),
        tolerance_mm_(2.0 * std::sqrt(static_cast<double>(ct_mm.cols())) * limit_mm),
        reference_distances_(Distances(reference_mm)),
        ct_distances_(Distances(ct_mm)) {}

  std::vector<Order> Run() {
    Extend();
    std::ranges::stable_sort(found_, {}, &Order::fre_rms_mm);
    return std::move(found_);
  }

 private:
  void Extend() {
    const auto next = static_cast<Index>(ct_of_.size());
    if (next == ct_mm_.cols()) {
      const double fre_mm = FitMarkers(reference_mm_, ct_mm_(Eigen::all, ct_of_)).fre_rms_mm;
      if (fre_mm <= limit_mm_) found_.push_back({.ct_of = ct_of_, .fre_rms_mm = fre_mm});
      return;
    }
    for (Index candidate = 0; candidate < ct_mm_.cols(); ++candidate) {
      if (std::ranges::find(ct_of_, candidate) != ct_of_.end() || !Agrees(next, candidate))
        continue;
      ct_of_.push_back(candidate);
      Extend();
      ct_of_.pop_back();
    }
  }

  bool Agrees(Index next, Index candidate) const {
    for (Index i = 0; i < next; ++i) {
      const double difference_mm = reference_distances_(i, next) -
                                   ct_distances_(ct_of_[static_cast<std::size_t>(i)], candidate);
      if (std::abs(difference_mm) > tolerance_mm_) return false;
    }
    return true;
  }

  const transforms::Markers& reference_mm_;
  const transforms::Markers& ct_mm_;
  double limit_mm_;
  double tolerance_mm_;
  MatrixXd reference_distances_;
  MatrixXd ct_distances_;
  std::vector<Index> ct_of_;
  std::vector<Order> found_;
};

/// Orders of many markers, from the poses that three of them allow.
class SearchByPose {
 public:
  SearchByPose(const transforms::Markers& reference_mm, const transforms::Markers& ct_mm,
               double limit_mm)
      : reference_mm_(reference_mm),
        ct_mm_(ct_mm),
        limit_mm_(limit_mm),
        tolerance_mm_(kNearestFactor * limit_mm),
        reference_distances_(Distances(reference_mm)),
        ct_distances_(Distances(ct_mm)) {}

  std::vector<Order> Run() {
    const std::array<Index, 3> three = FarApart();
    const Index n = ct_mm_.cols();
    for (Index a = 0; a < n; ++a) {
      for (Index b = 0; b < n; ++b) {
        if (b == a || !Agree(three[0], three[1], a, b)) continue;
        for (Index c = 0; c < n; ++c) {
          if (c == a || c == b) continue;
          if (Agree(three[0], three[2], a, c) && Agree(three[1], three[2], b, c)) {
            Try(three, {a, b, c});
          }
        }
      }
    }
    std::ranges::stable_sort(found_, {}, &Order::fre_rms_mm);
    return std::move(found_);
  }

 private:
  static constexpr double kNearestFactor = 6.0;
  static constexpr int kMostFits = 10;

  bool Agree(Index i, Index j, Index a, Index b) const {
    return std::abs(reference_distances_(i, j) - ct_distances_(a, b)) <= tolerance_mm_;
  }

  /// The two that are farthest apart, and the one farthest from their line.
  std::array<Index, 3> FarApart() const {
    Index i = 0, j = 0, k = 0;
    reference_distances_.maxCoeff(&i, &j);
    const Eigen::Vector3d along = (reference_mm_.col(j) - reference_mm_.col(i)).normalized();
    double farthest = -1.0;
    for (Index m = 0; m < reference_mm_.cols(); ++m) {
      const Eigen::Vector3d off = reference_mm_.col(m) - reference_mm_.col(i);
      const double across = (off - off.dot(along) * along).norm();
      if (m == i || m == j || across <= farthest) continue;
      farthest = across;
      k = m;
    }
    return {i, j, k};
  }

  /// The nearest CT marker of each; empty if two have the same.
  std::vector<Index> NearestTo(const Eigen::Isometry3d& ct_from_reference) const {
    const transforms::Markers placed = ct_from_reference * reference_mm_;
    std::vector<Index> nearest;
    for (Index i = 0; i < placed.cols(); ++i) {
      Index best = 0;
      (ct_mm_.colwise() - placed.col(i)).colwise().squaredNorm().minCoeff(&best);
      if (std::ranges::find(nearest, best) != nearest.end()) return {};
      nearest.push_back(best);
    }
    return nearest;
  }

  void Try(const std::array<Index, 3>& three, const std::array<Index, 3>& ct) {
    MarkerFit fit = FitMarkers(reference_mm_(Eigen::all, three), ct_mm_(Eigen::all, ct));
    std::vector<Index> order;
    for (int round = 0; round < kMostFits; ++round) {
      std::vector<Index> nearest = NearestTo(fit.ct_from_reference);
      if (nearest.empty()) return;
      if (nearest == order) break;
      order = std::move(nearest);
      fit = FitMarkers(reference_mm_, ct_mm_(Eigen::all, order));
    }
    const auto is_same = [&](const Order& other) { return other.ct_of == order; };
    if (fit.fre_rms_mm > limit_mm_ || std::ranges::any_of(found_, is_same)) return;
    found_.push_back({.ct_of = order, .fre_rms_mm = fit.fre_rms_mm});
  }

  const transforms::Markers& reference_mm_;
  const transforms::Markers& ct_mm_;
  double limit_mm_;
  double tolerance_mm_;
  MatrixXd reference_distances_;
  MatrixXd ct_distances_;
  std::vector<Order> found_;
};

bool IsPresentOrder(const Order& order) {
  for (std::size_t i = 0; i < order.ct_of.size(); ++i) {
    if (order.ct_of[i] != static_cast<Index>(i)) return false;
  }
  return true;
}

}  // namespace

std::vector<Order> FindOrders(const transforms::Markers& reference_mm,
                              const transforms::Markers& ct_mm, double limit_mm, std::size_t most) {
  ACUS_ASSERT(ct_mm.cols() <= kMostToOrder && reference_mm.cols() == ct_mm.cols());
  std::vector<Order> orders = ct_mm.cols() <= kMostToOrderInFull
                                  ? Search(reference_mm, ct_mm, limit_mm).Run()
                                  : SearchByPose(reference_mm, ct_mm, limit_mm).Run();
  if (orders.size() > most) orders.resize(most);
  return orders;
}

std::optional<Order> BetterOrder(const transforms::Markers& reference_mm,
                                 const transforms::Markers& ct_mm) {
  const double fre_mm = FitMarkers(reference_mm, ct_mm).fre_rms_mm;
  if (ct_mm.cols() > kMostToOrder || fre_mm < kLeastFreMm) return std::nullopt;
  // Three markers fit many orders to some degree; their FRE must be small against their distances.
  const double limit_mm = std::min(kTellingFactor * fre_mm, 0.05 * SpreadMm(ct_mm).norm());
  const auto orders = FindOrders(reference_mm, ct_mm, limit_mm, 1);
  if (orders.empty() || IsPresentOrder(orders.front())) return std::nullopt;
  return orders.front();
}

std::vector<Order> EquallyGoodOrders(const transforms::Markers& reference_mm,
                                     const transforms::Markers& ct_mm) {
  const double fre_mm = std::max(kLeastFreMm, FitMarkers(reference_mm, ct_mm).fre_rms_mm);
  if (ct_mm.cols() > kMostToOrder || fre_mm > 0.1 * SpreadMm(ct_mm).norm()) return {};
  std::vector<Order> orders = FindOrders(reference_mm, ct_mm, kAlikeFactor * fre_mm);
  std::erase_if(orders, IsPresentOrder);
  return orders;
}

std::string DescribeOrder(const Order& order, const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < order.ct_of.size(); ++i) {
    const auto j = static_cast<std::size_t>(order.ct_of[i]);
    if (i != j) text += Message(text.empty() ? "" : ", ", "'", names[i], "' is '", names[j], "'");
  }
  return text;
}

transforms::MarkerPairs Reordered(const transforms::MarkerPairs& pairs, const Order& order) {
  transforms::MarkerPairs result = pairs;
  result.ct_mm = pairs.ct_mm(Eigen::all, order.ct_of);
  return result;
}

}  // namespace acus::registration
