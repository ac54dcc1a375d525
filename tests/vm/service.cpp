// SPDX-License-Identifier: GPL-3.0-or-later
#include "service.hpp"

#include <sys/stat.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace eha::test {
namespace {

std::filesystem::path new_folder() {
  std::string name = "/tmp/service-XXXXXX";
  if (mkdtemp(name.data()) == nullptr || chmod(name.c_str(), 0755) != 0) throw std::runtime_error(name);
  return name;
}

}  // namespace

Service::Service(const std::string& rig_file)
    : folder_(new_folder()),
      process_({"ehad", "--rig", rig_file, "--state", folder_ / "state", "--socket", folder_ / "ehad.sock"}) {
  const auto listens = [&] { return eha({"status"}).wait() == 0; };
  if (!wait_until(listens) || chmod((folder_ / "ehad.sock").c_str(), 0666) != 0) {
    throw std::runtime_error("ehad does not listen: " + process_.output());
  }
}

Service::~Service() {
  process_.signal(SIGTERM);
  process_.wait();
}

Process Service::eha(std::vector<std::string> words, const ProcessOptions& options) const {
  words.insert(words.begin(), "eha");
  words.insert(words.end(), {"--socket", folder_ / "ehad.sock"});
  return Process(words, options);
}

}  // namespace eha::test
