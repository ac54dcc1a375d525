// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/hdf5_heaps.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "core/error.hpp"
#include "core/os/file_descriptor.hpp"
#include "core/os/files.hpp"
#include "daemon/record/hdf5_handle.hpp"

namespace eha::importer {
namespace {

constexpr std::string_view kSignature("GCOL\1", 5);  // with its version
constexpr std::uint64_t kHead = 16;                  // signature, version, the heap's bytes
constexpr std::uint64_t kObjectHead = 16;            // index, references, the object's bytes
constexpr std::uint64_t kLeastHeap = 4096;

std::uint64_t number_at(std::string_view bytes, std::uint64_t at) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

/// @param rest  from the heap's signature to the end of the file
bool is_sound(std::string_view rest) {
  if (rest.size() < kHead) return false;
  const std::uint64_t size = number_at(rest, 8);
  if (size < kLeastHeap || size > rest.size()) return false;
  std::uint64_t at = kHead;
  // What is too short for an object is free.
  while (size - at >= kObjectHead) {
    const bool is_free = rest[at] == 0 && rest[at + 1] == 0;
    const std::uint64_t content = number_at(rest, at + 8);
    if (content > size - at) return false;
    // Free space counts its own head; contents are padded to 8 bytes.
    const std::uint64_t whole = is_free ? content : kObjectHead + (content + 7) / 8 * 8;
    if (whole < kObjectHead || whole > size - at) return false;
    at += whole;
  }
  return true;
}

/// A file in memory, read only.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& path) : size_(std::filesystem::file_size(path)) {
    if (size_ == 0) return;
    const os::FileDescriptor file = os::open_regular_file(path);
    address_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.get(), 0);
    if (address_ == MAP_FAILED) throw IoError(path.string() + ": cannot be mapped: " + error_text(errno));
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile() {
    if (size_ > 0) munmap(address_, size_);
  }
  [[nodiscard]] std::string_view bytes() const { return {static_cast<const char*>(address_), size_}; }

 private:
  std::size_t size_;
  void* address_ = nullptr;
};

/// Whether lengths in the file take 8 bytes, as everybody's do.
bool has_long_lengths(const std::filesystem::path& path) {
  const record::QuietHdf5 quiet;
  const record::Hdf5File file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  if (!file) return false;
  const record::Hdf5Properties creation(H5Fget_create_plist(file.get()));
  std::size_t address_bytes = 0;
  std::size_t length_bytes = 0;
  const bool is_known = H5Pget_sizes(creation.get(), &address_bytes, &length_bytes) >= 0;
  return is_known && length_bytes == sizeof(std::uint64_t);
}

}  // namespace

void check_heaps(const std::filesystem::path& path, const std::string& name) {
  const MappedFile file(path);
  const std::string_view bytes = file.bytes();
  bool is_read = true;
  bool is_found = false;
  for (std::size_t at = bytes.find(kSignature); is_read && at != std::string_view::npos;
       at = bytes.find(kSignature, at + 1)) {
    is_found = true;
    is_read = is_sound(bytes.substr(at));
  }
  if (is_read && is_found) is_read = has_long_lengths(path);
  if (!is_read) {
    throw DataError(fmt::format("{}: a text in it lies outside its place: a damaged HDF5 file; save it again", name));
  }
}

}  // namespace eha::importer
