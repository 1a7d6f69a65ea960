#include "benchmarks/measured_tables.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"
#include "acus/base/report/svg_plot.h"

namespace acus::benchmarks {
namespace {

std::string One(const std::vector<AskedLine>& lines, const std::string& key,
                const std::string& otherwise) {
  const auto found = std::ranges::find(lines, key, &AskedLine::key);
  return found == lines.end() ? otherwise : found->name;
}

std::vector<AskedLine> All(const std::vector<AskedLine>& lines, const std::string& key) {
  std::vector<AskedLine> out;
  std::ranges::copy_if(lines, std::back_inserter(out),
                       [&](const AskedLine& line) { return line.key == key; });
  ACUS_REQUIRE(!out.empty(), "a line '", key, " ...' is missing");
  return out;
}

std::vector<std::string> ValuesOf(const std::vector<Row>& rows, const std::string& knob) {
  std::vector<std::string> values;
  for (const Row& row : rows) {
    if (row.knob == knob && std::ranges::find(values, row.value) == values.end()) {
      values.push_back(row.value);
    }
  }
  ACUS_REQUIRE(!values.empty(), "the sweep has no knob '", knob, "'");
  return values;
}

/// Of this knob and value, and of the unit that the field wants; null if there is none.
const Row* Find(const std::vector<Row>& rows, const std::string& knob, const std::string& value,
                const RowField& field) {
  const auto found = std::ranges::find_if(rows, [&](const Row& row) {
    return row.knob == knob && row.value == value && field.IsOf(row);
  });
  return found == rows.end() ? nullptr : &*found;
}

/// A '|' would make a cell in Markdown.
std::string ValueText(std::string text) {
  std::ranges::replace(text, '|', '/');
  return text;
}

std::string MarkdownRow(const std::vector<std::string>& cells) {
  return "| " + Joined(cells, " | ") + " |\n";
}

std::string Header(const std::vector<std::string>& cells) {
  std::string rule = "|";
  for (std::size_t n = 0; n < cells.size(); ++n) rule += "---|";
  return MarkdownRow(cells) + rule + "\n";
}

report::Series Points(const std::string& name) {
  return {.name = name, .style = report::Style::kPoints};
}

void AddTo(report::Series& series, double x, double y) {
  series.x.push_back(x);
  series.y.push_back(y);
}

/// The curves of one figure, and the dots on them.
class Figure {
 public:
  Figure(const std::vector<AskedLine>& lines, const std::vector<Row>& rows)
      : rows_(rows), x_(All(lines, "x")[0].name), y_(All(lines, "y")[0].name) {
    plot_.title = One(lines, "title", "");
    plot_.x_label = All(lines, "x")[0].meaning;
    plot_.y_label = All(lines, "y")[0].meaning;
    plot_.log_x = plot_.log_y = true;
    for (const AskedLine& line : lines) {
      if (line.key == "linear") (line.name == "x" ? plot_.log_x : plot_.log_y) = false;
    }
    plot_.height_px = 340;
    for (const AskedLine& line : lines) {
      if (line.key == "line" || line.key == "points") knobs_.push_back(line);
    }
    ACUS_REQUIRE(!knobs_.empty(), "a line 'line KNOB' or 'points KNOB' is missing");
  }

  std::string Svg() {
    for (const AskedLine& knob : knobs_) {
      for (const std::string& value : ValuesOf(rows_, knob.name)) {
        const Row* row = Find(rows_, knob.name, value, y_);
        if (row == nullptr || !row->unusable.empty() || !std::isfinite(y_.Of(*row))) continue;
        largest_ = std::max(largest_, y_.Of(*row));
      }
    }
    for (const AskedLine& knob : knobs_) AddKnob(knob);
    for (report::Series* series : {&ours_, &papers_}) {
      if (!series->x.empty()) plot_.series.push_back(std::move(*series));
    }
    return report::SvgText(plot_);
  }

 private:
  void AddKnob(const AskedLine& knob) {
    report::Series line{.name = knob.meaning};
    for (const std::string& value : ValuesOf(rows_, knob.name)) {
      const Row* row = Find(rows_, knob.name, value, y_);
      if (row == nullptr || !row->unusable.empty()) continue;
      const double x = x_.Of(*row);
      const double y = y_.Of(*row);
      if (!std::isfinite(x) || !std::isfinite(y)) continue;
      if (plot_.log_x && x <= 0.0) continue;
      if (plot_.log_y && y <= 1e-4 * largest_) continue;  // Rounding: it would stretch the axis.
      if (knob.key == "points") {                         // A mark would lie on the dot.
        const char* mark = row->is_default ? " (default)" : row->is_paper ? " (paper)" : "";
        plot_.series.push_back(Points(ValueText(value) + mark));
        AddTo(plot_.series.back(), x, y);
        continue;
      }
      if (row->is_default) AddTo(ours_, x, y);
      if (row->is_paper) AddTo(papers_, x, y);
      AddTo(line, x, y);
    }
    if (!line.x.empty()) plot_.series.push_back(std::move(line));
  }

