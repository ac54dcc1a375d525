// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

#include "core/code_text.hpp"
#include "ident/export/model_formats.hpp"

namespace eha::ident {
namespace {

constexpr const char* kHead = R"(function {1} = {0}({2}, step_s)
% {1} = {0}({2}, step_s): output of the model for the input, one value a row, rows step_s seconds apart.
)";

constexpr const char* kBody = R"(
  if ~(isscalar(step_s) && step_s > 0), error('step_s: expected a positive number of seconds'); end
  rows = numel(u);
  samples = delay_s / step_s;
  whole = floor(samples);
  if samples - whole > 1 - 1e-9, whole = whole + 1; end
  late_s = 0;
  if samples - whole > 1e-9, late_s = delay_s - whole * step_s; end
  v = [zeros(whole + 1, 1); v];

  % Every section over one step, exactly; the input changes late_s into it.
  A = []; before = []; now = []; x = []; c = [];
  for i = 1:size(sections, 1)
    d = sections{i, 2}(:);
    n = numel(d);
    M = zeros(n + 1);
    M(1:n, 1) = -d;
    M(1:n-1, 2:n) = eye(n - 1);
    M(1:n, n + 1) = sections{i, 3}(:);
    M = M * sections{i, 1};
    held = expm(M * step_s);
    first = expm(M * late_s);
    rest = expm(M * (step_s - late_s));
    A = blkdiag(A, held(1:n, 1:n));
    before = [before; rest(1:n, 1:n) * first(1:n, n + 1)];
    now = [now; rest(1:n, n + 1)];
    x = [x; sections{i, 4}(:)];
    c = [c, 1, zeros(1, n - 1)];
  end

  y = initial_output + direct * v(1:rows);
  for k = 1:rows
    if isempty(x), break; end
    y(k) = y(k) + c * x;
    x = A * x + before * v(k) + now * v(k + 1);
  end
  @OUTPUT@
end
)";

}  // namespace

std::string octave_text(const ExportedModel& model, const std::string& function) {
  const std::string input = with_unit("u", model.input_unit);
  const std::string output = with_unit("y", model.output_unit);
  std::string text = fmt::format(kHead, function, output, input);
  for (const std::string& line : notes(model)) text += "% " + line + "\n";
  text += "\n  % rate [rad/s], denominator and numerator below the highest power of s/rate, state at the first row\n";
  text += "  sections = {\n";
  for (const Section& s : model.sections.list) {
    text += fmt::format("    {}, [{}], [{}], [{}];\n", s.rate_rad_s, fmt::join(s.denominator, " "),
                        fmt::join(s.numerator, " "), fmt::join(s.state, " "));
  }
  text += "  };\n";
  text += fmt::format("  direct = {};\n  delay_s = {};\n  initial_output = {};\n", model.sections.direct,
                      model.sections.delay_s, model.initial_output);
  text += "  u = " + input + "(:);\n";
  if (model.input_map) {
    text += fmt::format(
        "  null = {};\n  dead_band = {};\n  negative_gain_ratio = {};\n"
        "  v = max(u - (null + dead_band), 0) + negative_gain_ratio * min(u - (null - dead_band), 0);\n",
        model.input_map->null, model.input_map->dead_band, model.input_map->negative_gain_ratio);
  } else {
    text += fmt::format("  v = u + {};\n", model.input_bias);
  }
  std::string body = kBody;
  constexpr std::string_view kOutput = "  @OUTPUT@\n";
  body.replace(body.find(kOutput), kOutput.size(), output == "y" ? "" : "  " + output + " = y;\n");
  return text + body;
}

}  // namespace eha::ident
