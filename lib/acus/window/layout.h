// Where in the window each view is.
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
/// Of the images of effects, as many are shown.
inline constexpr std::array kEffectViews = {ViewKind::kEffect, ViewKind::kSecondEffect};
std::string_view TitleOf(ViewKind view) noexcept;

/// From names as in `acus-live --views`: "ultrasound,3d,volume". Those of `effects` are two.
/// @throws InputError for an empty list, or a name that no view has.
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

  /// Null if it is not shown.
  const View* Find(ViewKind kind) const;
  /// Null if none is there.
  const View* At(int column, int row) const;
};

/// One view fills all, two share it, of three the first has a side of its own and the others lie
/// above each other; four or more make two rows. A window that is higher than wide is divided the
/// other way round.
/// @param shown  Without repetition.
/// @param alone  If among those shown: it gets all the room.
/// @param has_exercise  Leaves room for the exercise, in windows of at least kLeastForExercisePx.
Layout LayOut(int width_px, int height_px, const std::vector<ViewKind>& shown,
              std::optional<ViewKind> alone, bool has_exercise = false);

inline constexpr int kLeastForExercisePx = 480;

/// The largest rectangle of the given proportions within another, in its middle.
Rectangle Fit(const Rectangle& room, double width, double height);

}  // namespace acus::window
