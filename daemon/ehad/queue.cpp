// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/queue.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/lock_file.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSchema = "eha-queue/1";
constexpr std::array kEntryStates{EntryState::held,    EntryState::waiting, EntryState::running,
                                  EntryState::fitting, EntryState::over,    EntryState::cancelled};

EntryState state_from_text(const std::string& text) {
  for (const EntryState state : kEntryStates) {
    if (to_text(state) == text) return state;
  }
  throw DataError(fmt::format("\"{}\" is no state of a queued experiment", text));
}

bool is_over(const Entry& entry) { return entry.state == EntryState::over || entry.state == EntryState::cancelled; }

Entry entry_from_text(const std::string& text) {
  const Json json = Json::parse(text);
  if (json.at("schema") != kSchema) throw DataError(fmt::format("schema: expected {}", kSchema));
  Entry entry;
  entry.id = json.at("entry");
  entry.state = state_from_text(json.at("state"));
  entry.name = json.at("name");
  entry.file = json.at("file");
  entry.uid = json.at("uid");
  entry.user = json.at("user");
  entry.fast = json.at("fast");
  entry.submitted = json.at("submitted");
  entry.experiment = json.at("experiment");
  entry.run = json.at("run");
  entry.outcome = json.at("outcome");
  entry.note = json.at("note");
  entry.models = json.at("models");
  entry.exit_code = json.at("exit_code");
  if (const auto placed = json.find("placed_in"); placed != json.end() && placed->is_number())
    entry.placed_in = *placed;
  entry.place = json.value("place", entry.id);
  entry.duration_s = json.value("duration_s", 0.0);
  entry.rehearsal = json.value("rehearsal", Json());
  entry.accept_travel_risk = json.value("accept_travel_risk", false);
  entry.warnings = json.value("warnings", std::vector<std::string>());
  entry.only_places = json.value("only_places", false);
  entry.is_for_machine = json.value("for_machine", true);
  entry.is_open_fault = json.value("open_fault", false);
  entry.has_open_slip = json.value("open_slip", false);
  entry.missed_motion = json.value("missed_motion", false);
  if (const auto found = json.find("calibration"); found != json.end() && found->is_array()) {
    entry.calibration = {found->at(0), found->at(1)};
  }
  if (entry.id < 1) throw DataError("entry: expected a number above 0");
  return entry;
}

}  // namespace

std::string_view to_text(EntryState state) noexcept {
  switch (state) {
    case EntryState::held:
      return "held";
    case EntryState::waiting:
      return "waiting";
    case EntryState::running:
      return "running";
    case EntryState::fitting:
      return "fitting";
    case EntryState::judging:
      return "judging";
    case EntryState::over:
      return "over";
    case EntryState::cancelled:
      return "cancelled";
  }
  return "unknown";
}

Json describe(const Entry& entry) {
  return {{"entry", entry.id},
          {"state", to_text(entry.state)},
          {"name", entry.name},
          {"file", entry.file},
          {"uid", entry.uid},
          {"user", entry.user},
          {"fast", entry.fast},
          {"only_places", entry.only_places},
          {"submitted", entry.submitted},
          {"duration_s", entry.duration_s},
          {"run", entry.run},
          {"outcome", entry.outcome},
          {"note", entry.note},
          {"warnings", entry.warnings},
          {"rehearsal", entry.rehearsal},
          {"models", entry.models},
          {"placed_in", entry.placed_in ? Json(*entry.placed_in) : Json(nullptr)},
          {"exit_code", entry.exit_code},
          {"open_slip", entry.has_open_slip},
          {"missed_motion", entry.missed_motion}};
}

std::string bad_end_of(const Entry& entry) {
  std::string text = fmt::format("experiment {}: {}", entry.id, entry.outcome);
  // What the disk said is the whole of such an end, and stands last in its note.
  const bool is_of_disk = entry.outcome == acquisition::to_text(acquisition::Outcome::write_failed);
  if (!entry.note.empty()) text += ": " + (is_of_disk ? entry.note : record::without_remedy(entry.note));
  if (!entry.run.empty()) text += "; run " + entry.run;
  return text;
}

