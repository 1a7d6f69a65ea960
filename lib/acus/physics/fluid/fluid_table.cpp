#include "acus/physics/fluid/fluid_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::fluid {
namespace {

using nlohmann::json;

/// [low, typical, high]; the median of the draws is the typical value.
double Drawn(const json& range, const std::string& key, const std::string& where,
             std::optional<std::uint64_t> seed, const std::string& tissue) {
  const double low = range.at(0);
  const double typical = range.at(1);
  const double high = range.at(2);
  ACUS_REQUIRE(low <= typical && typical <= high, where, "/", key, ": is ", range.dump(),
               "; give [lowest, typical, highest] in rising order");
  if (!seed) return typical;
  const double u = RandomStream(*seed, "fluid/" + tissue + "/" + key).Uniform(-1.0, 1.0);
  return u < 0.0 ? typical + u * (typical - low) : typical + u * (high - typical);
}

Return ReturnFrom(const std::string& word) {
  if (word == "content") return Return::kContent;
  return word == "injected" ? Return::kInjected : Return::kNothing;
}

/// A row without a key has what the struct has.
FluidTissue TissueFrom(const json& row, const std::string& where,
                       std::optional<std::uint64_t> seed) {
  FluidTissue out;
  out.name = row.at("tissue");
  const auto set = [&](const char* key, double& value) {
    if (row.contains(key)) value = Drawn(row.at(key), key, where, seed, out.name);
  };
  out.returns = ReturnFrom(row.at("returns"));
  set("opening_kpa", out.opening_kpa);
  set("entry_kpa_s_per_ml", out.entry_kpa_s_per_ml);
  set("spread_kpa_s_per_ml", out.spread_kpa_s_per_ml);
  set("spread_time_s", out.spread_time_s);
  set("source_radius_mm", out.source_radius_mm);
  set("space_compliance_ml_per_kpa", out.space_compliance_ml_per_kpa);
  set("resting_kpa", out.resting_kpa);
  set("pulse_kpa", out.pulse_kpa);
  set("breath_kpa", out.breath_kpa);
  set("content_ml", out.content_ml);
  set("fluid_share", out.fluid_share);
  set("flatness", out.flatness);
  set("absorption_s", out.absorption_s);
  const auto require_above_0 = [&](const char* key, double value) {
    ACUS_REQUIRE(value > 0.0, where, "/", key, ": is ", value, "; it must be above 0");
  };
  require_above_0("entry_kpa_s_per_ml", out.entry_kpa_s_per_ml);
  require_above_0("spread_time_s", out.spread_time_s);
  require_above_0("source_radius_mm", out.source_radius_mm);
  require_above_0("fluid_share", out.fluid_share);
  require_above_0("flatness", out.flatness);
  ACUS_REQUIRE(out.fluid_share <= 1.0 && out.flatness <= 1.0, where,
               ": fluid_share and flatness must be at most 1");
  ACUS_REQUIRE(
      out.returns != Return::kContent || out.content_ml > 0.0, where,
      ": returns its content, of which content_ml gives the volume, but that is not given");
  return out;
}

Syringe SyringeFrom(const json& row) {
  Syringe out;
  out.name = row.at("name");
  out.capacity_ml = row.at("capacity_ml");
  out.bore_mm = row.at("bore_mm");
  out.dead_space_ml = row.at("dead_space_ml");
  out.compliance_ml_per_kpa = row.at("compliance_ul_per_kpa").get<double>() * 1e-3;
  out.static_friction_n = row.at("static_friction_n");
  out.sliding_friction_n = row.at("sliding_friction_n");
  out.stribeck_speed_mm_per_s = row.at("stribeck_speed_mm_per_s");
  out.stick_n_per_mm = row.at("stick_n_per_mm");
  out.viscous_n_s_per_mm = row.at("viscous_n_s_per_mm");
  out.plunger_mass_kg = row.at("plunger_mass_g").get<double>() * 1e-3;
  return out;
}

template <typename Rows>
void RequireOnce(const Rows& rows, const std::string& name, const std::string& where) {
  const bool is_there =
      std::ranges::any_of(rows, [&](const auto& row) { return row.name == name; });
  ACUS_REQUIRE(!is_there, where, ": '", name, "' has a row already; remove one of the two");
}

}  // namespace

int FluidTable::TissueIndex(std::string_view name) const noexcept {
  const auto found = std::ranges::find(tissues, name, &FluidTissue::name);
  return found == tissues.end() ? -1 : static_cast<int>(found - tissues.begin());
}

const Syringe& FluidTable::SyringeNamed(std::string_view name) const {
  const auto found = std::ranges::find(syringes, name, &Syringe::name);
  if (found != syringes.end()) return *found;
  std::string names;
  for (const Syringe& syringe : syringes) names += (names.empty() ? "" : ", ") + syringe.name;
  throw InputError(Message(file, ": has no syringe '", name, "'; there are: ", names));
}

double FluidTable::BoreMm(int gauge, std::string_view needle) const {
  std::string known;
  for (const Bore& bore : bores) {
    if (bore.gauge == gauge && bore.needle == needle) return bore.inner_diameter_mm;
    known += Message(known.empty() ? "" : ", ", bore.gauge, " G ", bore.needle);
  }
  throw InputError(
      Message(file, ": has no bore of a needle of ", gauge, " G ", needle, "; there are: ", known));
}

FluidTable FluidTableFromJson(json document, const std::string& label,
                              std::optional<std::uint64_t> seed) {
  document = config::CheckedConfig(std::move(document), "acus-fluid", label);
  FluidTable table;
  table.file = label;
  table.saline = {document.at("liquid").at("viscosity_mpa_s"),
                  document.at("liquid").at("density_kg_per_m3")};
  FluidTissue outside;
  outside.name = "outside";
  outside.returns = Return::kContent;
  outside.content_ml = 1e9;
  outside.entry_kpa_s_per_ml = 1e-3;
  table.tissues.push_back(outside);
  const json& rows = document.at("tissues");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string where = Message(label, ": /tissues/", i);
    FluidTissue tissue = TissueFrom(rows[i], where, seed);
    RequireOnce(table.tissues, tissue.name, where + "/tissue");
    table.tissues.push_back(std::move(tissue));
  }
  for (std::size_t i = 0; i < document.at("syringes").size(); ++i) {
    const std::string where = Message(label, ": /syringes/", i);
    Syringe syringe = SyringeFrom(document.at("syringes")[i]);
    RequireOnce(table.syringes, syringe.name, where + "/name");
    ACUS_REQUIRE(syringe.static_friction_n >= syringe.sliding_friction_n, where,
                 "/static_friction_n: is ", syringe.static_friction_n,
                 "; it must not be below sliding_friction_n, ", syringe.sliding_friction_n);
    table.syringes.push_back(std::move(syringe));
  }
  for (const json& row : document.at("bores")) {
    table.bores.push_back({row.at("gauge"), row.at("needle"), row.at("inner_diameter_mm")});
  }
  return table;
}

FluidTable ReadFluidTable(const std::filesystem::path& path, std::optional<std::uint64_t> seed) {
  return FluidTableFromJson(config::ReadJson(path), path.string(), seed);
}

}  // namespace acus::fluid
