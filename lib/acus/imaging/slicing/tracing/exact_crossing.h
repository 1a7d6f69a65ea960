// Whether a segment crosses a triangle, without rounding.
//
// Places are whole numbers of a small unit, so that signs of determinants can be computed exactly.
// Segments are taken as if moved by (e, e^2, e^3), e above 0 and next to nothing (simulation of
// simplicity, Edelsbrunner and Muecke 1990): the same move for all, so that a path through nodes
// and edges of a closed surface, and one that bends on a triangle, crosses it exactly as often as a
// path next to it. No crossing is lost or counted twice.
#pragma once

#include <array>
#include <cstdint>

namespace acus::tracing {

/// Largest coordinates for which nothing overflows.
inline constexpr std::int64_t kMaxNode = std::int64_t{1} << 23;
inline constexpr std::int64_t kMaxPlace = std::int64_t{1} << 27;

using Place = std::array<std::int64_t, 3>;

struct SegmentCrossing {
  double share;  ///< Of the segment's length, 0 to 1.
  int turn;      ///< +1 against the triangle's normal, that is, into a surface; -1 along it.
};

/// Whether the segment from `from` to `to` crosses the triangle a, b, c, whose normal is (b - a) x
/// (c - a). @pre coordinates of a, b, c are within kMaxNode, those of the segment within kMaxPlace.
bool Crosses(const Place& from, const Place& to, const Place& a, const Place& b, const Place& c,
             SegmentCrossing& out) noexcept;

}  // namespace acus::tracing
