// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/sleep_delay.hpp"

#include <utility>

namespace eha::cli {

SleepDelay::SleepDelay(Suspends suspends, acquisition::StopRequest& stop) {
  if (suspends == Suspends::do_not_matter) return;
  inhibitor_.emplace("eha",
                     SleepInhibitor::Events{[this, &stop] {
                                              stop.request_ramp_out();
                                              tell("the machine is about to be suspended: ramping out");
                                            },
                                            [this](const std::string& why) { tell(undelayed_suspend_text(why)); }});
  inhibitor_->hold();
}

std::string SleepDelay::news() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, {});
}

void SleepDelay::tell(std::string news) {
  const std::lock_guard lock(mutex_);
  news_ = std::move(news);
}

}  // namespace eha::cli
