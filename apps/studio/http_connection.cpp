// SPDX-License-Identifier: MIT
#include "apps/studio/http_connection.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/report/convert.h>
#include <kibori/run/documents.h>
#include <kibori/report/export.h>
#include <kibori/report/import_report.h>
#include <kibori/document/rescue.h>
#include "apps/studio/session/stock_scene.h"

#include "apps/studio/bundle.h"
#include "apps/studio/playback.h"
#include "apps/studio/websocket_client.h"

namespace kibori::studio {
namespace {

using Clock = Server::State::Clock;

constexpr const char* kPlainText = "text/plain; charset=utf-8";
constexpr auto kLinger = std::chrono::seconds(2);
constexpr double kMaxChoice = 1e6;                    // of a number that a page states [mm]
constexpr auto kTransfer = std::chrono::minutes(10);  // limit for one file

// The credentials after "Bearer " (RFC 6750). Empty for any other scheme.
std::string_view bearer(std::string_view authorization) {
  constexpr std::string_view kScheme = "Bearer ";
  return authorization.substr(0, kScheme.size()) == kScheme ? authorization.substr(kScheme.size())
                                                            : std::string_view();
}

// The value of a cookie in the header Cookie (RFC 6265). Empty: none.
std::string_view cookie(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const size_t end = std::min(header.find(';'), header.size());
    std::string_view one = header.substr(0, end);
    header.remove_prefix(std::min(end + 1, header.size()));
    one.remove_prefix(std::min(one.find_first_not_of(' '), one.size()));
    if (one.substr(0, name.size()) == name && one.substr(name.size(), 1) == "=")
      return one.substr(name.size() + 1);
  }
  return {};
}

const char* mime(std::string_view path) {
  const auto ends = [&](std::string_view end) {
    return path.size() >= end.size() && path.substr(path.size() - end.size()) == end;
  };
  if (ends(".html")) return "text/html; charset=utf-8";
  if (ends(".js")) return "text/javascript; charset=utf-8";
  if (ends(".css")) return "text/css; charset=utf-8";
  if (ends(".svg")) return "image/svg+xml";
  return "application/octet-stream";
}

// The unescaped value of `name` in the target's query. Empty if it is missing or badly escaped.
std::string query(std::string_view target, std::string_view name) {
  const size_t mark = target.find('?');
  std::string_view rest =
      mark == std::string_view::npos ? std::string_view() : target.substr(mark + 1);
  while (!rest.empty()) {
    const size_t end = std::min(rest.find('&'), rest.size());
    const std::string_view one = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (one.size() <= name.size() || one.substr(0, name.size()) != name || one[name.size()] != '=')
      continue;
    std::string value;
    for (size_t i = name.size() + 1; i < one.size(); i++) {
      if (one[i] != '%') {
        value += one[i];
        continue;
      }
      unsigned code = 0;
      if (i + 2 >= one.size()) return {};
      const auto read = std::from_chars(one.data() + i + 1, one.data() + i + 3, code, 16);
      if (read.ec != std::errc() || read.ptr != one.data() + i + 3) return {};
      value += static_cast<char>(code);
      i += 2;
    }
    return value;
  }
  return {};
}

std::optional<double> number(const std::string& text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size())
    return std::nullopt;
  return value;
}

// Parses "1:4,2:0": label 1 has material 4, label 2 has material 0.
std::optional<std::map<uint16_t, uint8_t>> labels_of(const std::string& text) {
  std::map<uint16_t, uint8_t> labels;
  const char *at = text.data(), *const end = at + text.size();
  while (at != end) {
    uint16_t label = 0;
    uint8_t material = 0;
    const auto read = std::from_chars(at, end, label);
    if (read.ec != std::errc() || read.ptr == end || *read.ptr != ':') return std::nullopt;
    const auto of = std::from_chars(read.ptr + 1, end, material);
    if (of.ec != std::errc() || (of.ptr != end && *of.ptr != ',')) return std::nullopt;
    labels[label] = material;
    at = of.ptr == end ? end : of.ptr + 1;
  }
  return labels;
}

std::string_view path_of(std::string_view target) { return target.substr(0, target.find('?')); }

