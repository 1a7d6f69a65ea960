#include "acus/physics/mechanics/elasticity_table.h"

#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

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

/// The block "law" of a row. @param where  Of the row, for messages.
HyperelasticLaw LawFrom(const json& block, double shear_modulus_mpa, const std::string& where) {
  HyperelasticLaw law;
  const std::string model = block.at("model");
  const auto refuse_other = [&](const char* key, const char* owner) {
    ACUS_REQUIRE(model == owner || !block.contains(key), where, "/law/", key,
                 ": belongs to the law ", owner, ", this one is ", model,
                 "; remove the key or choose that law");
  };
  const auto demand = [&](const char* key) {
    ACUS_REQUIRE(block.contains(key), where, "/law/", key, ": missing; ", model, " needs it");
    return block.at(key).get<double>();
  };
  refuse_other("b", "fung");
  refuse_other("c2_kpa", "yeoh");
  refuse_other("c3_kpa", "yeoh");
  if (model == "fung") {
    law.kind = LawKind::kFung;
    law.exponent_b = demand("b");
  } else if (model == "yeoh") {
    law.kind = LawKind::kYeoh;
    law.c2_mpa = demand("c2_kpa") * 1e-3;
    law.c3_mpa = demand("c3_kpa") * 1e-3;
  }
  const double least = LeastSlopeShare(law, shear_modulus_mpa);
  ACUS_REQUIRE(least >= kLeastSlopeShare, where, "/law: with c2_kpa ", block.value("c2_kpa", 0.0),
               " the tissue's stiffness falls to ", least, " of that at rest, at least ",
               kLeastSlopeShare, " is allowed: it would let go under strain; use a larger c2_kpa ",
               "or c3_kpa");
  return law;
}

}  // namespace

const ElasticTissue& ElasticityTable::At(volume::Label label) const {
  ACUS_REQUIRE(label != 0, "the mesh holds tetrahedra of 'outside' (label 0), which is free space ",
               "and has no stiffness; mesh the label map again with acus-mesh");
  ACUS_REQUIRE(named.test(label), "the mesh holds ", NameOf(label), " but ", file,
               " has no row for it; add a row with youngs_modulus_kpa and poissons_ratio, or mesh ",
               "with that tissue among the fixed_tissues");
  return tissue[label];
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
    table.named.set(tissue);
  }
  return table;
}

ElasticityTable ReadElasticityTable(const std::filesystem::path& path) {
  return ElasticityTableFromJson(config::ReadJson(path), path.string());
}

}  // namespace acus::mechanics
