#include "acus/window/exercise_panel.h"

#include <algorithm>
#include <sstream>

#include "acus/base/core/text_table.h"
#include "acus/base/translation/translation.h"
#include "acus/window/severity_mark.h"

namespace acus::window {
namespace {

using translation::Translated;

std::string WithUnit(const std::string& number, const std::string& unit) {
  return unit.empty() ? number : number + ' ' + unit;
}

/// As training::GoalText(), translated.
std::string LimitText(const training::Goal& goal, const std::string& unit) {
  const auto number = [&](double value) { return WithUnit(RoundedText(value, 6), unit); };
  const std::string most =
      goal.at_most ? Translated("at most {1}", {number(*goal.at_most)}) : std::string();
  if (!goal.at_least) return most;
  const std::string least = Translated("at least {1}", {number(*goal.at_least)});
  return most.empty() ? least : least + ", " + most;
}

ExerciseOnDisplay::Goal GoalToShow(const replay::GoalNow& goal) {
  const training::GoalResult& result = goal.result;
  ExerciseOnDisplay::Goal out;
  out.name = result.goal.metric;
  out.limit = LimitText(result.goal, result.unit);
  if (goal.at_end) {
    out.value = Translated("in the report");
  } else if (result.goal.metric.starts_with("tip to target") && result.value) {
    // Its number is of another time than the distance shown: the window shows one distance only.
    out.value = result.met ? Translated("met so far") : Translated("not yet");
    out.severity = result.met ? Severity::kGood : Severity::kNote;
  } else if (result.value) {
    out.value = WithUnit(RoundedText(*result.value, 3), result.unit);
    out.severity = result.met ? Severity::kGood : Severity::kWarning;
  } else {
    out.value = "-";
  }
  return out;
}

/// Writes rows from the top down.
class Column {
 public:
  Column(const Rectangle& place, const TextSizes& sizes, Sketch& sketch)
      : place_(place), sizes_(sizes), sketch_(sketch), row_(place.top + Px(8)) {}

  bool HasRoom(int height_px) const { return row_ + height_px <= place_.top + place_.height; }
  int RowPx() const { return sketch_.TextHeight(sizes_.small_px) + Px(3); }
  int IndentPx() const { return Px(14); }
  int RoomLeft() const { return place_.top + place_.height - row_; }

  void Heading(const std::string& text) {
    row_ += Px(6);
    Text(text, palette::kFaint, 0, true);
  }
  void Text(const std::string& text, Colour colour, int indent_px, bool bold = false) {
    for (const std::string& line :
         Wrapped(text, sizes_.small_px, place_.width - Px(24) - indent_px, sketch_)) {
      if (!HasRoom(RowPx())) return;
      sketch_.Text(Corner(Px(12) + indent_px), line,
                   {.size_px = sizes_.small_px, .colour = colour, .bold = bold},
                   place_.width - Px(24) - indent_px);
      row_ += RowPx();
    }
  }
  /// A dot, a name and on the right a value.
  void Pair(Severity severity, const std::string& name, const std::string& value, Colour colour) {
    if (!HasRoom(RowPx())) return;
    Mark(severity);
    const int value_px = sketch_.TextWidth(value, sizes_.small_px);
    const int room = place_.width - Px(24) - IndentPx();
    sketch_.Text({place_.left + place_.width - Px(12), row_}, value,
                 {.size_px = sizes_.small_px, .colour = colour, .align = Align::kRight}, room);
    if (room - value_px - 8 > 20) {
      sketch_.Text(Corner(Px(12) + IndentPx()), name, {.size_px = sizes_.small_px},
                   room - value_px - 8);
    }
    row_ += RowPx();
  }
  /// @param state  As DrawMark() takes them.
  template <typename... State>
  void Mark(State... state) {
    const double half = 0.5 * sketch_.TextHeight(sizes_.small_px);
    DrawMark(state..., {place_.left + 16.0 * MarkScale(sizes_), row_ + half}, 0.7 * half, sketch_);
  }

