#include "acus/window/sketch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace acus::window {
namespace {

constexpr char32_t kCutMark = 0x2026;

/// The part of a segment within a rectangle (Liang and Barsky 1984); false if there is none.
bool ClipSegment(const Rectangle& clip, Eigen::Vector2d& from, Eigen::Vector2d& to) {
  if (!from.allFinite() || !to.allFinite()) return false;
  const Eigen::Vector2d along = to - from;
  double first = 0.0;
  double last = 1.0;
  const std::array<double, 2> low{static_cast<double>(clip.left), static_cast<double>(clip.top)};
  const std::array<double, 2> high{low[0] + clip.width, low[1] + clip.height};
  for (int axis = 0; axis < 2; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (along[axis] == 0.0) {
      if (from[axis] < low[a] || from[axis] > high[a]) return false;
      continue;
    }
    double enter = (low[a] - from[axis]) / along[axis];
    double leave = (high[a] - from[axis]) / along[axis];
    if (enter > leave) std::swap(enter, leave);
    first = std::max(first, enter);
    last = std::min(last, leave);
  }
  if (first > last) return false;
  to = from + last * along;
  from += first * along;
  return true;
}

}  // namespace

void Sketch::Clear() {
  vertices_.clear();
  clip_ = {.left = 0, .top = 0, .width = 1 << 20, .height = 1 << 20};
}

void Sketch::Piece(const std::array<Eigen::Vector2d, 4>& corners, const FontAtlas::Strip& texture,
                   Colour colour) {
  // The texture's width is along the first edge; its middle row avoids adjacent letters.
  const auto row = static_cast<float>(texture.row + 2);
  const auto first = static_cast<float>(texture.column) + 0.5F;
  const auto last = static_cast<float>(texture.column + texture.width) - 0.5F;
  for (std::size_t i = 0; i < 4; ++i) {
    vertices_.push_back({.x = static_cast<float>(corners[i][0]),
                         .y = static_cast<float>(corners[i][1]),
                         .u = i == 0 || i == 3 ? first : last,
                         .v = row,
                         .colour = colour});
  }
}

void Sketch::Fill(const Rectangle& place, Colour colour) {
  if (place.empty()) return;
  const double left = place.left;
  const double top = place.top;
  const double right = left + place.width;
  const double bottom = top + place.height;
  Piece({Eigen::Vector2d(left, top), {right, top}, {right, bottom}, {left, bottom}},
        atlas_->white(), colour);
}

void Sketch::Frame(const Rectangle& place, Colour colour) {
  Rectangle side = place;
  side.height = 1;
  Fill(side, colour);
  side.top = place.top + place.height - 1;
  Fill(side, colour);
  side = place;
  side.width = 1;
  Fill(side, colour);
  side.left = place.left + place.width - 1;
  Fill(side, colour);
}

void Sketch::Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
                  Colour colour) {
  Eigen::Vector2d a = from;
  Eigen::Vector2d b = to;
  if (!ClipSegment(clip_, a, b)) return;
  const Eigen::Vector2d along = b - a;
  const double length = along.norm();
  if (length < 1e-9) return;
  // The profile's outer pixels are transparent: one more on each side than the visible width.
  const Eigen::Vector2d across =
      Eigen::Vector2d(-along[1], along[0]) / length * (0.5 * width + 1.0);
  Piece({a - across, a + across, b + across, b - across}, atlas_->line(), colour);
}

void Sketch::Dashes(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
                    Colour colour) {
  constexpr double kOnPx = 6.0;
  constexpr double kOffPx = 5.0;
  constexpr int kMost = 1000;
  Eigen::Vector2d a = from;
  Eigen::Vector2d b = to;
  if (!ClipSegment(clip_, a, b)) return;
  const double length = (b - a).norm();
  if (length < 1.0) return;
  const Eigen::Vector2d along = (b - a) / length;
  for (int i = 0; i < kMost; ++i) {
    const double at = i * (kOnPx + kOffPx);
    if (at >= length) break;
    Line(a + at * along, a + std::min(at + kOnPx, length) * along, width, colour);
  }
}

