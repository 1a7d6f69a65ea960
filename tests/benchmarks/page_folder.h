// All pages about measurements, from a folder of templates and a folder of results.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "benchmarks/page_template.h"

namespace acus::benchmarks {

/// Files by their path in the folder of pages: NAME.md for each NAME.template, figures/NAME.svg.
/// Pages for elsewhere (claims are marked) do not link to other pages of the documentation.
/// @throws InputError naming the template, as MakePage, and if there is no template.
std::map<std::filesystem::path, std::string> MakePages(const std::filesystem::path& templates,
                                                       const std::filesystem::path& data,
                                                       Claims claims);

}  // namespace acus::benchmarks
