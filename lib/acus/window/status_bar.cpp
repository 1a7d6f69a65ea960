#include "acus/window/status_bar.h"

#include <algorithm>
#include <cmath>

#include "acus/base/translation/translation.h"
#include "acus/window/command.h"
#include "acus/window/exercise_panel.h"
#include "acus/window/orders.h"
#include "acus/window/severity_mark.h"

namespace acus::window {
namespace {

using translation::Translated;

/// A lower rate is visible; 29 in place of 30 images/s is not.
constexpr double kSlowImagesPerS = 27.0;

Eigen::Vector2i StatusBarCorner(int column, int row) {
  return {column, row};
}

std::string ClockText(double session_s) {
  const long seconds = std::isfinite(session_s) ? static_cast<long>(std::max(0.0, session_s)) : 0;
  const auto two = [](long n) { return (n < 10 ? "0" : "") + std::to_string(n); };
  return std::to_string(seconds / 60) + ":" + two(seconds % 60);
}

/// Inserts failed steps of the exercise before messages about the computer.
void AddFailedSteps(const ExerciseOnDisplay& exercise, std::vector<StatusLine>& lines) {
  std::size_t place = 0;
  for (const ExerciseOnDisplay::Step& step : exercise.steps) {
    if (step.state != training::StepState::kFailed) continue;
    lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(place++),
                 {.severity = Severity::kWarning,
                  .text = Translated("Failed: {1}.", {Translated(step.text)})});
  }
}

/// The next step of the exercise as a sentence; empty if there is none.
std::string NextStepText(const ExerciseOnDisplay& exercise) {
  if (exercise.next_step) {
    const std::string next =
        Translated("Next: {1}.", {Translated(exercise.steps[*exercise.next_step].text)});
    return exercise.how.empty() ? next : next + ' ' + exercise.how;
  }
  const auto is_done = [](const ExerciseOnDisplay::Step& step) {
    return step.state == training::StepState::kDone;
  };
  if (exercise.steps.empty()) return "";
  return std::ranges::all_of(exercise.steps, is_done)
             ? Translated("All steps are done: press Q twice to end the session.")
             : Translated("No step remains: press Q twice to end the session.");
}

/// What to do now: remove the first obstacle, otherwise the next step of the exercise.
std::string AdviceOf(const DisplayFrame& frame) {
  if (!frame.coach.empty()) return frame.coach;
  return frame.exercise ? NextStepText(*frame.exercise) : "";
}

/// All lines that fit.
void DrawLines(const DisplayFrame& frame, const ViewChoice& choice, const Rectangle& place,
               const TextSizes& sizes, Sketch& sketch) {
  const std::vector<StatusLine> lines = LinesToShow(frame, choice);
  const std::string advice = AdviceOf(frame);
  const bool is_calm = std::ranges::none_of(
      lines, [](const StatusLine& line) { return line.severity >= Severity::kWarning; });
  const int step = sketch.TextHeight(sizes.normal_px) + Scaled(7, sizes);
  const int text_left = place.left + Scaled(30, sizes);
  int row = place.top + 10;
  for (const StatusLine& line : lines) {
    if (row + step > place.top + place.height) break;
    const Colour colour = ColourOf(line.severity);
    const double half = 0.5 * sketch.TextHeight(sizes.normal_px);
    DrawMark(line.severity, {place.left + 16.0 * MarkScale(sizes), row + half}, 0.75 * half,
             sketch);
    const bool stands_out = line.severity >= Severity::kWarning;
    const TextStyle style{.size_px = sizes.normal_px,
                          .colour = stands_out            ? colour
                                    : line.text == advice ? palette::kNeedle
                                                          : palette::kText,
                          .bold = is_calm && line.text == advice};
    const int room = place.width - Scaled(40, sizes);
    const auto pieces =
        Wrapped(line.text, sizes.normal_px, room - room / 12, sketch);  // Bold is wider.
    for (const std::string& piece : pieces) {
      if (row + step > place.top + place.height) break;
      sketch.Text(StatusBarCorner(text_left, row), piece, style, room);
      row += step - (&piece == &pieces.back() ? 0 : 4);
    }
  }
}

void DrawForce(std::string_view name, const std::optional<double>& force_n, double limit_n,
               bool with_number, const Rectangle& place, const TextSizes& sizes, Sketch& sketch) {
  const bool known = force_n && std::isfinite(*force_n);
  sketch.Text(StatusBarCorner(place.left, place.top), name,
              {.size_px = sizes.small_px, .colour = palette::kFaint});
  if (with_number) {
    sketch.Text(StatusBarCorner(place.left + place.width, place.top),
                known ? Digits(*force_n, 2) + " N" : "-",
                {.size_px = sizes.small_px, .align = Align::kRight});
  }
  const Rectangle bar{.left = place.left,
                      .top = place.top + sketch.TextHeight(sizes.small_px) + 3,
                      .width = place.width,
                      .height = Scaled(6, sizes)};
  sketch.Fill(bar, palette::kRule);
  if (!known || !(limit_n > 0.0)) return;
  const double share = std::clamp(*force_n / limit_n, 0.0, 1.0);
  Rectangle filled = bar;
  filled.width = static_cast<int>(std::lround(share * bar.width));
  sketch.Fill(filled, share >= 0.99   ? palette::kFault
                      : share >= 0.75 ? palette::kWarning
                                      : palette::kGood);
}

void DrawDistance(const DisplayFrame& frame, const Rectangle& place, const TextSizes& sizes,
                  Sketch& sketch) {
  const auto& distance = frame.tip_to_target_mm;
  const int middle = place.left + place.width / 2;
  sketch.Text(StatusBarCorner(middle, place.top), Translated("Tip to target"),
              {.size_px = sizes.small_px, .colour = palette::kFaint, .align = Align::kMiddle},
              place.width);
  sketch.Text(StatusBarCorner(middle, place.top + sketch.TextHeight(sizes.small_px) + 3),
              distance ? Digits(*distance, *distance < 9.95 ? 1 : 0) + " mm" : "-",
              {.size_px = sizes.large_px,
               .colour = distance ? palette::kText : palette::kFaint,
               .align = Align::kMiddle,
               .bold = true},
              place.width);
}

std::string VolumeText(const VolumeReadout& volume) {
  if (volume.whole) return Translated("all pixels");
  std::string text = volume.per_s > 0.0 ? Digits(volume.per_s, volume.per_s < 2.0 ? 1 : 0) : "-";
  text += " /s";
  if (!volume.rays_on.empty()) text += ", " + Translated("card");
  if (volume.dropped > 0) {
    text += ", " + Translated("{1} dropped", {std::to_string(volume.dropped)});
  }
  return text;
}

/// Rows of a name on the left and a value on the right.
class Rows {
 public:
  Rows(const Rectangle& place, const TextSizes& sizes, Sketch& sketch)
      : place_(place), sizes_(sizes), sketch_(sketch), row_(place.top) {}