void Sketch::Polyline(std::span<const Eigen::Vector2d> points, double width, Colour colour) {
  for (std::size_t i = 1; i < points.size(); ++i) Line(points[i - 1], points[i], width, colour);
}

void Sketch::Ring(const Eigen::Vector2d& centre, double radius, double width, Colour colour) {
  if (!centre.allFinite() ||
      !clip_.Contains(static_cast<int>(centre[0]), static_cast<int>(centre[1]))) {
    return;
  }
  constexpr int kSides = 36;
  const double inner = std::max(0.0, radius - 0.5 * width - 1.0);
  const double outer = radius + 0.5 * width + 1.0;
  Eigen::Vector2d before(1.0, 0.0);
  for (int i = 1; i <= kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    const Eigen::Vector2d at(std::cos(angle), std::sin(angle));
    Piece({centre + inner * before, centre + outer * before, centre + outer * at,
           centre + inner * at},
          atlas_->line(), colour);
    before = at;
  }
}

void Sketch::Dot(const Eigen::Vector2d& centre, double radius, Colour colour) {
  if (!centre.allFinite() ||
      !clip_.Contains(static_cast<int>(centre[0]), static_cast<int>(centre[1]))) {
    return;
  }
  constexpr int kSides = 20;
  Eigen::Vector2d before = centre + Eigen::Vector2d(radius, 0.0);
  for (int i = 1; i <= kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    const Eigen::Vector2d at = centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    Triangle(centre, before, at, colour);
    before = at;
  }
}

void Sketch::Triangle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                      Colour colour) {
  Piece({a, b, c, c}, atlas_->white(), colour);
}

int Sketch::WidthOf(const std::vector<char32_t>& text, const FontAtlas::Face& face) const {
  int width = 0;
  for (const char32_t letter : text) width += atlas_->GlyphOf(face, letter).advance;
  return width;
}

int Sketch::TextWidth(std::string_view text, int size_px, bool bold) const {
  return WidthOf(CodePointsOf(text), atlas_->FaceOf(size_px, bold));
}

int Sketch::TextHeight(int size_px, bool bold) const {
  return atlas_->FaceOf(size_px, bold).height;
}

void Sketch::Letters(const Eigen::Vector2i& place, const std::vector<char32_t>& text,
                     const FontAtlas::Face& face, Colour colour) {
  int pen = place[0];
  for (const char32_t letter : text) {
    const FontAtlas::Glyph& glyph = atlas_->GlyphOf(face, letter);
    if (letter != U' ') {
      for (int corner = 0; corner < 4; ++corner) {
        const int right = corner == 1 || corner == 2 ? glyph.width : 0;
        const int down = corner >= 2 ? glyph.height : 0;
        vertices_.push_back({.x = static_cast<float>(pen + glyph.left + right),
                             .y = static_cast<float>(place[1] + glyph.top + down),
                             .u = static_cast<float>(glyph.column + right),
                             .v = static_cast<float>(glyph.row + down),
                             .colour = colour});
      }
    }
    pen += glyph.advance;
  }
}

int Sketch::Text(const Eigen::Vector2i& place, std::string_view text, const TextStyle& style,
                 int room_px) {
  const FontAtlas::Face& face = atlas_->FaceOf(style.size_px, style.bold);
  std::vector<char32_t> letters = CodePointsOf(text);
  int width = WidthOf(letters, face);
  if (room_px >= 0 && width > room_px) {
    letters.push_back(kCutMark);
    while (letters.size() > 1 && WidthOf(letters, face) > room_px) {
      letters.erase(letters.end() - 2);
    }
    width = WidthOf(letters, face);
    if (width > room_px) return 0;
  }
  Eigen::Vector2i at = place;
  if (style.align == Align::kMiddle) at[0] -= width / 2;
  if (style.align == Align::kRight) at[0] -= width;
  if (style.shade) {
    for (const Eigen::Vector2i& by : {Eigen::Vector2i(1, 1), Eigen::Vector2i(-1, 0),
                                      Eigen::Vector2i(1, -1), Eigen::Vector2i(0, 1)}) {
      Letters(at + by, letters, face, {.red = 0, .green = 0, .blue = 0, .opacity = 150});
    }
  }
  Letters(at, letters, face, style.colour);
  return width;
}

}  // namespace acus::window
