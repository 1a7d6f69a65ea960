#include "acus/run/replay/plan_diagram.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/report/markup.h"
#include "acus/base/report/plot_drawing.h"

namespace acus::replay {
namespace {

using report::Px;
using simulation::PlannedStage;
using simulation::StageTimes;

constexpr double kColumnPx = 150.0;
constexpr double kRowPx = 58.0;
constexpr double kBoxWidthPx = 112.0;
constexpr double kBoxHeightPx = 40.0;
constexpr double kTopPx = 46.0;
constexpr double kLeftPx = 8.0;
constexpr int kLastColumn = 7;  // Column of the outputs; inputs are in column 0.
constexpr double kItemPx = 17.0;
constexpr double kItemWidthPx = 118.0;

/// The position of a stage, in columns and rows: data flows from left to right.
struct Place {
  double column;
  double row;
};

/// Stages that every scene has, by their output.
std::optional<Place> FixedPlaceOf(const PlannedStage& stage) {
  namespace ports = effects::ports;
  const std::pair<effects::PortRef, Place> fixed[] = {
      {ports::kBreath, {1, 0}},     {ports::kNeedle, {1, 1.5}},  {ports::kProbe, {1, 5}},
      {ports::kTissue, {2, 0.7}},   {ports::kContact, {2, 2.3}}, {ports::kForce, {3, 1.5}},
      {ports::kProbeForce, {3, 4}}, {ports::kShape, {4, 0.7}},   {ports::kRestMap, {4, 2.6}},
      {ports::kCtImage, {5, 3.3}},  {ports::kBMode, {5, 5}}};
  for (const auto& [port, place] : fixed) {
    if (stage.writes.front() == port) return place;
  }
  return std::nullopt;
}

/// Places by the number of the stage. Stages of other effects are below: an effect in a row, with
/// its stages at every sample on the left and those at every image on the right.
std::vector<Place> PlacesOf(const std::vector<PlannedStage>& stages) {
  std::vector<Place> places;
  std::vector<std::string_view> rows;
  for (const PlannedStage& stage : stages) {
    if (const auto fixed = FixedPlaceOf(stage)) {
      places.push_back(*fixed);
      continue;
    }
    auto row = std::ranges::find(rows, stage.owner);
    if (row == rows.end()) row = rows.insert(rows.end(), stage.owner);
    places.push_back({stage.is_image() ? 6.0 : 1.0, 6.0 + static_cast<double>(row - rows.begin())});
  }
  return places;
}

double LeftOf(double column) {
  return kLeftPx + column * kColumnPx;
}

double MiddleOf(double row) {
  return kTopPx + row * kRowPx + 0.5 * kBoxHeightPx;
}

bool Holds(const std::vector<effects::PortRef>& ports, effects::PortRef port) {
  return std::ranges::find(ports, port) != ports.end();
}

/// An input or output of the plan: a word at the image's edge.
struct Item {
  effects::PortRef port;
  double wanted_px;  ///< Mean height of its stages.
  double y_px = 0.0;
};

/// Places items as near to their stages as their number allows, in the order of those.
void Spread(std::vector<Item>& items, double height_px) {
  std::ranges::stable_sort(items, {}, &Item::wanted_px);
  double free_px = kTopPx + 0.5 * kItemPx;
  for (Item& item : items) {
    item.y_px = std::max(item.wanted_px, free_px);
    free_px = item.y_px + kItemPx;
  }
  double limit_px = height_px - kItemPx;
  for (auto item = items.rbegin(); item != items.rend(); ++item) {
    item->y_px = std::min(item->y_px, limit_px);
    limit_px = item->y_px - kItemPx;
  }
}

class PlanDrawing {
 public:
  PlanDrawing(const simulation::EffectPlan& plan, const StageTimes& times)
      : plan_(plan), times_(times), places_(PlacesOf(plan.stages())) {
    double lowest_px = 0.0;
    for (const PlannedStage& stage : plan.stages()) {
      total_s_ += times.Of(stage).seconds;
      lowest_px = std::max(lowest_px, MiddleOf(PlaceOf(stage).row));
    }
    CollectInputs();
    CollectOutputs();
    height_px_ = std::max(lowest_px + kBoxHeightPx,
                          kTopPx + kItemPx * static_cast<double>(inputs_.size() + 1));
    Spread(inputs_, height_px_);
    Spread(outputs_, height_px_);
  }