// Replaces the temporary path in an error by the user's file name.
Error with_original_name(const std::string& name, const std::filesystem::path& path,
                         std::string why) {
  const std::string here = path.string(), there = sanitize_message(name);
  for (size_t at = 0; (at = why.find(here, at)) != std::string::npos; at += there.size())
    why.replace(at, here.size(), there);
  return Error{why};
}

// One HTTP connection.
class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(net::Socket socket, Server::State& server, Entrance& entrance);
  void read();

 private:
  // Status codes of HTTP (RFC 9110).
  enum class Status : uint16_t {
    ok = 200,
    accepted = 202,
    no_content = 204,
    bad_request = 400,
    forbidden = 403,
    not_found = 404,
    method_not_allowed = 405,
    conflict = 409,
    gone = 410,
    length_required = 411,
    payload_too_large = 413,
    unsupported_media_type = 415,
    misdirected_request = 421,
    unprocessable_entity = 422,
    upgrade_required = 426,
    too_many_requests = 429,
    internal_server_error = 500,
    service_unavailable = 503,
    insufficient_storage = 507,
  };
  void answer();
  // True if the request has a valid key or session.
  bool may_enter() const;
  // Sends the key in exchange for the token.
  void admit();
  // Gives a device of the network a session in exchange for the code.
  void pair();
  // Receives a file into the temporary folder. Opens a document at once. Any other file waits until
  // the page decides what to make of it. The answer describes that file as JSON (import_report.h),
  // with an id.
  void take_import();
  void open_brought();
  bool is_job() const;
  bool may_import();
  void look_at_import();
  void answer_import(Import import, const kibori::Status& read, const std::string& json,
                     bool wanted);
  // Requests about this page's import: preview, drop, make a document.
  void send_preview();
  void drop_import();
  void make_import();
  void answer_made(const kibori::Status& made);
  void make_body(const Import& import, const FileStock& how);
  // A milling job: reads its files, and begins it.
  void look_at_job();
  void make_job(const Import& import);
  void send_program();
  void send_curve();
  // Returns the page's waiting file. If the page or the file is missing, sends an error and returns
  // null.
  const Import* waiting();
  void send_export();
  void send_thumbnail();
  void send_spline();
  void send_file(const std::filesystem::path& path);
  void respond(Status status, std::string body, const char* type = kPlainText,
               const std::vector<std::pair<std::string, std::string>>& headers = {});
  // `body` must live as long as the program.
  void send_bundled(std::string_view body, const char* type);
  // Returns an answer without content: its status, and the headers of every answer.
  net::Response head(Status status, const char* type) const;
  // Returns the callback for the end of an answer. It reads the next request or closes the
  // connection.
  std::function<void(bool)> then();
  void close() { stream_.finish(kLinger, shared_from_this()); }

  net::HttpStream stream_;
  Server::State& server_;
  Entrance& entrance_;
  std::shared_ptr<Guest> guest_;
  std::shared_ptr<void> room_;               // reserved space for an upload
  std::shared_ptr<TemporaryFolder> folder_;  // holds the upload
  std::string name_;                         // the name of the uploaded file
  std::string target_;
  bool keep_alive_ = false;
};

}  // namespace

Result<std::unique_ptr<Session>> open_copy(const std::filesystem::path& from,
                                           const std::filesystem::path& to,
                                           const SessionOptions& how) {
  {
    auto document = Document::open(from, Document::Access::read);
    if (!document) return Error{document.error()};
    if (const kibori::Status copied = document.value()->save_copy(to); !copied)
      return Error{copied.error()};
  }
  auto opened = open_session(to, how);
  if (!opened) remove_document(to);
  return opened;
}

void serve_http(net::Socket socket, Server::State& server, Entrance& entrance) {
  std::make_shared<HttpConnection>(std::move(socket), server, entrance)->read();
}

HttpConnection::HttpConnection(net::Socket socket, Server::State& server, Entrance& entrance)
    : stream_(std::move(socket)),
      server_(server),
      entrance_(entrance),
      guest_(std::make_shared<Guest>(entrance.guests, [this] { stream_.close(); })) {}

void HttpConnection::read() {
  stream_.expire_after(std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(server_.limits.header_s)));
  // The limit leaves room for cookies of other ports of this machine, because a browser sends those
  // too.
  stream_.read_head({32768, server_.limits.import_bytes},
                    [self = shared_from_this()](net::Received head) {
                      if (head == net::Received::too_large)
                        return self->respond(Status::payload_too_large,
                                             "the file exceeds the upload limit of 1 GB\n");
                      if (head != net::Received::ok) return self->close();
                      self->answer();
                    });
}

