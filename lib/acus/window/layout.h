// The positions of the views in the window.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace acus::window {

enum class ViewKind { kVideo, kUltrasound, kTeaching, kVolume, kCtSlice, kEffect, kSecondEffect };
inline constexpr std::array kViewKinds = {
    ViewKind::kVideo,   ViewKind::kUltrasound, ViewKind::kTeaching,    ViewKind::kVolume,
    ViewKind::kCtSlice, ViewKind::kEffect,     ViewKind::kSecondEffect};
/// At most this number of effects' images is shown.
inline constexpr std::array kEffectViews = {ViewKind::kEffect, ViewKind::kSecondEffect};
/// In English, for the catalogues of translations.
const char* TitleOf(ViewKind view) noexcept;

/// Parses names as in `acus-live --views`: "ultrasound,3d,volume". `effects` stands for two views.
/// @throws InputError for an empty list, or an unknown name.
std::vector<ViewKind> ViewsOf(std::string_view names);

/// In pixels of the window, from its upper left corner, row 0 at the top.
struct Rectangle {
  int left = 0;
  int top = 0;
  int width = 0;
  int height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
  bool Contains(int column, int row) const {
    return column >= left && column < left + width && row >= top && row < top + height;
  }
};

struct Layout {
  struct View {
    ViewKind kind = ViewKind::kVideo;
    Rectangle place;
  };
  std::vector<View> views;  ///< They do not overlap.
  Rectangle status;         ///< The bar below them.
  Rectangle exercise;       ///< Left of the views; empty: there is none, or no room for it.

  /// Null if the view is not shown.
  const View* Find(ViewKind kind) const;
  /// Null if no view is there.
  const View* At(int column, int row) const;
};

/// One view fills all, two share it, of three the first has one side and the others lie one above
/// the other; four or more form two rows. In a window that is higher than wide, rows and columns
/// are exchanged.
/// @param shown  Without repetition.
/// @param alone  If among those shown: it fills all the room.
/// @param has_exercise  Reserves room for the exercise, in windows of at least kLeastForExercisePx.
Layout LayOut(int width_px, int height_px, const std::vector<ViewKind>& shown,
              std::optional<ViewKind> alone, bool has_exercise = false);

inline constexpr int kLeastForExercisePx = 480;

/// The largest rectangle of the given proportions within another, in its middle.
Rectangle Fit(const Rectangle& room, double width, double height);

}  // namespace acus::window
