// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <matio.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/importer/array_table.hpp"
#include "daemon/importer/hdf5_heaps.hpp"

namespace eha::importer {
namespace {

using MatFile = std::unique_ptr<mat_t, decltype(&Mat_Close)>;
using MatVariable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

/// matio reports faults through this function; what it returned says enough.
void say_nothing(int /*level*/, char* /*message*/) {}

const char* version_name(mat_ft version) {
  switch (version) {
    case MAT_FT_MAT4:
      return "MAT-file 4";
    case MAT_FT_MAT73:
      return "MAT-file 7.3";
    default:
      return "MAT-file 5";
  }
}

template <typename Number>
void convert(const matvar_t& variable, std::size_t first, std::size_t stride, std::size_t count,
             std::vector<double>& values) {
  const auto* numbers = static_cast<const Number*>(variable.data);
  values.reserve(count);
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<double>(numbers[first + i * stride]));
}

/// Calls convert for the type of the variable's numbers. @returns false for other types
bool extract(const matvar_t& variable, std::size_t first, std::size_t stride, std::size_t count,
             std::vector<double>& values) {
  const auto with = [&](auto number) { convert<decltype(number)>(variable, first, stride, count, values); };
  switch (variable.data_type) {
    case MAT_T_DOUBLE:
      with(double{});
      return true;
    case MAT_T_SINGLE:
      with(float{});
      return true;
    case MAT_T_INT8:
      with(std::int8_t{});
      return true;
    case MAT_T_UINT8:
      with(std::uint8_t{});
      return true;
    case MAT_T_INT16:
      with(std::int16_t{});
      return true;
    case MAT_T_UINT16:
      with(std::uint16_t{});
      return true;
    case MAT_T_INT32:
      with(std::int32_t{});
      return true;
    case MAT_T_UINT32:
      with(std::uint32_t{});
      return true;
    case MAT_T_INT64:
      with(std::int64_t{});
      return true;
    case MAT_T_UINT64:
      with(std::uint64_t{});
      return true;
    default:
      return false;
  }
}

/// The text of a char array, of one byte or two a character; empty for anything else.
std::string text_of(const matvar_t* variable) {
  constexpr std::size_t kLongestName = 256;
  if (variable == nullptr || variable->class_type != MAT_C_CHAR || variable->rank != 2 || variable->data == nullptr) {
    return {};
  }
  const std::size_t count = variable->dims[0] == 1 ? variable->dims[1] : 0;
  const auto bytes = static_cast<std::size_t>(std::max(variable->data_size, 0));
  if (count == 0 || count > kLongestName || bytes == 0 || variable->nbytes / bytes < count) return {};
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    const auto* data = static_cast<const unsigned char*>(variable->data);
    const unsigned wide = bytes == 2 ? static_cast<const std::uint16_t*>(variable->data)[i] : data[i * bytes];
    // What one byte does not hold in Latin-1 is no letter of a channel.
    if (wide < 0x20U || wide > 0xFFU) return {};
    if (wide < 0x80U) {
      text += static_cast<char>(wide);
    } else {
      text += static_cast<char>(0xC0U | (wide >> 6U));
      text += static_cast<char>(0x80U | (wide & 0x3FU));
    }
  }
  return text;
}

/// The first of these fields of a struct's element that is a text.
std::string text_among(matvar_t* variable, std::size_t element, std::initializer_list<const char*> fields) {
  for (const char* field : fields) {
    std::string text = text_of(Mat_VarGetStructFieldByName(variable, field, element));
    if (!text.empty()) return text;
  }
  return {};
}

class MatCollector {
 public:
  explicit MatCollector(std::string path) : path_(std::move(path)) {}

  void add(matvar_t* variable, const std::string& name, int depth) {
    if (variable == nullptr || depth > kDeepest) return;
    if (variable->class_type == MAT_C_STRUCT) {
      add_struct(variable, name, depth);
    } else if (variable->class_type == MAT_C_CELL) {
      remark_ = fmt::format("{} is a cell array; in MATLAB: x = cell2mat({}), then save x", name, name);
    } else if (variable->class_type == MAT_C_OPAQUE || variable->class_type == MAT_C_OBJECT ||
               variable->class_type == MAT_C_FUNCTION) {
      remark_ = fmt::format(
          "{} is an object (a table or timeseries?), which only MATLAB can read; there: "
          "writetable({}, 'record.csv')",
          name, name);
    } else {
      add_array(*variable, name);
    }
  }

  [[nodiscard]] std::vector<ArrayColumn>& arrays() { return arrays_; }
  [[nodiscard]] std::string& remark() { return remark_; }

 private:
  void add_struct(matvar_t* variable, const std::string& name, int depth) {
    char* const* fields = Mat_VarGetStructFieldnames(variable);
    const unsigned count = Mat_VarGetNumberOfFields(variable);
    if (fields == nullptr || count == 0 || variable->data == nullptr) return;
    // matio believes the dimensions; what it holds is one pointer a field and element.
    const std::size_t held = variable->nbytes / sizeof(matvar_t*) / count;
    std::size_t elements = 1;
    for (int d = 0; d < variable->rank; ++d) {
      if (variable->dims[d] != 0 && elements > held / variable->dims[d]) damaged(name);
      elements *= variable->dims[d];
    }
    elements = std::min(elements, kMostMatrixColumns);
    for (std::size_t element = 0; element < elements; ++element) {
      const std::string at = elements > 1 ? fmt::format("{}({})", name, element + 1) : name;
      const std::size_t before = arrays_.size();
      for (unsigned i = 0; i < count; ++i) {
        add(Mat_VarGetStructFieldByName(variable, fields[i], element), fmt::format("{}.{}", at, fields[i]), depth + 1);
      }
      entitle(before, name, text_among(variable, element, {"Name", "name", "Label", "label"}),
              text_among(variable, element, {"Unit", "unit", "Units", "units"}));
    }
  }

