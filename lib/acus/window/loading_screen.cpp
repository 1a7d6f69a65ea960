#include "acus/window/loading_screen.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "acus/base/core/monotonic_time.h"
#include "acus/base/translation/translation.h"
#include "acus/window/marks.h"
#include "acus/window/sketch_layer.h"

namespace acus::window {
namespace {

using translation::Translated;

/// Drawing takes time from what is being prepared.
constexpr std::int64_t kLoadingRedrawNs = 100'000'000;

void DrawLoading(const std::string& task, double fraction, int width_px, int height_px,
                 Sketch& sketch) {
  const TextSizes sizes = SizesFor(height_px);
  const int middle = width_px / 2;
  int row = height_px * 2 / 5;
  sketch.Fill({.left = 0, .top = 0, .width = width_px, .height = height_px}, palette::kBackground);
  sketch.Text({middle, row}, Translated("The session is being prepared."),
              {.size_px = sizes.large_px, .align = Align::kMiddle, .bold = true}, width_px - 40);
  row += 2 * sizes.large_px;
  sketch.Text({middle, row}, task,
              {.size_px = sizes.normal_px, .colour = palette::kFaint, .align = Align::kMiddle},
              width_px - 40);
  row += 2 * sizes.normal_px;
  Rectangle bar{
      .left = width_px / 3, .top = row, .width = width_px / 3, .height = sizes.small_px / 2};
  sketch.Fill(bar, palette::kRule);
  bar.width = static_cast<int>(std::lround(std::clamp(fraction, 0.0, 1.0) * bar.width));
  sketch.Fill(bar, palette::kNeedle);
}

}  // namespace

struct LoadingScreen::Content {
  std::unique_ptr<Screen> screen;
  FontAtlas atlas;
  Sketch sketch{atlas};
  SketchLayer layer{atlas};
  std::string task;
  std::int64_t drawn_ns = 0;
};

LoadingScreen::LoadingScreen(const WindowSettings& settings)
    : content_(std::make_unique<Content>()) {
  content_->screen =
      std::make_unique<Screen>(settings.title, settings.width_px, settings.height_px);
  content_->screen->Add(content_->layer.renderer(), 0);
  Show("", 0.0);
}

LoadingScreen::~LoadingScreen() {
  Release();
}

void LoadingScreen::Show(std::string_view task, double fraction) {
  Content& c = *content_;
  if (!c.screen) return;
  const std::int64_t now_ns = MonotonicNs();
  if (c.drawn_ns != 0 && task == c.task && now_ns - c.drawn_ns < kLoadingRedrawNs) return;
  c.task = task;
  c.drawn_ns = now_ns;
  c.screen->TakeEvents();
  c.sketch.Clear();
  DrawLoading(Translated(c.task), fraction, c.screen->width_px(), c.screen->height_px(), c.sketch);
  c.layer.Draw(c.sketch, c.screen->height_px());
  c.screen->Render();
}

RunContext LoadingScreen::Shown(const RunContext& context) {
  RunContext shown = context;
  shown.on_progress = [this, before = context.on_progress](std::string_view task, double fraction) {
    Show(task, fraction);
    if (before) before(task, fraction);
  };
  return shown;
}

std::unique_ptr<Screen> LoadingScreen::Release() {
  if (content_->screen) content_->screen->Remove(content_->layer.renderer());
  return std::move(content_->screen);
}

}  // namespace acus::window
