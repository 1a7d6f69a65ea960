// Texts of the user interface in the user's language, from the catalogues of gettext (lib/po/).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace acus::translation {

/// Marks a text for the catalogues and returns it: for tables, whose texts are translated when they
/// are displayed.
constexpr const char* Marked(const char* text) noexcept {
  return text;
}

/// The text in the chosen language; the text itself where its catalogue has no translation.
std::string Translated(const std::string& text);

/// The same, then "{1}", "{2}" and so on are replaced by the values.
std::string Translated(const std::string& text, const std::vector<std::string>& values);

/// The language that the environment names, as gettext reads it (LANGUAGE, LC_ALL, LC_MESSAGES,
/// LANG): "de" for "de_DE.UTF-8"; "en" if none is named.
std::string LanguageOfEnvironment();

/// Chooses the language of all later texts. Numbers keep their form: only texts change. Call it
/// before other threads start.
/// @param locale_folder  Contains LANGUAGE/LC_MESSAGES/acus.mo. A language without a file there is
/// English.
void UseLanguage(const std::string& language, const std::filesystem::path& locale_folder);

/// ../share/locale beside the running program.
std::filesystem::path LocaleFolder();

}  // namespace acus::translation
