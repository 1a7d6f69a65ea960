#include "acus/data/session/frame_guess.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <span>
#include <string_view>

namespace acus::session {
namespace {

std::string Lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Frames whose name has one of the words, in the order of the words.
std::vector<std::string> Having(std::span<const std::string_view> words,
                                const std::vector<std::string>& frames) {
  std::vector<std::string> found;
  for (const std::string_view word : words) {
    for (const std::string& frame : frames) {
      const bool is_new = std::ranges::find(found, frame) == found.end();
      if (is_new && Lower(frame).find(word) != std::string::npos) found.push_back(frame);
    }
  }
  return found;
}

std::string ReferenceOf(const std::vector<transforms::TransformName>& names) {
  std::map<std::string, int> count;
  for (const auto& name : names) ++count[name.to];
  for (const char* usual : {"Reference", "Tracker", "RAS", "World"}) {
    if (count.contains(usual)) return usual;
  }
  return std::ranges::max_element(count, {}, [](const auto& frame) { return frame.second; })->first;
}

/// Frames that transforms connect with the reference, the nearest first.
std::vector<std::string> ConnectedWith(const std::string& reference,
                                       const std::vector<transforms::TransformName>& names) {
  std::vector<std::string> reached = {reference};
  for (std::size_t i = 0; i < reached.size(); ++i) {
    const std::string here = reached[i];
    for (const auto& name : names) {
      if (name.from != here && name.to != here) continue;
      const std::string& other = name.from == here ? name.to : name.from;
      if (std::ranges::find(reached, other) == reached.end()) reached.push_back(other);
    }
  }
  reached.erase(reached.begin());
  return reached;
}

}  // namespace

std::optional<FrameGuess> GuessFrames(const std::vector<transforms::TransformName>& names) {
  if (names.empty()) return {};
  FrameGuess guess{.reference = ReferenceOf(names), .needle = {}, .probe = {}};
  const std::vector<std::string> frames = ConnectedWith(guess.reference, names);
  constexpr std::array<std::string_view, 3> kNeedle = {"needle", "stylus", "pointer"};
  constexpr std::array<std::string_view, 3> kProbe = {"transducer", "probe", "image"};
  guess.needle = Having(kNeedle, frames);
  guess.probe = Having(kProbe, frames);
  if (guess.needle.empty() && guess.probe.empty() && !frames.empty()) {
    guess.needle = {frames.front()};
  }
  return guess;
}

}  // namespace acus::session
