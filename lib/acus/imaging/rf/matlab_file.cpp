#include "acus/imaging/rf/matlab_file.h"

#include <array>
#include <cstdint>
#include <matio.h>
#include <memory>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/core/input_file.h"
#include "acus/imaging/rf/matlab_elements.h"

namespace acus::rf {
namespace {

struct CloseMatlab {
  void operator()(mat_t* file) const { Mat_Close(file); }
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using MatlabFile = std::unique_ptr<mat_t, CloseMatlab>;
using MatlabVariable = std::unique_ptr<matvar_t, CloseMatlab>;

/// The library prints on stderr otherwise; what it finds wrong shows in what it returns.
void SilenceMatio() {
  Mat_LogInitFunc(nullptr, [](int, char*) {});
}

template <typename T>
void CopyNumbers(const matvar_t& variable, std::vector<float>& out) {
  const auto* in = static_cast<const T*>(variable.data);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(in[i]);
}

/// @return false if the class is not one of real numbers.
bool CopyValues(const matvar_t& variable, std::vector<float>& out) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      CopyNumbers<double>(variable, out);
      return true;
    case MAT_C_SINGLE:
      CopyNumbers<float>(variable, out);
      return true;
    case MAT_C_INT8:
      CopyNumbers<std::int8_t>(variable, out);
      return true;
    case MAT_C_UINT8:
      CopyNumbers<std::uint8_t>(variable, out);
      return true;
    case MAT_C_INT16:
      CopyNumbers<std::int16_t>(variable, out);
      return true;
    case MAT_C_UINT16:
      CopyNumbers<std::uint16_t>(variable, out);
      return true;
    case MAT_C_INT32:
      CopyNumbers<std::int32_t>(variable, out);
      return true;
    case MAT_C_UINT32:
      CopyNumbers<std::uint32_t>(variable, out);
      return true;
    default:
      return false;
  }
}

bool IsNumeric(const matvar_t& variable) {
  return variable.class_type >= MAT_C_DOUBLE && variable.class_type <= MAT_C_UINT32;
}

/// The number of values; 0 if the shape is not that of channel data.
std::size_t CountOf(const matvar_t& variable) {
  if (variable.rank != 2 && variable.rank != 3) return 0;
  std::size_t count = 1;
  for (int d = 0; d < variable.rank; ++d) {
    constexpr std::size_t kMost = std::size_t{1} << 31;
    const std::size_t size = variable.dims[d];
    if (size == 0 || size > kMost / count) return 0;
    count *= size;
  }
  return count;
}

/// Reads headers until the one that was requested. Adds the names of all variables to `names`.
MatlabVariable FindHeader(mat_t* file, const std::string& variable, std::string& names) {
  while (MatlabVariable header{Mat_VarReadNextInfo(file)}) {
    if (header->name == nullptr) continue;
    names += (names.empty() ? "" : ", ") + std::string(header->name);
    const bool wanted =
        variable.empty() ? IsNumeric(*header) && CountOf(*header) > 1 : header->name == variable;
    if (wanted) return header;
  }
  return nullptr;
}

void AddVariable(mat_t* file, const std::filesystem::path& path, const char* name,
                 matio_classes number_class, matio_types type, std::span<const std::size_t> dims,
                 const void* values) {
  std::vector<std::size_t> sizes(dims.begin(), dims.end());
  const MatlabVariable variable(Mat_VarCreate(name, number_class, type,
                                              static_cast<int>(sizes.size()), sizes.data(),
                                              const_cast<void*>(values), MAT_F_DONT_COPY_DATA));
  ACUS_REQUIRE(variable != nullptr && Mat_VarWrite(file, variable.get(), MAT_COMPRESSION_ZLIB) == 0,
               path.string(), ": cannot be written; is the disk full?");
}

}  // namespace

