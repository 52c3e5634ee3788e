// SPDX-License-Identifier: BSD-3-Clause
#include "server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sys/random.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <map>
#include <thread>

#include "page_files.h"
#include "s2nnds/core/check.h"
#include "s2nnds/core/platform.h"

namespace s2nnds::studio {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::size_t kLargestBody = 16 << 20;  // bytes
constexpr int kMostListeners = 6;               // pages that listen for events at once
constexpr int kThreads = 16;                    // more than listeners, so that requests find one
constexpr double kHeartbeat = 5.0;              // seconds between signs of life

std::string random_token() {
  unsigned char bytes[16];
  check(::getrandom(bytes, sizeof(bytes), 0) == sizeof(bytes), "studio: the system gives no random numbers");
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

// Takes as long for every wrong token.
bool same(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

void answer(httplib::Response& response, int status, const ordered_json& body) {
  response.status = status;
  response.set_content(body.dump(-1, ' ', false, ordered_json::error_handler_t::replace),
                       "application/json; charset=utf-8");
}

void refuse(httplib::Response& response, int status, const std::string& why) {
  answer(response, status, {{"error", why}});
}

// What the page asks for, done; every way in which it can go wrong has its status.
void guarded(httplib::Response& response, const std::function<void()>& act) {
  try {
    act();
  } catch (const json::exception&) {
    refuse(response, 400, "the request is no JSON of the form that was expected");
  } catch (const Conflict& error) {
    refuse(response, 409, error.what());
  } catch (const Error& error) {
    refuse(response, 422, error.what());
  } catch (const std::exception& error) {
    refuse(response, 500, error.what());
  }
}

class Server {
 public:
  Server(Studio& studio, int port) : studio_(studio), token_(random_token()), files_(page_files()) {
    // Not SO_REUSEPORT, with which a second studio would take half of the requests.
    server_.set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    });
    server_.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server_.set_payload_max_length(kLargestBody);
    server_.set_keep_alive_max_count(1000);
    server_.set_read_timeout(10);
    server_.set_write_timeout(10);
    server_.set_default_headers({{"Cache-Control", "no-store"},
                                 {"X-Content-Type-Options", "nosniff"},
                                 {"X-Frame-Options", "DENY"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"Cross-Origin-Resource-Policy", "same-origin"},
                                 {"Content-Security-Policy",
                                  "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'"}});
    server_.set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
      return admit(request, response) ? httplib::Server::HandlerResponse::Unhandled
                                      : httplib::Server::HandlerResponse::Handled;
    });
    server_.set_error_handler([](const httplib::Request&, httplib::Response& response) {
      if (!response.body.empty()) return;
      refuse(response, response.status,
             response.status == 413 ? fmt::format("found more than {} MB; expected less", kLargestBody >> 20)
                                    : "found nothing of this name");
    });
    server_.set_exception_handler([](const httplib::Request&, httplib::Response& response,
                                     std::exception_ptr) { refuse(response, 500, "internal failure"); });
    add_routes();
    if (port == 0) {
      port_ = server_.bind_to_any_port("127.0.0.1");
    } else if (server_.bind_to_port("127.0.0.1", port)) {
      port_ = port;
    }
    check(port_ > 0, "studio: cannot listen at 127.0.0.1, port {}: it is taken", port);
  }

  std::string address() const { return fmt::format("http://127.0.0.1:{}/{}/", port_, token_); }
  void listen() { server_.listen_after_bind(); }
  void stop() { server_.stop(); }

 private:
  // Before any body is read.
  bool admit(const httplib::Request& request, httplib::Response& response) const {
    const std::string host = request.get_header_value("Host");
    const std::string here = fmt::format("127.0.0.1:{}", port_), named = fmt::format("localhost:{}", port_);
    const auto stop = [&](int status, const char* why) {
      refuse(response, status, why);
      response.set_header("Connection", "close");
      return false;
    };
    if (host != here && host != named) return stop(403, "this is not the studio of that host");
    if (request.has_header("Origin")) {
      const std::string origin = request.get_header_value("Origin");
      if (origin != "http://" + here && origin != "http://" + named)
        return stop(403, "a page from elsewhere asks");
    }
    const std::string site = request.get_header_value("Sec-Fetch-Site");
    if (site == "cross-site" && request.method != "GET") return stop(403, "a page from elsewhere asks");
    const std::size_t end = request.path.find('/', 1);
    if (end == std::string::npos || !same(request.path.substr(1, end - 1), token_))
      return stop(403, "the token in the address is not this studio's");
    // Their size is not known before they are read.
    if (request.has_header("Transfer-Encoding")) return stop(411, "expected a body with a length");
    return true;
  }

  std::string route(const std::string& rest) const { return "/" + token_ + "/" + rest; }

  void add_routes() {
    for (const auto& [name, file] : files_) {
      if (name == "report.html") continue;
      const PageFile* shown = &file;
      server_.Get(route(name == "index.html" ? "" : name),
                  [shown](const httplib::Request&, httplib::Response& response) {
                    response.set_content(shown->bytes, shown->type.c_str());
                  });
    }
    get("api/state",
        [this](const httplib::Request&, httplib::Response& r) { answer(r, 200, studio_.state()); });
    get("api/run", [this](const httplib::Request&, httplib::Response& r) {
      r.set_content(studio_.run(), "application/json; charset=utf-8");
    });
    get("api/preview",
        [this](const httplib::Request&, httplib::Response& r) { answer(r, 200, studio_.preview()); });
    get("api/download", [this](const httplib::Request& request, httplib::Response& r) {
      const Studio::Download file = studio_.download(request.get_param_value("kind"));
      r.set_header("Content-Disposition", fmt::format("attachment; filename=\"{}\"", file.name));
      r.set_content(file.bytes, "application/octet-stream");
    });
    post("api/drawing",
         [this](const httplib::Request& request) { studio_.set_drawing(json::parse(request.body)); });
    post("api/learn", [this](const httplib::Request&) { studio_.learn(); });
    post("api/resume", [this](const httplib::Request&) { studio_.resume(); });
    post("api/adapt", [this](const httplib::Request&) { studio_.adapt(); });
    post("api/cancel", [this](const httplib::Request&) { studio_.cancel(); });
    server_.Post(route("api/file"), [this](const httplib::Request& request, httplib::Response& response) {
      guarded(response, [&] {
        answer(response, 200, studio_.take_file(request.get_param_value("name"), request.body));
      });
    });
    server_.Get(route("api/events"),
                [this](const httplib::Request&, httplib::Response& response) { listen_to(response); });
  }

  void get(const char* name, std::function<void(const httplib::Request&, httplib::Response&)> act) {
    server_.Get(route(name),
                [act = std::move(act)](const httplib::Request& request, httplib::Response& response) {
                  guarded(response, [&] { act(request, response); });
                });
  }

  // Answers with the state after it.
  void post(const char* name, std::function<void(const httplib::Request&)> act) {
    server_.Post(route(name),
                 [this, act = std::move(act)](const httplib::Request& request, httplib::Response& response) {
                   guarded(response, [&] {
                     act(request);
                     answer(response, 200, studio_.state());
                   });
                 });
  }

  // Server-sent events: the state, whenever it is another.
  void listen_to(httplib::Response& response) {
    if (listeners_.fetch_add(1) >= kMostListeners) {
      --listeners_;
      return refuse(response, 503, "as many pages as the studio serves are open");
    }
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, seen = std::int64_t{0}](std::size_t, httplib::DataSink& sink) mutable {
          const std::int64_t before = seen;
          if (!studio_.wait_for_change(seen, kHeartbeat)) return false;
          const std::string event =
              seen == before
                  ? ": alive\n\n"
                  : "data: " + studio_.state().dump(-1, ' ', false, ordered_json::error_handler_t::replace) +
                        "\n\n";
          return sink.write(event.data(), event.size());
        },
        [this](bool) { --listeners_; });
  }

  Studio& studio_;
  const std::string token_;
  const std::map<std::string, PageFile> files_;
  httplib::Server server_;
  int port_ = 0;
  std::atomic<int> listeners_ = 0;
};

}  // namespace

void serve(Studio& studio, int port, const std::function<void(const std::string&)>& ready) {
  // Blocked in this thread before there are others, which inherit it; one of them waits for these signals.
  sigset_t ends, before;
  ::sigemptyset(&ends);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&ends, signal);
  ::pthread_sigmask(SIG_BLOCK, &ends, &before);
  std::signal(SIGPIPE, SIG_IGN);  // of a browser that went away
  Server server(studio, port);
  std::atomic<bool> over = false;
  std::thread waiting([&] {
    while (!over && wait_for_signal(ends, 0.5) == 0) {
    }
    studio.close();
    server.stop();
  });
  ready(server.address());
  server.listen();
  over = true;
  waiting.join();
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

}  // namespace s2nnds::studio
