// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <hdf5.h>

#include <utility>

namespace eha::record {

/// Owns one HDF5 identifier and closes it with `Close`. HDF5 as built in Debian is not thread-safe: one thread at a
/// time.
template <herr_t (*Close)(hid_t)>
class Hdf5Handle {
 public:
  explicit Hdf5Handle(hid_t identifier) noexcept : identifier_(identifier) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : identifier_(std::exchange(other.identifier_, H5I_INVALID_HID)) {}
  Hdf5Handle& operator=(Hdf5Handle&&) = delete;
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle() { close(); }

  [[nodiscard]] hid_t get() const noexcept { return identifier_; }
  [[nodiscard]] explicit operator bool() const noexcept { return identifier_ >= 0; }

  /// @returns whether the library closed it without an error; a full disk may show only now
  bool close() noexcept { return identifier_ < 0 || Close(std::exchange(identifier_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t identifier_;
};

using Hdf5File = Hdf5Handle<H5Fclose>;
using Hdf5Dataset = Hdf5Handle<H5Dclose>;
using Hdf5Space = Hdf5Handle<H5Sclose>;
using Hdf5Type = Hdf5Handle<H5Tclose>;
using Hdf5Attribute = Hdf5Handle<H5Aclose>;
using Hdf5Properties = Hdf5Handle<H5Pclose>;

/// Whether reading a dataset would read another file.
inline bool is_elsewhere(hid_t dataset) {
  const Hdf5Properties how(H5Dget_create_plist(dataset));
  return H5Pget_external_count(how.get()) > 0 || H5Pget_layout(how.get()) == H5D_VIRTUAL;
}

/// Keeps HDF5 from printing its error stack while this lives: errors become exceptions.
class QuietHdf5 {
 public:
  QuietHdf5() noexcept {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  QuietHdf5(const QuietHdf5&) = delete;
  QuietHdf5& operator=(const QuietHdf5&) = delete;
  ~QuietHdf5() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

}  // namespace eha::record
