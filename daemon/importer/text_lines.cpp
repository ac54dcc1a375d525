// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/text_lines.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <iconv.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <new>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"

namespace eha::importer {
namespace {

constexpr const char* kNulByte = "a NUL byte: this is a binary file, not CSV text";
constexpr std::size_t kReadBytes = std::size_t{1} << 18U;

class Converter {
 public:
  explicit Converter(const char* from) : handle_(iconv_open("UTF-8", from)) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): iconv(3) says so
    if (handle_ == reinterpret_cast<iconv_t>(-1)) throw std::bad_alloc();
  }
  Converter(const Converter&) = delete;
  Converter& operator=(const Converter&) = delete;
  ~Converter() { iconv_close(handle_); }
  [[nodiscard]] iconv_t get() const { return handle_; }

 private:
  iconv_t handle_;
};

/// Appends the conversion of `bytes`. @returns bytes left over: 0, or an incomplete character; none when one is invalid
std::optional<std::size_t> convert(iconv_t handle, std::string_view bytes, std::string& text) {
  std::array<char, 4096> piece{};
  // iconv does not change its input; its C prototype has no const.
  char* in = const_cast<char*>(bytes.data());
  std::size_t left = bytes.size();
  while (left > 0) {
    char* out = piece.data();
    std::size_t room = piece.size();
    const std::size_t result = iconv(handle, &in, &left, &out, &room);
    text.append(piece.data(), static_cast<std::size_t>(out - piece.data()));
    if (result != static_cast<std::size_t>(-1)) break;
    if (errno == EINVAL) return left;
    if (errno != E2BIG) return std::nullopt;
  }
  return left;
}

/// UTF-16 without a byte order mark: mostly ASCII, so that every other byte is 0.
const char* utf16_without_mark(std::string_view bytes) {
  const std::size_t pairs = std::min<std::size_t>(bytes.size() / 2, 512);
  std::size_t low_zero = 0;
  std::size_t high_zero = 0;
  for (std::size_t i = 0; i < pairs; ++i) {
    low_zero += bytes[2 * i] == '\0' ? 1 : 0;
    high_zero += bytes[2 * i + 1] == '\0' ? 1 : 0;
  }
  if (pairs < 4) return nullptr;
  if (high_zero * 10 >= pairs * 9 && low_zero == 0) return "UTF-16LE";
  if (low_zero * 10 >= pairs * 9 && high_zero == 0) return "UTF-16BE";
  return nullptr;
}

/// Whether text is UTF-8, apart from a character cut at its end.
bool is_utf8(std::string_view text) {
  const Converter converter("UTF-8");
  std::string ignored;
  return convert(converter.get(), text, ignored).has_value();
}

}  // namespace

std::optional<std::string> to_utf8(std::string_view text, const char* from) {
  const Converter converter(from);
  std::string result;
  const auto left = convert(converter.get(), text, result);
  if (!left || *left > 0) return std::nullopt;
  return result;
}

TextLines::TextLines(const std::filesystem::path& path, os::FileDescriptor text)
    : path_(path), file_(std::move(text)), converter_(nullptr, &iconv_close) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) os::throw_system_error("read", path, EISDIR);
  if (!file_) file_ = os::open_file(path, O_RDONLY);
  struct stat facts {};
  if (fstat(file_.get(), &facts) == 0 && S_ISREG(facts.st_mode)) size_ = static_cast<std::uint64_t>(facts.st_size);
  fill();
  choose_encoding();
  if (text_.find('\n') == std::string::npos && text_.find('\r') != std::string::npos) line_end_ = '\r';
}

TextLines::~TextLines() = default;

void TextLines::choose_encoding() {
  const std::string_view bytes = text_;
  const char* utf16 = nullptr;
  std::size_t mark = 0;
  if (bytes.substr(0, 3) == "\xEF\xBB\xBF") {
    text_.erase(0, 3);
    return;
  }
  if (bytes.substr(0, 2) == "\xFF\xFE" || bytes.substr(0, 2) == "\xFE\xFF") {
    utf16 = bytes[0] == '\xFF' ? "UTF-16LE" : "UTF-16BE";
    mark = 2;
  } else {
    utf16 = utf16_without_mark(bytes);
  }
  if (utf16 == nullptr) {
    if (!is_utf8(bytes)) encoding_ = "Latin-1";
    return;
  }
  encoding_ = "UTF-16";
  iconv_t handle = iconv_open("UTF-8", utf16);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): iconv(3) says so
  if (handle == reinterpret_cast<iconv_t>(-1)) throw std::bad_alloc();
  converter_.reset(handle);
  const std::string raw = text_.substr(mark);
  text_.clear();
  convert_utf16(raw);
}

