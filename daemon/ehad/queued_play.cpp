// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/queued_play.hpp"

#include <spdlog/spdlog.h>

#include <optional>

#include "daemon/precision/precision_watch.hpp"

namespace eha::service {

play::FinishedRun play(const Entry& entry, const config::PreparedExperiment& prepared,
                       const std::filesystem::path& folder, const config::RigConfig& config, OwnedRig* card,
                       const std::optional<RodAtRest>& rest, const std::filesystem::path& snapshot,
                       acquisition::NonRealtime non_realtime, acquisition::StateMachine& machine,
                       acquisition::EarlierRuns& earlier, acquisition::StopRequest& stop, play::RunWatch& watch) {
  std::optional<OwnedRig> simulated;
  OwnedRig& rig = card != nullptr ? *card : simulated.emplace(config, snapshot);
  const auto early_end = precision::watch_of(prepared.config, config, folder, [&entry](const std::string& sentence) {
    spdlog::info("experiment {}: {}", entry.id, sentence);
  });
  const play::PlayRequest request{
      .rig = config,
      .experiment = prepared.config,
      .table_V = {prepared.table_V.data(), static_cast<std::size_t>(prepared.table_V.size())},
      .predicted_in = {prepared.predicted_in.data(), static_cast<std::size_t>(prepared.predicted_in.size())},
      .folder = folder,
      .time_base = entry.fast ? acquisition::TimeBase::virtual_time : acquisition::TimeBase::monotonic,
      .non_realtime = non_realtime,
      .played_by = play::PlayedBy::ehad,
      .early_end = early_end.get(),
      .watch = &watch,
      .earlier = &earlier,
      .page = &rig.page(),
      .share_journal = [&rig](const os::FileDescriptor& journal) { rig.hold(journal); },
      .before_driven =
          [&](hal::Rig& driven) {
            if (card != nullptr && rest) require_at_rest(driven, *rest, DisplayUnit(config.units));
          }};
  return play::play(rig.rig(), machine, request, stop);
}

}  // namespace eha::service