void HttpConnection::answer() {
  const net::Request& request = stream_.request();
  target_ = request.target;
  const bool body = request.content_length.value_or(0) > 0 || request.chunked;
  keep_alive_ = request.keep_alive && !body;
  const std::string_view target = target_, host = request.header("Host");
  // Refuse other host names that resolve to this machine (DNS rebinding).
  if (request.count("Host") != 1 ||
      std::find(entrance_.hosts.begin(), entrance_.hosts.end(), host) == entrance_.hosts.end())
    return respond(
        Status::misdirected_request,
        "the request is for another host name; open the address that 'kibori studio' printed\n");
  const std::string_view origin = request.header("Origin");
  const bool own = origin == entrance_.scheme + "://" + std::string(host);
  if (request.count("Origin") != 0 && !own)
    return respond(Status::forbidden, "requests from other sites are refused\n");
  const std::string_view method = request.method;
  const bool import = path_of(target) == "/import" && method == "POST";
  const bool change = import || (path_of(target) == "/import" && method == "DELETE") ||
                      (path_of(target) == "/make" && method == "POST");
  const bool enter =
      path_of(target) == (entrance_.pairing ? "/pair" : "/enter") && method == "POST";
  if (method != "GET" && !change && !enter)
    return respond(Status::method_not_allowed, "this address accepts only GET\n");
  if (body && !import) return respond(Status::bad_request, "this address accepts no content\n");
  // For a browser, all ports of this machine are the same site. Refuse other ports too.
  const std::string_view from = request.header("Sec-Fetch-Site");
  if (path_of(target) != "/" && !from.empty() && from != "same-origin" && from != "none")
    return respond(Status::forbidden, "requests from other sites are refused\n");
  if (enter && !own) return respond(Status::forbidden, "requests from other sites are refused\n");
  if (enter) return entrance_.pairing ? pair() : admit();
  if (target == "/ws") {
    if (!request.upgrade) return respond(Status::upgrade_required, "a WebSocket\n");
    if (!own) return respond(Status::forbidden, "requests from other sites are refused\n");
    // A page on this machine sends the key in its first message.
    const auto admits = [&door = server_.door, paired = entrance_.pairing && may_enter(),
                         here = !entrance_.pairing](std::string_view key) {
      return here ? door.is_key(key) : paired;
    };
    std::make_shared<WebSocketClient>(stream_.upgrade(), server_, std::move(guest_), admits)
        ->accept();
    return;
  }
  if (method == "GET") {
    std::string_view path = path_of(target) == "/" ? std::string_view("/index.html") : target;
    if (entrance_.pairing && path == "/index.html" && !may_enter()) {
      entrance_.pairing->offer(Pairing::Clock::now());
      path = "/pair.html";
    }
    for (const BundledFile& file : bundle())
      if (path == file.path)
        return send_bundled({reinterpret_cast<const char*>(file.data), file.size}, mime(path));
  }
  if (!may_enter())
    return respond(Status::forbidden,
                   entrance_.pairing
                       ? "this device is not paired; open the address of the studio in a browser\n"
                       : "open the address that 'kibori studio' printed, with its token\n");
  if (!guest_->welcome())
    return respond(Status::service_unavailable,
                   "too many windows of the studio are open; close some\n");
  if (change && !own) return respond(Status::forbidden, "requests from other sites are refused\n");
  if (import) return take_import();
  if (change) return method == "DELETE" ? drop_import() : make_import();
  if (path_of(target) == "/import") return send_preview();
  if (path_of(target) == "/export") return send_export();
  if (path_of(target) == "/thumbnail") return send_thumbnail();
  if (path_of(target) == "/spline") return send_spline();
  if (path_of(target) == "/program") return send_program();
  if (path_of(target) == "/curve") return send_curve();
  respond(Status::not_found, "there is no such file\n");
}

void HttpConnection::admit() {
  const std::string key = server_.door.enter(query(target_, "token"),
                                             bearer(stream_.request().header("Authorization")));
  if (key.empty())
    return respond(
        Status::forbidden,
        "this address is no longer valid; open the newest address that the studio printed\n");
  respond(Status::ok, key);
}