  const std::vector<Row>& rows_;
  RowField x_;
  RowField y_;
  report::Plot plot_;
  std::vector<AskedLine> knobs_;
  double largest_ = 0.0;
  report::Series ours_ = Points("default");
  report::Series papers_ = Points("paper");
};

}  // namespace

std::string Shown(double value) {
  if (!std::isfinite(value)) return "–";
  return std::abs(value) < 1e-9 ? "0" : RoundedText(value, 2);
}

std::vector<AskedLine> AskedLines(std::string_view lines, std::string_view keys) {
  const auto known = Parts(keys, ' ');
  std::vector<AskedLine> out;
  for (const std::string& text : Parts(lines, '\n')) {
    if (text.empty()) continue;
    const auto blank = text.find(' ');
    AskedLine line{.key = text.substr(0, blank), .name = {}, .meaning = {}};
    ACUS_REQUIRE(std::ranges::find(known, line.key) != known.end(), "'", text,
                 "': must begin with one of: ", keys);
    if (blank != text.npos) line.name = Trimmed(text.substr(blank));
    line.meaning = line.name;
    if (const auto equals = line.name.find(" = "); equals != line.name.npos) {
      line.meaning = Trimmed(line.name.substr(equals + 3));
      line.name = Trimmed(line.name.substr(0, equals));
    }
    out.push_back(std::move(line));
  }
  return out;
}

std::string SettingsTable(std::string_view asked, const PageData& data) {
  const auto lines = AskedLines(asked, "sweep knob column");
  const auto& rows = data.Sweep(One(lines, "sweep", ""));
  const auto knobs = All(lines, "knob");
  const auto columns = All(lines, "column");
  std::vector<std::string> head;
  knobs.size() > 1 ? head = {"knob", "value"} : head = {knobs[0].meaning};
  for (const AskedLine& column : columns) head.push_back(column.name);
  std::string text = Header(head);
  for (const AskedLine& knob : knobs) {
    for (const std::string& value : ValuesOf(rows, knob.name)) {
      std::string shown = ValueText(value);
      std::vector<std::string> cells;
      bool is_default = false, is_paper = false, unusable = false;
      for (const AskedLine& column : columns) {
        const RowField field(column.meaning);
        const Row* row = Find(rows, knob.name, value, field);
        cells.push_back(row == nullptr ? "" : Shown(field.Of(*row)));
        if (row == nullptr) continue;
        is_default = is_default || row->is_default;
        is_paper = is_paper || row->is_paper;
        unusable = unusable || !row->unusable.empty();
      }
      if (is_default) shown = "**" + shown + "**";
      if (is_paper) shown += " (paper)";
      if (unusable) shown += " (unusable)";
      cells.insert(cells.begin(), shown);
      if (knobs.size() > 1) cells.insert(cells.begin(), knob.meaning);
      text += MarkdownRow(cells);
    }
  }
  return text;
}

std::string ValuesTable(std::string_view asked, const PageData& data) {
  const auto lines = AskedLines(asked, "sweep title at row cell column unusable");
  const auto& rows = data.Sweep(One(lines, "sweep", ""));
  const std::string unusable = One(lines, "unusable", "unusable");
  std::vector<std::string> head{One(lines, "title", "")};
  for (const AskedLine& at : All(lines, "at")) head.push_back(at.meaning);
  for (const AskedLine& line : lines) {
    if (line.key == "column") head.push_back(line.name);
  }
  std::string text = Header(head);
  const auto shown = [&](const std::string& knob, const std::string& value, const RowField& field) {
    const Row* row = Find(rows, knob, value, field);
    if (row == nullptr) return std::string("–");
    return row->unusable.empty() ? Shown(field.Of(*row)) : unusable;
  };
  for (const AskedLine& knob : All(lines, "row")) {
    ValuesOf(rows, knob.name);
    std::vector<std::string> cells{knob.meaning};
    for (const AskedLine& at : All(lines, "at")) {
      std::vector<std::string> parts;
      for (const AskedLine& cell : All(lines, "cell")) {
        const std::string part = shown(knob.name, at.name, RowField(cell.name));
        if (parts.empty() || part != unusable) parts.push_back(part);
      }
      cells.push_back(Joined(parts, " / "));
    }
    for (const AskedLine& column : lines) {
      if (column.key != "column") continue;
      const auto field_at = Parts(column.meaning, '@');
      ACUS_REQUIRE(field_at.size() == 2, "'", column.meaning, "': must be FIELD @ value");
      cells.push_back(shown(knob.name, field_at[1], RowField(field_at[0])));
    }
    text += MarkdownRow(cells);
  }
  return text;
}

std::string FigureSvg(std::string_view asked, const PageData& data) {
  const auto lines = AskedLines(asked, "sweep title x y line points linear");
  return Figure(lines, data.Sweep(One(lines, "sweep", ""))).Svg();
}

}  // namespace acus::benchmarks
