// Markers that were touched in another order than they are listed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/patient/registration/rigid_registration.h"

namespace acus::registration {

/// More markers than this are not searched through.
constexpr Eigen::Index kMostToOrder = 40;
/// Up to so many, every order that fits is found.
constexpr Eigen::Index kMostToOrderInFull = 8;

struct Order {
  /// Reference marker i is CT marker ct_of[i].
  std::vector<Eigen::Index> ct_of;
  double fre_rms_mm = 0.0;
};

/// The orders of the CT markers that fit the reference markers with an FRE of at most `limit_mm`,
/// best first, at most `most`. Markers i and j can only be a and b if the distance is the same to
/// within 2 sqrt(n) limit_mm, so that few of the n! orders are tried, and none is missed.
///
/// With more than kMostToOrderInFull markers, three that lie far apart are taken for any three
/// others with the same distances; the pose that follows puts each marker at the nearest one, and
/// is fitted again until no choice changes. An order is found if the markers are farther apart than
/// `limit_mm` throws them from their places.
/// @pre n <= kMostToOrder, both sets determine a pose.
std::vector<Order> FindOrders(const transforms::Markers& reference_mm,
                              const transforms::Markers& ct_mm, double limit_mm,
                              std::size_t most = 10);

/// The order that fits at least five times better than the present one, if there is one.
std::optional<Order> BetterOrder(const transforms::Markers& reference_mm,
                                 const transforms::Markers& ct_mm);

/// Orders other than the present one that fit about as well (FRE less than 1.5 times as large):
/// then the layout is so symmetrical that a wrong order would not be noticed. Empty for FRE above a
/// tenth of the spread, where nothing fits.
std::vector<Order> EquallyGoodOrders(const transforms::Markers& reference_mm,
                                     const transforms::Markers& ct_mm);

/// "A is C, C is A": what changes, in names. Empty if nothing does.
std::string DescribeOrder(const Order& order, const std::vector<std::string>& names);

/// The pairs with CT markers in another order; each keeps the name of the reference marker.
transforms::MarkerPairs Reordered(const transforms::MarkerPairs& pairs, const Order& order);

}  // namespace acus::registration