bool HttpConnection::may_enter() const {
  const net::Request& request = stream_.request();
  return entrance_.pairing
             ? entrance_.pairing->is_session(cookie(request.header("Cookie"), entrance_.cookie))
             : server_.door.is_key(bearer(request.header("Authorization")));
}

void HttpConnection::pair() {
  using Outcome = Pairing::Outcome;
  const Pairing::Answer answer =
      entrance_.pairing->enter(query(target_, "code"), Pairing::Clock::now());
  const std::string wait = std::to_string(answer.wait.count());
  switch (answer.outcome) {
    case Outcome::paired:
      // The browser returns the cookie only to this host, and only over TLS. No script can read it,
      // and requests from other sites do not carry it.
      return respond(Status::no_content, "", kPlainText,
                     {{"Set-Cookie", entrance_.cookie + "=" + answer.session +
                                         "; Path=/; Secure; HttpOnly; SameSite=Strict"}});
    case Outcome::wrong:
      return respond(Status::forbidden, "this is not the code that the terminal shows\n");
    case Outcome::expired:
      return respond(Status::gone,
                     "this code is no longer valid; enter the newest one that the "
                     "terminal shows\n");
    case Outcome::wait:
      return respond(Status::too_many_requests,
                     "too many wrong codes; wait " + wait + " s and load this address again\n",
                     kPlainText, {{"Retry-After", wait}});
  }
}

void HttpConnection::take_import() {
  WebSocketClient* const page = server_.page_of(query(target_, "page"));
  if (!page) return respond(Status::forbidden, "this page has lost its connection; reload it\n");
  if (!may_import()) return;
  name_ = query(target_, "name");
  const std::string ending = ending_of(name_);
  if (stream_.request().chunked)
    return respond(Status::length_required, "the header Content-Length is missing\n");
  if (!is_import(ending) || (server_.session && !is_one_of(kMeshesRead, ending)))
    return respond(Status::unsupported_media_type,
                   "a file of this type can't be carved; choose a mesh (" + list_of(kMeshesRead) +
                       "), a picture (.png), a labelled volume (.nrrd), a document (.kibori) or a "
                       "milling program (such as .nc)\n");
  server_.imports.drop(page);
  room_ = server_.imports.room(stream_.request().content_length.value_or(0));
  if (!room_)
    return respond(
        Status::insufficient_storage,
        "other windows have files that wait to be imported; import or cancel those first\n");
  const auto folder = TemporaryFolder::make();
  if (!folder) return respond(Status::insufficient_storage, folder.error() + "\n");
  folder_ = folder.value();
  stream_.expire_after(kTransfer);
  const bool writable = stream_.receive_body(
      folder_->path() / ("import" + ending), [self = shared_from_this()](net::Received body) {
        if (body == net::Received::too_large)
          return self->respond(Status::payload_too_large,
                               "the file exceeds the upload limit of 1 GB\n");
        if (body == net::Received::disk_full)
          return self->respond(Status::insufficient_storage, "the temporary folder is full\n");
        if (body != net::Received::ok) return self->close();
        if (self->is_job()) return self->look_at_job();
        if (ending_of(self->name_) == ".kibori") return self->open_brought();
        self->look_at_import();
      });
  if (!writable) respond(Status::insufficient_storage, "the temporary folder is not writable\n");
}

void HttpConnection::open_brought() {
  const Result<std::filesystem::path> place =
      server_.library.place_for(std::filesystem::path(name_).stem().string());
  if (!place) return respond(Status::insufficient_storage, place.error() + "\n");
  const kibori::Status opened = server_.open(
      "Reading " + sanitize_message(name_), place.value(),
      [folder = folder_, name = name_, to = place.value(),
       how = server_.how](std::atomic<double>&) -> Result<std::unique_ptr<Session>> {
        const std::filesystem::path from = folder->path() / ("import" + ending_of(name));
        auto made = open_copy(from, to, how);
        if (!made) return with_original_name(name, from, made.error());
        return made;
      });
  if (!opened) return respond(Status::conflict, opened.error() + "\n");
  folder_.reset();
  room_.reset();
  keep_alive_ = false;
  respond(Status::accepted, "");
}

