#include "acus/assess/regression/comparison/compare_forces.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/words.h"

namespace acus::comparison {
namespace {

/// Row numbers of samples that both tables have.
struct SharedRows {
  std::vector<std::size_t> a;
  std::vector<std::size_t> b;
};

std::vector<double> Times(const CsvTable& table) {
  std::vector<double> times_s = table.Numbers("time_s");
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    ACUS_REQUIRE(times_s[i] > times_s[i - 1], table.Where(i), ": time_s is ", times_s[i],
                 ", not after ", times_s[i - 1], " of the row before");
  }
  return times_s;
}

SharedRows Share(const std::vector<double>& a_s, const std::vector<double>& b_s,
                 double tolerance_s) {
  SharedRows rows;
  for (std::size_t i = 0, j = 0; i < a_s.size() && j < b_s.size();) {
    if (std::abs(a_s[i] - b_s[j]) <= tolerance_s) {
      rows.a.push_back(i++);
      rows.b.push_back(j++);
    } else if (a_s[i] < b_s[j]) {
      ++i;
    } else {
      ++j;
    }
  }
  return rows;
}

std::vector<std::string> OnlyIn(const CsvTable& table, const CsvTable& other) {
  std::vector<std::string> names;
  for (const std::string& name : table.columns()) {
    if (!other.Has(name)) names.push_back(name);
  }
  return names;
}

Check CompareColumns(const CsvTable& a, const CsvTable& b, const std::string& name) {
  const auto only_a = OnlyIn(a, b);
  const auto only_b = OnlyIn(b, a);
  std::string remark;
  if (!only_a.empty()) remark = "only in A: " + Joined(only_a);
  if (!only_b.empty())
    remark += (remark.empty() ? "only in B: " : "; only in B: ") + Joined(only_b);
  return remark.empty() ? Verdict(name + ": columns", true, remark)
                        : OnlyInOne(name + ": columns", remark);
}

template <typename T>
std::vector<T> Taken(const std::vector<T>& values, const std::vector<std::size_t>& rows) {
  std::vector<T> taken;
  taken.reserve(rows.size());
  for (const std::size_t row : rows) taken.push_back(values[row]);
  return taken;
}

struct Difference {
  double rms = 0.0;
  double max = 0.0;
  double time_of_max_s = 0.0;
};

Difference DifferenceOf(const std::vector<double>& a, const std::vector<double>& b,
                        const std::vector<double>& time_s) {
  Difference difference;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double delta = std::abs(a[i] - b[i]);
    sum += delta * delta;
    if (delta <= difference.max) continue;
    difference.max = delta;
    difference.time_of_max_s = time_s[i];
  }
  difference.rms = std::sqrt(sum / static_cast<double>(a.size()));
  return difference;
}

std::string At(const Difference& difference) {
  return difference.max > 0.0 ? Message("at ", difference.time_of_max_s, " s") : "";
}

Check CompareTissue(const std::vector<std::string>& a, const std::vector<std::string>& b,
                    const std::vector<double>& time_s, double limit_percent) {
  std::size_t count = 0;
  std::string first;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] == b[i]) continue;
    if (count++ == 0) first = Message("first at ", time_s[i], " s: ", a[i], " | ", b[i]);
  }
  const double percent = 100.0 * static_cast<double>(count) / static_cast<double>(a.size());
  return AtMost("tissue: samples that differ", "%", percent, limit_percent, first);
}

struct Event {
  double time_s;
  std::string name;
};

std::vector<Event> EventsOf(const CsvTable& table, const std::vector<double>& times_s) {
  std::vector<Event> events;
  const std::vector<std::string> names = table.Texts("event");
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!names[i].empty()) events.push_back({times_s[i], names[i]});
  }
  return events;
}

/// Names and order first: times can be compared only if those agree.
void CompareEvents(const std::vector<Event>& a, const std::vector<Event>& b, double limit_s,
                   std::vector<Check>& checks) {
  const auto text = [](const std::vector<Event>& events, std::size_t i) {
    return i < events.size() ? Message(events[i].name, " at ", events[i].time_s, " s")
                             : std::string("none");
  };
  double latest_s = 0.0;
  std::string where;
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    if (i >= a.size() || i >= b.size() || a[i].name != b[i].name) {
      checks.push_back(
          Verdict("events", false, Message("number ", i + 1, ": ", text(a, i), " | ", text(b, i))));
      return;
    }
    const double delta_s = std::abs(a[i].time_s - b[i].time_s);
    if (delta_s <= latest_s) continue;
    latest_s = delta_s;
    where = text(a, i) + " | " + text(b, i);
  }
  checks.push_back(Verdict("events", true, Message(a.size(), " in both")));
  checks.push_back(AtMost("events: time", "s", latest_s, limit_s, where));
}

}  // namespace

ForceComparison CompareForces(const CsvTable& a, const CsvTable& b,
                              const ForceTolerances& tolerances, const std::string& name) {
  ForceComparison result;
  result.checks.push_back(CompareColumns(a, b, name));
  const std::vector<double> a_s = Times(a);
  const std::vector<double> b_s = Times(b);
  const SharedRows rows = Share(a_s, b_s, tolerances.time_max_s);
  const bool all = rows.a.size() == a_s.size() && rows.b.size() == b_s.size();
  result.checks.push_back(
      Verdict(name + ": samples", all,
              Message(a_s.size(), " | ", b_s.size(), ", ", rows.a.size(), " at the same time")));
  if (a.Has("event") && b.Has("event")) {
    CompareEvents(EventsOf(a, a_s), EventsOf(b, b_s), tolerances.event_time_s, result.checks);
  }
  if (rows.a.empty()) return result;
  result.time_s = Taken(a_s, rows.a);
  for (const std::string& column : a.columns()) {
    if (!b.Has(column)) continue;
    if (column == "tissue") {
      result.checks.push_back(CompareTissue(Taken(a.Texts(column), rows.a),
                                            Taken(b.Texts(column), rows.b), result.time_s,
                                            tolerances.tissue_percent));
    }
    const bool is_torque = column.ends_with("_n_mm");
    const bool is_length = column.ends_with("_mm") && !is_torque;
    if (!is_length && !is_torque && !column.ends_with("_n")) continue;
    auto in_a = Taken(a.Numbers(column), rows.a);
    auto in_b = Taken(b.Numbers(column), rows.b);
    const Difference difference = DifferenceOf(in_a, in_b, result.time_s);
    if (is_length || is_torque) {
      result.checks.push_back(
          AtMost(column + ": largest difference", is_torque ? "N mm" : "mm", difference.max,
                 is_torque ? tolerances.torque_max_n_mm : tolerances.depth_max_mm, At(difference)));
      continue;
    }
    const ForceLimit& limit = tolerances.Of(column);
    result.checks.push_back(AtMost(column + ": RMS difference", "N", difference.rms, limit.rms_n));
    result.checks.push_back(
        AtMost(column + ": largest difference", "N", difference.max, limit.max_n, At(difference)));
    result.forces.push_back({column, std::move(in_a), std::move(in_b)});
  }
  return result;
}

}  // namespace acus::comparison
