#include "acus/assess/regression/comparison/compare_metrics.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "acus/base/core/error.h"

namespace acus::comparison {
namespace {

using nlohmann::json;

struct Metric {
  std::string name;
  std::string unit;
  std::optional<double> value;  ///< Nothing if the run had no value (null).
};

std::vector<Metric> MetricsOf(const json& document, const std::string& label) {
  ACUS_REQUIRE(
      document.is_object() && document.contains("metrics") && document["metrics"].is_array(), label,
      ": /metrics: a list of metrics is needed");
  std::vector<Metric> metrics;
  for (std::size_t i = 0; i < document["metrics"].size(); ++i) {
    const json& entry = document["metrics"][i];
    const std::string where = Message(label, ": /metrics/", i);
    ACUS_REQUIRE(entry.is_object() && entry.contains("name") && entry["name"].is_string() &&
                     entry.contains("value"),
                 where, ": must have a name (text) and a value");
    const json& value = entry["value"];
    ACUS_REQUIRE(value.is_number() || value.is_null(), where, "/value: must be a number or null");
    ACUS_REQUIRE(value.is_null() || std::isfinite(value.get<double>()), where,
                 "/value: is not finite");
    Metric metric;
    metric.name = entry["name"].get<std::string>();
    if (entry.contains("unit") && entry["unit"].is_string()) {
      metric.unit = entry["unit"].get<std::string>();
    }
    if (value.is_number()) metric.value = value.get<double>();
    const auto same = [&](const Metric& other) { return other.name == metric.name; };
    ACUS_REQUIRE(std::ranges::none_of(metrics, same), where, ": '", metric.name, "' appears twice");
    metrics.push_back(std::move(metric));
  }
  return metrics;
}

std::string TextOf(const std::optional<double>& value) {
  return value ? Message(*value) : "none";
}

Check CompareOne(const Metric& a, const Metric& b, const MetricTolerances& tolerances) {
  const std::string quantity = "metric: " + a.name;
  const std::string values = TextOf(a.value) + " | " + TextOf(b.value);
  if (a.unit != b.unit) {
    return Verdict(quantity, false, "the units differ: " + a.unit + " | " + b.unit);
  }
  if (!a.value || !b.value) {
    return Verdict(quantity, a.value.has_value() == b.value.has_value(), values);
  }
  const double size = std::max(std::abs(*a.value), std::abs(*b.value));
  return AtMost(quantity, a.unit, std::abs(*a.value - *b.value),
                tolerances.absolute + tolerances.RelativeOf(a.name) * size, values);
}

}  // namespace

std::vector<Check> CompareMetrics(const json& a, const std::string& label_a, const json& b,
                                  const std::string& label_b, const MetricTolerances& tolerances) {
  const std::vector<Metric> in_a = MetricsOf(a, label_a);
  std::vector<Metric> in_b = MetricsOf(b, label_b);
  std::vector<Check> checks;
  for (const Metric& metric : in_a) {
    const auto found = std::ranges::find(in_b, metric.name, &Metric::name);
    if (found == in_b.end()) {
      checks.push_back(OnlyInOne("metric: " + metric.name, "only in A"));
      continue;
    }
    checks.push_back(CompareOne(metric, *found, tolerances));
    in_b.erase(found);
  }
  for (const Metric& metric : in_b) {
    checks.push_back(OnlyInOne("metric: " + metric.name, "only in B"));
  }
  return checks;
}

}  // namespace acus::comparison
