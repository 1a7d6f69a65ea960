#include "acus/physics/forces/laws/hu_springs.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"

namespace acus::forces {
namespace {

constexpr double SpringParameters::*kSpringParameters[] = {
    &SpringParameters::a1_n_per_mm, &SpringParameters::a2_n_per_mm2, &SpringParameters::cutting_n,
    &SpringParameters::shaft_n_per_mm2, &SpringParameters::friction_n_per_mm};

}  // namespace

SpringParameters HuSprings::At(double hu) const noexcept {
  const auto above = std::upper_bound(rows.begin(), rows.end(), hu,
                                      [](double value, const Row& row) { return value < row.hu; });
  if (above == rows.begin()) return rows.front().at;
  if (above == rows.end()) return rows.back().at;
  const Row& below = *(above - 1);
  const double along = (hu - below.hu) / (above->hu - below.hu);
  SpringParameters out;
  for (const auto parameter : kSpringParameters) {
    out.*parameter = below.at.*parameter + along * (above->at.*parameter - below.at.*parameter);
  }
  return out;
}

void HuSprings::Scale(double ratio) {
  for (Row& row : rows) {
    for (const auto parameter : kSpringParameters) row.at.*parameter *= ratio;
  }
}

HuSprings HuSpringsFromJson(const nlohmann::json& rows, const std::string& where) {
  HuSprings springs;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string place = Message(where, "/", i);
    const HuSprings::Row row = {.hu = rows[i].at("hu"),
                                .at = {.a1_n_per_mm = rows[i].at("a1_n_per_mm"),
                                       .a2_n_per_mm2 = rows[i].at("a2_n_per_mm2"),
                                       .cutting_n = rows[i].at("cutting_n"),
                                       .shaft_n_per_mm2 = rows[i].at("shaft_n_per_mm2"),
                                       .friction_n_per_mm = rows[i].at("friction_n_per_mm")}};
    ACUS_REQUIRE(springs.rows.empty() || row.hu > springs.rows.back().hu, place, "/hu: is ", row.hu,
                 "; it must be above the row before, ", springs.rows.back().hu);
    ACUS_REQUIRE(row.at.a1_n_per_mm + row.at.a2_n_per_mm2 > 0.0, place,
                 ": a1_n_per_mm and a2_n_per_mm2 are both 0, so that nothing is ever cut; allowed: "
                 "one of them above 0");
    springs.rows.push_back(row);
  }
  return springs;
}

}  // namespace acus::forces