 private:
  int Px(int px) const { return Scaled(px, sizes_); }
  Eigen::Vector2i Corner(int indent_px) const { return {place_.left + indent_px, row_}; }

  Rectangle place_;
  TextSizes sizes_;
  Sketch& sketch_;
  int row_;
};

void DrawSteps(const ExerciseOnDisplay& exercise, Column& column) {
  if (exercise.steps.empty()) return;
  column.Heading(Translated("Steps"));
  for (std::size_t i = 0; i < exercise.steps.size(); ++i) {
    const ExerciseOnDisplay::Step& step = exercise.steps[i];
    const bool is_next = exercise.next_step == i;
    if (!column.HasRoom(column.RowPx())) return;
    column.Mark(step.state, is_next);
    column.Text(Translated(step.text),
                is_next                                      ? palette::kText
                : step.state == training::StepState::kFailed ? palette::kFault
                                                             : palette::kFaint,
                column.IndentPx(), is_next);
    if (is_next && !exercise.hint.empty()) {
      column.Text(Translated(exercise.hint), palette::kNeedle, column.IndentPx());
    }
  }
}

void DrawGoals(const ExerciseOnDisplay& exercise, Column& column) {
  if (exercise.goals.empty()) return;
  column.Heading(Translated("Goals"));
  const int needed = 2 * static_cast<int>(exercise.goals.size()) + 1;
  const bool has_room = column.RoomLeft() >= needed * column.RowPx();
  for (const ExerciseOnDisplay::Goal& goal : exercise.goals) {
    column.Pair(goal.severity, Translated(goal.name), goal.value,
                goal.severity == Severity::kNote ? palette::kFaint : ColourOf(goal.severity));
    if (has_room) column.Text(goal.limit, palette::kFaint, column.IndentPx());
  }
}

}  // namespace

std::vector<std::string> Wrapped(const std::string& text, int size_px, int room_px,
                                 const Sketch& sketch) {
  std::vector<std::string> lines;
  std::istringstream words(text);
  std::string line;
  for (std::string word; words >> word;) {
    const std::string longer = line.empty() ? word : line + ' ' + word;
    if (!line.empty() && sketch.TextWidth(longer, size_px) > room_px) {
      lines.push_back(line);
      line = word;
    } else {
      line = longer;
    }
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

ExerciseOnDisplay ExerciseToShow(const training::Exercise& exercise,
                                 const replay::ExerciseProgress& progress,
                                 const std::optional<double>& tip_to_target_mm, int trial) {
  ExerciseOnDisplay out;
  out.name = exercise.name;
  out.target = exercise.target_name;
  out.target_reached = tip_to_target_mm && *tip_to_target_mm <= exercise.target_radius_mm;
  for (const replay::GoalNow& goal : progress.goals) out.goals.push_back(GoalToShow(goal));
  for (const training::StepResult& step : progress.checklist) {
    out.steps.push_back({step.text, step.state});
  }
  out.next_step = training::NextStep(progress.checklist);
  if (out.next_step && ShowsHint(exercise.hints, trial, progress.next_step_for_s)) {
    out.hint = exercise.checklist.steps[*out.next_step].hint;
  }
  return out;
}

void DrawExercise(const ExerciseOnDisplay& exercise, const Rectangle& place, const TextSizes& sizes,
                  Sketch& sketch) {
  if (place.empty()) return;
  sketch.SetClip(place);
  sketch.Fill(place, palette::kBackground);
  Column column(place, sizes, sketch);
  column.Text(Translated(exercise.name), palette::kText, 0, true);
  if (!exercise.caption.empty()) column.Text(exercise.caption, palette::kFaint, 0);
  const std::string target = Translated(exercise.target);
  column.Text(exercise.target_reached ? Translated("At the target: {1}", {target})
                                      : Translated("Target: {1}", {target}),
              exercise.target_reached ? palette::kGood : palette::kText, 0);
  DrawSteps(exercise, column);
  DrawGoals(exercise, column);
}

}  // namespace acus::window
