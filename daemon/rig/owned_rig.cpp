// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/owned_rig.hpp"

#include <cerrno>
#include <cstdlib>
#include <new>
#include <string>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/eha-safe/local_snapshots.hpp"
#include "daemon/rig/arming.hpp"
#include "hal/backends/backend.hpp"
#include "hal/snapshot_file.hpp"

namespace eha {
namespace {

namespace fs = std::filesystem;

/// A private folder of this process; only the guard reads its files.
fs::path create_private_folder() {
  std::string name = (local_snapshot_base() / kLocalSnapshotFolder).string() + "XXXXXX";
  if (mkdtemp(name.data()) == nullptr) os::throw_system_error("create", name, errno);
  return name;
}

fs::path beside(const fs::path& snapshot) { return snapshot.parent_path() / kPageFile; }

}  // namespace

OwnedRig::OwnedRig(const config::RigConfig& config, fs::path snapshot)
    : moves_machine_(hal::moves_machine(config.backend)),
      // The name in that folder is of the service that drives a card, which may be another one.
      memory_(os::SharedMemory::create(sizeof(GuardPage),
                                       moves_machine_ && !snapshot.empty() ? beside(snapshot) : fs::path())),
      page_(new (memory_.data()) GuardPage) {
  page_->mark_version();
  std::unique_ptr<hal::Rig> rig = open_at_rest(config);
  if (moves_machine_) {
    if (snapshot.empty()) {
      private_folder_ = create_private_folder();
      snapshot = private_folder_ / kLocalSnapshot;
    }
    hal::write_safe_snapshot(rig->safe_snapshot(), snapshot);
    guard_.emplace(guard_program(), snapshot, &memory_.file());
  } else {
    try {
      guard_.emplace(guard_program(), fs::path(), &memory_.file());
    } catch (const DeviceError&) {
      // Only the last rows can be lost, and only if this process is killed.
    }
  }
  rig_ = std::move(rig);
}

OwnedRig::~OwnedRig() {
  page_->beat();
  rig_.reset();
  guard_.reset();
  std::error_code ignored;
  if (!private_folder_.empty()) fs::remove_all(private_folder_, ignored);
}

void OwnedRig::made_safe() {
  if (!guard_) return;
  try {
    guard_->done();
  } catch (const DeviceError&) {
    if (moves_machine_) throw;
  }
}

}  // namespace eha
