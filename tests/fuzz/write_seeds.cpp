// Writes the seeds of all readers: write_seeds FOLDER makes FOLDER/READER/*, and prints the
// readers.
#include <cstdio>

#include "fuzz/readers.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  for (const auto& reader : acus::fuzz::Readers()) {
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / reader.name;
    std::filesystem::create_directories(folder);
    reader.write_seeds(folder);
    std::printf("%.*s\n", static_cast<int>(reader.name.size()), reader.name.data());
  }
  return 0;
}
