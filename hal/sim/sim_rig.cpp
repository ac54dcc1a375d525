// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/sim/sim_rig.hpp"

#include <cmath>
#include <sstream>

#include "core/error.hpp"
#include "core/inch.hpp"
#include "hal/converter.hpp"
#include "hal/sim/cylinder.hpp"
#include "hal/sim/normal_noise.hpp"

namespace eha::hal {
namespace {

constexpr double kInchPerMetre = 1.0 / kMetrePerInch;

class SimRig final : public Rig {
 public:
  SimRig(const SimOptions& options, double safe_V, Integration integration)
      : cylinder_(options),
        integration_(integration),
        output_(options.command_min_V, options.command_max_V, options.resolution_bits),
        input_(options.feedback_min_V, options.feedback_max_V, options.resolution_bits),
        noise_(options.seed),
        noise_V_(options.sensor_noise_V),
        scale_in_per_V_(options.scale_in_per_V),
        offset_in_(options.offset_in),
        safe_V_(safe_V) {
    capabilities_.backend = SimOptions::kName;
    capabilities_.moves_machine = SimOptions::kMovesMachine;
    capabilities_.has_virtual_clock = SimOptions::kHasVirtualClock;
    capabilities_.command_min_V = options.command_min_V;
    capabilities_.command_max_V = options.command_max_V;
    capabilities_.command_lsb_V = output_.lsb_V();
    capabilities_.feedback_min_V = options.feedback_min_V;
    capabilities_.feedback_max_V = options.feedback_max_V;
    capabilities_.feedback_lsb_V = input_.lsb_V();
    capabilities_.has_enable = true;
    make_safe();
  }

  [[nodiscard]] const RigCapabilities& capabilities() const noexcept override { return capabilities_; }

  RigStatus read(std::int64_t elapsed_ns, RigReading& reading) noexcept override {
    if (elapsed_ns > elapsed_ns_) {
      const Ports ports = enabled_ ? Ports::open : Ports::blocked;
      const double duration_s = static_cast<double>(elapsed_ns - elapsed_ns_) * 1e-9;
      if (integration_ == Integration::exact) cylinder_.advance(held_V_, ports, duration_s);
      if (integration_ == Integration::quick) cylinder_.advance_implicitly(held_V_, ports, duration_s);
    }
    elapsed_ns_ = elapsed_ns;
    const double exact_V = (cylinder_.state().displacement_m * kInchPerMetre - offset_in_) / scale_in_per_V_;
    const std::uint32_t code = input_.code(exact_V + noise_V_ * noise_());
    const double feedback_V = input_.volts(code);
    reading = {.displacement_in = offset_in_ + scale_in_per_V_ * feedback_V,
               .feedback_V = feedback_V,
               .feedback_code = code,
               .digital_inputs = 0,
               .feedback_at_rail = input_.at_rail(code),
               .emergency_stop = false};
    return RigStatus::ok;
  }

  RigStatus command(double command_V, AppliedCommand& applied) noexcept override {
    if (!std::isfinite(command_V)) return RigStatus::not_finite;
    applied.code = output_.code(command_V);
    applied.applied_V = output_.volts(applied.code);
    held_V_ = applied.applied_V;
    return RigStatus::ok;
  }

  RigStatus set_enable(bool on) noexcept override {
    enabled_ = on;
    return RigStatus::ok;
  }

  RigStatus make_safe() noexcept override {
    enabled_ = false;
    held_V_ = output_.volts(output_.code(safe_V_));
    return RigStatus::ok;
  }

 private:
  RigCapabilities capabilities_;
  Cylinder cylinder_;
  Integration integration_;
  Converter output_;
  Converter input_;
  NormalNoise noise_;
  double noise_V_;
  double scale_in_per_V_;
  double offset_in_;
  double safe_V_;
  double held_V_ = 0.0;
  bool enabled_ = false;
  std::int64_t elapsed_ns_ = 0;
};

}  // namespace

std::unique_ptr<Rig> open_rig(const SimOptions& options, double safe_V, Integration integration) {
  std::vector<OptionIssue> issues = check(options);
  if (!(safe_V >= options.command_min_V && safe_V <= options.command_max_V)) {
    std::ostringstream message;
    message << "expected to hold the rig's safe voltage, from " << options.command_min_V << " to "
            << options.command_max_V << " V, got " << safe_V;
    issues.push_back({"command_min_V", message.str()});
  }
  if (!issues.empty()) throw ConfigError(to_lines(issues, std::string(SimOptions::kName)));
  return std::make_unique<SimRig>(options, safe_V, integration);
}

}  // namespace eha::hal
