#include "acus/assess/dataset/dataset.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include "acus/assess/dataset/sequence_maker.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/parallel.h"

namespace acus::dataset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The patients of each split, in the order of the config.
json SplitsJson(const DatasetConfig& config, const std::vector<std::size_t>& split_of) {
  json splits = json::object();
  for (std::size_t n = 0; n < kSplitNames.size(); ++n) {
    json ids = json::array();
    for (std::size_t p = 0; p < split_of.size(); ++p) {
      if (split_of[p] == n) ids.push_back(config.patients[p].id);
    }
    splits[kSplitNames[n]] = ids;
  }
  return splits;
}

/// The classes of all sequences, by value.
/// @throws InputError if a value has two names.
json AllClasses(const std::vector<MadeSequence>& sequences) {
  std::map<int, json> by_value;
  for (const MadeSequence& sequence : sequences) {
    for (const json& one : sequence.classes) {
      const auto [known, added] = by_value.emplace(one.at("value").get<int>(), one);
      ACUS_REQUIRE(added || known->second.at("name") == one.at("name"), "patient ",
                   sequence.entry.at("patient").get<std::string>(), ": label ", known->first,
                   " is named ", one.at("name").get<std::string>(), ", in another patient ",
                   known->second.at("name").get<std::string>(),
                   "; give both label maps the same numbers");
    }
  }
  json classes = json::array();
  for (const auto& [value, one] : by_value) classes.push_back(one);
  return classes;
}

/// images/%05d.png of a frame, or the file of a stack.
std::string FileOf(const MadeSequence& sequence, const char* kind, std::size_t frame) {
  const std::string pattern =
      sequence.entry.at("folder").get<std::string>() + "/" + sequence.files.at(kind);
  const auto number = pattern.find("%05d");
  if (number == pattern.npos) return pattern;
  char text[16];
  std::snprintf(text, sizeof text, "%05zu", frame);
  return pattern.substr(0, number) + text + pattern.substr(number + 4);
}

/// The rows of all sequences; columns with patient, split and files precede their own.
std::string AllFrames(const std::vector<MadeSequence>& sequences) {
  std::string text = "split,patient,sequence,image,labels";
  for (const std::string& column : replay::FrameTable::Columns()) text += ',' + column;
  text += '\n';
  for (const MadeSequence& sequence : sequences) {
    const std::string belongs = sequence.entry.at("split").get<std::string>() + ',' +
                                sequence.entry.at("patient").get<std::string>() + ',' +
                                sequence.entry.at("sequence").get<std::string>() + ',';
    for (std::size_t n = 0; n < sequence.table.num_rows(); ++n) {
      text += belongs + FileOf(sequence, "image", n) + ',' + FileOf(sequence, "labels", n);
      for (const double value : sequence.table.row(n)) {
        text += ',';
        if (!std::isnan(value)) text += NumberText(value);
      }
      text += '\n';
    }
  }
  return text;
}

json ManifestOf(const DatasetConfig& config, std::uint64_t seed,
                const std::vector<std::size_t>& split_of,
                const std::vector<MadeSequence>& sequences) {
  json rows = json::array();
  std::map<std::string, std::size_t> frames;
  for (const char* name : kSplitNames) frames[name] = 0;
  for (const MadeSequence& sequence : sequences) {
    rows.push_back(sequence.entry);
    frames[sequence.entry.at("split")] += sequence.table.num_rows();
  }
  return {{"format", "acus-dataset-manifest/1"},
          {"name", config.name},
          {"seed", seed},
          {"splits", SplitsJson(config, split_of)},
          {"frames", frames},
          {"image_width_px", config.image_width_px},
          {"image_height_px", config.image_height_px},
          {"files", sequences.front().files},
          {"classes", AllClasses(sequences)},
          {"sequences", rows}};
}

/// Makes several sequences at a time, in batches, so that this thread reports progress.
std::vector<MadeSequence> MakeSequences(const DatasetConfig& config,
                                        const std::vector<std::size_t>& split_of,
                                        replay::LabelFormat format, const fs::path& folder,
                                        const RunContext& context) {
  std::vector<MadeSequence> sequences(static_cast<std::size_t>(config.num_sequences));
  const int piece = std::max(4 * context.num_threads, config.num_sequences / 50);
  for (int from = 0; from < config.num_sequences; from += piece) {
    context.Checkpoint("sequences", static_cast<double>(from) / config.num_sequences);
    const int count = std::min(piece, config.num_sequences - from);
    ParallelFor(count, context.num_threads, [&](int i) {
      const SequencePlan plan = DrawSequence(config, context.seed, from + i);
      sequences[static_cast<std::size_t>(from + i)] =
          MakeSequence(config, plan, kSplitNames[split_of[plan.patient]], format,
                       folder / "sequences" / plan.Name(), context);
    });
  }
  context.Checkpoint("sequences", 1.0);
  return sequences;
}

/// Reports each warning once, and records the inputs.
void KeepNotes(const std::vector<MadeSequence>& sequences, const fs::path& folder,
               RunContext& context) {
  std::set<std::string> reported;
  for (const MadeSequence& sequence : sequences) {
    for (const std::string& warning : sequence.warnings) {
      if (reported.insert(warning).second) {
        context.Warn("patient " + sequence.entry.at("patient").get<std::string>() + ": " + warning);
      }
    }
    for (const auto& [path, hash] : sequence.input_sha256) {
      // The probe file of a sequence is an output of this program.
      if (!path.starts_with(folder.string())) context.provenance.input_sha256[path] = hash;
    }
  }
}

std::string SplitsText(const json& splits) {
  std::string text;
  for (const char* name : kSplitNames) {
    text += std::string(name) + ":";
    for (const json& id : splits.at(name)) text += ' ' + id.get<std::string>();
    text += '\n';
  }
  return text;
}

}  // namespace

std::string PlanText(const DatasetConfig& config, std::uint64_t seed) {
  const auto split_of = SplitPatients(config, seed);
  std::string text = SplitsText(SplitsJson(config, split_of));
  for (int n = 0; n < config.num_sequences; ++n) {
    const SequencePlan plan = DrawSequence(config, seed, n);
    text += Message(plan.Name(), "  ", config.patients[plan.patient].id, "  ",
                    plan.scenario.stem().string(), "  ", plan.trainee.stem().string(), "  ",
                    plan.probe.empty() ? "" : plan.probe.stem().string() + "  ",
                    plan.needle.empty() ? "" : plan.needle.stem().string() + "  ", "gain ",
                    plan.probe_change.gain_offset_db, " dB\n");
  }
  return text;
}

std::string WriteDataset(const DatasetConfig& config, replay::LabelFormat format,
                         const fs::path& target, RunContext& context) {
  AtomicFolder folder(target, context.overwrite);
  context.provenance.AddInput(config.file);
  const auto split_of = SplitPatients(config, context.seed);
  const auto sequences = MakeSequences(config, split_of, format, folder.path(), context);
  const json manifest = ManifestOf(config, context.seed, split_of, sequences);
  config::WriteJson(folder.path() / "manifest.json", manifest);
  WriteTextFile(folder.path() / "frames.csv", AllFrames(sequences));
  KeepNotes(sequences, folder.path(), context);
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  std::size_t frames = 0;
  for (const MadeSequence& sequence : sequences) frames += sequence.table.num_rows();
  return Message(frames, " images of ", sequences.size(), " insertions in ", config.patients.size(),
                 " patients.\n", SplitsText(manifest.at("splits")));
}

}  // namespace acus::dataset