  std::string Text() {
    out_ = Message(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 ", Px(WidthPx()), " ",
        Px(height_px_ + 24.0), "\" width=\"", Px(WidthPx()), "\" height=\"", Px(height_px_ + 24.0),
        "\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"11\" "
        "role=\"img\" aria-label=\"effect plan\">\n<defs><pattern id=\"asleep\" width=\"6\" "
        "height=\"6\" patternTransform=\"rotate(45)\" patternUnits=\"userSpaceOnUse\"><rect "
        "width=\"6\" height=\"6\" fill=\"#dfe7f1\"/><rect width=\"2\" height=\"6\" "
        "fill=\"#b9c8dc\"/></pattern></defs>\n<rect width=\"100%\" height=\"100%\" "
        "fill=\"#ffffff\"/>\n");
    Heading(0, "inputs");
    Heading(1, "stages at every sample and every image, as data flow");
    Heading(kLastColumn, "outputs");
    for (const PlannedStage& stage : plan_.stages()) {
      if (stage.in) DrawFlowInto(stage);
    }
    for (const Item& item : inputs_) DrawItem(item, 0);
    for (const Item& item : outputs_) DrawItem(item, kLastColumn);
    for (const PlannedStage& stage : plan_.stages()) DrawStage(stage);
    DrawKey();
    return out_ + "</svg>\n";
  }

 private:
  const Place& PlaceOf(const PlannedStage& stage) const { return places_[stage.number]; }

  static double WidthPx() { return LeftOf(kLastColumn) + kItemWidthPx + 12.0; }

  void CollectInputs() {
    for (const simulation::PlannedInput& input : plan_.inputs()) {
      double sum_px = 0.0;
      int readers = 0;
      for (const PlannedStage& stage : plan_.stages()) {
        if (!stage.in || !Holds(stage.reads, input.port)) continue;
        sum_px += MiddleOf(PlaceOf(stage).row);
        ++readers;
      }
      inputs_.push_back({input.port, sum_px / std::max(readers, 1)});
    }
  }

  /// The outputs for whose sake effects have stages.
  void CollectOutputs() {
    for (const PlannedStage& stage : plan_.stages()) {
      if (!stage.in || !stage.reason.starts_with("effect")) continue;
      outputs_.push_back({stage.writes.front(), MiddleOf(PlaceOf(stage).row)});
    }
  }

  void Heading(int column, const char* text) {
    out_ += report::TextAt(LeftOf(column), 18.0, text, "font-weight=\"bold\" fill=\"#444444\"");
  }

  void Curve(double x0, double y0, double x1, double y1, const char* colour) {
    const double bow = std::max(24.0, 0.4 * (x1 - x0));
    out_ += Message("<path d=\"M", Px(x0), " ", Px(y0), "C", Px(x0 + bow), " ", Px(y0), " ",
                    Px(x1 - bow), " ", Px(y1), " ", Px(x1), " ", Px(y1),
                    "\" fill=\"none\" stroke=\"", colour, "\"/>\n");
  }

  void DrawFlowInto(const PlannedStage& stage) {
    const Place to = PlaceOf(stage);
    const double x1 = LeftOf(to.column);
    const double y1 = MiddleOf(to.row);
    for (const Item& item : inputs_) {
      if (Holds(stage.reads, item.port)) {
        Curve(LeftOf(0) + kItemWidthPx, item.y_px, x1, y1, "#d3c7a8");
      }
    }
    for (const PlannedStage& writer : plan_.stages()) {
      if (!writer.in || !Holds(stage.reads, writer.writes.front())) continue;
      const Place from = PlaceOf(writer);
      if (from.column == to.column) {  // One below the other.
        const double x = LeftOf(to.column) + 0.5 * kBoxWidthPx;
        out_ += Message("<path d=\"M", Px(x), " ", Px(MiddleOf(from.row)), "V", Px(y1),
                        "\" stroke=\"#5b7fa8\"/>\n");
      } else {
        Curve(LeftOf(from.column) + kBoxWidthPx, MiddleOf(from.row), x1, y1, "#5b7fa8");
      }
    }
    for (const Item& item : outputs_) {
      if (!(stage.writes.front() == item.port)) continue;
      Curve(x1 + kBoxWidthPx, y1, LeftOf(kLastColumn), item.y_px, "#a9bf9f");
    }
  }

  void DrawItem(const Item& item, int column) {
    const char* fill = column == 0 ? "#f6f0df" : "#e6f0e0";
    out_ += Message("<rect x=\"", Px(LeftOf(column)), "\" y=\"", Px(item.y_px - 7.5), "\" width=\"",
                    Px(kItemWidthPx), "\" height=\"15\" rx=\"3\" fill=\"", fill, "\"/>\n");
    out_ += report::TextAt(LeftOf(column) + 5.0, item.y_px + 4.0, std::string(item.port.name()),
                           "fill=\"#1c1e21\"");
  }

