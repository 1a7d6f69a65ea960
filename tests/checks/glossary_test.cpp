// Pages, help texts, messages, comments and descriptions of schemas and presets use the words of
// docs/glossary.md. The page is the single source: what stands in code type in a column "not" is a
// regular expression for whole words.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <gtest/gtest.h>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/core/atomic_file.h"

namespace acus {
namespace {

const std::filesystem::path kGlossaryRoot = ACUS_SOURCE_DIR;

/// Pages, and folders of pages, that are not held against the glossary, with the reason.
const std::vector<std::string> kGlossaryExceptions = {
    "docs/glossary.md",           // Quotes the words to avoid.
    "docs/reference/commands/",   // Generated from texts that MessagesUseItsWords reads.
    "docs/reference/config.md",   // Generated, likewise.
    "docs/stability.md",          // Names of hard cases, printed by their tests.
    "docs/accuracy-and-time.md",  // Generated: its template is held against the glossary.
    "docs/papers-claims.md",      // Generated, likewise.
};

struct GlossaryWord {
  std::string say;
  std::string avoid;
  std::regex whole_word;
  std::string begin = {};  ///< Letters that every match begins with: fast to look for.

  bool IsIn(const std::string& text) const {
    return text.find(begin) != text.npos && std::regex_search(text, whole_word);
  }
};

/// The letters before the first one that a pattern does not fix.
std::string FixedBeginning(const std::string& pattern) {
  auto end = pattern.find_first_of("?*+.\\[(|");
  if (end != pattern.npos && end > 0 && (pattern[end] == '?' || pattern[end] == '*')) --end;
  return pattern.substr(0, end);
}

std::string InLowerCase(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Replaces everything from `open` to the next `close` by blanks; lines stay where they are.
void BlankBetween(std::string& text, std::string_view open, std::string_view close) {
  for (auto begin = text.find(open); begin != text.npos; begin = text.find(open, begin)) {
    auto end = text.find(close, begin + open.size());
    end = end == text.npos ? text.size() : end + close.size();
    std::replace_if(
        text.begin() + static_cast<std::ptrdiff_t>(begin),
        text.begin() + static_cast<std::ptrdiff_t>(end), [](char c) { return c != '\n'; }, ' ');
    begin = end;
  }
}

/// The lines of `text` without code, generated parts, formulas of templates and targets of links.
std::vector<std::string> ProseLines(std::string text) {
  BlankBetween(text, "{{", "}}");
  BlankBetween(text, "\n```", "\n```");
  BlankBetween(text, "<!-- faults: made by", "<!-- end of faults -->");
  BlankBetween(text, "`", "`");
  BlankBetween(text, "](", ")");
  std::vector<std::string> lines;
  std::istringstream in(InLowerCase(text));
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> TableCells(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream in(row.substr(1));
  for (std::string cell; std::getline(in, cell, '|');) {
    const auto begin = cell.find_first_not_of(' ');
    const auto end = cell.find_last_not_of(' ');
    cells.push_back(begin == cell.npos ? "" : cell.substr(begin, end - begin + 1));
  }
  return cells;
}

std::vector<GlossaryWord> WordsToAvoid() {
  const std::regex code("`([^`]+)`");
  std::vector<GlossaryWord> words;
  std::ptrdiff_t column = -1;  // Of "not" in the table that is being read.
  bool in_table = false;
  std::istringstream in(ReadTextFile(kGlossaryRoot / "docs" / "glossary.md"));
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("|")) {
      in_table = false;
      continue;
    }
    const std::vector<std::string> cells = TableCells(line);
    if (!in_table) column = std::ranges::find(cells, "not") - cells.begin();
    in_table = true;
    if (column >= std::ssize(cells)) continue;
    const std::string& avoid = cells[static_cast<std::size_t>(column)];
    for (std::sregex_iterator match(avoid.begin(), avoid.end(), code), end; match != end; ++match) {
      const std::string word = (*match)[1];
      words.push_back(
          {cells.front(), word, std::regex("\\b(?:" + word + ")\\b"), FixedBeginning(word)});
    }
  }
  return words;
}

std::vector<std::string> PagesWithProse() {
  std::vector<std::string> pages{"README.md"};
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kGlossaryRoot / "docs")) {
    const std::string name = entry.path().lexically_relative(kGlossaryRoot).generic_string();
    const bool is_page = name.ends_with(".md") || name.ends_with(".template");
    const bool is_exception =
        std::ranges::any_of(kGlossaryExceptions, [&name](const std::string& exception) {
          return exception.ends_with("/") ? name.starts_with(exception) : name == exception;
        });
    if (is_page && !is_exception) pages.push_back(name);
  }
  std::ranges::sort(pages);
  return pages;
}

