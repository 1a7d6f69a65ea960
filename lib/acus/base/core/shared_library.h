// Vendors' libraries, loaded at run time: nothing of theirs is in this tree, and a machine without
// them runs all the rest.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace acus {

/// One row of a table of functions. `pointer` is the address of a function pointer.
struct Symbol {
  const char* name;
  void** pointer;
  bool is_required = true;
};

/// A row for the function pointer `pointer`.
template <typename Function>
Symbol Required(const char* name, Function*& pointer) {
  return {name, reinterpret_cast<void**>(&pointer), true};
}
/// The same; null where the library has no such function.
template <typename Function>
Symbol Optional(const char* name, Function*& pointer) {
  return {name, reinterpret_cast<void**>(&pointer), false};
}

struct LibraryRequest {
  std::string product;               ///< "OpenHaptics", for messages.
  std::string path;                  ///< The user's choice (CheckLibraryWord); empty: `names`.
  std::vector<std::string> names;    ///< Tried in this order.
  std::vector<std::string> preload;  ///< Loaded before it, where they are there.
  bool shares_symbols = false;       ///< RTLD_GLOBAL: parts of the product look for each other.
  std::string advice;                ///< What to do if it is not there.
  double timeout_s = 5.0;            ///< For its constructors.
};

/// Loads the library and fills the table. The library is first loaded by a separate process:
/// some hang or abort at that, and then only that process does. It is never unloaded: some fail
/// when they are loaded a second time. Asking again for the same one is cheap.
/// A path is loaded if it is a TrustedFile(); a name goes to the system's search, which must not
/// lead to the working directory (CheckSearch).
/// @throws InputError naming the library, what was tried, the loader's own words, and for a symbol
///     that is missing, which.
void LoadLibrary(const LibraryRequest& request, std::span<const Symbol> symbols);

/// The file that LoadLibrary() would try first. Loads nothing and starts no process.
/// @throws InputError as LoadLibrary() for what can be known without loading: the file is not
/// there,
///     or may not be loaded.
std::filesystem::path FindLibrary(const LibraryRequest& request);

/// Calls that may never return, one at a time.
class PatientCalls {
 public:
  /// Calls `function` in a separate thread and waits for it. If it does not return in time, the
  /// thread remains with what `function` holds: give it copies. Until it returns, later
  /// calls fail at once.
  /// @param what  "hdInitDevice of OpenHaptics", for the message.
  /// @throws InputError after `timeout_s`, and with the words of what `function` throws.
  void Call(const std::string& what, double timeout_s, std::function<void()> function);

 private:
  std::shared_ptr<std::atomic<bool>> is_busy_ = std::make_shared<std::atomic<bool>>(false);
};

}  // namespace acus
