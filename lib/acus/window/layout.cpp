#include "acus/window/layout.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/base/translation/translation.h"

namespace acus::window {
namespace {

constexpr int kGapPx = 2;

int StatusHeight(int height_px) {
  return std::clamp(height_px * 2 / 15, 60, 288);
}

/// The share of the room for the first of three views.
constexpr double kShareOfFirst = 0.64;

/// Splits a room into `count` rectangles of nearly the same size, side by side or one below the
/// other.
void Place(const Rectangle& room, std::span<const ViewKind> kinds, bool below,
           std::vector<Layout::View>& out) {
  const int count = static_cast<int>(kinds.size());
  const int size = below ? room.height : room.width;
  for (int i = 0; i < count; ++i) {
    const int begin = i * (size + kGapPx) / count;
    const int length = std::max(0, (i + 1) * (size + kGapPx) / count - begin - kGapPx);
    Rectangle place = room;
    (below ? place.top : place.left) += begin;
    (below ? place.height : place.width) = length;
    out.push_back({.kind = kinds[static_cast<std::size_t>(i)], .place = place});
  }
}

std::pair<Rectangle, Rectangle> Split(const Rectangle& room, bool below, double share) {
  std::pair<Rectangle, Rectangle> parts(room, room);
  const int size = (below ? room.height : room.width) - kGapPx;
  const int first = std::max(0, static_cast<int>(std::lround(share * size)));
  (below ? parts.first.height : parts.first.width) = first;
  (below ? parts.second.top : parts.second.left) += first + kGapPx;
  (below ? parts.second.height : parts.second.width) = std::max(0, size - first);
  return parts;
}

}  // namespace

const char* TitleOf(ViewKind view) noexcept {
  using translation::Marked;
  switch (view) {
    case ViewKind::kVideo:
      return Marked("Camera");
    case ViewKind::kUltrasound:
      return Marked("Ultrasound");
    case ViewKind::kTeaching:
      return Marked("3D");
    case ViewKind::kVolume:
      return Marked("Volume");
    case ViewKind::kCtSlice:
      return Marked("CT in the probe's plane");
    case ViewKind::kEffect:
    case ViewKind::kSecondEffect:
      return "Effect";  // Its own title is in the window.
  }
  return "";
}

std::vector<ViewKind> ViewsOf(std::string_view names) {
  static const std::map<std::string_view, std::vector<ViewKind>> known = {
      {"camera", {ViewKind::kVideo}}, {"ultrasound", {ViewKind::kUltrasound}},
      {"3d", {ViewKind::kTeaching}},  {"volume", {ViewKind::kVolume}},
      {"ct", {ViewKind::kCtSlice}},   {"effects", {ViewKind::kEffect, ViewKind::kSecondEffect}}};
  std::vector<ViewKind> views;
  while (true) {
    const std::size_t comma = names.find(',');
    const std::string_view name = names.substr(0, comma);
    const auto found = known.find(name);
    ACUS_REQUIRE(found != known.end(), "--views: there is no view \"", name,
                 "\"; allowed are camera, ultrasound, 3d, volume, ct and effects, with commas "
                 "between them");
    for (const ViewKind kind : found->second) {
      if (std::ranges::find(views, kind) == views.end()) views.push_back(kind);
    }
    if (comma == std::string_view::npos) return views;
    names.remove_prefix(comma + 1);
  }
}

const Layout::View* Layout::Find(ViewKind kind) const {
  const auto found = std::ranges::find(views, kind, &View::kind);
  return found == views.end() ? nullptr : &*found;
}

const Layout::View* Layout::At(int column, int row) const {
  const auto found = std::ranges::find_if(
      views, [&](const View& view) { return view.place.Contains(column, row); });
  return found == views.end() ? nullptr : &*found;
}

Layout LayOut(int width_px, int height_px, const std::vector<ViewKind>& shown,
              std::optional<ViewKind> alone, bool has_exercise) {
  Layout layout;
  const int status_px = std::min(StatusHeight(height_px), height_px / 2);
  layout.status = {.left = 0, .top = height_px - status_px, .width = width_px, .height = status_px};
  Rectangle room{.left = 0, .top = 0, .width = width_px, .height = height_px - status_px - kGapPx};
  if (has_exercise && width_px >= kLeastForExercisePx) {
    layout.exercise = room;
    layout.exercise.width = std::clamp(width_px * 22 / 100, 150, 840);
    room.left = layout.exercise.width + kGapPx;
    room.width -= room.left;
  }
  if (alone && std::ranges::find(shown, *alone) != shown.end()) {
    layout.views.push_back({.kind = *alone, .place = room});
    return layout;
  }
  const std::span<const ViewKind> all(shown);
  const bool is_high = room.height > room.width;
  if (all.size() <= 2) {
    Place(room, all, is_high, layout.views);
  } else if (all.size() == 3) {
    const auto [first, others] = Split(room, is_high, kShareOfFirst);
    Place(first, all.first(1), is_high, layout.views);
    Place(others, all.subspan(1), !is_high, layout.views);
  } else {
    const auto [upper, lower] = Split(room, true, 0.5);
    const std::size_t in_upper = all.size() / 2;
    Place(upper, all.first(in_upper), false, layout.views);
    Place(lower, all.subspan(in_upper), false, layout.views);
  }
  return layout;
}

Rectangle Fit(const Rectangle& room, double width, double height) {
  if (room.empty() || !(width > 0.0) || !(height > 0.0)) {
    return {.left = room.left, .top = room.top, .width = 0, .height = 0};
  }
  const double scale = std::min(room.width / width, room.height / height);
  Rectangle fit;
  fit.width = std::clamp(static_cast<int>(std::lround(scale * width)), 1, room.width);
  fit.height = std::clamp(static_cast<int>(std::lround(scale * height)), 1, room.height);
  fit.left = room.left + (room.width - fit.width) / 2;
  fit.top = room.top + (room.height - fit.height) / 2;
  return fit;
}

}  // namespace acus::window
