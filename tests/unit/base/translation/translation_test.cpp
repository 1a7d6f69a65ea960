#include "acus/base/translation/translation.h"

#include <cstdlib>
#include <gtest/gtest.h>

namespace acus::translation {
namespace {

TEST(Translated, PutsValuesIntoPlaces) {
  EXPECT_EQ(Translated("The tip is {1} from the {2}.", {"3 mm", "target"}),
            "The tip is 3 mm from the target.");
  EXPECT_EQ(Translated("{2} before {1}, {3} stays", {"b", "a"}), "a before b, {3} stays");
  EXPECT_EQ(Translated("a { b } {", {"x"}), "a { b } {");
  EXPECT_EQ(Translated(""), "");
}

TEST(Language, IsThatOfTheEnvironment) {
  for (const char* name : {"LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"}) unsetenv(name);
  EXPECT_EQ(LanguageOfEnvironment(), "en");
  setenv("LANG", "de_CH.UTF-8", 1);
  EXPECT_EQ(LanguageOfEnvironment(), "de");
  setenv("LC_ALL", "C.UTF-8", 1);
  EXPECT_EQ(LanguageOfEnvironment(), "en");
  setenv("LANGUAGE", "fr:de", 1);
  EXPECT_EQ(LanguageOfEnvironment(), "fr");
}

TEST(Language, TextsAreThoseOfItsCatalogue) {
  const std::filesystem::path folder = std::filesystem::path(ACUS_BUILD_DIR) / "share" / "locale";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "built without msgfmt (package gettext)";
  UseLanguage("de", folder);
  EXPECT_EQ(Translated("Time"), "Zeit");
  UseLanguage("fr", folder);
  EXPECT_EQ(Translated("Time"), "Temps");
  UseLanguage("xx", folder);
  EXPECT_EQ(Translated("Time"), "Time");
}

}  // namespace
}  // namespace acus::translation
