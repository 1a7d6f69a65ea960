// How paths stand in outputs: folders may carry the names of patients.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace acus {

/// What --no-folders says: provenance, reports and run.json hold file names without their folders.
void ShowFolders(bool show);
bool FoldersAreShown();

/// The path as it may stand in an output: as it is, or its last part.
std::string ShownPath(const std::filesystem::path& path);

/// A message as it may stand in an output: without the folders of the paths that ShownPath() was
/// requested, if folders are not shown.
std::string ShownText(std::string text);

/// One word of a command line as it may stand in an output, where a path may follow a '=', as in
/// --ct=a/b.
std::string ShownWord(std::string_view word);

}  // namespace acus
