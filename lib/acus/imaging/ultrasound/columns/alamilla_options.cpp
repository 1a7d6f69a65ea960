#include "acus/imaging/ultrasound/columns/alamilla_options.h"

#include <map>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

TextureImages ImagesOf(const nlohmann::json& block, const std::filesystem::path& table) {
  TextureImages images;
  const auto found = [&](const char* key) {
    return config::FindConfig(block.at(key).get<std::string>(), table.parent_path());
  };
  images.along = found("along");
  if (!block.at("across").get<std::string>().empty()) images.across = found("across");
  images.mm_per_px = block.at("mm_per_px");
  return images;
}

}  // namespace

std::vector<std::filesystem::path> AlamillaOptions::ExampleImages() const {
  std::vector<std::filesystem::path> images;
  for (const AlamillaTissue& tissue_of_row : tissues) {
    if (!tissue_of_row.example) continue;
    images.push_back(tissue_of_row.example->along);
    if (!tissue_of_row.example->across.empty()) images.push_back(tissue_of_row.example->across);
  }
  return images;
}

AlamillaOptions ReadAlamillaOptions(const std::filesystem::path& path) {
  static const std::map<std::string, TissueTexture> kTextures = {
      {"speckle", TissueTexture::kSpeckle},
      {"thick_fibres", TissueTexture::kThickFibres},
      {"thin_fibres", TissueTexture::kThinFibres}};
  const auto json = config::ReadConfig(path, "acus-image-alamilla");
  AlamillaOptions options;
  options.name = json.at("name");
  options.file = path.string();
  std::set<std::string> seen;
  for (const auto& row : json.at("tissues")) {
    AlamillaTissue tissue;
    tissue.tissue = row.at("tissue");
    ACUS_REQUIRE(seen.insert(tissue.tissue).second, path.string(), ": /tissues/", seen.size(),
                 ": a second row for ", tissue.tissue, "; keep one");
    tissue.grey = row.at("grey");
    tissue.contrast = row.at("contrast");
    tissue.grain_mm = row.at("grain_mm");
    tissue.texture = kTextures.at(row.at("texture").get<std::string>());
    if (row.contains("example")) {
      ACUS_REQUIRE(tissue.texture != TissueTexture::kThinFibres, path.string(), ": /tissues/",
                   seen.size() - 1, ": an example for the texture thin_fibres, which is noise ",
                   "blurred along the fibres; choose thick_fibres or speckle, or no example");
      tissue.example = ImagesOf(row.at("example"), path);
    }
    tissue.absorption_per_cm = row.at("absorption_per_cm");
    tissue.reflection = row.at("reflection");
    tissue.blocks = row.at("blocks");
    options.tissues.push_back(tissue);
  }
  options.reflection = json.at("reflection");
  options.shadow = json.at("shadow");
  options.absorption = json.at("absorption");
  options.speckle = json.at("speckle");
  options.fibres = json.at("fibres");
  options.surface_mm = json.at("surface_mm");
  options.shadow_share = json.at("shadow_share");
  options.needle_share = json.at("needle_share");
  options.angle_exponent = json.at("angle_exponent");
  options.thick_fibre_ratio = json.at("thick_fibre_ratio");
  options.thin_fibre_mm = json.at("thin_fibre_mm");
  options.coupling_gap_mm = json.at("coupling_gap_mm");
  return options;
}

}  // namespace acus::ultrasound
