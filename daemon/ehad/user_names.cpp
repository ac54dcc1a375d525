// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/user_names.hpp"

#include <pthread.h>
#include <pwd.h>

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "core/os/users.hpp"
#include "core/text.hpp"
#include "daemon/acquisition/fatal_signals.hpp"

namespace eha::service {
namespace {

constexpr std::size_t kLongestName = 64;
constexpr std::size_t kBuffer = 16 * 1024;

/// Returns the name by the name service switch; the number if it has none.
std::string looked_up_name(uid_t uid) {
  std::vector<char> buffer(kBuffer);
  passwd entry{};
  passwd* found = nullptr;
  if (getpwuid_r(uid, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr) {
    return shortened(found->pw_name, kLongestName);
  }
  return std::to_string(uid);
}

}  // namespace

struct UserNames::LookUps {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<uid_t> wanted;
  std::map<uid_t, std::string> found;
  bool ending = false;

  void run() {
    acquisition::block_all_but_fatal_signals();
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [this] { return ending || !wanted.empty(); });
      if (ending) return;
      const uid_t uid = wanted.front();
      wanted.pop_front();
      lock.unlock();
      std::string name = looked_up_name(uid);
      lock.lock();
      found[uid] = std::move(name);
    }
  }
};

UserNames::UserNames() : look_ups_(std::make_shared<LookUps>()) {
  std::thread thread([shared = look_ups_] { shared->run(); });
  pthread_setname_np(thread.native_handle(), "eha-names");
  thread.detach();
}

UserNames::~UserNames() {
  const std::lock_guard lock(look_ups_->mutex);
  look_ups_->ending = true;
  look_ups_->changed.notify_one();
}

std::string UserNames::name(uid_t uid) {
  const std::lock_guard lock(look_ups_->mutex);
  if (names_.size() + look_ups_->found.size() >= kMostKept) names_.clear();
  for (auto& [found, name] : look_ups_->found) names_[found] = std::move(name);
  look_ups_->found.clear();
  const auto known = names_.find(uid);
  if (known != names_.end()) return known->second;
  std::string& name = names_[uid];
  name = shortened(os::local_user_name(uid), kLongestName);
  if (name.empty()) {
    name = std::to_string(uid);
    look_ups_->wanted.push_back(uid);
    look_ups_->changed.notify_one();
  }
  return name;
}

}  // namespace eha::service
