#include "acus/patient/registration/correspondence.h"

#include <algorithm>
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
  std::vector<Order> orders = Search(reference_mm, ct_mm, limit_mm).Run();
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
