// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/system/foreign_files.hpp"

#include <fmt/format.h>
#include <hdf5.h>
#include <iconv.h>
#include <matio.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>

namespace eha::test {
namespace {

namespace fs = std::filesystem;

void require(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

void write_text(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  require(bool(file), "a fixture can be written");
}

std::string with_comma(std::string number) {
  std::replace(number.begin(), number.end(), '.', ',');
  return number;
}

std::string point(double x) { return fmt::format("{}", x); }
std::string comma(double x) { return with_comma(point(x)); }

using Number = std::string (*)(double);

/// `header`, then a row for each sample: its numbers with `delimiter` between them and `end` behind.
std::string rows(const Measured& record, const std::string& header, const std::string& delimiter, Number number,
                 const std::string& end = "\n") {
  std::string text = header;
  for (std::size_t k = 0; k < record.time_s.size(); ++k) {
    text += number(record.time_s[k]) + delimiter + number(record.input_V[k]) + delimiter + number(record.output_in[k]) +
            end;
  }
  return text;
}

/// A row for each sample as `row` writes it.
std::string each(const Measured& record, const std::string& header,
                 const std::function<std::string(std::size_t, double, double, double)>& row) {
  std::string text = header;
  for (std::size_t k = 0; k < record.time_s.size(); ++k) {
    text += row(k, record.time_s[k], record.input_V[k], record.output_in[k]);
  }
  return text;
}

using Variable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

Variable column(const char* name, const std::vector<double>& values, std::size_t columns = 1) {
  std::size_t size[2] = {values.size() / columns, columns};
  // matio copies the numbers.
  return {Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, size, const_cast<double*>(values.data()), 0),
          &Mat_VarFree};
}

void write_mat(const fs::path& path, mat_ft version, matvar_t* variable, matio_compression compression) {
  mat_t* file = Mat_CreateVer(path.c_str(), nullptr, version);
  require(file != nullptr && Mat_VarWrite(file, variable, compression) == 0, "matio writes a fixture");
  Mat_Close(file);
}

void write_mat_struct(const Measured& record, const fs::path& path, mat_ft version) {
  const char* fields[] = {"t", "u", "y"};
  std::size_t size[2] = {1, 1};
  const Variable whole(Mat_VarCreateStruct("rec", 2, size, fields, 3), &Mat_VarFree);
  // The struct owns its fields.
  Mat_VarSetStructFieldByName(whole.get(), "t", 0, column("t", record.time_s).release());
  Mat_VarSetStructFieldByName(whole.get(), "u", 0, column("u", record.input_V).release());
  Mat_VarSetStructFieldByName(whole.get(), "y", 0, column("y", record.output_in).release());
  write_mat(path, version, whole.get(), version == MAT_FT_MAT73 ? MAT_COMPRESSION_NONE : MAT_COMPRESSION_ZLIB);
}

void write_mat_matrix(const Measured& record, const fs::path& path) {
  std::vector<double> all = record.time_s;
  all.insert(all.end(), record.input_V.begin(), record.input_V.end());
  all.insert(all.end(), record.output_in.begin(), record.output_in.end());
  const Variable whole = column("data", all, 3);
  write_mat(path, MAT_FT_MAT5, whole.get(), MAT_COMPRESSION_NONE);
}

}  // namespace

Measured measured(std::size_t rows) {
  Measured record;
  double lag = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    const auto row = static_cast<double>(k);
    const double input = std::round(1e4 * (std::sin(0.031 * row) + 0.7 * std::sin(0.11 * row + 1.0))) / 1e4;
    record.time_s.push_back(row / 100.0);
    record.input_V.push_back(input);
    record.output_in.push_back(std::round(1e6 * (2.5 + lag + 0.002 * std::sin(5.0 * row * row))) / 1e6);
    lag += 0.05 * (0.8 * input - lag);
  }
  return record;
}

