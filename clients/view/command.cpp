// SPDX-License-Identifier: GPL-3.0-or-later
// hapt view: shows a running session or a recording to browsers, a session to Foxglove too.
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "clients/hapt/commands.h"
#include "clients/hapt/session_choice.h"
#include "clients/view/bridge.h"
#include "clients/view/log_source.h"
#include "clients/view/session_source.h"
#include "clients/view/web/token.h"
#include "proto/config/command_line.h"
#include "proto/ipc/control_socket.h"
#include "proto/ipc/process.h"
#include "proto/ipc/sessions.h"
#include "proto/os/environment.h"
#include "proto/os/programs.h"
#include "proto/os/source_tree.h"

namespace haptic {
namespace {

namespace fs = std::filesystem;

struct ViewCommand {
  SessionChoice session;
  std::string address = "127.0.0.1", token_file, page, clearance;
  std::vector<std::string> hosts, origins;
  uint32_t port = 8765;
  bool no_open = false;
};

/// The folder of the page: beside the programs of a build, or in share/hapticd of an installation.
std::string find_page() {
  std::error_code error;
  for (const fs::path& folder :
       {fs::path(own_folder()).parent_path() / "view", shared_folder("view")}) {
    if (fs::exists(folder / "index.html", error)) return folder.string();
  }
  return "";
}

/// Opens the address in the browser of a desktop, where there is one. The browser is told a file
/// that leads there: everybody may read the arguments of a process, and the token is not for them.
std::unique_ptr<PrivateFile> open_browser(const std::string& url, uint16_t port) {
  if (environment("DISPLAY").empty() && environment("WAYLAND_DISPLAY").empty()) return nullptr;
  const std::string path = runtime_folder() + "/view-" + std::to_string(port) + ".html";
  auto file = std::make_unique<PrivateFile>(
      path, "<!doctype html><meta http-equiv=\"refresh\" content=\"0; url=" + url + "\">\n");
  // a grandchild, so that nobody has to wait for it
  const pid_t child = fork();
  if (child == 0) {
    if (fork() == 0) {
      execlp("xdg-open", "xdg-open", path.c_str(), nullptr);
    }
    _exit(0);
  }
  if (child > 0) waitpid(child, nullptr, 0);
  return file;
}

std::string shown_address(const std::string& address) {
  return address.find(':') == address.npos ? address : "[" + address + "]";
}

/// The token in a file, for programs of this user; without it where the folder is not theirs.
std::unique_ptr<PrivateFile> write_token(const ViewCommand& options, uint16_t port,
                                         const std::string& token) {
  if (!options.token_file.empty())
    return std::make_unique<PrivateFile>(options.token_file, token + "\n");
  const std::string path = runtime_folder() + "/view-" + std::to_string(port) + ".token";
  try {
    return std::make_unique<PrivateFile>(path, token + "\n");
  } catch (const MessageError& error) {
    std::cerr << "hapt: " << error.what() << '\n';
    return nullptr;
  }
}

/// True if the argument is a recording: an existing file, or a name that ends like one.
bool names_log(const std::string& argument) {
  std::error_code error;
  return argument.ends_with(".mcap") || fs::is_regular_file(argument, error);
}

void show(const ViewCommand& options) {
  catch_stop_signals();
  const bool is_log = names_log(options.session.name);
  const std::string session = is_log ? "" : name_of_session(once_up(options.session));
  std::optional<TightestPlace> tightest;
  if (!options.clearance.empty()) {
    if (!is_log) throw InputError("--clearance: belongs to a recording; name its file (.mcap)");
    tightest = read_tightest(options.clearance);
  }
  const BridgeOptions bridge_options{
      .web = {.address = options.address, .port = static_cast<uint16_t>(options.port)},
      .rules = {.hosts = options.hosts, .origins = options.origins},
      .token = make_token(),
      .page_folder = options.page.empty() ? find_page() : options.page,
      .say = [session](const std::string& line) { return say_to_session(session, line); }};
  Bridge bridge(is_log ? log_source(options.session.name, tightest) : session_source(session),
                bridge_options);

  const auto file = write_token(options, bridge.port(), bridge_options.token);
  const std::string url = "http://" + shown_address(options.address) + ":" +
                          std::to_string(bridge.port()) + "/#token=" + bridge_options.token;
  std::cout << url << std::endl;
  if (options.address != "127.0.0.1" && options.address != "::1") {
    std::cerr << "hapt: everybody who reaches " << shown(options.address) << " may watch\n";
  }
  const auto leads_there = options.no_open ? nullptr : open_browser(url, bridge.port());
  bridge.run(stop_requested);
}

}  // namespace

void add_view_command(Command& app) {
  const auto options = std::make_shared<ViewCommand>();
  Command command = add_elsewhere(app, "view");
  add_session(command, options->session);
  command.option("SESSION", options->session.name, "a session, or the file of a recording (.mcap)")
      .excludes("--session");
  command.option("--port", options->port, "of the address; 0: any that is free")
      .range(0, 65535)
      .show_default();
  command.option("--address ADDRESS", options->address, "to listen at").show_default();
  command.option("--allow-host HOST", options->hosts,
                 "another name, or name:port, under which a browser may ask for the page");
  command.option("--allow-origin ORIGIN", options->origins,
                 "a web page that may watch by the Foxglove protocol, as https://app.foxglove.dev");
  command.option("--token-file FILE", options->token_file, "where the token is written")
      .show_default("view-PORT.token in the folder of the sessions");
  command.option("--page FOLDER", options->page, "of the page")
      .show_default("that of this build or installation");
  command.option(
      "--clearance FILE", options->clearance,
      "what `hapt clearance LOG --json` has printed: draws the tool at its tightest place");
  command.flag("--no-open", options->no_open, "do not open a browser");
  command.example("hapt view bunny --no-open");
  command.example("hapt view out.mcap");
  command.example("hapt view frame.mcap --clearance frame.json");
  command.action([options] { show(*options); });
}

}  // namespace haptic
