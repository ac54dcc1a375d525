// SPDX-License-Identifier: GPL-3.0-or-later
// stop_thread TID: stops one thread of another process, as SIGSTOP would stop all of them, until standard input ends.
// Prints "stopped" once it stands.
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
  const pid_t thread = argc == 2 ? static_cast<pid_t>(std::strtol(argv[1], nullptr, 10)) : 0;
  if (thread <= 0) {
    std::fputs("usage: stop_thread TID\n", stderr);
    return 2;
  }
  int status = 0;
  if (ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) != 0 || ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) != 0 ||
      waitpid(thread, &status, __WALL) != thread || !WIFSTOPPED(status)) {
    std::perror("stop_thread");
    return 1;
  }
  std::puts("stopped");
  std::fflush(stdout);
  char byte = 0;
  while (read(STDIN_FILENO, &byte, 1) > 0) {
  }
  // Ending detaches the thread, which then goes on if it still lives.
  return 0;
}