std::string in_charset(const std::string& text, const char* charset) {
  iconv_t converter = iconv_open(charset, "UTF-8");
  std::string result(4 * text.size() + 8, '\0');
  char* in = const_cast<char*>(text.data());
  std::size_t in_left = text.size();
  char* out = result.data();
  std::size_t out_left = result.size();
  const std::size_t outcome = iconv(converter, &in, &in_left, &out, &out_left);
  iconv_close(converter);
  require(outcome != static_cast<std::size_t>(-1), "a fixture can be written in that character set");
  result.resize(result.size() - out_left);
  return result;
}

void write_hdf5(const fs::path& path, const std::vector<std::pair<std::string, std::vector<double>>>& datasets,
                const std::string& first_unit) {
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t groups = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(groups, 1);
  for (const auto& [name, values] : datasets) {
    const hsize_t size = values.size();
    const hid_t space = H5Screate_simple(1, &size, nullptr);
    const hid_t data = H5Dcreate2(file, name.c_str(), H5T_NATIVE_DOUBLE, space, groups, H5P_DEFAULT, H5P_DEFAULT);
    require(H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
            "HDF5 writes a fixture");
    if (!first_unit.empty() && &values == &datasets.front().second) {
      const hid_t text = H5Tcopy(H5T_C_S1);
      H5Tset_size(text, first_unit.size());
      const hid_t one = H5Screate(H5S_SCALAR);
      const hid_t unit = H5Acreate2(data, "unit", text, one, H5P_DEFAULT, H5P_DEFAULT);
      H5Awrite(unit, text, first_unit.data());
      H5Aclose(unit);
      H5Sclose(one);
      H5Tclose(text);
    }
    H5Dclose(data);
    H5Sclose(space);
  }
  H5Pclose(groups);
  require(H5Fclose(file) >= 0, "HDF5 closes a fixture");
}

