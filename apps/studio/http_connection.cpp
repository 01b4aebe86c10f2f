// SPDX-License-Identifier: MIT
#include "apps/studio/http_connection.h"

#include <charconv>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/report/convert.h>
#include <kibori/run/documents.h>
#include <kibori/report/export.h>
#include <kibori/report/import_report.h>
#include <kibori/document/rescue.h>
#include "apps/studio/session/stock_scene.h"

#include "apps/studio/accept_websocket.h"
#include "apps/studio/bundle.h"
#include "apps/studio/websocket_client.h"

namespace kibori::studio {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Clock = Server::State::Clock;

constexpr auto kLinger = std::chrono::seconds(2);
constexpr auto kTransfer = std::chrono::minutes(10);  // limit for one file

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

// The credentials after "Bearer " (RFC 6750). Empty for any other scheme.
std::string_view bearer(std::string_view authorization) {
  constexpr std::string_view kScheme = "Bearer ";
  return authorization.substr(0, kScheme.size()) == kScheme ? authorization.substr(kScheme.size())
                                                            : std::string_view();
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
  HttpConnection(asio::ip::tcp::socket socket, Server::State& server);
  void read();

 private:
  using Status = http::status;
  void answer();
  // Sends the key in exchange for the token.
  void admit();
  // Receives a file into the temporary folder. A document is opened at once. For other files the
  // answer describes them (JSON of import_report.h and an id), and the file waits.
  void take_import();
  void open_brought();
  bool may_import();
  void look_at_import();
  // Requests about this page's import: preview, drop, make a document.
  void send_preview();
  void drop_import();
  void make_import();
  void make_body(const Import& import, const FileStock& how);
  // Null if the page or its file is missing. The request is then answered.
  const Import* waiting();
  void send_export();
  void send_thumbnail();
  void send_spline();
  void send_file(const std::filesystem::path& path);
  void respond(Status status, std::string body, const char* type = "text/plain; charset=utf-8");
  // `body` must live as long as the program.
  void send_bundled(std::string_view body, const char* type);
  template <class Body>
  void write(http::response<Body>& response);
  void close();
  void drain();

  beast::tcp_stream stream_;
  Server::State& server_;
  std::shared_ptr<Guest> guest_;
  std::shared_ptr<void> room_;  // reserved space for an upload
  beast::flat_buffer buffer_{16384};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::optional<http::request_parser<http::file_body>> import_;
  std::shared_ptr<TemporaryFolder> folder_;  // of an upload
  std::string name_;                         // of that file
  std::string target_;
  bool keep_alive_ = false;
  std::string body_;
  http::response<http::span_body<const char>> response_;
  http::response<http::file_body> file_response_;
};

}  // namespace

void serve_http(asio::ip::tcp::socket socket, Server::State& server) {
  std::make_shared<HttpConnection>(std::move(socket), server)->read();
}

HttpConnection::HttpConnection(asio::ip::tcp::socket socket, Server::State& server)
    : stream_(std::move(socket)),
      server_(server),
      guest_(std::make_shared<Guest>(server.door, [this] { stream_.close(); })) {}

void HttpConnection::read() {
  parser_.emplace();
  parser_->header_limit(32768);  // cookies of other ports of this machine are sent too
  parser_->body_limit(server_.limits.import_bytes);
  stream_.expires_after(std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(server_.limits.header_s)));
  http::async_read_header(stream_, buffer_, *parser_,
                          [self = shared_from_this()](beast::error_code failed, size_t) {
                            if (failed == http::error::body_limit)
                              return self->respond(Status::payload_too_large,
                                                   "the file exceeds the upload limit of 1 GB\n");
                            if (failed) return self->close();
                            self->answer();
                          });
}