// True if the upload is a milling job: a program, or several files.
bool HttpConnection::is_job() const {
  return is_one_of(kProgramsRead, ending_of(name_)) || !query(target_, "files").empty();
}

// An imported file becomes a document. If this page carves in an open document, the file becomes a
// body there.
bool HttpConnection::may_import() {
  const bool carves = server_.live() && server_.page_of(query(target_, "page")) == server_.holder;
  if ((!server_.session || carves) && !server_.job.busy()) return true;
  respond(Status::conflict,
          "a document is open, or another job is running; close the document or wait\n");
  return false;
}

void HttpConnection::look_at_import() {
  if (!may_import()) return;
  server_.work("Reading " + sanitize_message(name_),
               [self = shared_from_this(), folder = folder_,
                name = name_](std::atomic<double>&) -> Job::Then {
                 Import import{random_hex(), name, folder, 0, {}, {}, {}};
                 std::error_code unknown;
                 import.bytes = std::filesystem::file_size(import.path(), unknown);
                 const Result<ImportReport> report = report_import(import.path());
                 kibori::Status read = Ok{};
                 std::string json;
                 if (report) {
                   import.preview = import_preview(report.value());
                   nlohmann::json about = parse_json(import_report_json(report.value()));
                   about["import"] = import.id;
                   json = about.dump();
                 } else {
                   read = with_original_name(name, import.path(), report.error());
                 }
                 return [self, import, read, json](bool wanted) mutable {
                   self->answer_import(std::move(import), read, json, wanted);
                 };
               });
}

// The file waits, and the page gets its description or the error.
void HttpConnection::answer_import(Import import, const kibori::Status& read,
                                   const std::string& json, bool wanted) {
  stream_.expire_after(kTransfer);
  folder_.reset();
  room_.reset();
  if (!wanted) return respond(Status::gone, "");
  if (!read) return respond(Status::unprocessable_entity, read.error() + "\n");
  const WebSocketClient* const page = server_.page_of(query(target_, "page"));
  if (!page) return respond(Status::gone, "");
  import.since = Clock::now();
  const kibori::Status added = server_.imports.add(page, std::move(import));
  if (!added) return respond(Status::insufficient_storage, added.error() + "\n");
  respond(Status::ok, json, "application/json");
}

void HttpConnection::look_at_job() {
  if (!may_import()) return;
  server_.work("Reading " + sanitize_message(name_),
               [self = shared_from_this(), folder = folder_, name = name_,
                list = query(target_, "files")](std::atomic<double>&) -> Job::Then {
                 Import import{random_hex(), name, folder, 0, {}, {}, {}};
                 std::error_code unknown;
                 import.bytes = std::filesystem::file_size(import.path(), unknown);
                 Result<PlaybackFiles> files = unpack_job(folder, import.path(), name, list);
                 kibori::Status read = Ok{};
                 std::string json;
                 if (files) {
                   import.files = files.value().names;
                   const Result<PlaybackNeeds> needs = playback_needs(files.value());
                   if (needs)
                     json = needs_json(needs.value(), import.id);
                   else
                     read = Error{needs.error()};
                 } else {
                   read = Error{files.error()};
                 }
                 return [self, import, read, json](bool wanted) mutable {
                   self->answer_import(std::move(import), read, json, wanted);
                 };
               });
}

const Import* HttpConnection::waiting() {
  const WebSocketClient* const page = server_.page_of(query(target_, "page"));
  const Import* const import =
      page ? server_.imports.find(page, query(target_, "import")) : nullptr;
  if (!import) respond(Status::not_found, "the studio no longer has this file; choose it again\n");
  return import;
}

void HttpConnection::send_preview() {
  if (const Import* const import = waiting())
    respond(Status::ok, std::string(import->preview.begin(), import->preview.end()),
            "application/octet-stream");
}

void HttpConnection::drop_import() {
  // A file that is already gone counts as dropped, for example after the page's next upload.
  const WebSocketClient* const page = server_.page_of(query(target_, "page"));
  if (page && server_.imports.find(page, query(target_, "import"))) server_.imports.drop(page);
  respond(Status::no_content, "");
}

