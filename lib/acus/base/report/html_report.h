// A report as one HTML file: opens from disk with no network, reads well on screen and on paper.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "acus/base/report/svg_plot.h"

namespace acus::report {

/// Built from top to bottom, then written. All texts are plain UTF-8 and are escaped here.
class HtmlReport {
 public:
  explicit HtmlReport(std::string title, std::string subtitle = "");

  /// Begins a section; it appears in the table of contents.
  void Section(const std::string& heading);

  void Paragraph(const std::string& text);

  /// A list of names and values, values with their units.
  void KeyValues(std::span<const std::pair<std::string, std::string>> rows);

  /// Cells that are numbers are set flush right. @pre every row has as many cells as `header`.
  void Table(const std::vector<std::string>& header,
             const std::vector<std::vector<std::string>>& rows, const std::string& caption = "");

  /// Plots above each other with one x axis; values can be read off with the mouse.
  void Plots(std::span<const Plot> plots, const std::string& caption = "");

  /// Any other SVG image, embedded as it is: its texts are escaped already.
  void Drawing(const std::string& svg, const std::string& caption = "");

  /// A PNG file, embedded. `alt` says what is to be seen, for those who cannot see it.
  /// @throws InputError if it cannot be read or is not a PNG.
  void Image(const std::filesystem::path& png, const std::string& alt,
             const std::string& caption = "");

  /// A video that lies beside the report: linked by its path relative to it, not embedded.
  void Film(const std::filesystem::path& relative_path, const std::string& caption = "");

  /// What the user should read before trusting the numbers; stands at the top of the report.
  void Warnings(std::span<const std::string> texts);

  /// What made the report (Provenance::ToJson()); stands at its end.
  void SetProvenance(const nlohmann::json& provenance);

  /// The whole document.
  std::string Text() const;

  /// Writes Text(), whole or not at all.
  void Write(const std::filesystem::path& path) const;

 private:
  void Figure(const std::string& content, const std::string& caption);

  std::string title_;
  std::string subtitle_;
  std::vector<std::string> headings_;
  std::string warnings_;
  std::string body_;
  std::string provenance_;
};

}  // namespace acus::report
