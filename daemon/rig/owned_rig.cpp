// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/owned_rig.hpp"

#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include "core/os/files.hpp"
#include "daemon/eha-safe/local_snapshots.hpp"
#include "hal/backend.hpp"
#include "hal/snapshot_file.hpp"

namespace eha {
namespace {

namespace fs = std::filesystem;

/// A folder of this process's own; only the guard reads what is in it.
fs::path create_private_folder() {
  std::string name = (local_snapshot_base() / kLocalSnapshotFolder).string() + "XXXXXX";
  if (mkdtemp(name.data()) == nullptr) os::throw_system_error("create", name, errno);
  return name;
}

}  // namespace

OwnedRig::OwnedRig(const config::RigConfig& config, fs::path snapshot) {
  std::unique_ptr<hal::Rig> rig = hal::open(config.backend, config.limits.safe_V);
  if (hal::moves_machine(config.backend)) {
    if (snapshot.empty()) {
      private_folder_ = create_private_folder();
      snapshot = private_folder_ / kLocalSnapshot;
    }
    hal::write_safe_snapshot(rig->safe_snapshot(), snapshot);
    guard_.emplace(guard_program(), snapshot);
  }
  rig_ = std::move(rig);
}

OwnedRig::~OwnedRig() {
  rig_.reset();
  guard_.reset();
  std::error_code ignored;
  if (!private_folder_.empty()) fs::remove_all(private_folder_, ignored);
}

void OwnedRig::made_safe() {
  if (guard_) guard_->done();
}

}  // namespace eha
