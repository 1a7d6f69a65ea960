#include "benchmarks/page_folder.h"

#include <regex>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"

namespace acus::benchmarks {
namespace {

namespace fs = std::filesystem;

/// [text](path.md) becomes text: beside pages elsewhere there are no others.
std::string WithoutLinks(const std::string& markdown) {
  static const std::regex link(R"re(\[([^\]\n]+)\]\([^)\s]+\.md[^)\s]*\))re");
  return std::regex_replace(markdown, link, "$1");
}

}  // namespace

std::map<fs::path, std::string> MakePages(const fs::path& templates, const fs::path& data,
                                          Claims claims) {
  const PageData measured = PageData::Read(data);
  std::map<fs::path, std::string> files;
  ACUS_REQUIRE(fs::is_directory(templates), templates.string(), ": no such folder");
  for (const auto& entry : fs::directory_iterator(templates)) {
    if (entry.path().extension() != ".template") continue;
    const std::string name = entry.path().stem().string();
    try {
      Page page = MakePage(ReadTextFile(entry.path()), measured, claims);
      if (claims == Claims::kAreMarked) page.text = WithoutLinks(page.text);
      files[name + ".md"] = std::move(page.text);
      for (auto& [figure, svg] : page.figures) {
        files[fs::path("figures") / (figure + ".svg")] = std::move(svg);
      }
    } catch (const InputError& error) {
      throw InputError(Message(entry.path().filename().string(), ":\n", error.what()));
    }
  }
  ACUS_REQUIRE(!files.empty(), templates.string(), ": there is no *.template");
  return files;
}

}  // namespace acus::benchmarks
