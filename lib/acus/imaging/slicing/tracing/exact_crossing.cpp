#include "acus/imaging/slicing/tracing/exact_crossing.h"

#include <algorithm>
#include <cmath>

namespace acus::tracing {
namespace {

/// Differences of places, and their cross products where coordinates are small enough.
using Difference = std::array<std::int64_t, 3>;
__extension__ using Wide = __int128;

/// Share of the sum of the magnitudes of a determinant's six products: above it the sign is right.
/// Rounding adds up to less than 8 units of 2^-53 (Shewchuk 1997, section 4.2).
constexpr double kRounding = 1e-15;

Difference Minus(const Place& a, const Place& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Sign of the first component that is not 0: of the scalar product with the move of the segment.
int SignAlongMove(const std::array<Wide, 3>& v) {
  for (const Wide component : v) {
    if (component != 0) return component > 0 ? 1 : -1;
  }
  return 0;
}

std::array<Wide, 3> WideCross(const Difference& a, const Difference& b) {
  return {static_cast<Wide>(a[1]) * b[2] - static_cast<Wide>(a[2]) * b[1],
          static_cast<Wide>(a[2]) * b[0] - static_cast<Wide>(a[0]) * b[2],
          static_cast<Wide>(a[0]) * b[1] - static_cast<Wide>(a[1]) * b[0]};
}

struct Determinant {
  double value;
  int sign;
};

/// d . (u x v). The sign is exact, the value to within rounding.
Determinant TripleProduct(const Difference& d, const Difference& u, const Difference& v) {
  const auto number = [](std::int64_t n) { return static_cast<double>(n); };
  double value = 0.0;
  double magnitude = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    const double first = number(u[j]) * number(v[k]);
    const double second = number(u[k]) * number(v[j]);
    value += number(d[i]) * (first - second);
    magnitude += std::abs(number(d[i])) * (std::abs(first) + std::abs(second));
  }
  if (std::abs(value) > kRounding * magnitude) return {value, value > 0.0 ? 1 : -1};
  const std::array<Wide, 3> cross = WideCross(u, v);
  const Wide exact = d[0] * cross[0] + d[1] * cross[1] + d[2] * cross[2];
  return {static_cast<double>(exact), exact > 0 ? 1 : exact < 0 ? -1 : 0};
}

/// On which side of the edge from u to v (seen from a segment's start) the moved segment passes; 0
/// if it is parallel to the edge: then a triangle at that edge is seen from its side and not met.
int SideOfEdge(const Difference& along, const Difference& u, const Difference& v) {
  const int sign = TripleProduct(along, u, v).sign;
  if (sign != 0) return sign;
  return SignAlongMove(WideCross(along, {v[0] - u[0], v[1] - u[1], v[2] - u[2]}));
}

/// Volume between the triangle with that normal and a place at `to_corner` before its corner, and
/// the sign for the moved place: above 0 behind the triangle.
Determinant Depth(const Difference& edge, const Difference& other_edge,
                  const Difference& to_corner) {
  Determinant out = TripleProduct(to_corner, edge, other_edge);
  if (out.sign == 0) out.sign = -SignAlongMove(WideCross(edge, other_edge));
  return out;
}

}  // namespace

bool Crosses(const Place& from, const Place& to, const Place& a, const Place& b, const Place& c,
             SegmentCrossing& out) noexcept {
  const Difference along = Minus(to, from);
  const Difference u = Minus(a, from);
  const Difference v = Minus(b, from);
  const Difference w = Minus(c, from);
  const int side = SideOfEdge(along, u, v);
  if (side == 0 || SideOfEdge(along, v, w) != side || SideOfEdge(along, w, u) != side) return false;
  const Difference edge = Minus(b, a);
  const Difference other_edge = Minus(c, a);
  const Determinant first = Depth(edge, other_edge, u);
  const Determinant last = Depth(edge, other_edge, Minus(a, to));
  if (first.sign == last.sign) return false;
  const double whole = first.value - last.value;
  out.share = whole != 0.0 ? std::clamp(first.value / whole, 0.0, 1.0) : 0.0;
  out.turn = side > 0 ? -1 : 1;
  return true;
}

}  // namespace acus::tracing
