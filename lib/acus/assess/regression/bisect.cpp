#include "acus/assess/regression/bisect.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"

namespace acus::regression {
namespace {

namespace fs = std::filesystem;

CsvTable TraceOf(const fs::path& run, const char* name) {
  ACUS_REQUIRE(fs::exists(run / name), (run / name).string(),
               ": not there; replay with acus-replay --trace");
  return CsvTable(run / name);
}

/// Splits "needle force/depth_mm" into stage and variable.
void SetColumn(TraceDifference& difference, const std::string& column) {
  const std::size_t slash = column.find('/');
  difference.stage = slash == column.npos ? "session" : column.substr(0, slash);
  difference.variable = slash == column.npos ? column : column.substr(slash + 1);
}

/// Columns or rows that only one of the two has, if the common ones are equal.
std::optional<TraceDifference> LengthDifference(const CsvTable& a, const CsvTable& b,
                                                TraceDifference difference) {
  for (const auto& [one, other, is_a] : {std::tuple{&a, &b, true}, std::tuple{&b, &a, false}}) {
    for (const std::string& column : one->columns()) {
      if (other->Has(column)) continue;
      SetColumn(difference, column);
      difference.a = is_a ? "there" : "not there";
      difference.b = is_a ? "not there" : "there";
      return difference;
    }
  }
  if (a.num_rows() == b.num_rows()) return std::nullopt;
  difference.row = std::min(a.num_rows(), b.num_rows());
  difference.stage = "session";
  difference.variable = "number of rows";
  difference.a = std::to_string(a.num_rows());
  difference.b = std::to_string(b.num_rows());
  return difference;
}

std::optional<TraceDifference> FirstDifference(const CsvTable& a, const CsvTable& b,
                                               const char* trace) {
  TraceDifference first;
  first.trace = trace;
  std::size_t rows = std::min(a.num_rows(), b.num_rows());
  bool found = false;
  // In the order of stages: of two columns that differ first in the same row, the earlier is the
  // cause.
  for (const std::string& column : a.columns()) {
    if (!b.Has(column)) continue;
    const std::vector<std::string> of_a = a.Texts(column), of_b = b.Texts(column);
    const auto end = of_a.begin() + static_cast<std::ptrdiff_t>(rows);
    const auto at = std::mismatch(of_a.begin(), end, of_b.begin());
    if (at.first == end) continue;
    first.row = rows = static_cast<std::size_t>(at.first - of_a.begin());
    SetColumn(first, column);
    first.a = *at.first;
    first.b = *at.second;
    found = true;
  }
  if (!found) return LengthDifference(a, b, first);
  first.time_s = a.Texts("time_s")[first.row];
  return first;
}

std::string LineOf(const TraceDifference& d) {
  return Message("first different ", d.trace, ": number ", d.row,
                 d.time_s.empty() ? "" : ", at " + d.time_s + " s", ", stage ", d.stage,
                 ", variable ", d.variable, ": ", d.a, " | ", d.b, "\n");
}

}  // namespace

Bisection Bisect(const fs::path& run_a, const fs::path& run_b) {
  Bisection found;
  const CsvTable a = TraceOf(run_a, "trace.csv"), b = TraceOf(run_b, "trace.csv");
  found.num_steps = a.num_rows();
  found.step = FirstDifference(a, b, "step");
  constexpr const char* kImages = "image_trace.csv";
  if (fs::exists(run_a / kImages) || fs::exists(run_b / kImages)) {
    found.image = FirstDifference(TraceOf(run_a, kImages), TraceOf(run_b, kImages), "image");
  }
  return found;
}

std::string TextOf(const Bisection& found) {
  if (found.same()) return Message("the same in all ", found.num_steps, " steps and all images\n");
  return (found.step ? LineOf(*found.step)
                     : Message("all ", found.num_steps, " steps are the same\n")) +
         (found.image ? LineOf(*found.image) : "all images are the same\n");
}

}  // namespace acus::regression
