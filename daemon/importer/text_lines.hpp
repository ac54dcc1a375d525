// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/os/file_descriptor.hpp"

namespace eha::importer {

/// `text` in another character set as UTF-8; none when it is not text of that set. @param from  a name of iconv(1)
[[nodiscard]] std::optional<std::string> to_utf8(std::string_view text, const char* from);

/// The lines of a text file, whatever its character set and line ends: UTF-8, UTF-16 (with or without a byte order
/// mark), else Windows-1252, of which Latin-1 is a part; LF, CR LF, or CR. Constant memory; the file is read once, so
/// it may be a pipe. UTF-16 is converted with iconv; of the others `decoded` converts what is shown.
class TextLines {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{1} << 16U;

  /// Reads the beginning. @param text  an open file that has the text; none: that of the path, which messages name
  /// @throws IoError, PermissionError, DataError
  explicit TextLines(const std::filesystem::path& path, os::FileDescriptor text = {});
  TextLines(const TextLines&) = delete;
  TextLines& operator=(const TextLines&) = delete;
  ~TextLines();

  /// The first lines, at most 64 KiB of text; reading them again with next() is possible.
  [[nodiscard]] std::vector<std::string> first_lines(std::size_t most) const;
  /// The next line without its end, valid until the next call; none at the end of the file.
  [[nodiscard]] std::optional<std::string_view> next();
  /// Number of the line that next() gave last, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// Whether that line is the last one and has no end, as where a copy broke off.
  [[nodiscard]] bool is_unfinished() const { return is_unfinished_; }
  /// Share of the file that was read, 0..1; 0 when its size is unknown.
  [[nodiscard]] double share() const;
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// "UTF-16", "Latin-1"; empty for UTF-8 and ASCII.
  [[nodiscard]] const std::string& encoding() const { return encoding_; }
  /// Text of the file as UTF-8.
  [[nodiscard]] std::string decoded(std::string_view text) const;
  [[noreturn]] void fail(const std::string& what) const;

 private:
  void fill();
  void convert_utf16(std::string_view bytes);
  void choose_encoding();

  std::filesystem::path path_;
  os::FileDescriptor file_;
  std::uint64_t size_ = 0;
  std::uint64_t bytes_read_ = 0;
  std::string encoding_;
  std::unique_ptr<void, int (*)(void*)> converter_;  ///< iconv_t, for UTF-16
  std::string rest_;                                 ///< bytes of an incomplete UTF-16 character
  std::string text_;                                 ///< read and not yet handed out, from begin_
  std::size_t begin_ = 0;
  char line_end_ = '\n';
  bool at_end_ = false;
  bool is_unfinished_ = false;
  std::size_t line_ = 0;
};

}  // namespace eha::importer
