// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/process/hapticd_process.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "proto/os/programs.h"

namespace haptic::test {

std::filesystem::path program_folder() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

ProgramProcess::ProgramProcess(const std::string& name, std::vector<std::string> arguments,
                               const std::string& folder)
    : log_path_(folder + "/log." + std::to_string(now_ns())) {
  const std::string program = program_folder() / name;
  std::vector<char*> argv{const_cast<char*>(program.c_str())};
  for (std::string& word : arguments) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ != 0) return;
  const int log = open(log_path_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execv(program.c_str(), argv.data());
  _exit(127);
}

ProgramProcess::~ProgramProcess() {
  if (pid_ > 0) {
    send(SIGTERM);
    exit_code();
  }
}

void ProgramProcess::send(int signal) const {
  kill(pid_, signal);
}

int ProgramProcess::exit_code() {
  int status = 0;
  const bool ended = eventually([&] { return waitpid(pid_, &status, WNOHANG) == pid_; });
  if (!ended) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  pid_ = -1;
  if (!ended) return -1000;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

std::string ProgramProcess::log() const {
  std::ostringstream text;
  text << std::ifstream(log_path_).rdbuf();
  return text.str();
}

}  // namespace haptic::test