QueueStore::QueueStore(fs::path folder) : folder_(std::move(folder)) {
  os::create_folders(folder_);
  lock_ = os::lock_file(folder_ / "lock",
                        "another process of this user, as a rule another ehad that uses this folder; stop it first");
}

fs::path QueueStore::file_of(EntryId id) const { return folder_ / fmt::format("{:08}.json", id); }

std::vector<Entry> QueueStore::load(std::vector<std::string>& damaged) const {
  std::vector<fs::path> files;
  std::error_code error;
  fs::directory_iterator entries(folder_, error);
  if (error) os::throw_system_error("list", folder_, error.value());
  for (const auto& entry : entries) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Entry> loaded;
  for (const fs::path& file : files) {
    try {
      loaded.push_back(entry_from_text(os::read_file(file)));
    } catch (const std::exception& fault) {
      fs::path aside = file;
      aside += ".damaged";
      fs::rename(file, aside, error);
      damaged.push_back(fmt::format("{}: not an entry of the queue ({}); set aside as {}", file.string(), fault.what(),
                                    aside.filename().string()));
    }
  }
  return loaded;
}

void QueueStore::save(const Entry& entry) const {
  Json json{{"schema", kSchema}};
  json.update(describe(entry));
  json["place"] = entry.place;
  json["accept_travel_risk"] = entry.accept_travel_risk;
  json["for_machine"] = entry.is_for_machine;
  json["experiment"] = entry.experiment;
  json["open_fault"] = entry.is_open_fault;
  if (entry.calibration) json["calibration"] = {entry.calibration->first, entry.calibration->second};
  os::write_file_atomically(file_of(entry.id), json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void QueueStore::remove(EntryId id) const noexcept {
  std::error_code ignored;
  fs::remove(file_of(id), ignored);
}

Queue::Queue(std::vector<Entry> entries) {
  for (Entry& entry : entries) add(std::move(entry));
}

Entry& Queue::add(Entry entry) {
  next_id_ = std::max(next_id_, entry.id + 1);
  const EntryId id = entry.id;
  if (entry.place == 0) entry.place = id;
  return entries_.insert_or_assign(id, std::move(entry)).first->second;
}

Entry* Queue::find(EntryId id) {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : &found->second;
}

std::size_t Queue::count(EntryState state) const {
  return static_cast<std::size_t>(
      std::count_if(entries_.begin(), entries_.end(), [&](const auto& item) { return item.second.state == state; }));
}

std::size_t Queue::count_queued() const { return count(EntryState::held) + count(EntryState::waiting); }

std::size_t Queue::count_queued(uid_t uid) const {
  return static_cast<std::size_t>(std::count_if(entries_.begin(), entries_.end(), [&](const auto& item) {
    const Entry& entry = item.second;
    return entry.uid == uid && (entry.state == EntryState::held || entry.state == EntryState::waiting);
  }));
}

std::vector<EntryId> Queue::in_order() const {
  std::vector<EntryId> ids;
  for (const auto& [id, entry] : entries_) ids.push_back(id);
  std::stable_sort(ids.begin(), ids.end(), [this](EntryId a, EntryId b) {
    const Entry& first = entries_.at(a);
    const Entry& second = entries_.at(b);
    const auto rank = [](const Entry& entry) {
      return is_over(entry) ? 0 : entry.state == EntryState::running ? 1 : 2;
    };
    return rank(first) != rank(second) ? rank(first) < rank(second) : first.place < second.place;
  });
  return ids;
}

std::vector<EntryId> Queue::of(uid_t uid, EntryState state) const {
  std::vector<EntryId> ids;
  for (const EntryId id : in_order()) {
    const Entry& entry = entries_.at(id);
    if (entry.uid == uid && entry.state == state) ids.push_back(id);
  }
  return ids;
}

std::vector<EntryId> Queue::queued_of(uid_t uid) const {
  std::vector<EntryId> ids;
  for (const EntryId id : in_order()) {
    const Entry& entry = entries_.at(id);
    if (entry.uid == uid && (entry.state == EntryState::held || entry.state == EntryState::waiting)) ids.push_back(id);
  }
  return ids;
}

std::vector<EntryId> Queue::move(EntryId id, std::int64_t position) {
  std::vector<EntryId> order = queued_of(entries_.at(id).uid);
  const auto from = std::find(order.begin(), order.end(), id);
  if (from == order.end()) return {};
  std::vector<EntryId> places;
  for (const EntryId one : order) places.push_back(entries_.at(one).place);
  order.erase(from);
  const auto last = static_cast<std::int64_t>(order.size()) + 1;
  order.insert(order.begin() + (std::clamp<std::int64_t>(position, 1, last) - 1), id);
  std::vector<EntryId> changed;
  for (std::size_t i = 0; i < order.size(); ++i) {
    Entry& entry = entries_.at(order[i]);
    if (entry.place == places[i]) continue;
    entry.place = places[i];
    changed.push_back(entry.id);
  }
  return changed;
}

std::size_t Queue::hold_waiting(const std::string& why) {
  std::size_t count = 0;
  for (auto& [id, entry] : entries_) {
    if (entry.state != EntryState::waiting) continue;
    entry.state = EntryState::held;
    entry.note = why;
    ++count;
  }
  return count;
}

Entry* Queue::next_of(uid_t uid) {
  Entry* next = nullptr;
  for (auto& [id, entry] : entries_) {
    if (entry.state != EntryState::waiting || entry.uid != uid) continue;
    if (next == nullptr || entry.place < next->place) next = &entry;
  }
  return next;
}

Entry* Queue::next_to_fit() {
  for (auto& [id, entry] : entries_) {
    if (entry.state == EntryState::fitting) return &entry;
  }
  return nullptr;
}

const Entry* Queue::open_fault() const {
  const Entry* newest = nullptr;
  for (const auto& [id, entry] : entries_) {
    if (entry.is_open_fault) newest = &entry;
  }
  return newest;
}

std::vector<EntryId> Queue::clear(bool Entry::*mark, const std::optional<std::pair<double, double>>& in_force) {
  std::vector<EntryId> changed;
  for (auto& [id, entry] : entries_) {
    if (in_force && !is_same_place(entry.calibration.value_or(*in_force), *in_force)) continue;
    if (std::exchange(entry.*mark, false)) changed.push_back(id);
  }
  return changed;
}

std::vector<EntryId> Queue::close_faults() { return clear(&Entry::is_open_fault); }

bool is_same_place(const std::pair<double, double>& one, const std::pair<double, double>& other) {
  constexpr double kMost_V = 10.0;        // of a card
  constexpr double kRounding_in = 0.005;  // the same numbers in other units or with fewer digits
  const double slope_in = kMost_V * std::abs(one.first - other.first);
  return slope_in + std::abs(one.second - other.second) <= kRounding_in;
}

const Entry* Queue::open_slip(const std::pair<double, double>& in_force) const {
  const Entry* newest = nullptr;
  for (const auto& [id, entry] : entries_) {
    if (entry.has_open_slip && is_same_place(entry.calibration.value_or(in_force), in_force)) newest = &entry;
  }
  return newest;
}

std::vector<EntryId> Queue::missed_motion(const std::pair<double, double>& in_force) const {
  std::vector<EntryId> missed;
  for (const auto& [id, entry] : entries_) {
    if (entry.missed_motion && is_same_place(entry.calibration.value_or(in_force), in_force)) missed.push_back(id);
  }
  return missed;
}

std::vector<EntryId> Queue::forget_missed_motion(const std::pair<double, double>& in_force) {
  return clear(&Entry::missed_motion, in_force);
}

std::vector<EntryId> Queue::close_slips(const std::pair<double, double>& in_force) {
  return clear(&Entry::has_open_slip, in_force);
}

std::vector<EntryId> Queue::forget_old(EntryId kept) {
  auto over = static_cast<std::size_t>(
      std::count_if(entries_.begin(), entries_.end(), [&](const auto& item) { return is_over(item.second); }));
  std::vector<EntryId> forgotten;
  for (auto item = entries_.begin(); item != entries_.end() && over > kMostOver;) {
    if (!is_over(item->second) || item->first == kept || item->second.has_open_slip || item->second.missed_motion) {
      ++item;
      continue;
    }
    forgotten.push_back(item->first);
    item = entries_.erase(item);
    --over;
  }
  return forgotten;
}

}  // namespace eha::service
