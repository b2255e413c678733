#include "compare/report/netcdf_file.h"

#include <fmt/format.h>
#include <netcdf_mem.h>

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "compare/report/files.h"

namespace concord::compare {

namespace {

/// The bytes of an HDF5 file in memory without the unused room behind its end, which its superblock tells (HDF5 File
/// Format Specification, II.A: of version 0, with offsets of eight bytes).
std::string_view without_room(const NC_memio& image) {
  constexpr std::size_t kVersion = 8;
  constexpr std::size_t kOffsetSize = 13;
  constexpr std::size_t kEndOfFile = 40;
  const std::string_view bytes(static_cast<const char*>(image.memory), image.size);
  if (bytes.size() < kEndOfFile + sizeof(std::uint64_t) || bytes[kVersion] != 0 || bytes[kOffsetSize] != 8)
    return bytes;
  std::uint64_t end = 0;
  for (std::size_t k = 0; k < sizeof end; ++k) {
    end |= std::uint64_t{static_cast<unsigned char>(bytes[kEndOfFile + k])} << (8 * k);
  }
  return bytes.substr(0, end);
}

}  // namespace

NetcdfFile::NetcdfFile(const std::filesystem::path& path) : path_(path) {
  constexpr std::size_t kFirstBytes = 1 << 16;
  // Where the library gives up, it removes the file of this name, in memory or not: no file can have it.
  const std::filesystem::path nowhere = path / "in memory";
  check(nc_create_mem(nowhere.c_str(), NC_NETCDF4, kFirstBytes, &id_), "nc_create_mem");
  open_ = true;
}

NetcdfFile::~NetcdfFile() {
  if (open_) nc_abort(id_);
}

int NetcdfFile::dimension(const char* name, std::size_t length) {
  int dimension = 0;
  check(nc_def_dim(id_, name, length, &dimension), "nc_def_dim");
  return dimension;
}

int NetcdfFile::variable(const char* name, nc_type type, const std::vector<int>& dimensions) {
  int variable = 0;
  const int count = static_cast<int>(dimensions.size());
  check(nc_def_var(id_, name, type, count, dimensions.data(), &variable), "nc_def_var");
  return variable;
}

void NetcdfFile::attribute(int variable, const char* name, const std::string& text) {
  check(nc_put_att_text(id_, variable, name, text.size(), text.c_str()), "nc_put_att_text");
}

void NetcdfFile::put(int variable, const std::vector<double>& numbers) {
  check(nc_put_var_double(id_, variable, numbers.data()), "nc_put_var_double");
}

void NetcdfFile::put(int variable, const std::vector<std::string>& texts) {
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  check(nc_put_var_string(id_, variable, pointers.data()), "nc_put_var_string");
}

void NetcdfFile::finish() {
  open_ = false;
  NC_memio image{};
  check(nc_close_memio(id_, &image), "nc_close_memio");
  const std::unique_ptr<void, decltype(&std::free)> bytes(image.memory, &std::free);
  write_file(path_, without_room(image));
}

void NetcdfFile::check(int code, const char* call) const {
  if (code == NC_NOERR) return;
  throw std::runtime_error(fmt::format("{}: cannot be written: {}: {}", path_.string(), call, nc_strerror(code)));
}

}  // namespace concord::compare