ChannelData ReadMatlab(const std::filesystem::path& path, const std::string& variable) {
  SilenceMatio();
  RequireSoundMatlab(path);
  const MatlabFile file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  ACUS_REQUIRE(file != nullptr, path.string(),
               ": is not a MATLAB file; save the channel data with save -v7");
  std::string names;
  const MatlabVariable found = FindHeader(file.get(), variable, names);
  ACUS_REQUIRE(found != nullptr, path.string(), ": has no ",
               variable.empty() ? "array of numbers" : "variable '" + variable + "'", "; it has ",
               names.empty() ? "none that can be read" : names);
  const std::size_t count = CountOf(*found);
  ACUS_REQUIRE(
      count > 0 && found->isComplex == 0, path.string(), ": ", found->name,
      ": must be a real array of samples x elements or samples x elements x transmissions");
  RequireMemory(static_cast<double>(count * (Mat_SizeOfClass(found->class_type) + sizeof(float))),
                static_cast<double>(std::filesystem::file_size(path)), path.string());
  ChannelData data;
  data.samples = static_cast<int>(found->dims[0]);
  data.elements = static_cast<int>(found->dims[1]);
  data.transmits = found->rank == 3 ? static_cast<int>(found->dims[2]) : 1;
  const bool read = Mat_VarReadDataAll(file.get(), found.get()) == 0 && found->data != nullptr &&
                    found->nbytes == count * Mat_SizeOfClass(found->class_type);
  ACUS_REQUIRE(read, path.string(), ": ", found->name,
               ": the values cannot be read; is the file cut off or damaged?");
  data.values.resize(count);
  ACUS_REQUIRE(CopyValues(*found, data.values), path.string(), ": ", found->name,
               ": is not an array of real numbers");
  return data;
}

double ReadMatlabNumber(const std::filesystem::path& path, const std::string& name) {
  SilenceMatio();
  RequireSoundMatlab(path);
  const MatlabFile file(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  ACUS_REQUIRE(file != nullptr, path.string(), ": is not a MATLAB file; save with save -v7");
  const std::size_t dot = name.find('.');
  const MatlabVariable variable(Mat_VarRead(file.get(), name.substr(0, dot).c_str()));
  matvar_t* found = variable.get();
  if (found != nullptr && dot != std::string::npos) {
    found = found->class_type == MAT_C_STRUCT
                ? Mat_VarGetStructFieldByName(found, name.substr(dot + 1).c_str(), 0)
                : nullptr;
  }
  std::vector<float> is_number(1);
  ACUS_REQUIRE(found != nullptr && found->data != nullptr && found->isComplex == 0 &&
                   found->rank == 2 && found->dims[0] * found->dims[1] == 1 &&
                   CopyValues(*found, is_number),
               path.string(), ": has no number '", name,
               "'; correct its name in /recording of the settings");
  return found->class_type == MAT_C_DOUBLE ? *static_cast<const double*>(found->data)
                                           : static_cast<double>(is_number[0]);
}

void WriteMatlab(const std::filesystem::path& path, const ChannelData& data) {
  AtomicFile out(path);
  MatlabFile file(
      Mat_CreateVer(out.path().c_str(), "MATLAB 5.0 MAT-file, channel data by Acus", MAT_FT_MAT5));
  ACUS_REQUIRE(file != nullptr, path.string(), ": cannot be written; may you write to its folder?");
  const std::array<std::size_t, 3> shape = {static_cast<std::size_t>(data.samples),
                                            static_cast<std::size_t>(data.elements),
                                            static_cast<std::size_t>(data.transmits)};
  AddVariable(file.get(), path, "rf", MAT_C_SINGLE, MAT_T_SINGLE, shape, data.values.data());
  const std::array<std::size_t, 2> one = {1, 1};
  const double rate_hz = 1e6 * data.sampling_mhz;
  const double start_s = 1e-6 * data.start_us;
  AddVariable(file.get(), path, "fs_hz", MAT_C_DOUBLE, MAT_T_DOUBLE, one, &rate_hz);
  AddVariable(file.get(), path, "t0_s", MAT_C_DOUBLE, MAT_T_DOUBLE, one, &start_s);
  ACUS_REQUIRE(Mat_Close(file.release()) == 0, path.string(),
               ": cannot be written; is the disk full?");
  out.Commit();
}

}  // namespace acus::rf