/// A text for users in a source, a schema or a preset.
struct Text {
  int line = 0;
  std::string text;
};

/// The string literals of a source that are prose: they have a blank.
std::vector<Text> Literals(const std::string& source) {
  static const std::regex literal(R"re("((?:\\.|[^"\\])*)")re");
  std::vector<Text> texts;
  std::istringstream in(source);
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const auto first = line.find_first_not_of(' ');
    if (first == line.npos || line.compare(first, 2, "//") == 0 || line[first] == '#') continue;
    for (std::sregex_iterator match(line.begin(), line.end(), literal), end; match != end;
         ++match) {
      const std::string text = (*match)[1];
      if (text.find(' ') != text.npos) texts.push_back({number, InLowerCase(text)});
    }
  }
  return texts;
}

std::vector<std::string> FilesWithMessages() {
  std::vector<std::string> files;
  for (const char* folder : {"lib", "apps", "configs"}) {
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(kGlossaryRoot / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".cpp" || extension == ".h" || extension == ".json") {
        files.push_back(entry.path().lexically_relative(kGlossaryRoot).generic_string());
      }
    }
  }
  std::ranges::sort(files);
  return files;
}

TEST(Glossary, MessagesUseItsWords) {
  const std::vector<GlossaryWord> words = WordsToAvoid();
  const std::vector<std::string> files = FilesWithMessages();
  ASSERT_GT(files.size(), 1000u);
  std::size_t num_texts = 0;
  for (const std::string& file : files) {
    for (const Text& text : Literals(ReadTextFile(kGlossaryRoot / file))) {
      ++num_texts;
      for (const GlossaryWord& word : words) {
        EXPECT_FALSE(word.IsIn(text.text)) << file << ":" << text.line << ": say '" << word.say
                                           << "', not '" << word.avoid << "': " << text.text;
      }
    }
  }
  EXPECT_GT(num_texts, 5000u);
}

TEST(Glossary, FindsWordsInLiterals) {
  const auto texts =
      Literals("// \"a picture\"\n#include \"a b\"\nWarn(\"A \\\"Picture\\\"\", \"picture\");\n");
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_EQ(texts[0].line, 3);
  EXPECT_EQ(texts[0].text, "a \\\"picture\\\"");
}

/// A line of a source without comment and literals.
std::string Code(std::string line) {
  static const std::regex literal(R"re("(?:\\.|[^"\\])*")re");
  line = std::regex_replace(line, literal, "\"\"");
  return line.substr(0, line.find("//"));
}

TEST(Glossary, IdentifiersUseItsWords) {
  // Only those that no other word of an identifier contains.
  const std::vector<std::string> avoid = {"picture", "dearest", "fidelity"};
  for (const std::string& file : FilesWithMessages()) {
    if (file.ends_with(".json")) continue;
    std::istringstream in(ReadTextFile(kGlossaryRoot / file));
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      const std::string code = InLowerCase(Code(line));
      for (const std::string& word : avoid) {
        EXPECT_EQ(code.find(word), code.npos) << file << ":" << number << ": " << line;
      }
    }
  }
  EXPECT_EQ(Code("int a = Of(\"a \\\"picture\\\"\", b);  // Of a picture"),
            "int a = Of(\"\", b);  ");
}

/// The wings whose comments are held against the glossary.
const std::vector<std::string> kWingsWithCheckedComments = {
    "base", "data", "physics", "imaging", "patient", "rig", "scene", "window", "assess", "run"};

/// The comment of a line, without code spans and names of parameters; empty if it has none.
std::string Comment(std::string line) {
  if (line.find("//") == line.npos) return "";
  static const std::regex literal(R"re("(?:\\.|[^"\\])*")re");
  static const std::regex code(R"re(`[^`]*`|@param [\w, ]+?  )re");
  line = std::regex_replace(line, literal, "\"\"");
  const auto begin = line.find("//");
  return begin == line.npos ? "" : std::regex_replace(line.substr(begin), code, "");
}

TEST(Glossary, CommentsUseItsWords) {
  std::vector<GlossaryWord> words = WordsToAvoid();
  // The usual word for adjacent voxels, nodes and triangles.
  std::erase_if(words,
                [](const GlossaryWord& word) { return word.avoid.starts_with("neighbour"); });
  // A whole line that begins like this has no subject; at the end of a line the member is that.
  const std::regex without_subject(R"re(^\s*//[/!]? ?Of )re");
  std::size_t num_comments = 0;
  for (const std::string& file : FilesWithMessages()) {
    const bool is_checked = std::ranges::any_of(
        kWingsWithCheckedComments,
        [&file](const std::string& wing) { return file.starts_with("lib/acus/" + wing + "/"); });
    if ((!is_checked && !file.starts_with("apps/")) || file.ends_with(".json")) continue;
    std::istringstream in(ReadTextFile(kGlossaryRoot / file));
    int number = 0;
    std::string previous;
    for (std::string line; std::getline(in, line); previous = line) {
      ++number;
      const std::string comment = InLowerCase(Comment(line));
      if (comment.empty()) continue;
      ++num_comments;
      for (const GlossaryWord& word : words) {
        EXPECT_FALSE(word.IsIn(comment)) << file << ":" << number << ": say '" << word.say
                                         << "', not '" << word.avoid << "': " << line;
      }
      const bool begins = previous.find("//") == previous.npos;
      EXPECT_FALSE(begins && std::regex_search(line, without_subject))
          << file << ":" << number << ": name the quantity: " << line;
    }
  }
  EXPECT_GT(num_comments, 10000u);
}

TEST(Glossary, FindsTheCommentOfALine) {
  EXPECT_EQ(Comment("F(\"// a\");  // One `code`."), "// One .");
  EXPECT_EQ(Comment("/// @param wanted  By pixel."), "/// By pixel.");
  EXPECT_EQ(Comment("int a;"), "");
}

TEST(Glossary, PagesUseItsWords) {
  const std::vector<GlossaryWord> words = WordsToAvoid();
  ASSERT_GT(words.size(), 50u);
  const std::vector<std::string> pages = PagesWithProse();
  ASSERT_GT(pages.size(), 40u);
  for (const std::string& page : pages) {
    const std::string text = ReadTextFile(kGlossaryRoot / page);
    EXPECT_EQ(std::ranges::count(text, '`') % 2, 0) << page << ": a code span does not end";
    int number = 0;
    for (const std::string& line : ProseLines(text)) {
      ++number;
      for (const GlossaryWord& word : words) {
        EXPECT_FALSE(word.IsIn(line)) << page << ":" << number << ": say '" << word.say
                                      << "', not '" << word.avoid << "': " << line;
      }
    }
  }
}

TEST(Glossary, ReadsProseAndNothingElse) {
  const auto lines = ProseLines(
      "One Picture.\n```\na picture\n```\nSee [it](picture.md), `picture`,\n{{text\npicture\n}}\n");
  const std::vector<GlossaryWord> words = WordsToAvoid();
  const auto picture = std::ranges::find(words, "pictures?", &GlossaryWord::avoid);
  ASSERT_NE(picture, words.end());
  std::vector<bool> found;
  for (const std::string& line : lines) {
    found.push_back(picture->IsIn(line));
  }
  EXPECT_EQ(found, (std::vector<bool>{true, false, false, false, false, false, false, false}));
}

TEST(Glossary, ItsExceptionsAreThere) {
  for (const std::string& exception : kGlossaryExceptions) {
    EXPECT_TRUE(std::filesystem::exists(kGlossaryRoot / exception)) << exception;
  }
}

}  // namespace
}  // namespace acus
