#include "acus/base/translation/translation.h"

#include <array>
#include <clocale>
#include <cstdlib>
#include <libintl.h>

namespace acus::translation {
namespace {

constexpr const char* kDomain = "acus";

}  // namespace

std::string Translated(const std::string& text) {
  // The empty text stands for the header of a catalogue.
  return text.empty() ? text : dgettext(kDomain, text.c_str());
}

std::string Translated(const std::string& text, const std::vector<std::string>& values) {
  const std::string pattern = Translated(text);
  std::string out;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const bool is_place = pattern[i] == '{' && i + 2 < pattern.size() && pattern[i + 2] == '}';
    const auto number = is_place ? static_cast<std::size_t>(pattern[i + 1] - '1') : values.size();
    if (number < values.size()) {
      out += values[number];
      i += 2;
    } else {
      out += pattern[i];
    }
  }
  return out;
}

std::string LanguageOfEnvironment() {
  for (const char* name : {"LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"}) {
    const char* value = std::getenv(name);
    if (value == nullptr || *value == '\0') continue;
    const std::string language(value);
    const std::string code = language.substr(0, language.find_first_of("_.:@"));
    return code == "C" || code == "POSIX" ? "en" : code;
  }
  return "en";
}

void UseLanguage(const std::string& language, const std::filesystem::path& locale_folder) {
  // LANGUAGE chooses the catalogue; the locale only has to be another one than C, and this one is
  // part of every Debian system.
  setenv("LANGUAGE", language.c_str(), 1);
  std::setlocale(LC_MESSAGES, "C");  // Texts that were found before are looked for again.
  std::setlocale(LC_MESSAGES, "C.UTF-8");
  bindtextdomain(kDomain, locale_folder.c_str());
  bind_textdomain_codeset(kDomain, "UTF-8");
}

std::filesystem::path LocaleFolder() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / "share" / "locale";
}

}  // namespace acus::translation
