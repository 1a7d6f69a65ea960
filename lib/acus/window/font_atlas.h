// Letters as an image, so that any amount of text is drawn and changed quickly.
#pragma once

#include <cstdint>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

namespace acus::window {

/// Sans-serif letters of several sizes: ASCII, Latin-1, and the ellipsis. Beside them a row whose
/// opacity decreases to both sides, for smooth lines, and white, for filled shapes.
class FontAtlas {
 public:
  /// Distance of letters is `advance`; `left` may be below zero.
  struct Glyph {
    int left = 0;
    int top = 0;  ///< Below the upper edge of the line.
    int width = 0;
    int height = 0;
    int advance = 0;
    int column = 0;  ///< Upper left corner in the image.
    int row = 0;
  };
  struct Face {
    int height = 0;  ///< Height of a line: from at most a capital's accent to the lowest descender.
    std::vector<Glyph> glyphs;
  };
  /// Columns of the line's profile: opacity 0 at both ends.
  struct Strip {
    int column = 0;
    int row = 0;
    int width = 0;
  };

  FontAtlas();

  /// The largest face not above `size_px`, or else the smallest.
  const Face& FaceOf(int size_px, bool bold) const;
  /// @param code_point  Unicode; '?' replaces missing ones.
  const Glyph& GlyphOf(const Face& face, char32_t code_point) const;

  int width() const { return width_; }
  int height() const { return height_; }
  /// Opacity of white by pixel, row 0 at the top.
  const std::vector<std::uint8_t>& opacity() const { return opacity_; }
  const Strip& line() const { return line_; }
  const Strip& white() const { return white_; }

 private:
  void AddFace(int size_px, bool bold);
  std::pair<int, int> Reserve(int width, int height);

  int width_ = 1024;
  int height_ = 0;
  int next_column_ = 0;
  int next_row_ = 0;
  int row_height_ = 0;
  std::vector<std::uint8_t> opacity_;
  std::map<std::pair<bool, int>, Face> faces_;
  Strip line_;
  Strip white_;
};

/// Code points of UTF-8; invalid bytes become '?'.
std::vector<char32_t> CodePointsOf(std::string_view text);

}  // namespace acus::window
