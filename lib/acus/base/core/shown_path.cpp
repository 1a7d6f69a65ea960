#include "acus/base/core/shown_path.h"

#include <atomic>
#include <mutex>
#include <set>

namespace acus {
namespace {

std::atomic<bool> folders_are_shown{true};  ///< Set once, when a program starts.

/// Folders that messages may name, as "a/b/", the longest first.
struct LongestFirst {
  bool operator()(const std::string& a, const std::string& b) const {
    return a.size() != b.size() ? a.size() > b.size() : a < b;
  }
};

std::mutex& FoldersMutex() {
  static std::mutex mutex;
  return mutex;
}

std::set<std::string, LongestFirst>& HiddenFolders() {
  static std::set<std::string, LongestFirst> folders;
  return folders;
}

void Hide(const std::filesystem::path& folder) {
  if (folder.empty() || folder == folder.root_path()) return;
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(folder, error);
  const std::lock_guard lock(FoldersMutex());
  for (const auto& form : {folder, whole, whole.lexically_normal()}) {
    if (!form.empty()) HiddenFolders().insert(form.string() + "/");
  }
}

}  // namespace

void ShowFolders(bool show) {
  folders_are_shown.store(show);
}

bool FoldersAreShown() {
  return folders_are_shown.load();
}

std::string ShownPath(const std::filesystem::path& path) {
  if (FoldersAreShown()) return path.string();
  const bool ends_in_slash = path.has_parent_path() && path.filename().empty();
  const std::filesystem::path plain = ends_in_slash ? path.parent_path() : path;
  Hide(plain.parent_path());
  return plain.filename().string();
}

std::string ShownText(std::string text) {
  if (FoldersAreShown()) return text;
  const std::lock_guard lock(FoldersMutex());
  for (const std::string& folder : HiddenFolders()) {
    for (std::size_t at = text.find(folder); at != text.npos; at = text.find(folder, at)) {
      text.erase(at, folder.size());
    }
  }
  return text;
}

std::string ShownWord(std::string_view word) {
  if (FoldersAreShown()) return std::string(word);
  const std::size_t equals = word.find('=');
  // A JSON pointer before the '=' (--set /patient/ct=...) is no path.
  const std::size_t begin = equals == word.npos ? 0 : equals + 1;
  const bool is_text = word.find_first_of("\"{[", begin) != word.npos;
  if (is_text || word.find('/', begin) == word.npos) return std::string(word);
  return std::string(word.substr(0, begin)) + ShownPath(word.substr(begin));
}

}  // namespace acus
