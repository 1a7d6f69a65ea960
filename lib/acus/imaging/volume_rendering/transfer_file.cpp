#include "acus/imaging/volume_rendering/transfer_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/data/volume/labels.h"

namespace acus::volume_rendering {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFolder = "transfer_functions";

std::string NamesOfPresets() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& file : fs::directory_iterator(config::ConfigsFolder() / kFolder, ignored)) {
    if (file.path().extension() == ".json") names.push_back(file.path().stem().string());
  }
  std::ranges::sort(names);
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

}  // namespace

fs::path FindTransferFunction(std::string_view name_or_path, const fs::path& folder) {
  const fs::path path = name_or_path;
  if (path.has_parent_path() || path.has_extension()) return config::FindConfig(path, folder);
  const fs::path preset = config::ConfigsFolder() / kFolder / (path.string() + ".json");
  ACUS_REQUIRE(!path.empty() && fs::exists(preset), "there is no transfer function \"",
               name_or_path, "\"; allowed are ", NamesOfPresets(),
               ", or the path of a file of format acus-transfer-function");
  return preset;
}

void CheckNodes(const std::vector<OpacityNode>& nodes, std::string_view where) {
  ACUS_REQUIRE(nodes.size() >= 2, where, ": ", nodes.size(), " nodes; at least two are needed");
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    ACUS_REQUIRE(std::isfinite(nodes[n].hu) && nodes[n].colour.allFinite(), where, ": node ", n,
                 " is not finite");
    ACUS_REQUIRE(nodes[n].extinction_per_mm >= 0.0 && nodes[n].extinction_per_mm <= 100.0, where,
                 ": node ", n, " has an extinction of ", nodes[n].extinction_per_mm,
                 " per mm; allowed is 0 to 100");
    ACUS_REQUIRE(n == 0 || nodes[n].hu > nodes[n - 1].hu, where, ": node ", n, " at ", nodes[n].hu,
                 " HU does not lie above the one before it");
  }
}

TransferFile ReadTransferFunction(const fs::path& path) {
  const auto json = config::ReadConfig(path, "acus-transfer-function");
  TransferFile out;
  out.name = json.at("name");
  for (const auto& node : json.at("nodes")) {
    const auto& colour = node.at("colour");
    out.nodes.push_back({node.at("hu"),
                         node.at("extinction_per_mm"),
                         {colour[0].get<float>(), colour[1].get<float>(), colour[2].get<float>()}});
  }
  CheckNodes(out.nodes, path.string() + ": /nodes");
  for (const auto& tissue : json.at("tissues")) {
    try {
      out.tissues.push_back(volume::LabelOf(tissue.get<std::string>()));
    } catch (const InputError& error) {
      throw InputError(Message(path.string(), ": /tissues: ", error.what()));
    }
  }
  return out;
}

}  // namespace acus::volume_rendering