void HttpConnection::make_import() {
  const Import* const import = waiting();
  if (!import) return;
  if (!import->files.empty()) return make_job(*import);
  const auto number_or = [&](const char* key, double otherwise) {
    const std::string text = query(target_, key);
    return text.empty() ? std::optional<double>(otherwise) : number(text);
  };
  const auto size = number(query(target_, "size")), rays = number(query(target_, "rays")),
             material = number(query(target_, "material")),
             height = number_or("height", FileStock{}.height_mm),
             base = number_or("base", FileStock{}.base_mm);
  if (!size || !rays || !material || !(*material >= 0 && *material < 64) || !height || !base)
    return respond(Status::bad_request,
                   "the size, detail, material, height or base is not a number\n");
  const auto axis = [&](const char* key, SignedAxis otherwise) {
    const std::string text = query(target_, key);
    return text.empty() ? std::optional<SignedAxis>(otherwise) : parse_signed_axis(text);
  };
  const auto up = axis("up", SignedAxis::plus_z);
  const auto front = axis("front", standing(up.value_or(SignedAxis::plus_z)).front);
  if (!up || !front || !is_turn({*up, *front}))
    return respond(Status::bad_request,
                   "up and front must be two axes at right angles, each x, -x, y, -y, z or -z\n");
  const auto labels = labels_of(query(target_, "labels"));
  if (!labels)
    return respond(Status::bad_request,
                   "labels must give the material of each label, as in 1:4,2:0\n");
  const FileStock how{*size,   *rays, static_cast<size_t>(*material),  {*up, *front},
                      *height, *base, query(target_, "invert") == "1", *labels};
  const std::string called = query(target_, "name"), name = import->name;
  if (server_.session) return make_body(*import, how);
  const Result<std::filesystem::path> place = server_.library.place_for(
      called.empty() ? std::filesystem::path(name).stem().string() : called);
  if (!place) return respond(Status::insufficient_storage, place.error() + "\n");
  // The page that makes the document gets the tool.
  server_.hold(server_.page_of(query(target_, "page")));
  const kibori::Status opened = server_.open(
      "Making the stock", place.value(),
      // The lambda keeps the folder alive while it reads, even if the page closes.
      [folder = import->folder, from = import->path(), name, how, to = place.value(),
       options = server_.how](std::atomic<double>&) -> Result<std::unique_ptr<Session>> {
        const Result<Scene> scene = file_scene(from, how);
        if (!scene) return with_original_name(name, from, scene.error());
        auto made = create_session(to, scene.value(), options);
        if (!made) return with_original_name(name, from, made.error());
        return made;
      },
      [self = shared_from_this()](const kibori::Status& made) { self->answer_made(made); });
  if (!opened) respond(Status::conflict, opened.error() + "\n");
}

void HttpConnection::make_job(const Import& import) {
  if (server_.session) return respond(Status::conflict, "a document is open; close it first\n");
  PlaybackChoice choice;
  const auto optional = [&](const char* key, std::optional<double>& into) {
    const std::string text = query(target_, key);
    if (text.empty()) return true;
    into = number(text);
    return into && std::abs(*into) <= kMaxChoice;
  };
  std::array<std::optional<double>, 6> stock;
  bool good = optional("pitch", choice.pitch_mm) && optional("diameter", choice.diameter_mm);
  constexpr std::array kCorners{"x0", "y0", "z0", "x1", "y1", "z1"};
  for (size_t i = 0; i < stock.size(); i++) good = optional(kCorners[i], stock[i]) && good;
  if (!good) return respond(Status::bad_request, "the stock, pitch or diameter is not a number\n");
  if (std::all_of(stock.begin(), stock.end(), [](const auto& x) { return x.has_value(); }))
    choice.stock =
        Box{Vec3(*stock[0], *stock[1], *stock[2]), Vec3(*stock[3], *stock[4], *stock[5])};
  choice.ball = query(target_, "ball") == "1";
  if (const std::string material = query(target_, "material"); !material.empty())
    choice.material = material;
  // The page that opens the job holds the tool.
  server_.hold(server_.page_of(query(target_, "page")));
  const kibori::Status opened = server_.open(
      "Opening " + sanitize_message(import.name), {},
      [files = PlaybackFiles{import.folder, import.files}, choice](std::atomic<double>&) {
        return PlaybackSession::start(files, choice);
      },
      [self = shared_from_this()](const kibori::Status& made) { self->answer_made(made); });
  if (!opened) respond(Status::conflict, opened.error() + "\n");
}

