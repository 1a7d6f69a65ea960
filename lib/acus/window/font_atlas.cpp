#include "acus/window/font_atlas.h"

#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include "acus/base/core/error.h"

namespace acus::window {
namespace {

constexpr std::array kSizesPx = {11, 12, 13, 14, 15, 16, 18, 20, 22, 26, 30, 36, 42, 60};
constexpr char32_t kEllipsis = 0x2026;
constexpr int kScreenDpi = 72;  // Points are pixels.
constexpr int kProfilePx = 5;

const std::vector<char32_t>& Letters() {
  static const std::vector<char32_t> letters = [] {
    std::vector<char32_t> out;
    for (char32_t c = 0x20; c < 0x7F; ++c) out.push_back(c);
    for (char32_t c = 0xA0; c < 0x100; ++c) out.push_back(c);
    out.push_back(kEllipsis);
    return out;
  }();
  return letters;
}

std::string Utf8(char32_t code) {
  std::string out;
  if (code < 0x80) {
    out += static_cast<char>(code);
  } else if (code < 0x800) {
    out += static_cast<char>(0xC0U | code >> 6U);
    out += static_cast<char>(0x80U | (code & 0x3FU));
  } else {
    out += static_cast<char>(0xE0U | code >> 12U);
    out += static_cast<char>(0x80U | (code >> 6U & 0x3FU));
    out += static_cast<char>(0x80U | (code & 0x3FU));
  }
  return out;
}

/// Draws letters with VTK, which contains its own fonts.
class Pen {
 public:
  Pen(int size_px, bool bold) : renderer_(vtkTextRenderer::GetInstance()) {
    ACUS_REQUIRE(renderer_ != nullptr, "display: this build of VTK has no fonts");
    renderer_->SetScaleToPowerOfTwo(false);
    property_->SetFontFamilyToArial();
    property_->SetFontSize(size_px);
    property_->SetBold(bold ? 1 : 0);
    property_->SetColor(1.0, 1.0, 1.0);
  }
  void Write(const std::string& text) {
    std::array<int, 2> size{};
    if (!renderer_->RenderString(property_, vtkStdString(text), image_, size.data(), kScreenDpi)) {
      throw InputError("display: VTK's fonts cannot be used");
    }
    image_->GetExtent(extent_.data());
  }
  int Width(const std::string& text) {
    Write(text);
    return extent_[1] - extent_[0] + 1;
  }
  int left() const { return extent_[0]; }
  int width() const { return extent_[1] - extent_[0] + 1; }
  int height() const { return extent_[3] - extent_[2] + 1; }
  /// @param row  0 at the top.
  std::uint8_t Opacity(int column, int row) {
    const auto* pixel = static_cast<const std::uint8_t*>(
        image_->GetScalarPointer(extent_[0] + column, extent_[3] - row, 0));
    return pixel[image_->GetNumberOfScalarComponents() - 1];
  }

 private:
  vtkTextRenderer* renderer_;
  vtkNew<vtkTextProperty> property_;
  vtkNew<vtkImageData> image_;
  std::array<int, 6> extent_{};
};

}  // namespace

FontAtlas::FontAtlas() {
  const auto [column, row] = Reserve(kProfilePx, 4);
  line_ = {.column = column, .row = row, .width = kProfilePx};
  const auto [white_column, white_row] = Reserve(4, 4);
  white_ = {.column = white_column, .row = white_row, .width = 4};
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < kProfilePx; ++x) {
      const bool inside = x > 0 && x < kProfilePx - 1;
      opacity_[static_cast<std::size_t>((row + y) * width_ + column + x)] = inside ? 255 : 0;
    }
    for (int x = 0; x < 4; ++x) {
      opacity_[static_cast<std::size_t>((white_row + y) * width_ + white_column + x)] = 255;
    }
  }
  for (const bool bold : {false, true}) {
    for (const int size : kSizesPx) AddFace(size, bold);
  }
}

std::pair<int, int> FontAtlas::Reserve(int width, int height) {
  constexpr int kMarginPx = 1;
  if (next_column_ + width + kMarginPx > width_) {
    next_column_ = 0;
    next_row_ += row_height_;
    row_height_ = 0;
  }
  row_height_ = std::max(row_height_, height + kMarginPx);
  height_ = std::max(height_, next_row_ + row_height_);
  opacity_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  const std::pair place{next_column_, next_row_};
  next_column_ += width + kMarginPx;
  return place;
}

void FontAtlas::AddFace(int size_px, bool bold) {
  Pen pen(size_px, bold);
  // The box of a text has the larger width of its black pixels and its advance; between two bars it
  // is the advance.
  const int bars = pen.Width("||");
  Face face;
  pen.Write("Ag");
  face.height = pen.height();
  for (const char32_t letter : Letters()) {
    const std::string text = Utf8(letter);
    Glyph glyph;
    glyph.advance = pen.Width("|" + text + "|") - bars;
    pen.Write(text);
    glyph.left = pen.left();
    glyph.width = pen.width();
    glyph.height = pen.height();
    glyph.top = face.height - glyph.height;
    std::tie(glyph.column, glyph.row) = Reserve(glyph.width, glyph.height);
    for (int y = 0; y < glyph.height; ++y) {
      for (int x = 0; x < glyph.width; ++x) {
        opacity_[static_cast<std::size_t>((glyph.row + y) * width_ + glyph.column + x)] =
            pen.Opacity(x, y);
      }
    }
    face.glyphs.push_back(glyph);
  }
  faces_[{bold, size_px}] = std::move(face);
}

const FontAtlas::Face& FontAtlas::FaceOf(int size_px, bool bold) const {
  auto found = faces_.upper_bound({bold, size_px});
  if (found != faces_.begin() && std::prev(found)->first.first == bold) --found;
  return found->second;
}

const FontAtlas::Glyph& FontAtlas::GlyphOf(const Face& face, char32_t code_point) const {
  const auto& letters = Letters();
  auto found = std::ranges::lower_bound(letters, code_point);
  if (found == letters.end() || *found != code_point) {
    found = std::ranges::lower_bound(letters, U'?');
  }
  return face.glyphs[static_cast<std::size_t>(found - letters.begin())];
}

std::vector<char32_t> CodePointsOf(std::string_view text) {
  std::vector<char32_t> out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first < 0x80 ? 1 : first >> 5U == 6 ? 2 : first >> 4U == 14 ? 3 : 0;
    if (length == 0 || i + length > text.size()) {
      out.push_back(U'?');
      ++i;
      continue;
    }
    char32_t code = length == 1 ? first : first & (0xFFU >> (length + 1));
    bool good = true;
    for (std::size_t k = 1; k < length; ++k) {
      const auto next = static_cast<unsigned char>(text[i + k]);
      good = good && next >> 6U == 2;
      code = code << 6U | (next & 0x3FU);
    }
    out.push_back(good ? code : U'?');
    i += good ? length : 1;
  }
  return out;
}

}  // namespace acus::window
