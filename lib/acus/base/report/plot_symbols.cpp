#include "acus/base/report/plot_symbols.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::report {
namespace {

constexpr double kRingPx = 6.5;
constexpr double kStarPx = 8.0;
constexpr double kCapPx = 2.5;
constexpr double kLabelPx = 10.0;

std::string Polygon(const std::vector<PixelPoint>& corners, const std::string& attributes) {
  std::string points;
  for (const PixelPoint& corner : corners) {
    points += (points.empty() ? "" : " ") + Px(corner.x) + "," + Px(corner.y);
  }
  return Message("<polygon points=\"", points, "\" ", attributes, "/>");
}

std::vector<PixelPoint> StarAround(const PixelPoint& at) {
  std::vector<PixelPoint> corners;
  for (int i = 0; i < 10; ++i) {
    const double radius = i % 2 == 0 ? kStarPx : 0.45 * kStarPx;
    const double angle = std::numbers::pi * (i / 5.0 - 0.5);
    corners.push_back({at.x + radius * std::cos(angle), at.y + radius * std::sin(angle)});
  }
  return corners;
}

}  // namespace

std::string SymbolText(Symbol symbol, const PixelPoint& at, const std::string& colour) {
  const std::string outline = Message("fill=\"none\" stroke=\"", colour, "\" stroke-width=\"1.6\"");
  const double r = kRingPx;
  switch (symbol) {
    case Symbol::kDot:
      return Message("<circle cx=\"", Px(at.x), "\" cy=\"", Px(at.y), "\" r=\"3\" fill=\"", colour,
                     "\"/>");
    case Symbol::kRing:
      return Message("<circle cx=\"", Px(at.x), "\" cy=\"", Px(at.y), "\" r=\"", Px(r), "\" ",
                     outline, "/>");
    case Symbol::kDiamond:
      return Polygon(
          {{at.x, at.y - r - 1}, {at.x + r + 1, at.y}, {at.x, at.y + r + 1}, {at.x - r - 1, at.y}},
          outline);
    case Symbol::kStar:
      return Polygon(StarAround(at), Message("fill=\"", colour, "\" stroke=\"#ffffff\""));
  }
  ACUS_ASSERT(false);
}

std::string BarsPath(const std::vector<PixelPoint>& from, const std::vector<PixelPoint>& to) {
  ACUS_ASSERT(from.size() == to.size());
  std::string path;
  const auto line = [&path](double x1, double y1, double x2, double y2) {
    path += "M" + Px(x1) + "," + Px(y1) + "L" + Px(x2) + "," + Px(y2);
  };
  for (std::size_t i = 0; i < from.size(); ++i) {
    const PixelPoint& a = from[i];
    const PixelPoint& b = to[i];
    if (std::hypot(b.x - a.x, b.y - a.y) < 1.0) continue;  // Too short to be seen.
    line(a.x, a.y, b.x, b.y);
    const bool upright = std::abs(b.y - a.y) > std::abs(b.x - a.x);
    for (const PixelPoint& end : {a, b}) {
      if (upright) {
        line(end.x - kCapPx, end.y, end.x + kCapPx, end.y);
      } else {
        line(end.x, end.y - kCapPx, end.x, end.y + kCapPx);
      }
    }
  }
  return path;
}

void LabelPlacer::Avoid(const PixelPoint& point) {
  taken_.push_back({point.x - 3.0, point.y - 3.0, point.x + 3.0, point.y + 3.0});
}

bool LabelPlacer::IsFree(const Box& box) const {
  if (box.left < frame_.left || box.right > frame_.right() || box.top < frame_.top ||
      box.bottom > frame_.bottom()) {
    return false;
  }
  return std::ranges::none_of(taken_, [&box](const Box& other) {
    return box.left < other.right && other.left < box.right && box.top < other.bottom &&
           other.top < box.bottom;
  });
}

std::string LabelPlacer::Place(const PixelPoint& point, const std::string& text,
                               const std::string& colour) {
  const double width = TextWidth(text, kLabelPx);
  struct Place {
    double x;  ///< Of the text's left end.
    double y;  ///< Of its foot.
  };
  const std::array<Place, 6> places = {{{point.x + 6.0, point.y - 4.0},
                                        {point.x + 6.0, point.y + 11.0},
                                        {point.x - 6.0 - width, point.y - 4.0},
                                        {point.x - 6.0 - width, point.y + 11.0},
                                        {point.x - 0.5 * width, point.y - 9.0},
                                        {point.x - 0.5 * width, point.y + 17.0}}};
  for (const Place& place : places) {
    const Box box{place.x, place.y - 8.0, place.x + width, place.y + 2.0};
    if (!IsFree(box)) continue;
    taken_.push_back(box);
    return TextAt(place.x, place.y, text,
                  Message("font-size=\"10\" fill=\"", colour,
                          "\" paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"2\" "
                          "stroke-opacity=\"0.8\""));
  }
  return {};
}

}  // namespace acus::report
