#include "acus/assess/study/reference_page.h"

#include <algorithm>
#include <cmath>

#include "acus/assess/study/csv_cell.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/counted.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/base/report/markup.h"
#include "acus/run/training/progress.h"

namespace acus::study {
namespace {

std::string Short(double value) {
  return RoundedText(value, 3);
}

std::string RangeText(const std::optional<math::Interval>& range) {
  return range ? Message(" [", Short(range->low), ", ", Short(range->high), "]") : std::string();
}

std::vector<std::string> RowOf(const Standing& standing) {
  const bool has_earlier = !standing.earlier.empty();
  return {WithUnit(standing.metric), Short(standing.value),
          has_earlier ? Short(math::Median(standing.earlier)) + RangeText(standing.earlier_median)
                      : "-",
          Short(standing.group_mean) + RangeText(standing.group_interval),
          FixedText(standing.percentile, 0) + RangeText(standing.percentile_interval)};
}

const std::vector<std::string> kHeader = {"metric", "newest session", "earlier sessions, median",
                                          "group, mean", "percentile in the group"};

std::vector<std::vector<std::string>> RowsOfGoals(const GroupComparison& comparison) {
  std::vector<std::vector<std::string>> rows;
  for (const Standing& standing : comparison.standings) {
    if (standing.is_of_goal) rows.push_back(RowOf(standing));
  }
  return rows;
}

std::string GroupText(const GroupComparison& comparison) {
  return Message("Reference group: ", Counted(comparison.num_persons, "person"), ", ",
                 Counted(comparison.num_trials, "trial"),
                 comparison.num_persons < kFewestPersons ? "; too few persons for intervals" : "");
}

constexpr double kStripWidthPx = 640.0;
constexpr double kStripPx = 46.0;
constexpr double kStripLeftPx = 230.0;
constexpr double kStripRightPx = 620.0;

/// Maps the values of a strip to pixels.
class StripAxis {
 public:
  explicit StripAxis(const Standing& standing) : least_(standing.value), most_(standing.value) {
    for (const auto* values : {&standing.persons, &standing.earlier}) {
      for (const double value : *values) {
        least_ = std::min(least_, value);
        most_ = std::max(most_, value);
      }
    }
    if (most_ - least_ <= 0.0) most_ = least_ + std::max(1.0, std::abs(least_));
  }
  std::string Px(double value) const {
    const double share = (value - least_) / (most_ - least_);
    return FixedText(kStripLeftPx + share * (kStripRightPx - kStripLeftPx), 1);
  }
  double least() const { return least_; }
  double most() const { return most_; }

 private:
  double least_;
  double most_;
};

std::string Words(const std::string& x, double y, const std::string& text, const char* anchor) {
  return Message("<text x=\"", x, "\" y=\"", y, "\" text-anchor=\"", anchor, "\">",
                 report::Escaped(text), "</text>\n");
}

std::string Dot(const std::string& x, double y, double radius, const char* style) {
  return Message("<circle cx=\"", x, "\" cy=\"", y, "\" r=\"", radius, "\" ", style, "/>\n");
}

std::string StripSvg(const Standing& standing, double top) {
  const StripAxis axis(standing);
  const double middle = top + 0.4 * kStripPx;
  std::string svg =
      Words(FixedText(kStripLeftPx - 12.0, 1), middle + 4.0, WithUnit(standing.metric), "end");
  svg += Message("<line x1=\"", kStripLeftPx, "\" x2=\"", kStripRightPx, "\" y1=\"", middle,
                 "\" y2=\"", middle, "\" stroke=\"#ccc\"/>\n");
  if (standing.group_interval) {
    svg += Message("<line x1=\"", axis.Px(standing.group_interval->low), "\" x2=\"",
                   axis.Px(standing.group_interval->high), "\" y1=\"", middle, "\" y2=\"", middle,
                   "\" stroke=\"#3182bd\" stroke-width=\"9\" stroke-opacity=\"0.35\"/>\n");
  }
  for (const double person : standing.persons) {
    svg += Dot(axis.Px(person), middle, 4.0, "fill=\"#3182bd\" fill-opacity=\"0.6\"");
  }
  for (const double earlier : standing.earlier) {
    svg += Dot(axis.Px(earlier), middle + 8.0, 3.0, "fill=\"none\" stroke=\"#d95f0e\"");
  }
  svg += Dot(axis.Px(standing.value), middle, 6.0, "fill=\"#d95f0e\"");
  svg += Words(axis.Px(axis.least()), middle + 24.0, Short(axis.least()), "start");
  return svg + Words(axis.Px(axis.most()), middle + 24.0, Short(axis.most()), "end");
}

std::string StripsSvg(const GroupComparison& comparison) {
  std::string strips;
  double top = 0.0;
  for (const Standing& standing : comparison.standings) {
    if (!standing.is_of_goal) continue;
    strips += StripSvg(standing, top);
    top += kStripPx;
  }
  return Message("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", kStripWidthPx,
                 "\" height=\"", top, "\" viewBox=\"0 0 ", kStripWidthPx, " ", top,
                 "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#333\">\n", strips,
                 "</svg>\n");
}

std::string CellOf(const std::optional<math::Interval>& range) {
  return range ? NumberText(range->low) + ',' + NumberText(range->high) : std::string(",");
}

}  // namespace

std::string ReferenceText(const GroupComparison& comparison) {
  return GroupText(comparison) + "; intervals of 95 %\n" +
         TextTable(kHeader, RowsOfGoals(comparison));
}

std::string ReferenceCsv(const GroupComparison& comparison) {
  std::string csv =
      "trainee,exercise,metric,unit,value,earlier_sessions,earlier_median,earlier_low,earlier_high,"
      "persons,group_mean,group_low,group_high,percentile,percentile_low,percentile_high\n";
  for (const Standing& standing : comparison.standings) {
    csv += Message(CsvCell(comparison.code), ',', CsvCell(comparison.exercise), ',',
                   CsvCell(standing.metric.name), ',', CsvCell(standing.metric.unit), ',',
                   NumberText(standing.value), ',', standing.earlier.size(), ',');
    if (!standing.earlier.empty()) csv += NumberText(math::Median(standing.earlier));
    csv += ',' + CellOf(standing.earlier_median) + ',' +
           Message(standing.persons.size(), ',', NumberText(standing.group_mean), ',') +
           CellOf(standing.group_interval) + ',' + NumberText(standing.percentile) + ',' +
           CellOf(standing.percentile_interval) + '\n';
  }
  return csv;
}

void AddReferenceSection(const GroupComparison& comparison, report::HtmlReport& report) {
  report.Section("Newest session beside the reference group");
  report.Table(kHeader, RowsOfGoals(comparison),
               GroupText(comparison) +
                   ". Brackets: 95 % intervals. Percentile: share of the persons whose mean is "
                   "smaller.");
  report.Drawing(StripsSvg(comparison),
                 "Filled orange: the newest session; orange rings: earlier ones; blue: persons of "
                 "the group, and the interval of their mean.");
}

void WriteProgress(const std::filesystem::path& folder,
                   std::span<const training::Assessment> sessions,
                   const std::optional<GroupComparison>& group, const RunContext& context) {
  AtomicFolder made(folder, context.overwrite);
  training::WriteProgress(made.path(), sessions, context, [&](report::HtmlReport& report) {
    if (group) AddReferenceSection(*group, report);
  });
  if (group) WriteTextFile(made.path() / "reference.csv", ReferenceCsv(*group));
  made.Commit();
}

}  // namespace acus::study