void HttpConnection::answer() {
  const auto& request = parser_->get();
  target_ = std::string(view(request.target()));
  const bool body = parser_->content_length().value_or(0) > 0 || parser_->chunked();
  keep_alive_ = request.keep_alive() && !body;
  const std::string_view target = target_, host = view(request[http::field::host]);
  // Refuse other host names that resolve to this machine (DNS rebinding).
  if (request.count(http::field::host) != 1 || (host != server_.host && host != server_.local_host))
    return respond(
        Status::misdirected_request,
        "the request is for another host name; open the address that 'kibori studio' printed\n");
  const std::string_view origin = view(request[http::field::origin]);
  const bool own = origin.substr(0, 7) == "http://" && origin.substr(7) == host;
  if (request.count(http::field::origin) != 0 && !own)
    return respond(Status::forbidden, "requests from other sites are refused\n");
  const http::verb method = request.method();
  const bool import = path_of(target) == "/import" && method == http::verb::post;
  const bool change = import || (path_of(target) == "/import" && method == http::verb::delete_) ||
                      (path_of(target) == "/make" && method == http::verb::post);
  const bool enter = path_of(target) == "/enter" && method == http::verb::post;
  if (method != http::verb::get && !change && !enter)
    return respond(Status::method_not_allowed, "this address accepts only GET\n");
  if (body && !import) return respond(Status::bad_request, "this address accepts no content\n");
  // Other servers on this machine count as the same site. Refuse them too.
  const std::string_view from = view(request["Sec-Fetch-Site"]);
  if (path_of(target) != "/" && !from.empty() && from != "same-origin" && from != "none")
    return respond(Status::forbidden, "requests from other sites are refused\n");
  if (enter)
    return own ? admit() : respond(Status::forbidden, "requests from other sites are refused\n");
  if (target == "/ws") {
    if (!websocket::is_upgrade(request)) return respond(Status::upgrade_required, "a WebSocket\n");
    if (!own) return respond(Status::forbidden, "requests from other sites are refused\n");
    stream_.expires_never();
    accept_websocket(std::move(stream_), request, server_, std::move(guest_));
    return;
  }
  if (method == http::verb::get) {
    const std::string_view path = path_of(target) == "/" ? std::string_view("/index.html") : target;
    for (const BundledFile& file : bundle())
      if (path == file.path)
        return send_bundled({reinterpret_cast<const char*>(file.data), file.size}, mime(path));
  }
  if (!server_.door.is_key(bearer(view(request[http::field::authorization]))))
    return respond(Status::forbidden,
                   "open the address that 'kibori studio' printed, with its token\n");
  if (!guest_->welcome())
    return respond(Status::service_unavailable,
                   "too many windows of the studio are open; close some\n");
  if (change && !own) return respond(Status::forbidden, "requests from other sites are refused\n");
  if (import) return take_import();
  if (change) return method == http::verb::delete_ ? drop_import() : make_import();
  if (path_of(target) == "/import") return send_preview();
  if (path_of(target) == "/export") return send_export();
  if (path_of(target) == "/thumbnail") return send_thumbnail();
  if (path_of(target) == "/spline") return send_spline();
  respond(Status::not_found, "there is no such file\n");
}

void HttpConnection::admit() {
  const std::string key = server_.door.enter(
      query(target_, "token"), bearer(view(parser_->get()[http::field::authorization])));
  if (key.empty())
    return respond(
        Status::forbidden,
        "this address is no longer valid; open the newest address that the studio printed\n");
  respond(Status::ok, key);
}

