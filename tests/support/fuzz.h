// Damages a valid file in many ways: a reader must then read something or throw InputError.
#pragma once

#include <algorithm>
#include <exception>
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <source_location>
#include <string>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/bound.h"

namespace acus::testing_support {

/// Calls `read` on `count` damaged copies of `valid`, written to `path` one after the other: cut
/// off, bits flipped, bytes replaced, a piece removed or doubled. Anything thrown but InputError
/// fails the test. @returns how many of the copies were refused.
inline int ReadDamagedCopies(const std::string& valid, const std::filesystem::path& path, int count,
                             const std::function<void()>& read,
                             std::source_location where = std::source_location::current()) {
  const HardCase hard("A file that was cut off, or whose bits, bytes or pieces are others.", where);
  int refused = 0;
  int neither = 0;
  for (int i = 0; i < count; ++i) {
    RandomStream random(/*seed=*/17, "damage", static_cast<std::uint64_t>(i));
    const auto place = [&] {
      // Half of the damage goes into the first 2 kB: there the headers are.
      const std::size_t size =
          random.Uniform() < 0.5 ? std::min<std::size_t>(2048, valid.size()) : valid.size();
      return static_cast<std::size_t>(random.Uniform() * static_cast<double>(size));
    };
    std::string damaged = valid;
    switch (i % 5) {
      case 0:
        damaged.resize(place());
        break;
      case 1:
        for (int flip = 0; flip < 1 + i % 4; ++flip) {
          char& byte = damaged[place()];
          byte = static_cast<char>(byte ^ (1 << (random.Next() % 8)));
        }
        break;
      case 2:
        damaged[place()] = "0123456789-.eE =\n,\0\xff"[random.Next() % 19];
        break;
      case 3:
        damaged.erase(place(), 1 + random.Next() % 40);
        break;
      default: {
        const std::size_t from = place();
        damaged.insert(place(), damaged.substr(from, 1 + random.Next() % 40));
        break;
      }
    }
    WriteTextFile(path, damaged);
    try {
      read();
    } catch (const InputError&) {
      ++refused;
    } catch (const std::exception& error) {
      ++neither;
      ADD_FAILURE() << "damaged copy " << i << ": not an InputError: " << error.what();
    }
  }
  hard.Expect(Message("copies neither read nor refused, of ", count, " damaged ",
                      path.extension().string(), " files"),
              neither, Exactly(0));
  return refused;
}

}  // namespace acus::testing_support
