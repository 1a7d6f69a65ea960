// Words and numbers of a text held in memory, line by line.
#pragma once

#include <charconv>
#include <string>
#include <string_view>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/number_text.h"

namespace acus::mesh {

/// Walks over the lines of `text`; LF and CRLF. Messages carry "label:line".
class TextScanner {
 public:
  TextScanner(std::string_view text, std::string label) : text_(text), label_(std::move(label)) {}

  /// Moves to the next line that holds a word; its words are in words(). False at the end.
  bool NextLine() {
    while (position_ < text_.size()) {
      words_.clear();
      AddLine();
      if (!words_.empty()) return true;
    }
    position_ = std::min(position_, text_.size());
    return false;
  }
  /// Adds the words of the lines that a backslash at the end of this one continues, as OBJ does.
  void JoinContinuedLines() {
    while (!words_.empty() && words_.back().ends_with('\\')) {
      words_.back().remove_suffix(1);
      if (words_.back().empty()) words_.pop_back();
      if (position_ >= text_.size()) return;
      AddLine();
    }
  }
  const std::vector<std::string_view>& words() const { return words_; }
  std::size_t position() const { return position_; }  ///< Of the byte after the current line.
  std::string Where() const { return Message(label_, ":", line_); }

  /// Word `index` of this line as a finite number.
  double Number(std::size_t index) const {
    ACUS_REQUIRE(index < words_.size(), Where(), ": a number is missing; is the file cut off?");
    std::string_view word = words_[index];
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto value = ParseFinite(word);
    ACUS_REQUIRE(value, Where(), ": '", words_[index], "' is not a finite number");
    return *value;
  }

  /// Leading whole number of word `index`, up to its end or a '/'.
  long long Whole(std::size_t index) const {
    ACUS_REQUIRE(index < words_.size(), Where(), ": a whole number is missing");
    const std::string_view word = words_[index];
    long long value = 0;
    const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    ACUS_REQUIRE(error == std::errc() && (rest == word.data() + word.size() || *rest == '/'),
                 Where(), ": '", word, "' is not a whole number");
    return value;
  }

 private:
  void AddLine() {
    const std::size_t line_end = std::min(text_.find('\n', position_), text_.size());
    const std::string_view line = text_.substr(position_, line_end - position_);
    position_ = line_end + 1;
    ++line_;
    constexpr std::string_view kBlank = " \t\r\v\f";
    for (std::size_t at = line.find_first_not_of(kBlank); at != std::string_view::npos;) {
      const std::size_t end = std::min(line.find_first_of(kBlank, at), line.size());
      words_.push_back(line.substr(at, end - at));
      at = line.find_first_not_of(kBlank, end);
    }
  }

  std::string_view text_;
  std::string label_;
  std::size_t position_ = 0;
  std::size_t line_ = 0;
  std::vector<std::string_view> words_;
};

}  // namespace acus::mesh
