#pragma once

#include <netcdf.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace concord::compare {

/// A NetCDF-4 file that is built in memory: on a disk that is full, HDF5 ends the program. All throw
/// std::runtime_error, with the call that failed, if the library refuses.
class NetcdfFile {
 public:
  explicit NetcdfFile(const std::filesystem::path& path);
  ~NetcdfFile();
  NetcdfFile(const NetcdfFile&) = delete;
  NetcdfFile& operator=(const NetcdfFile&) = delete;

  int dimension(const char* name, std::size_t length);
  int variable(const char* name, nc_type type, const std::vector<int>& dimensions);
  void attribute(int variable, const char* name, const std::string& text);
  void put(int variable, const std::vector<double>& numbers);
  void put(int variable, const std::vector<std::string>& texts);

  /// Writes the file; throws as write_file() does.
  void finish();

 private:
  void check(int code, const char* call) const;

  std::filesystem::path path_;
  int id_ = 0;
  bool open_ = false;
};

}  // namespace concord::compare
