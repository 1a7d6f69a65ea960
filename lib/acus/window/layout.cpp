#include "acus/window/layout.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace acus::window {
namespace {

constexpr int kGapPx = 2;

int StatusHeight(int height_px) {
  return std::clamp(height_px * 2 / 15, 60, 160);
}

/// Splits a row into `count` places of nearly the same width.
void PlaceInRow(const Rectangle& row, std::span<const ViewKind> kinds,
                std::vector<Layout::View>& out) {
  const int count = static_cast<int>(kinds.size());
  for (int i = 0; i < count; ++i) {
    const int left = row.left + i * (row.width + kGapPx) / count;
    const int next = row.left + (i + 1) * (row.width + kGapPx) / count;
    out.push_back({.kind = kinds[static_cast<std::size_t>(i)],
                   .place = {.left = left,
                             .top = row.top,
                             .width = std::max(0, next - left - kGapPx),
                             .height = row.height}});
  }
}

}  // namespace

std::string_view TitleOf(ViewKind view) noexcept {
  switch (view) {
    case ViewKind::kVideo:
      return "Camera";
    case ViewKind::kUltrasound:
      return "Ultrasound";
    case ViewKind::kTeaching:
      return "3D";
    case ViewKind::kCtSlice:
      return "CT in the probe's plane";
    case ViewKind::kEffect:
    case ViewKind::kSecondEffect:
      return "Effect";  // Its own title stands in the window.
  }
  return "";
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
              std::optional<ViewKind> alone) {
  Layout layout;
  const int status_px = std::min(StatusHeight(height_px), height_px / 2);
  layout.status = {.left = 0, .top = height_px - status_px, .width = width_px, .height = status_px};
  const Rectangle room{
      .left = 0, .top = 0, .width = width_px, .height = height_px - status_px - kGapPx};
  if (alone && std::ranges::find(shown, *alone) != shown.end()) {
    layout.views.push_back({.kind = *alone, .place = room});
    return layout;
  }
  const std::span<const ViewKind> all(shown);
  if (all.size() <= 2) {
    PlaceInRow(room, all, layout.views);
    return layout;
  }
  Rectangle upper = room;
  upper.height = static_cast<int>(std::lround(0.58 * (room.height - kGapPx)));
  Rectangle lower = room;
  lower.top = upper.height + kGapPx;
  lower.height = room.height - lower.top;
  PlaceInRow(upper, all.first(2), layout.views);
  PlaceInRow(lower, all.subspan(2), layout.views);
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
