#include "acus/imaging/acoustics/tissue_acoustics.h"

#include <algorithm>
#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/spelling.h"
#include "acus/data/volume/labels.h"
#include "acus/imaging/acoustics/plus_simulator.h"

namespace acus::acoustics {
namespace {

using nlohmann::json;

TissueAcoustics TissueFromJson(const json& row) {
  TissueAcoustics tissue;
  tissue.speed_m_per_s = row.at("speed_m_per_s");
  tissue.impedance_mrayl = row.at("impedance_mrayl");
  tissue.attenuation_db_per_cm_mhz = row.at("attenuation_db_per_cm_mhz");
  tissue.attenuation_along_fibres_db_per_cm_mhz =
      row.value("attenuation_along_fibres_db_per_cm_mhz", tissue.attenuation_db_per_cm_mhz);
  tissue.attenuation_exponent = row.at("attenuation_exponent");
  tissue.scatterers_per_mm3 = row.at("scatterers_per_mm3");
  tissue.backscatter_db = row.at("backscatter_db");
  tissue.fibre_ratio = row.at("fibre_ratio");
  return tissue;
}

/// Every source that a row names must be listed; every value it gives a source for must be there.
void CheckSources(const json& row, const json& references, const std::string& where) {
  for (const auto& [value, source] : row.at("sources").items()) {
    ACUS_REQUIRE(row.contains(value), where, "/sources/", value,
                 ": is not a value of this tissue; remove it");
    const auto name = source.get<std::string>();
    ACUS_REQUIRE(references.contains(name), where, "/sources/", value, ": \"", name,
                 "\" is not listed in /references; add it there");
  }
}

std::vector<HuTissue> HuFromJson(const json& knots, const TissueAcousticsTable& table) {
  std::vector<HuTissue> out;
  for (std::size_t n = 0; n < knots.size(); ++n) {
    out.push_back({knots[n].at("hu"), knots[n].at("tissue")});
    ACUS_REQUIRE(n == 0 || out[n].hu > out[n - 1].hu, table.file, ": /by_hu/", n, "/hu: is ",
                 out[n].hu, ", not above the knot before it (", out[n - 1].hu,
                 "); sort the knots by HU");
    table.Of(out[n].tissue);
  }
  return out;
}

}  // namespace

double TissueAcoustics::AttenuationDbPerCm(double frequency_mhz, double cos_to_fibres) const {
  const double along = cos_to_fibres * cos_to_fibres;
  return std::pow(frequency_mhz, attenuation_exponent) *
         (along * attenuation_along_fibres_db_per_cm_mhz +
          (1.0 - along) * attenuation_db_per_cm_mhz);
}

const TissueAcoustics& TissueAcousticsTable::Of(std::string_view tissue) const {
  const auto found = tissues.find(std::string(tissue));
  if (found != tissues.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& entry : tissues) known.push_back(entry.first);
  const auto nearest = NearestSpelling(tissue, known);
  throw InputError(Message(file, ": has no tissue '", tissue, "'",
                           nearest ? Message("; did you mean '", *nearest, "'?")
                                   : std::string("; add a row to /tissues")));
}

TissueAcoustics TissueAcousticsTable::AtHu(double hu) const {
  ACUS_REQUIRE(!by_hu.empty(), file, ": has no tissues by HU; add /by_hu");
  const auto upper = std::ranges::lower_bound(by_hu, hu, {}, &HuTissue::hu);
  if (upper == by_hu.begin()) return Of(upper->tissue);
  const HuTissue& low = *std::prev(upper);
  if (upper == by_hu.end()) return Of(low.tissue);
  const TissueAcoustics& a = Of(low.tissue);
  const TissueAcoustics& b = Of(upper->tissue);
  const double t = (hu - low.hu) / (upper->hu - low.hu);
  TissueAcoustics out;
  for (double TissueAcoustics::*value :
       {&TissueAcoustics::speed_m_per_s, &TissueAcoustics::impedance_mrayl,
        &TissueAcoustics::attenuation_db_per_cm_mhz,
        &TissueAcoustics::attenuation_along_fibres_db_per_cm_mhz,
        &TissueAcoustics::attenuation_exponent, &TissueAcoustics::scatterers_per_mm3,
        &TissueAcoustics::backscatter_db, &TissueAcoustics::fibre_ratio}) {
    out.*value = a.*value + t * (b.*value - a.*value);
  }
  return out;
}

TissueAcousticsTable ReadTissueAcoustics(const std::filesystem::path& path) {
  if (IsPlusConfiguration(path)) return ReadPlusSimulator(path).acoustics;
  const json document = config::ReadConfig(path, "acus-tissue-acoustics");
  TissueAcousticsTable table;
  table.name = document.at("name");
  table.file = path.string();
  for (const auto& [name, row] : document.at("tissues").items()) {
    CheckSources(row, document.at("references"), table.file + ": /tissues/" + name);
    table.tissues[name] = TissueFromJson(row);
  }
  table.by_hu = HuFromJson(document.at("by_hu"), table);
  return table;
}

LabelAcoustics AcousticsOfLabels(const TissueAcousticsTable& table, const volume::LabelMap& labels,
                                 const std::string& labels_file) {
  LabelAcoustics out;
  for (const volume::Label label : labels.voxels) out.occurs.set(label);
  out.of.fill(table.Of(table.by_hu.empty() ? "water" : table.by_hu.front().tissue));
  if (table.tissues.contains("outside") || table.tissues.contains("water")) {
    out.of[0] = table.Of(table.tissues.contains("outside") ? "outside" : "water");
  }
  for (std::size_t label = 1; label < out.of.size(); ++label) {
    if (!out.occurs.test(label)) continue;
    const auto named = labels.names.find(static_cast<volume::Label>(label));
    std::string name = named != labels.names.end() ? named->second : std::string();
    if (name.empty() && label < volume::StandardLabels().size()) {
      name = volume::StandardLabels()[label].name;
    }
    const auto row = table.tissues.find(name);
    ACUS_REQUIRE(row != table.tissues.end(), labels_file, ": label ", label,
                 name.empty() ? std::string(" has no name and") : Message(" (\"", name, "\")"),
                 " has no acoustic entry in ", table.file, "; ",
                 name.empty()
                     ? Message("name the label in the label map, or map it to a standard label")
                     : Message("add \"", name,
                               "\" to /tissues there, or map the label to a "
                               "tissue that is listed (acus-segment --mapping)"));
    out.of[label] = row->second;
  }
  return out;
}

}  // namespace acus::acoustics