  /// Gives the one signal that a struct holds the name and unit that stand beside it, as ControlDesk and Simulink do.
  /// @param first  of the arrays that the struct added
  void entitle(std::size_t first, const std::string& path, const std::string& title, const std::string& unit) {
    const auto is_signal = [](const ArrayColumn& array) { return array.values.size() > 1; };
    const auto begin = arrays_.begin() + static_cast<std::ptrdiff_t>(first);
    if (std::count_if(begin, arrays_.end(), is_signal) != 1) return;
    ArrayColumn& signal = *std::find_if(begin, arrays_.end(), is_signal);
    if (!unit.empty() && signal.unit.empty()) signal.unit = unit;
    if (title.empty()) return;
    const std::string named = path.substr(0, path.find('.')) + "." + title;
    const bool is_used = std::any_of(arrays_.begin(), arrays_.end(), [&](const auto& a) { return a.name == named; });
    if (!is_used) signal.name = named;
  }

  [[noreturn]] void damaged(const std::string& name) const {
    throw DataError(
        fmt::format("{}: {} has another size than it says: a damaged MAT-file; save it again", path_, name));
  }

  void add_array(const matvar_t& variable, const std::string& name) {
    if (variable.isComplex != 0) {
      remark_ = fmt::format("{} is complex", name);
      return;
    }
    if (variable.class_type == MAT_C_CHAR || variable.class_type == MAT_C_SPARSE || variable.rank != 2 ||
        variable.data == nullptr) {
      return;
    }
    std::size_t rows = variable.dims[0];
    std::size_t columns = variable.dims[1];
    const bool lies = rows < columns;
    if (lies) std::swap(rows, columns);
    // Of single numbers one may be the sample period.
    if (rows == 0 || columns == 0 || columns > kMostMatrixColumns) return;
    if (rows == 1 && variable.class_type != MAT_C_DOUBLE) return;
    if (rows > kMostValues) return;
    const std::size_t values = rows * columns;
    if (variable.data_size <= 0 || variable.nbytes / static_cast<std::size_t>(variable.data_size) < values) return;
    total_ += values;
    if (total_ > kMostValues) {
      throw DataError(fmt::format("{}: more than {} numbers; save only time, input and output", path_, kMostValues));
    }
    for (std::size_t c = 0; c < columns; ++c) {
      ArrayColumn column;
      column.name = columns == 1 ? name
                    : lies       ? fmt::format("{}({},:)", name, c + 1)
                                 : fmt::format("{}(:,{})", name, c + 1);
      column.is_single = variable.data_type == MAT_T_SINGLE;
      if (!extract(variable, lies ? c : c * rows, lies ? columns : 1, rows, column.values)) return;
      arrays_.push_back(std::move(column));
    }
  }

  std::string path_;
  std::vector<ArrayColumn> arrays_;
  std::string remark_;
  std::size_t total_ = 0;
};

}  // namespace

Arrays read_mat(const std::filesystem::path& path, const std::string& name) {
  Mat_LogInitFunc("eha", say_nothing);
  const std::uint64_t file_bytes = std::filesystem::file_size(path);
  const auto opened = [&] {
    MatFile file(Mat_Open(path.c_str(), MAT_ACC_RDONLY), &Mat_Close);
    if (!file) throw DataError(fmt::format("{}: a damaged or truncated MAT-file; save it again", name));
    return file;
  };
  // Sizes first, without the numbers: a few bytes may ask for gigabytes.
  const MatFile sizes = opened();
  if (Mat_GetVersion(sizes.get()) == MAT_FT_MAT73) check_heaps(path, name);
  std::size_t variables = 0;
  for (;; ++variables) {
    const MatVariable variable(Mat_VarReadNextInfo(sizes.get()), &Mat_VarFree);
    if (!variable) break;
    std::uint64_t elements = 1;
    for (int d = 0; d < variable->rank; ++d) {
      const std::uint64_t size = variable->dims[d];
      if (size != 0 && elements > UINT64_MAX / size) elements = UINT64_MAX;
      if (elements != UINT64_MAX) elements *= size;
    }
    const std::size_t element_bytes = Mat_SizeOfClass(variable->class_type);
    if (!can_hold(file_bytes, elements, element_bytes)) {
      throw DataError(fmt::format("{}: {} is said to have {} values, more than a file of {} bytes can hold: damaged",
                                  name, variable->name == nullptr ? "a variable" : variable->name, elements,
                                  file_bytes));
    }
  }
  const MatFile file = opened();
  MatCollector collector(name);
  for (; variables > 0; --variables) {
    const MatVariable variable(Mat_VarReadNext(file.get()), &Mat_VarFree);
    if (!variable) break;
    if (variable->name == nullptr || variable->name[0] == '#') continue;
    collector.add(variable.get(), variable->name, 0);
  }
  if (collector.arrays().empty() && Mat_GetVersion(file.get()) == MAT_FT_MAT73) {
    // matio knows no class that is padded with NULs, as h5py writes it; the numbers are datasets of HDF5.
    Arrays datasets = read_hdf5(path, name);
    std::erase_if(datasets.columns, [](const ArrayColumn& array) { return array.name.starts_with('#'); });
    if (!datasets.columns.empty()) return {version_name(MAT_FT_MAT73), std::move(datasets.columns), ""};
  }
  return {version_name(Mat_GetVersion(file.get())), std::move(collector.arrays()), std::move(collector.remark())};
}

}  // namespace eha::importer
