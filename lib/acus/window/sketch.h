// Marks and text of a window, collected as pieces of one image of letters.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/window/font_atlas.h"
#include "acus/window/layout.h"

namespace acus::window {

struct Colour {
  std::uint8_t red = 255;
  std::uint8_t green = 255;
  std::uint8_t blue = 255;
  std::uint8_t opacity = 255;

  Colour Faded(double share) const {
    return {.red = red,
            .green = green,
            .blue = blue,
            .opacity = static_cast<std::uint8_t>(opacity * share + 0.5)};
  }
};

/// The appearance of the window: calm, dark, and one meaning for each colour. States differ for
/// people with any colour blindness (severity_mark_test), and have marks of their own besides.
namespace palette {
inline constexpr Colour kBackground{.red = 15, .green = 19, .blue = 24, .opacity = 255};
inline constexpr Colour kPanel{.red = 6, .green = 8, .blue = 11, .opacity = 255};
inline constexpr Colour kRule{.red = 58, .green = 68, .blue = 79, .opacity = 255};
inline constexpr Colour kText{.red = 218, .green = 224, .blue = 230, .opacity = 255};
inline constexpr Colour kFaint{.red = 140, .green = 152, .blue = 164, .opacity = 255};
inline constexpr Colour kGood{.red = 90, .green = 225, .blue = 150, .opacity = 255};
inline constexpr Colour kWarning{.red = 248, .green = 195, .blue = 40, .opacity = 255};
inline constexpr Colour kFault{.red = 245, .green = 72, .blue = 60, .opacity = 255};
inline constexpr Colour kNeedle{.red = 120, .green = 214, .blue = 226, .opacity = 255};
inline constexpr Colour kTarget{.red = 250, .green = 210, .blue = 80, .opacity = 255};
}  // namespace palette

enum class Align { kLeft, kMiddle, kRight };

struct TextStyle {
  int size_px = 14;
  Colour colour = palette::kText;
  Align align = Align::kLeft;
  bool bold = false;
  bool shade = false;  ///< A dark rim, for legibility over images.
};

/// Positions are pixels from the upper left corner of the window; (0, 0) is the corner itself.
class Sketch {
 public:
  struct Vertex {
    float x, y;
    float u, v;  ///< In pixels of the atlas, row 0 at the top.
    Colour colour;
  };

  /// @param atlas  Must outlive it.
  explicit Sketch(const FontAtlas& atlas) : atlas_(&atlas) {}

  void Clear();
  /// Clips all further lines and dots.
  void SetClip(const Rectangle& clip) { clip_ = clip; }

  void Fill(const Rectangle& place, Colour colour);
  void Frame(const Rectangle& place, Colour colour);
  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width, Colour colour);
  void Dashes(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width, Colour colour);
  void Polyline(std::span<const Eigen::Vector2d> points, double width, Colour colour);
  void Ring(const Eigen::Vector2d& centre, double radius, double width, Colour colour);
  void Dot(const Eigen::Vector2d& centre, double radius, Colour colour);
  void Triangle(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
                Colour colour);

  int TextWidth(std::string_view text, int size_px, bool bold = false) const;
  int TextHeight(int size_px, bool bold = false) const;
  /// Draws text with its upper edge at `place`. Text wider than `room_px`, if that is not negative,
  /// ends with an ellipsis. Returns the width drawn.
  int Text(const Eigen::Vector2i& place, std::string_view text, const TextStyle& style,
           int room_px = -1);

  /// Four vertices for each piece, in order.
  const std::vector<Vertex>& vertices() const { return vertices_; }

 private:
  void Piece(const std::array<Eigen::Vector2d, 4>& corners, const FontAtlas::Strip& texture,
             Colour colour);
  void Letters(const Eigen::Vector2i& place, const std::vector<char32_t>& text,
               const FontAtlas::Face& face, Colour colour);
  int WidthOf(const std::vector<char32_t>& text, const FontAtlas::Face& face) const;

  const FontAtlas* atlas_;
  Rectangle clip_{.left = 0, .top = 0, .width = 1 << 20, .height = 1 << 20};
  std::vector<Vertex> vertices_;
};

}  // namespace acus::window
