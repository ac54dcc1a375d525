// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/code_text.hpp"
#include "ident/export/model_formats.hpp"

namespace eha::ident {
namespace {

constexpr const char* kCommon = R"(

def _exponential(m):
    """exp(m) by scaling, Taylor series and squaring."""
    norm = np.abs(m).sum(axis=1).max()
    squarings = max(0, int(np.ceil(np.log2(norm / 0.5)))) if norm > 0 else 0
    m = m / 2.0 ** squarings
    result = np.eye(len(m))
    for k in range(14, 0, -1):
        result = np.eye(len(m)) + m @ result / k
    for _ in range(squarings):
        result = result @ result
    return result


def _stacked(step_s, late_s):
    """All sections over one step, exactly; the input changes late_s into it."""
    states = sum(len(d) for _, d, _, _ in SECTIONS)
    a, c = np.zeros((states, states)), np.zeros(states)
    before, now, x = np.zeros(states), np.zeros(states), np.zeros(states)
    at = 0
    for rate, d, b, state in SECTIONS:
        n = len(d)
        m = np.zeros((n + 1, n + 1))
        m[:n, 0] = -np.array(d)
        m[:n - 1, 1:n] = np.eye(n - 1)
        m[:n, n] = b
        first, rest = _exponential(m * rate * late_s), _exponential(m * rate * (step_s - late_s))
        a[at:at + n, at:at + n] = _exponential(m * rate * step_s)[:n, :n]
        before[at:at + n] = rest[:n, :n] @ first[:n, n]
        now[at:at + n] = rest[:n, n]
        x[at:at + n] = state
        c[at] = 1.0
        at += n
    return a, before, now, c, x
)";

constexpr const char* kFunction = R"(

def {0}({2}, step_s):
    """Output of the model for the input, one value a row, rows step_s seconds apart."""
    if not step_s > 0:
        raise ValueError("step_s: expected a positive number of seconds")
    u = np.asarray({2}, dtype=float).ravel()
    samples = DELAY_S / step_s
    whole = int(np.floor(samples))
    if samples - whole > 1 - 1e-9:
        whole += 1
    late_s = DELAY_S - whole * step_s if samples - whole > 1e-9 else 0.0
    v = np.concatenate([np.zeros(whole + 1), {1}])
    a, before, now, c, x = _stacked(step_s, late_s)
    y = INITIAL_OUTPUT + DIRECT * v[:len(u)]
    for k in range(len(u)):
        y[k] += c @ x
        x = a @ x + before * v[k] + now * v[k + 1]
    return y
)";

}  // namespace

std::string python_text(const ExportedModel& model, const std::string& function) {
  std::string text = "\"\"\"";
  for (const std::string& line : notes(model)) text += line + "\n";
  text += "\"\"\"\nimport numpy as np\n\n";
  text += "# rate [rad/s], denominator and numerator below the highest power of s/rate, state at the first row\n";
  text += "SECTIONS = [\n";
  for (const Section& s : model.sections.list) {
    text += fmt::format("    ({}, [{}], [{}], [{}]),\n", s.rate_rad_s, fmt::join(s.denominator, ", "),
                        fmt::join(s.numerator, ", "), fmt::join(s.state, ", "));
  }
  text += "]\n";
  text += fmt::format("DIRECT = {}\nDELAY_S = {}\nINITIAL_OUTPUT = {}\n", model.sections.direct, model.sections.delay_s,
                      model.initial_output);
  std::string driving = "u + INPUT_BIAS";
  if (model.input_map) {
    text += fmt::format("NULL = {}\nDEAD_BAND = {}\nNEGATIVE_GAIN_RATIO = {}\n", model.input_map->null,
                        model.input_map->dead_band, model.input_map->negative_gain_ratio);
    driving =
        "np.maximum(u - (NULL + DEAD_BAND), 0.0)\n                        + NEGATIVE_GAIN_RATIO * np.minimum(u - (NULL "
        "- DEAD_BAND), 0.0)";
  } else {
    text += fmt::format("INPUT_BIAS = {}\n", model.input_bias);
  }
  return text + kCommon + fmt::format(kFunction, function, driving, with_unit("u", model.input_unit));
}

}  // namespace eha::ident