void TextLines::convert_utf16(std::string_view bytes) {
  rest_.append(bytes);
  const auto left = convert(converter_.get(), rest_, text_);
  if (!left || (at_end_ && *left > 0)) {
    throw DataError(fmt::format("{}: the text is not valid UTF-16; save the file as UTF-8", path_.string()));
  }
  rest_.erase(0, rest_.size() - *left);
}

void TextLines::fill() {
  text_.erase(0, std::exchange(begin_, 0));
  const std::size_t before = text_.size();
  if (converter_ == nullptr) {
    text_.resize(before + kReadBytes);
    const std::size_t count = os::read_up_to(file_, text_.data() + before, kReadBytes, path_);
    text_.resize(before + count);
    bytes_read_ += count;
    at_end_ = count < kReadBytes;
    return;
  }
  std::string raw(kReadBytes, '\0');
  raw.resize(os::read_up_to(file_, raw.data(), kReadBytes, path_));
  bytes_read_ += raw.size();
  at_end_ = raw.size() < kReadBytes;
  convert_utf16(raw);
}

std::vector<std::string> TextLines::first_lines(std::size_t most) const {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (lines.size() < most && begin < text_.size() && begin < kLongestLine) {
    const std::size_t end = text_.find(line_end_, begin);
    // A line that is cut there is complete only at the end of the file.
    if (end == std::string::npos && !at_end_) break;
    std::string_view line(text_);
    line = line.substr(begin, end == std::string::npos ? std::string::npos : end - begin);
    if (line.size() >= kLongestLine) break;
    while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    lines.emplace_back(line);
    if (end == std::string::npos) break;
    begin = end + 1;
  }
  return lines;
}

std::optional<std::string_view> TextLines::next() {
  std::size_t searched = begin_;
  std::size_t end = text_.find(line_end_, searched);
  while (end == std::string::npos && !at_end_) {
    searched = text_.size() - begin_;
    if (searched >= kLongestLine) break;
    fill();
    end = text_.find(line_end_, searched);
  }
  if (begin_ == text_.size()) return std::nullopt;
  ++line_;
  const std::size_t stop = end == std::string::npos ? text_.size() : end;
  if (stop - begin_ >= kLongestLine) {
    if (std::string_view(text_).substr(begin_, stop - begin_).find('\0') != std::string_view::npos) fail(kNulByte);
    fail(fmt::format("the line is longer than {} characters; this is no CSV text", kLongestLine - 1));
  }
  std::string_view line = std::string_view(text_).substr(begin_, stop - begin_);
  is_unfinished_ = end == std::string::npos;
  begin_ = is_unfinished_ ? stop : stop + 1;
  // Converting line ends twice leaves two of them.
  while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  // A CSV parser would end a row there, and the fields of both rows would be read as one.
  if (line.find('\r') != std::string_view::npos) {
    fail("a carriage return within the line; save the file with LF or CR LF at the end of each line");
  }
  if (line.find('\0') != std::string_view::npos) fail(kNulByte);
  return line;
}

double TextLines::share() const {
  if (size_ == 0) return 0.0;
  const auto waiting = static_cast<double>(text_.size() - begin_);
  return std::clamp((static_cast<double>(bytes_read_) - waiting) / static_cast<double>(size_), 0.0, 1.0);
}

std::string TextLines::decoded(std::string_view text) const {
  if (encoding_ != "Latin-1") {
    if (auto same = to_utf8(text, "UTF-8")) return *same;
  }
  if (auto converted = to_utf8(text, "CP1252")) return *converted;
  // Windows-1252 leaves five bytes undefined, Latin-1 none.
  return to_utf8(text, "ISO-8859-1").value_or(std::string(text));
}

void TextLines::fail(const std::string& what) const {
  throw DataError(fmt::format("{}:{}: {}", path_.string(), line_, what));
}

}  // namespace eha::importer