void HttpConnection::answer_made(const kibori::Status& made) {
  stream_.expire_after(kTransfer);
  if (made) return respond(Status::no_content, "");
  if (made.error().empty()) return respond(Status::gone, "");
  respond(Status::unprocessable_entity, made.error() + "\n");
}

// Sends lines of a milling program.
void HttpConnection::send_program() {
  const PlaybackSession* const playback = server_.session ? server_.session->playback() : nullptr;
  const auto program = number(query(target_, "program")), from = number(query(target_, "from"));
  const auto lines =
      playback && program && from ? program_lines(*playback, *program, *from) : std::nullopt;
  if (!lines) return respond(Status::not_found, "there is no such program\n");
  respond(Status::ok, *lines, "application/json");
}

void HttpConnection::send_curve() {
  const PlaybackSession* const playback = server_.session ? server_.session->playback() : nullptr;
  const auto parts = number(query(target_, "parts"));
  const auto curve = playback && parts ? force_curve(*playback, *parts) : std::nullopt;
  if (!curve) return respond(Status::not_found, "there is no such curve\n");
  respond(Status::ok, *curve, "application/json");
}

// Adds the file's shape as a new body, at the middle of the active body's material.
void HttpConnection::make_body(const Import& import, const FileStock& how) {
  if (!may_import()) return;
  BodyAdd add;
  add.material = server_.session->stock_material();
  add.properties.no_go = query(target_, "no_go") == "1";
  if (const std::string called = query(target_, "name"); !called.empty())
    add.properties.name = called;
  const Body& body = server_.session->active_body();
  add.pose.tip =
      body.pose.to_world(server_.session->lattice().to_mm(body.material_bounds.centre()));
  server_.work("Reading " + sanitize_message(import.name),
               [self = shared_from_this(), folder = import.folder, from = import.path(),
                name = import.name, how, add](std::atomic<double>&) -> Job::Then {
                 Result<Tool> shape = file_shape(from, how);
                 return [self, from, name, add, shape](bool wanted) mutable {
                   self->stream_.expire_after(kTransfer);
                   LiveSession* const live = self->server_.live();
                   if (!wanted || !live) return self->respond(Status::gone, "");
                   if (!shape)
                     return self->respond(
                         Status::unprocessable_entity,
                         with_original_name(name, from, shape.error()).message + "\n");
                   add.tool = std::move(shape).value();
                   live->act({{}, add});
                   self->server_.imports.drop(self->server_.page_of(query(self->target_, "page")));
                   self->respond(Status::no_content, "");
                 };
               });
}

void HttpConnection::send_export() {
  const std::string format = query(target_, "format");
  const double tolerance = number(query(target_, "tolerance")).value_or(0);
  if (!server_.session) return respond(Status::conflict, "no document is open\n");
  if (server_.job.busy()) return respond(Status::conflict, "another job is running; wait for it\n");
  if (!(tolerance >= 0 && tolerance <= 1000))
    return respond(Status::bad_request, "the tolerance must be 0 to 1000 mm\n");
  const auto made = TemporaryFolder::make();
  if (!made) return respond(Status::insufficient_storage, made.error() + "\n");
  const auto& folder = made.value();
  const std::filesystem::path path = folder->path() / ("model." + format);
  const auto sent = [self = shared_from_this(), folder, path](const kibori::Status& written,
                                                              bool wanted) {
    if (!wanted) return self->respond(Status::gone, "cancelled\n");
    if (!written) return self->respond(Status::internal_server_error, written.error() + "\n");
    self->send_file(path);
  };
  if (format == "kibori") {
    // The document writer writes it between two strokes.
    const auto promise = std::make_shared<std::promise<kibori::Status>>();
    server_.work("Writing " + format,
                 [written = std::make_shared<std::future<kibori::Status>>(promise->get_future()),
                  sent](std::atomic<double>&) -> Job::Then {
                   kibori::Status outcome = Error{"the document was closed before it was written"};
                   try {
                     outcome = written->get();
                   } catch (const std::future_error&) {
                     // The writer ended before it wrote the copy.
                   }
                   return [sent, outcome](bool wanted) { sent(outcome, wanted); };
                 });
    server_.session->save_copy(
        path, [promise](const kibori::Status& written) { promise->set_value(written); });
    return;
  }
  std::function<kibori::Status(const kibori::BodyList&, const Snapshot&)> make;
  if (is_one_of(kMeshesWritten, "." + format)) {
    std::vector<Rgb> colors;
    for (const Material& m : server_.session->materials()) colors.push_back(m.color);
    make = [path, colors, tolerance](const kibori::BodyList& bodies,
                                     const Snapshot&) -> kibori::Status {
      const Result<size_t> written = write_bodies(path, bodies.all, colors, tolerance, 1);
      return written ? kibori::Status(Ok{}) : kibori::Status(Error{written.error()});
    };
  } else if (format == "png") {
    // These formats contain only the active body.
    make = [path](const kibori::BodyList&, const Snapshot& model) -> kibori::Status {
      const auto written = write_height_map(path, model);
      return written ? kibori::Status(Ok{}) : kibori::Status(Error{written.error()});
    };
  } else if (format == "zip") {
    make = [path](const kibori::BodyList&, const Snapshot& model) {
      return write_layers_zip(path, model, {});
    };
  } else {
    return respond(Status::bad_request, "this format is not supported\n");
  }
  server_.work("Writing " + format,
               [bodies = server_.session->bodies(), model = server_.session->snapshot(), make,
                sent](std::atomic<double>&) -> Job::Then {
                 return
                     [sent, written = make(bodies, model)](bool wanted) { sent(written, wanted); };
               });
}