void HttpConnection::take_import() {
  WebSocketClient* const page = server_.page_of(query(target_, "page"));
  if (!page) return respond(Status::forbidden, "this page has lost its connection; reload it\n");
  if (!may_import()) return;
  name_ = query(target_, "name");
  const std::string ending = ending_of(name_);
  if (parser_->chunked())
    return respond(Status::length_required, "the header Content-Length is missing\n");
  if (!is_import(ending) || (server_.session && !is_one_of(kMeshesRead, ending)))
    return respond(Status::unsupported_media_type,
                   "a file of this type can't be carved; choose a mesh (" + list_of(kMeshesRead) +
                       "), a picture (.png), a labelled volume (.nrrd) or a document (.kibori)\n");
  server_.imports.drop(page);
  room_ = server_.imports.room(parser_->content_length().value_or(0));
  if (!room_)
    return respond(
        Status::insufficient_storage,
        "other windows have files that wait to be imported; import or cancel those first\n");
  const auto folder = TemporaryFolder::make();
  if (!folder) return respond(Status::insufficient_storage, folder.error() + "\n");
  folder_ = folder.value();
  import_.emplace(std::move(*parser_));
  beast::error_code failed;
  import_->get().body().open((folder_->path() / ("import" + ending)).c_str(),
                             beast::file_mode::write, failed);
  if (failed)
    return respond(Status::insufficient_storage, "the temporary folder is not writable\n");
  stream_.expires_after(kTransfer);
  http::async_read(
      stream_, buffer_, *import_, [self = shared_from_this()](beast::error_code stopped, size_t) {
        if (stopped == http::error::body_limit)
          return self->respond(Status::payload_too_large,
                               "the file exceeds the upload limit of 1 GB\n");
        if (stopped == beast::errc::no_space_on_device)
          return self->respond(Status::insufficient_storage, "the temporary folder is full\n");
        if (stopped) return self->close();
        self->import_->get().body().close();
        if (ending_of(self->name_) == ".kibori") return self->open_brought();
        self->look_at_import();
      });
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

// A file becomes a document. If this page carves in an open document, it becomes a body there.
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
                 Import import{random_hex(), name, folder, 0, {}, {}};
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
                   self->stream_.expires_after(kTransfer);
                   self->folder_.reset();
                   self->room_.reset();
                   if (!wanted) return self->respond(Status::gone, "");
                   if (!read)
                     return self->respond(Status::unprocessable_entity, read.error() + "\n");
                   const WebSocketClient* const page =
                       self->server_.page_of(query(self->target_, "page"));
                   if (!page) return self->respond(Status::gone, "");
                   import.since = Clock::now();
                   const kibori::Status added = self->server_.imports.add(page, std::move(import));
                   if (!added)
                     return self->respond(Status::insufficient_storage, added.error() + "\n");
                   self->respond(Status::ok, json, "application/json");
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
  // The page that makes the first document holds the tool.
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
      [self = shared_from_this()](const kibori::Status& made) {
        self->stream_.expires_after(kTransfer);
        if (made) return self->respond(Status::no_content, "");
        if (made.error().empty()) return self->respond(Status::gone, "");
        self->respond(Status::unprocessable_entity, made.error() + "\n");
      });
  if (!opened) respond(Status::conflict, opened.error() + "\n");
}

// Adds the file's shape in the middle of the active body.
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
                   self->stream_.expires_after(kTransfer);
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
                     // The writer is gone.
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
      [&io = server_.io, sent](const Bytes& png) { asio::post(io, [sent, png] { sent(png); }); });
}

// Sends the last applied spline, so that the page can edit it.
void HttpConnection::send_spline() {
  LiveSession* const live = server_.live();
  if (!live) return respond(Status::conflict, "no document is open for carving\n");
  live->last_spline([&io = server_.io, self = shared_from_this()](const std::string& json) {
    asio::post(io, [self, json] {
      if (json.empty())
        self->respond(Status::not_found, "no spline was applied yet\n");
      else
        self->respond(Status::ok, json, "application/json");
    });
  });
}

void HttpConnection::send_file(const std::filesystem::path& path) {
  file_response_ = {};
  beast::error_code failed;
  file_response_.body().open(path.c_str(), beast::file_mode::scan, failed);
  if (failed) return respond(Status::internal_server_error, "the written file cannot be read\n");
  file_response_.result(Status::ok);
  file_response_.set(http::field::content_type, "application/octet-stream");
  stream_.expires_after(kTransfer);
  write(file_response_);
}

void HttpConnection::respond(Status status, std::string body, const char* type) {
  body_ = std::move(body);
  keep_alive_ = keep_alive_ && status == Status::ok;
  response_ = {};
  response_.result(status);
  response_.set(http::field::content_type, type);
  response_.body() = {body_.data(), body_.size()};
  write(response_);
}

void HttpConnection::send_bundled(std::string_view body, const char* type) {
  response_ = {};
  response_.result(Status::ok);
  response_.set(http::field::content_type, type);
  response_.body() = {body.data(), body.size()};
  write(response_);
}

template <class Body>
void HttpConnection::write(http::response<Body>& response) {
  response.version(11);
  response.set("Content-Security-Policy",
               "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
               "img-src 'self' data: "
               "blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Referrer-Policy", "no-referrer");
  response.set(http::field::cache_control, "no-store");
  response.keep_alive(keep_alive_);
  response.prepare_payload();
  http::async_write(stream_, response,
                    [self = shared_from_this()](beast::error_code failed, size_t) {
                      self->file_response_ = {};
                      if (failed || !self->keep_alive_) return self->close();
                      self->read();
                    });
}

void HttpConnection::close() {
  beast::error_code ignored;
  stream_.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  stream_.expires_after(kLinger);
  drain();
}

// Reads and drops the remaining input for a moment. Closing at once would lose the answer.
void HttpConnection::drain() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(8192),
                          [self = shared_from_this()](beast::error_code failed, size_t) {
                            if (failed) return self->stream_.close();
                            self->drain();
                          });
}

}  // namespace kibori::studio