  void Add(const std::string& name, const std::string& value, Colour colour = palette::kText) {
    const int step = sketch_.TextHeight(sizes_.small_px) + 4;
    if (row_ + step > place_.top + place_.height) return;
    const int room = place_.width - sketch_.TextWidth(value, sizes_.small_px) - 6;
    if (room > 16) {
      sketch_.Text(StatusBarCorner(place_.left, row_), name,
                   {.size_px = sizes_.small_px, .colour = palette::kFaint}, room);
    }
    sketch_.Text(StatusBarCorner(place_.left + place_.width, row_), value,
                 {.size_px = sizes_.small_px, .colour = colour, .align = Align::kRight});
    row_ += step;
  }

 private:
  Rectangle place_;
  TextSizes sizes_;
  Sketch& sketch_;
  int row_;
};

/// What the trainee needs: time, and which tool mouse and keys move.
void DrawState(const DisplayFrame& frame, const ViewChoice& choice, Rows& rows) {
  rows.Add(Translated("Time"), ClockText(frame.session_s));
  rows.Add(Translated("Keys move"),
           choice.steers_probe ? Translated("the probe") : Translated("the needle"));
  if (frame.left_handed) rows.Add(Translated("Hands"), Translated("left-handed"));
  if (frame.breath_held) rows.Add(Translated("Breath"), Translated("held"));
}

/// What whoever looks after the computer needs.
void DrawFigures(const DisplayFrame& frame, const std::optional<VolumeReadout>& volume,
                 Rows& rows) {
  const Latency& latency = frame.latency;
  const auto known = [](double value, int digits, const char* unit) {
    return value > 0.0 && std::isfinite(value) ? Digits(value, digits) + unit : std::string("-");
  };
  rows.Add(Translated("Device to force"), known(latency.device_to_force_ms, 2, " ms"));
  rows.Add(Translated("Tracker to image"), known(latency.tracker_to_image_ms, 0, " ms"));
  const bool slow = latency.images_per_s > 0.0 && latency.images_per_s < kSlowImagesPerS;
  std::string images = known(latency.images_per_s, 0, " /s");
  if (latency.late_images > 0) {
    images += ", " + Translated("{1} late", {std::to_string(latency.late_images)});
  }
  rows.Add(Translated("Images"), images, slow ? palette::kWarning : palette::kText);
  if (frame.video) {
    rows.Add(Translated("Camera"),
             Translated("{1} dropped", {std::to_string(latency.dropped_of_camera)}));
  }
  if (volume) rows.Add(Translated("Volume"), VolumeText(*volume));
}

}  // namespace