void HttpConnection::send_thumbnail() {
  const auto sent = [self = shared_from_this()](const Bytes& png) {
    if (png.empty()) return self->respond(Status::no_content, "");
    self->respond(Status::ok, std::string(png.begin(), png.end()), "image/png");
  };
  const std::string document = query(target_, "document");
  if (!document.empty()) return sent(server_.library.thumbnail(document));
  const std::optional<double> step = number(query(target_, "step"));
  if (!server_.session || !step || !(*step >= 1 && *step < 4e9)) return sent({});
  server_.session->thumbnail(
      static_cast<StepId>(*step),
      [&loop = server_.loop, sent](const Bytes& png) { loop.post([sent, png] { sent(png); }); });
}

// Sends the last applied spline, so that the page can edit it.
void HttpConnection::send_spline() {
  LiveSession* const live = server_.live();
  if (!live) return respond(Status::conflict, "no document is open for carving\n");
  live->last_spline([&loop = server_.loop, self = shared_from_this()](const std::string& json) {
    loop.post([self, json] {
      if (json.empty())
        self->respond(Status::not_found, "no spline was applied yet\n");
      else
        self->respond(Status::ok, json, "application/json");
    });
  });
}

void HttpConnection::send_file(const std::filesystem::path& path) {
  stream_.expire_after(kTransfer);
  if (!stream_.write_file(head(Status::ok, "application/octet-stream"), path, then()))
    respond(Status::internal_server_error, "the written file cannot be read\n");
}

void HttpConnection::respond(Status status, std::string body, const char* type,
                             const std::vector<std::pair<std::string, std::string>>& headers) {
  keep_alive_ = keep_alive_ && status == Status::ok;
  net::Response response = head(status, type);
  response.headers.insert(response.headers.end(), headers.begin(), headers.end());
  response.body = std::move(body);
  stream_.write(std::move(response), then());
}

void HttpConnection::send_bundled(std::string_view body, const char* type) {
  net::Response response = head(Status::ok, type);
  response.body = body;
  stream_.write(std::move(response), then());
}

net::Response HttpConnection::head(Status status, const char* type) const {
  net::Response response;
  response.status = static_cast<unsigned>(status);
  response.keep_alive = keep_alive_;
  response.headers = {
      {"Content-Type", type},
      {"Content-Security-Policy",
       "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
       "img-src 'self' data: "
       "blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
      {"X-Content-Type-Options", "nosniff"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Referrer-Policy", "no-referrer"},
      {"Cache-Control", "no-store"}};
  return response;
}

std::function<void(bool)> HttpConnection::then() {
  return [self = shared_from_this()](bool sent) {
    if (!sent || !self->keep_alive_) return self->close();
    self->read();
  };
}

}  // namespace kibori::studio
