// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "daemon/published/published_set.hpp"

namespace eha::published {
namespace {

constexpr std::string_view kChampneys = "Champneys et al. 2024, arXiv 2405.10779";
constexpr std::string_view kChampneysFiles = "Champneys et al. 2024, result files";
constexpr std::string_view kForgione = "Forgione, Piga 2021, Eur. J. Control 59";
constexpr std::string_view kDynonet = "Forgione, Piga 2021, dynoNet";

// The periods of the records [s].
constexpr double kSilverbox_s = 16384.0 / 1e7;
constexpr double kBoucWen_s = 1.0 / 750.0;

Part of(std::vector<std::string_view> files, std::string_view input, std::string_view output, std::size_t first = 0,
        std::size_t rows = 0) {
  return {.files = std::move(files), .input = input, .output = output, .first = first, .rows = rows};
}

PublishedSet emps() {
  return {.name = "emps",
          .title = "Electro-mechanical positioning system",
          .what = "A linear axis with dry friction in closed loop: motor force to position.",
          .fetch = "nonlinearbenchmark.org, EMPS; also github.com/forgi86/sysid-neural-continuous, examples/EMPS/data",
          .period_s = 0.001,
          .decimation = 5,
          .estimation = of({"DATA_EMPS.mat"}, "vir", "qm"),
          .tests = {{.name = "pulses",
                     .part = of({"DATA_EMPS_PULSES.mat"}, "vir", "qm"),
                     .start_rows = 20,
                     .measure = rmse(),
                     .factor = 1000.0,
                     .unit = "mm",
                     .figures = {{"dynoNet network", 2.64, kDynonet},
                                 {"linear state space", 5.53, kChampneys},
                                 {"LSTM network", 74.1, kChampneysFiles},
                                 {"recurrent network", 89.2, kChampneysFiles},
                                 {"GRU network", 220.0, kChampneysFiles}}}}};
}

PublishedSet tanks() {
  const std::vector<std::string_view> files{"dataBenchmark.mat", "dataBenchmark.csv", "tanque.csv"};
  return {
      .name = "tanks",
      .title = "Cascaded tanks with overflow",
      .what = "Two tanks that empty into one another; at large levels they overflow. Pump to lower level.",
      .fetch =
          "nonlinearbenchmark.org, Cascaded tanks; also github.com/forgi86/sysid-neural-continuous, "
          "examples/CTS/data",
      .period_s = 4.0,
      .estimation = of(files, "uEst", "yEst"),
      .tests = {{.name = "second record",
                 .part = of(files, "uVal", "yVal"),
                 .start_rows = 5,
                 .measure = rmse(),
                 .unit = "V",
                 .figures = {{"grey box with overflow", 0.18, "Rogers et al. 2017, in Forgione, Piga 2021"},
                             {"neural differential equation", 0.33, kForgione},
                             {"nonlinear state space", 0.34, "Relan et al. 2017, in Forgione, Piga 2021"},
                             {"GRU network", 0.396, kChampneysFiles},
                             {"polynomial NARX", 0.413, kChampneysFiles},
                             {"state space, Gaussian process", 0.45, "Svensson, Schoen 2017, in Forgione, Piga 2021"},
                             {"Volterra", 0.54, "Birpoutsoukis et al. 2018, in Forgione, Piga 2021"},
                             {"linear state space", 0.588, kChampneys},
                             {"Gaussian process NARX", 0.622, kChampneysFiles},
                             {"ARX", 0.685, kChampneysFiles},
                             {"best linear approximation", 0.75, "Relan et al. 2017, in Forgione, Piga 2021"}}}}};
}

PublishedSet silverbox() {
  const std::vector<std::string_view> files{"SNLS80mV.mat", "SNLS80mV.csv"};
  constexpr std::size_t kStart = 50;
  return {.name = "silverbox",
          .title = "Silverbox",
          .what = "An electronic resonance whose spring hardens (Duffing).",
          .fetch = "nonlinearbenchmark.org, Silverbox; also github.com/biaslab/nsi-silverbox, data/Silverbox",
          .period_s = kSilverbox_s,
          .estimation = of(files, "V1", "V2", 40650, 65062),
          .tests = {{.name = "multisine",
                     .part = of(files, "V1", "V2", 105712, 21688),
                     .start_rows = kStart,
                     .measure = rmse(),
                     .factor = 1000.0,
                     .unit = "mV",
                     .figures = {{"GRU network", 1.49, kChampneysFiles},
                                 {"LSTM network", 1.50, kChampneysFiles},
                                 {"recurrent network", 1.64, kChampneysFiles},
                                 {"linear state space", 6.96, kChampneys}}},
                    {.name = "arrow",
                     .part = of(files, "V1", "V2", 100, 40475),
                     .start_rows = kStart,
                     .measure = rmse(),
                     .factor = 1000.0,
                     .unit = "mV",
                     .figures = {{"GRU network", 2.80, kChampneysFiles},
                                 {"LSTM network", 2.68, kChampneysFiles},
                                 {"recurrent network", 4.88, kChampneysFiles},
                                 {"linear state space", 14.4, kChampneys}}},
                    {.name = "arrow within the range",
                     .part = of(files, "V1", "V2", 100, 32000),
                     .start_rows = kStart,
                     .measure = rmse(),
                     .factor = 1000.0,
                     .unit = "mV",
                     .figures = {{"GRU network", 0.947, kChampneysFiles},
                                 {"LSTM network", 0.960, kChampneysFiles},
                                 {"recurrent network", 1.73, kChampneysFiles}}}}};
}

PublishedSet bouc_wen() {
  const std::vector<std::string_view> test{"Test signals/test.h5", "bouc-wen/test.h5"};
  return {.name = "bouc-wen",
          .title = "Bouc-Wen hysteresis",
          .what = "A simulated oscillator with a hysteretic spring: force to displacement.",
          .fetch =
              "nonlinearbenchmark.org, Bouc-Wen; with the estimating multisine in github.com/forgi86/dynonet, "
              "examples/BW/data/Test signals",
          .period_s = kBoucWen_s,
          .estimation = of({"Test signals/train.h5", "bouc-wen/train.h5"}, "multisine.u", "multisine.y"),
          .tests = {{.name = "multisine",
                     .part = of(test, "multisine.u", "multisine.y"),
                     .start_rows = 300,
                     .measure = rmse(),
                     .factor = 1e6,
                     .unit = "um",
                     .figures = {{"polynomial state space", 18.7, "Esfahani et al. 2017, in dynoNet's paper"},
                                 {"dynoNet network", 45.2, kDynonet},
                                 {"nonlinear FIR", 163.0, "dynoNet's paper"}}},
                    {.name = "sine sweep",
                     .part = of(test, "sinesweep.u", "sinesweep.y"),
                     .measure = rmse(),
                     .factor = 1e6,
                     .unit = "um"}}};
}

PublishedSet f16() {
  constexpr std::size_t kHalf = 16384;
  const std::vector<std::string_view> files{"f-16.txt"};
  return {.name = "f16",
          .title = "F-16 ground vibration test",
          .what = "A wing with a loose payload: shaker to acceleration, one record of the benchmark, in halves.",
          .fetch =
              "nonlinearbenchmark.org, F-16; this record: github.com/wilsonrljr/sysidentpy-data, "
              "datasets/f_16_vibration_test",
          .period_s = 0.0025,
          .estimation = of(files, "1", "3", 0, kHalf),
          .tests = {{.name = "second half",
                     .part = of(files, "1", "3", kHalf, kHalf),
                     .begin = Begin::continued,
                     .measure = fit_percent(),
                     .unit = "%"}}};
}

PublishedSet fomcon() {
  return {.name = "fomcon",
          .title = "FOMCON's identification example",
          .what = "A drive from 0 to 1 into a fractional plant with a dead zone.",
          .fetch = "github.com/outstandn/fomcon, dataFiles (a workbook needs xlsx2csv, or save it as CSV)",
          .period_s = 0.05,
          .estimation = of({"idenData.xlsx", "idenData.csv"}, "u", "y"),
          .tests = {{.name = "ValiData",
                     .part = of({"ValiData.xlsx", "ValiData.csv"}, "u", "y"),
                     .measure = fit_percent(),
                     .unit = "%",
                     .figures = {{"FOMCON, fractional, least", 94.2, "outstandn/fomcon, outputText&PDF"},
                                 {"FOMCON, fractional, greatest", 94.3, "outstandn/fomcon, outputText&PDF"}}}}};
}

PublishedSet thermal_rod() {
  constexpr std::size_t kHalf = 300;
  const std::vector<std::string_view> files{"ThermalRod.mat"};
  return {.name = "rod",
          .title = "CRONE toolbox, thermal rod",
          .what = "An aluminium rod heated at one end: flux to temperature 5 mm from there, in halves.",
          .fetch = "github.com/MaltiRachid/Crone-Toolbox, CRONE_demos",
          .period_s = 0.5,
          .estimation = of(files, "u", "y", 0, kHalf),
          .tests = {{.name = "second half",
                     .part = of(files, "u", "y", kHalf, kHalf),
                     .begin = Begin::continued,
                     .measure = fit_percent(),
                     .unit = "%"}}};
}

PublishedSet sid_demo() {
  constexpr std::size_t kHalf = 800;
  const std::vector<std::string_view> files{"SID_demo2.csv", "SID_demo2.mat"};
  return {.name = "sid-demo",
          .title = "CRONE toolbox, SID_demo2",
          .what = "A simulated 0.5/(0.5 s^3 + 1.5 s^1.5 + 1) with white noise of 0.2, in halves.",
          .fetch =
              "github.com/MaltiRachid/Crone-Toolbox, CRONE_demos/SID_demo2.m; after it writematrix([u yb], "
              "'SID_demo2.csv')",
          .period_s = 0.01,
          .estimation = of(files, "1", "2", 0, kHalf),
          .tests = {{.name = "second half",
                     .part = of(files, "1", "2", kHalf, kHalf),
                     .begin = Begin::continued,
                     .measure = rmse(),
                     .figures = {{"the noise alone", 0.2, "SID_demo2.m"}}}}};
}

PublishedSet moto_shield() {
  const std::vector<std::string_view> files{"aprbsResult.mat"};
  return {
      .name = "motoshield",
      .title = "MotoShield",
      .what = "A small motor: volts to speed. Published is the fit on the estimating record itself.",
      .fetch = "github.com/gergelytakacs/AutomationShield, matlab/examples/MotoShield",
      .period_s = 0.02,
      .estimation = of(files, "u", "y"),
      .tests = {{.name = "own record",
                 .part = of(files, "u", "y"),
                 .begin = Begin::continued,
                 .measure = fit_percent(),
                 .unit = "%",
                 .figures = {{"MATLAB tfest, two poles", 80.82, "AutomationShield, MotoShield_GreyboxModel_TF.mat"}}}}};
}

PublishedSet mts_servo() {
  constexpr std::size_t kHalf = 20000;
  const std::vector<std::string_view> files{"servohydraulic_mts.csv"};
  return {.name = "mts",
          .title = "MTS servo-hydraulic actuator",
          .what = "A sine sweep of a testing machine in closed loop: command to displacement, 40 s in halves.",
          .fetch =
              "github.com/DanielMaurelE/vRTHS_AMBC_MRdamper, Cap6_ModeloActuador/Preprocesamiento/Datos/0A.txt; "
              "the first 40 000 rows as CSV (docs/published.md)",
          .period_s = 0.001,
          .decimation = 10,
          .estimation = of(files, "2", "3", 0, kHalf),
          .tests = {{.name = "second half",
                     .part = of(files, "2", "3", kHalf, kHalf),
                     .begin = Begin::continued,
                     .measure = fit_percent(),
                     .unit = "%",
                     .figures = {{"two poles, whole record", 93.9,
                                  "DanielMaurelE/vRTHS_AMBC_MRdamper, model of the authors"}}}}};
}

PublishedSet crane() {
  constexpr std::size_t kHalf = 512;
  const std::vector<std::string_view> files{"actuator.mat"};
  return {.name = "crane",
          .title = "Hydraulic crane",
          .what = "Valve opening to oil pressure of a crane's arm, in halves.",
          .fetch = "github.com/zhenwendai/RGP, datasets/system_identification",
          .period_s = 1.0,
          .estimation = of(files, "u", "p", 0, kHalf),
          .tests = {{.name = "second half",
                     .part = of(files, "u", "p", kHalf, kHalf),
                     .begin = Begin::continued,
                     .measure = rmse()}}};
}

PublishedSet robot_arm() {
  constexpr std::size_t kHalf = 512;
  const std::vector<std::string_view> files{"robot_arm.dat", "robot-arm.csv"};
  return {.name = "arm",
          .title = "DaISy, flexible robot arm",
          .what =
              "Reaction torque to acceleration, a periodic sine sweep, in halves; the period is not published, 1 s "
              "stands for it.",
          .fetch =
              "homes.esat.kuleuven.be/~smc/daisy, robot_arm; also github.com/Rafa7046/Non_Linear_Identification, "
              "src/data",
          .period_s = 1.0,
          .estimation = of(files, "1", "2", 0, kHalf),
          .tests = {{.name = "second half",
                     .part = of(files, "1", "2", kHalf, kHalf),
                     .begin = Begin::continued,
                     .measure = fit_percent(),
                     .unit = "%"}}};
}

PublishedSet exchanger() {
  constexpr std::size_t kHalf = 2000;
  const std::vector<std::string_view> files{"exchanger.dat", "exchanger.csv"};
  return {.name = "exchanger",
          .title = "DaISy, steam heat exchanger",
          .what = "Liquid flow to outlet temperature, in halves.",
          .fetch =
              "homes.esat.kuleuven.be/~smc/daisy, exchanger; also github.com/Rafa7046/Non_Linear_Identification, "
              "src/data",
          .period_s = 1.0,
          .estimation = of(files, "2", "3", 0, kHalf),
          .tests = {{.name = "second half",
                     .part = of(files, "2", "3", kHalf, kHalf),
                     .begin = Begin::continued,
                     .measure = fit_percent(),
                     .unit = "%"}}};
}

}  // namespace

const Measure& rmse() {
  static constexpr Measure kRmse{"RMSE", false, [](const ident::Score& score) { return std::sqrt(score.mse); }};
  return kRmse;
}

const Measure& fit_percent() {
  static constexpr Measure kFit{"fit", true, [](const ident::Score& score) { return score.fit_percent; }};
  return kFit;
}

std::span<const PublishedSet> published_sets() {
  static const std::vector<PublishedSet> kSets{emps(),   tanks(),       silverbox(), bouc_wen(),    f16(),
                                               fomcon(), thermal_rod(), sid_demo(),  moto_shield(), mts_servo(),
                                               crane(),  robot_arm(),   exchanger()};
  return kSets;
}

}  // namespace eha::published