std::vector<StatusLine> LinesToShow(const DisplayFrame& frame, const ViewChoice& choice) {
  std::vector<StatusLine> lines = frame.status;
  if (choice.quit_asked) {
    lines.insert(lines.begin(), {.severity = Severity::kFault,
                                 .text = Translated("Press Q again to end the session.")});
  }
  if (frame.exercise) AddFailedSteps(*frame.exercise, lines);
  if (const std::string advice = AdviceOf(frame); !advice.empty()) {
    lines.insert(lines.begin(), {.severity = Severity::kNote, .text = advice});
  } else if (lines.empty()) {
    lines.push_back({.severity = Severity::kGood, .text = Translated("All is well.")});
  }
  // Good states come after messages, faults before.
  std::ranges::stable_sort(lines, std::ranges::greater(), [](const StatusLine& line) {
    return std::max(line.severity, Severity::kNote);
  });
  return lines;
}

void DrawStatusBar(const DisplayFrame& frame, const ViewChoice& choice,
                   const std::optional<VolumeReadout>& volume, const Rectangle& place,
                   const TextSizes& sizes, Sketch& sketch) {
  sketch.SetClip(place);
  sketch.Fill(place, palette::kBackground);
  Rectangle rule = place;
  rule.height = 1;
  sketch.Fill(rule, palette::kRule);
  const int numbers_width = std::min(15 * sizes.small_px, place.width / 4);
  const int middle_width = std::min(12 * sizes.small_px, place.width / 5);
  Rectangle part = place;
  part.left = place.width - numbers_width - 12;
  part.width = numbers_width;
  part.top += 8;
  part.height -= 10;
  Rows rows(part, sizes, sketch);
  DrawState(frame, choice, rows);
  if (choice.figures) {
    DrawFigures(frame, volume, rows);
  } else {
    rows.Add(Translated("Keys"), "H");
    rows.Add(Translated("Figures"), "E");
  }
  part.left -= middle_width + 28;
  part.width = middle_width;
  DrawForce(Translated("Needle"), frame.force.needle_n, frame.force.limit_n, choice.figures, part,
            sizes, sketch);
  part.top += sketch.TextHeight(sizes.small_px) + Scaled(16, sizes);
  if (frame.force.plunger_n) {
    DrawForce(Translated("Plunger (I)"), frame.force.plunger_n, kMostThumbN, choice.figures, part,
              sizes, sketch);
  } else {
    DrawForce(Translated("Probe"), frame.force.probe_n, frame.force.limit_n, choice.figures, part,
              sizes, sketch);
  }
  part.top = place.top + 12;
  part.left -= middle_width + 20;
  DrawDistance(frame, part, sizes, sketch);
  Rectangle lines = place;
  lines.width = part.left - 12;
  DrawLines(frame, choice, lines, sizes, sketch);
}

void DrawHelp(const Rectangle& window, const TextSizes& sizes, Sketch& sketch) {
  const int step = sketch.TextHeight(sizes.normal_px) + 6;
  const int rows = static_cast<int>(Keys().size()) + 8;
  const int width = std::min(window.width - 20, 44 * sizes.normal_px);
  const int height = std::min(window.height - 20, rows * step + 10);
  const Rectangle page{.left = window.left + (window.width - width) / 2,
                       .top = window.top + (window.height - height) / 2,
                       .width = width,
                       .height = height};
  sketch.Fill(page, {.red = 15, .green = 19, .blue = 24, .opacity = 238});
  sketch.Frame(page, palette::kRule);
  int row = page.top + 14;
  const int key_column = page.left + 24;
  const int text_column = page.left + 24 + 8 * sizes.normal_px;
  const auto line = [&](std::string_view keys, std::string_view text) {
    if (row + step > page.top + page.height) return;
    sketch.Text(StatusBarCorner(key_column, row), keys,
                {.size_px = sizes.normal_px, .colour = palette::kNeedle, .bold = true});
    sketch.Text(StatusBarCorner(text_column, row), text, {.size_px = sizes.normal_px},
                page.left + page.width - text_column - 16);
    row += step;
  };
  sketch.Text(StatusBarCorner(key_column, row), Translated("Keys"),
              {.size_px = sizes.large_px, .bold = true});
  row += sketch.TextHeight(sizes.large_px, true) + 10;
  for (const KeyHelp& key : Keys()) line(key.keys, Translated(key.text));
  line(Translated("Space"),
       Translated("pedal: forces are on while it is held, where a pedal is required"));
  row += step / 3;
  line(Translated("Mouse"), Translated("in 3D: left turns, middle shifts, right and wheel zoom"));
  line("", Translated("elsewhere: left moves the tool, right turns it, wheel advances it"));
  line(Translated("Arrows"),
       Translated("move the tool; Page Down and Page Up advance it; Shift: finely"));
}

}  // namespace acus::window