std::vector<ForeignFile> write_foreign_files(const Measured& r, const fs::path& folder) {
  std::vector<ForeignFile> files;
  const auto add = [&](const char* made_by, const char* name, const std::string& text) {
    write_text(folder / name, text);
    files.push_back({made_by, name});
  };

  add("Excel, German settings: CSV (Trennzeichen-getrennt)", "excel_de.csv",
      in_charset(rows(r, "Zeit [s];Spannung [V];L\xC3\xA4nge [in]\r\n", ";", comma, "\r\n"), "CP1252"));
  add("Excel, French settings: CSV UTF-8", "excel_fr.csv",
      "\xEF\xBB\xBF" + rows(r, "Temps (s);Tension (V);D\xC3\xA9placement (in)\r\n", ";", comma, "\r\n"));
  add("Excel: Unicode text", "excel_unicode.txt",
      "\xFF\xFE" + in_charset(rows(r, "Time [s]\tVoltage [V]\tPosition [in]\r\n", "\t", point, "\r\n"), "UTF-16LE"));
  add("Excel, with its separator line", "excel_sep.csv",
      "sep=;\r\n" + rows(r, "time_s;voltage_V;displacement_in\r\n", ";", point, "\r\n"));
  add("LibreOffice Calc, German settings, commas, text quoted", "libreoffice.csv",
      each(r, "\"Zeit\",\"Eingang [V]\",\"Weg [in]\"\n", [](std::size_t, double t, double u, double y) {
        return fmt::format("\"{}\",\"{}\",\"{}\"\n", comma(t), comma(u), comma(y));
      }));
  add("MATLAB writematrix", "writematrix.csv", each(r, "", [](std::size_t, double t, double u, double y) {
        return fmt::format("{:.15g},{:.15g},{:.15g}\n", t, u, y);
      }));
  add("MATLAB writetable", "writetable.csv", rows(r, "t,u,y\n", ",", point));
  add("MATLAB save -ascii", "save_ascii.txt", each(r, "", [](std::size_t, double t, double u, double y) {
        return fmt::format("   {:.16e}   {:.16e}   {:.16e}\n", t, u, y);
      }));
  add("numpy.savetxt with a header", "savetxt.txt",
      each(r, "# time voltage displacement\n", [](std::size_t, double t, double u, double y) {
        return fmt::format("{:.18e} {:.18e} {:.18e}\n", t, u, y);
      }));
  add("pandas to_csv with its index", "pandas.csv",
      each(r, ",time,voltage,position\n",
           [](std::size_t k, double t, double u, double y) { return fmt::format("{},{},{},{}\n", k, t, u, y); }));
  add("R write.table", "r.txt", each(r, "\"time\" \"u\" \"y\"\n", [](std::size_t k, double t, double u, double y) {
        return fmt::format("\"{}\" {} {} {}\n", k + 1, t, u, y);
      }));
  add("a logger: tabs, comments", "tabs.txt",
      "# rig 3\n# gain 1,5\n" + rows(r, "time [s]\tcommand [V]\trod [in]\n", "\t", point));
  add("a Macintosh of old: carriage returns", "mac.csv",
      rows(r, "time_s,voltage_V,displacement_in\r", ",", point, "\r"));
  add("a logger with a row of units", "units_row.csv", rows(r, "Time;Voltage;Displacement\ns;V;in\n", ";", comma));
  add("an oscilloscope: text above, a trailing comma", "scope.csv",
      rows(r, "Model,DPO2014\nSample rate,100\n\nTIME,VALVE,ROD,\n", ",", point, ",\n"));
  add("a logger in milliseconds", "milliseconds.csv",
      each(r, "t (ms);u (V);y (in)\n",
           [](std::size_t k, double, double u, double y) { return fmt::format("{};{};{}\n", 10 * k, u, y); }));
  add("a logger with more columns, the output before the input", "more_columns.csv",
      each(r, "Timestamp,Time [s],Pressure A [bar],Rod position [in],Valve voltage [V],Remark\n",
           [](std::size_t k, double t, double u, double y) {
             return fmt::format("2024-03-01 10:{:02}:{:05.2f},{},{},{},{},\"row, {}\"\n", k / 6000,
                                static_cast<double>(k % 6000) / 100.0, t, 100 + k % 7, y, u, k);
           }));
  add("UTF-16 without a mark", "utf16be.csv",
      in_charset(rows(r, "time_s,voltage_V,displacement_in\n", ",", point), "UTF-16BE"));
  add("two columns of volts", "two_inputs.csv",
      each(r, "time_s,a_V,b_V,c_in\n",
           [](std::size_t k, double t, double u, double y) { return fmt::format("{},{},{},{}\n", t, u, k % 3, y); }));
  add("dates and times of day", "dates.csv", each(r, "Timestamp;u;y\n", [](std::size_t k, double, double u, double y) {
        return fmt::format("2024-03-01 10:{:02}:{:05.2f};{};{}\n", k / 6000, static_cast<double>(k % 6000) / 100.0, u,
                           y);
      }));
  add("a run's data_40ms.csv", "data_40ms.csv",
      "# run 20240301T100000Z-paper\n# every 40th row\n" + rows(r, "time_s,voltage_V,displacement_in\n", ",", point));

  write_mat_struct(r, folder / "struct5.mat", MAT_FT_MAT5);
  files.push_back({"MATLAB save, a struct of arrays", "struct5.mat"});
  write_mat_struct(r, folder / "struct73.mat", MAT_FT_MAT73);
  files.push_back({"MATLAB save -v7.3, a struct of arrays", "struct73.mat"});
  write_mat_matrix(r, folder / "matrix.mat");
  files.push_back({"MATLAB save, a matrix", "matrix.mat"});
  write_hdf5(folder / "datasets.h5", {{"time", r.time_s}, {"voltage", r.input_V}, {"displacement", r.output_in}}, "s");
  files.push_back({"HDF5, a dataset a column", "datasets.h5"});
  write_hdf5(folder / "groups.h5", {{"run1/t", r.time_s}, {"run1/u", r.input_V}, {"run1/y", r.output_in}}, "");
  files.push_back({"HDF5, datasets in a group", "groups.h5"});
  return files;
}

}  // namespace eha::test