  void Rect(double x, double y, double width, double height, const std::string& look) {
    out_ += Message("<rect x=\"", Px(x), "\" y=\"", Px(y), "\" width=\"", Px(width), "\" height=\"",
                    Px(height), "\" ", look, "/>\n");
  }

  void DrawStage(const PlannedStage& stage) {
    const double x = LeftOf(PlaceOf(stage).column);
    const double y = MiddleOf(PlaceOf(stage).row) - 0.5 * kBoxHeightPx;
    const StageTimes::Cost& cost = times_.Of(stage);
    out_ += Message("<g class=\"", stage.in ? "in" : "out", "\"><title>",
                    report::Escaped(Tooltip(stage)), "</title>\n");
    if (!stage.in) {
      Rect(x, y, kBoxWidthPx, kBoxHeightPx,
           "rx=\"4\" fill=\"#f4f4f4\" stroke=\"#cccccc\" stroke-dasharray=\"3 3\"");
      out_ += report::TextAt(x + 6.0, y + 15.0, std::string(stage.name), "fill=\"#a0a0a0\"");
      out_ +=
          report::TextAt(x + 6.0, y + 31.0, "out", "fill=\"#a0a0a0\" font-size=\"9\"") + "</g>\n";
      return;
    }
    Rect(x, y, kBoxWidthPx, kBoxHeightPx, "rx=\"4\" fill=\"#ffffff\"");
    const double runs = static_cast<double>(std::max<std::int64_t>(cost.runs, 1));
    const double asleep = static_cast<double>(cost.asleep) / runs;
    if (asleep > 0.0) {
      Rect(x + kBoxWidthPx * (1.0 - asleep), y, kBoxWidthPx * asleep, kBoxHeightPx - 6.0,
           "fill=\"url(#asleep)\"");
    }
    const double share = total_s_ > 0.0 ? cost.seconds / total_s_ : 0.0;
    Rect(x, y + kBoxHeightPx - 6.0, kBoxWidthPx, 6.0, "fill=\"#e8edf3\"");
    if (share > 0.0) {
      Rect(x, y + kBoxHeightPx - 6.0, kBoxWidthPx * share, 6.0, "fill=\"#c4532d\"");
    }
    Rect(x, y, kBoxWidthPx, kBoxHeightPx, "rx=\"4\" fill=\"none\" stroke=\"#35567d\"");
    out_ += report::TextAt(x + 6.0, y + 14.0, std::string(stage.name),
                           "fill=\"#1c1e21\" font-weight=\"bold\"");
    std::string numbers = FixedText(100.0 * share, 1) + " %";
    if (asleep > 0.0) numbers += ", asleep " + FixedText(100.0 * asleep, 0) + " %";
    out_ +=
        report::TextAt(x + 6.0, y + 27.0, numbers, "fill=\"#444444\" font-size=\"9\"") + "</g>\n";
  }

  std::string Tooltip(const PlannedStage& stage) const {
    std::string text = Message(stage.name, ": ", stage.in ? "in, " : "out, ", stage.reason);
    const StageTimes::Cost& cost = times_.Of(stage);
    for (std::size_t r = 0; r < cost.asleep_for.size(); ++r) {
      if (cost.asleep_for[r] == 0) continue;
      text += Message("; asleep in ", cost.asleep_for[r], " of ", cost.runs,
                      " runs: ", WordsOf(static_cast<simulation::Sleep>(r)));
    }
    return text;
  }

  void DrawKey() {
    const double y = height_px_ + 4.0;
    const auto entry = [&](double x, const std::string& look, const char* text) {
      Rect(x, y, 22.0, 11.0, look);
      out_ += report::TextAt(x + 28.0, y + 9.0, text, "fill=\"#444444\" font-size=\"10\"");
    };
    entry(LeftOf(1), "fill=\"#c4532d\"", "share of the stages' CPU time");
    entry(LeftOf(2.6), "fill=\"url(#asleep)\"", "share of runs asleep");
    entry(LeftOf(3.9), "fill=\"#f4f4f4\" stroke=\"#cccccc\" stroke-dasharray=\"3 3\"",
          "out: nothing called for needs it");
  }

  const simulation::EffectPlan& plan_;
  const StageTimes& times_;
  std::vector<Place> places_;  ///< By the number of the stage.
  double total_s_ = 0.0;
  double height_px_ = 0.0;
  std::vector<Item> inputs_;
  std::vector<Item> outputs_;
  std::string out_;
};

}  // namespace

std::string PlanSvg(const simulation::EffectPlan& plan, const StageTimes& times) {
  return PlanDrawing(plan, times).Text();
}

}  // namespace acus::replay
