#include "acus/physics/mechanics/elements/elasticity_table.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/between_patients.h"

namespace acus::mechanics {
namespace {

using nlohmann::json;

volume::Label LabelAt(const json& name, const std::string& where) {
  try {
    return volume::LabelOf(name.get<std::string>());
  } catch (const InputError& error) {
    throw InputError(Message(where, ": ", error.what()));
  }
}

std::string NameOf(volume::Label label) {
  for (const volume::StandardLabel& standard : volume::StandardLabels()) {
    if (standard.label == label) return Message("'", standard.name, "' (label ", int{label}, ")");
  }
  return Message("label ", int{label}, ", which is no standard label,");
}

/// @param where  Of the law, for messages.
OgdenTerms OgdenTermsFrom(const json& block, const std::string& where) {
  ACUS_REQUIRE(block.contains("exponents"), where, "/exponents: missing; ogden needs it");
  const json& exponents = block.at("exponents");
  const json shares = block.value("shares", json::array({1.0}));
  ACUS_REQUIRE(shares.size() == exponents.size(), where, "/shares: has ", shares.size(),
               shares.size() == 1 ? " number, exponents has " : " numbers, exponents has ",
               exponents.size(), "; give each exponent its share of the shear modulus");
  OgdenTerms terms;
  double sum = 0.0;
  for (std::size_t i = 0; i < exponents.size(); ++i) {
    terms[i] = {shares[i], exponents[i]};
    ACUS_REQUIRE(std::abs(terms[i].exponent) >= kLeastOgdenExponent, where, "/exponents/", i,
                 ": is ", terms[i].exponent, "; at least ", kLeastOgdenExponent, " or at most ",
                 -kLeastOgdenExponent, " is allowed");
    sum += terms[i].share;
  }
  ACUS_REQUIRE(std::abs(sum - 1.0) < 1e-6, where, "/shares: sum to ", sum,
               "; they are shares of the shear modulus and must sum to 1");
  return terms;
}

/// @param where  Of the law, for messages.
Fibres FibresFrom(const json& block, const std::string& where) {
  const json& direction = block.at("direction");
  Fibres fibres{.k1_mpa = block.at("k1_kpa").get<double>() * 1e-3, .k2 = block.value("k2", 0.0)};
  for (int i = 0; i < 3; ++i) fibres.direction_in_ct[i] = direction[static_cast<std::size_t>(i)];
  ACUS_REQUIRE(fibres.direction_in_ct.norm() > 1e-6, where,
               "/fibres/direction: is zero; give the direction of the fibres, as [0, 0, 1] for "
               "head to foot");
  fibres.direction_in_ct.normalize();
  return fibres;
}

/// The block "law" of a row. @param where  Of the row, for messages.
HyperelasticLaw LawFrom(const json& block, double shear_modulus_mpa, const std::string& where) {
  HyperelasticLaw law;
  const std::string model = block.at("model");
  const auto refuse_other = [&](const char* key, std::initializer_list<const char*> owners) {
    ACUS_REQUIRE(!block.contains(key) || std::ranges::find(owners, model) != owners.end(), where,
                 "/law/", key, ": belongs to the law ", *owners.begin(), ", this one is ", model,
                 "; remove the key or choose that law");
  };
  const auto demand = [&](const char* key) {
    ACUS_REQUIRE(block.contains(key), where, "/law/", key, ": missing; ", model, " needs it");
    return block.at(key).get<double>();
  };
  refuse_other("b", {"fung", "knowles"});
  refuse_other("c2_kpa", {"yeoh"});
  refuse_other("c3_kpa", {"yeoh"});
  refuse_other("power", {"knowles"});
  refuse_other("exponents", {"ogden"});
  refuse_other("shares", {"ogden"});
  if (model == "fung") {
    law.kind = LawKind::kFung;
    law.exponent_b = demand("b");
  } else if (model == "yeoh") {
    law.kind = LawKind::kYeoh;
    law.c2_mpa = demand("c2_kpa") * 1e-3;
    law.c3_mpa = demand("c3_kpa") * 1e-3;
  } else if (model == "knowles") {
    law.kind = LawKind::kKnowles;
    law.exponent_b = demand("b");
    law.power_n = demand("power");
  } else if (model == "ogden") {
    law.kind = LawKind::kOgden;
    law.ogden = OgdenTermsFrom(block, where + "/law");
  }
  if (block.contains("fibres")) law.fibres = FibresFrom(block.at("fibres"), where + "/law");
  const double least = LeastSlopeShare(law, shear_modulus_mpa);
  ACUS_REQUIRE(least >= kLeastSlopeShare, where, "/law: with c2_kpa ", block.value("c2_kpa", 0.0),
               " the tissue's stiffness falls to ", least, " of that at rest, at least ",
               kLeastSlopeShare, " is allowed: it would let go under strain; use a larger c2_kpa ",
               "or c3_kpa");
  return law;
}

/// The tissues of the list, or all but the tissue itself where there is none.
std::bitset<256> OtherSide(const json& membrane, volume::Label tissue, const std::string& where) {
  std::bitset<256> out;
  if (membrane.contains("against")) {
    for (const json& name : membrane.at("against")) out.set(LabelAt(name, where));
  } else {
    out.set();
  }
  if (membrane.contains("not_against")) {
    for (const json& name : membrane.at("not_against")) out.reset(LabelAt(name, where));
  }
  out.reset(tissue);
  return out;
}

void ReadMembrane(const json& row, volume::Label tissue, const std::string& where,
                  ElasticityTable& table) {
  if (!row.contains("membrane")) return;
  const json& from = row.at("membrane");
  Membrane membrane;
  membrane.tissue = tissue;
  membrane.against = OtherSide(from, tissue, where + "/membrane");
  membrane.youngs_modulus_mpa = from.at("youngs_modulus_kpa").get<double>() * 1e-3;
  membrane.poissons_ratio = from.at("poissons_ratio");
  membrane.thickness_mm = from.at("thickness_mm");
  membrane.tension_n_per_mm = from.at("tension_n_per_m").get<double>() * 1e-3;
  table.membranes.push_back(membrane);
  if (from.contains("solid_youngs_modulus_kpa")) {
    table.beneath[tissue] = {from.at("solid_youngs_modulus_kpa").get<double>() * 1e-3,
                             table.tissue[tissue].poissons_ratio};
    table.has_beneath.set(tissue);
  }
}

Relaxation ReadRelaxation(const json& document, const std::string& label) {
  Relaxation out;
  if (!document.contains("relaxation")) return out;
  double sum = 0.0;
  for (const json& term : document.at("relaxation").at("terms")) {
    out.term[static_cast<std::size_t>(out.num_terms++)] = {term.at("share"), term.at("time_s")};
    sum += term.at("share").get<double>();
  }
  ACUS_REQUIRE(sum < 1.0, label, ": /relaxation/terms: the shares sum to ", sum,
               "; they must stay below 1, since tissue that lost all its force would flow");
  return out;
}

}  // namespace

const ElasticTissue& ElasticityTable::SolidAt(volume::Label label) const {
  const ElasticTissue& whole = At(label);
  return has_beneath.test(label) ? beneath[label] : whole;
}

const Membrane* ElasticityTable::MembraneOf(volume::Label covered, volume::Label beyond) const {
  const auto found = std::ranges::find(membranes, covered, &Membrane::tissue);
  return found != membranes.end() && found->against.test(beyond) ? &*found : nullptr;
}

const ElasticTissue& ElasticityTable::At(volume::Label label) const {
  ACUS_REQUIRE(label != 0, "the mesh holds tetrahedra of 'outside' (label 0), which is free space ",
               "and has no stiffness; mesh the label map again with acus-mesh");
  ACUS_REQUIRE(named.test(label), "the mesh holds ", NameOf(label), " but ", file,
               " has no row for it; add a row with youngs_modulus_kpa and poissons_ratio, or mesh ",
               "with that tissue among the fixed_tissues");
  return tissue[label];
}

ElasticityTable ElasticityTable::OfPatient(std::uint64_t seed) const {
  const auto factor = [&](volume::Label label) {
    return math::PatientFactor(between_patients_gsd[label], seed, label);
  };
  ElasticityTable drawn = *this;
  for (std::size_t i = 1; i < drawn.tissue.size(); ++i) {
    const double ratio = factor(static_cast<volume::Label>(i));
    drawn.tissue[i].youngs_modulus_mpa *= ratio;
    drawn.beneath[i].youngs_modulus_mpa *= ratio;
    drawn.law[i].c2_mpa *= ratio;
    drawn.law[i].c3_mpa *= ratio;
    drawn.law[i].fibres.k1_mpa *= ratio;
  }
  for (Membrane& membrane : drawn.membranes) {
    membrane.youngs_modulus_mpa *= factor(membrane.tissue);
    membrane.tension_n_per_mm *= factor(membrane.tissue);
  }
  return drawn;
}

bool ElasticityTable::VariesBetweenPatients() const noexcept {
  return std::ranges::any_of(between_patients_gsd, [](double gsd) { return gsd > 1.0; });
}

ElasticityTable ElasticityTableFromJson(json document, const std::string& label) {
  document = config::CheckedConfig(std::move(document), "acus-elasticity", label);
  ElasticityTable table;
  table.file = label;
  table.description = document.at("description");
  const json& rows = document.at("tissues");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const json& row = rows[i];
    const std::string where = Message(label, ": /tissues/", i, "/tissue");
    const volume::Label tissue = LabelAt(row.at("tissue"), where);
    ACUS_REQUIRE(tissue != 0, where, ": 'outside' is free space and has no row");
    ACUS_REQUIRE(!table.named.test(tissue), where, ": ", row.at("tissue").dump(),
                 " has a row already; remove one of the two");
    table.tissue[tissue] = {row.at("youngs_modulus_kpa").get<double>() * 1e-3,
                            row.at("poissons_ratio")};
    if (row.contains("law")) {
      table.law[tissue] = LawFrom(row.at("law"), table.tissue[tissue].ShearModulusMpa(),
                                  Message(label, ": /tissues/", i));
    }
    if (row.contains("between_patients")) {
      table.between_patients_gsd[tissue] = row.at("between_patients").at("gsd");
    }
    table.named.set(tissue);
    ReadMembrane(row, tissue, Message(label, ": /tissues/", i), table);
  }
  std::ranges::sort(table.membranes, {}, &Membrane::tissue);
  table.relaxation = ReadRelaxation(document, label);
  return table;
}

ElasticityTable ReadElasticityTable(const std::filesystem::path& path) {
  return ElasticityTableFromJson(config::ReadJson(path), path.string());
}

}  // namespace acus::mechanics
