#include "view/routes.h"

#include "base/error.h"
#include "view/command_text.h"
#include "view/page_files.h"

#include <metrolux/version.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace metrolux::core::view {
namespace {

const PageFile* pageFile(const std::string& path) {
    const std::string name = path == "/" ? "index.html" : path.substr(1);
    for (const PageFile& file : kPageFiles)
        if (file.name == name) return &file;
    return nullptr;
}

HttpResponse jsonResponse(const nlohmann::json& json) {
    return textResponse(200, json.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace),
                        "application/json");
}

/// No mistake of the page, which browsers would report.
HttpResponse nothingYet() { return {204, "text/plain", nullptr, {}}; }

nlohmann::json numberOrNull(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

/// A whole number of the query, `otherwise` if it is absent. Throws Error.
template <class Integer>
Integer number(const HttpRequest& request, const char* name, Integer otherwise) {
    const auto found = request.query.find(name);
    if (found == request.query.end()) return otherwise;
    const std::string& text = found->second;
    Integer value{};
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (code != std::errc() || end != text.data() + text.size())
        throw Error("{}: found '{}', expected a whole number", name, text);
    return value;
}

std::string layerOf(const HttpRequest& request) {
    const auto found = request.query.find("layer");
    return found == request.query.end() ? "color" : found->second;
}

nlohmann::json toJson(const SideState& side) {
    nlohmann::json json{{"integrator", side.integrator},
                        {"generation", side.generation},
                        {"passes", side.progress.passes},
                        {"seconds", side.progress.seconds},
                        {"seconds_remaining", side.progress.secondsRemaining},
                        {"relative_error", numberOrNull(side.progress.relativeError)},
                        {"rays_per_second", side.progress.raysPerSecond},
                        {"note", side.progress.note},
                        {"curve", side.curve},
                        {"frame", nullptr}};
    if (const auto& frame = side.frame)
        json["frame"] = {{"version", frame->version},    {"generation", frame->generation},
                         {"scale", frame->scale},        {"passes", frame->progress.passes},
                         {"width", frame->window.width}, {"height", frame->window.height}};
    return json;
}

nlohmann::json toJson(const BoardState& state) {
    nlohmann::json sides = nlohmann::json::array();
    for (const SideState& side : state.sides) sides.push_back(toJson(side));
    return {{"version", state.version},
            {"phase", phaseName(state.phase)},
            {"reason", state.reason},
            {"message",
             {{"number", state.messageNumber}, {"text", state.message}, {"error", state.messageIsError}}},
            {"resolution", {state.resolution.width, state.resolution.height}},
            {"window", {state.window.x, state.window.y, state.window.width, state.window.height}},
            {"camera", state.camera},
            {"sides", sides}};
}

}  // namespace

std::optional<HttpResponse> Routes::operator()(const HttpRequest& request, bool last) {
    Answer answer;
    std::string reason;
    const PageFile* const page = pageFile(request.path);
    const bool isPublic = page && page->name != "index.html";
    if (const unsigned status = access_.refused(request, isPublic, reason)) {
        answer = textResponse(status, reason);
    } else {
        try {
            answer = route(request, last);
        } catch (const Error& problem) {
            answer = textResponse(400, problem.what());
        }
    }
    if (answer) {
        // The page loads what is here and nothing else, and no other page may show or read it.
        for (const auto& [name, value] :
             {std::pair("Cache-Control", "no-store"), std::pair("X-Content-Type-Options", "nosniff"),
              std::pair("X-Frame-Options", "DENY"), std::pair("Referrer-Policy", "no-referrer"),
              std::pair("Cross-Origin-Resource-Policy", "same-origin"),
              std::pair("Content-Security-Policy",
                        "default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'")})
            answer->headers.emplace_back(name, value);
    }
    return answer;
}

Routes::Answer Routes::route(const HttpRequest& request, bool last) {
    if (request.path == "/command") {
        if (request.method != "POST") return textResponse(405, "expected POST");
        return command(request);
    }
    if (request.method != "GET" && request.method != "HEAD") return textResponse(405, "expected GET");
    if (request.path == "/about") return about();
    if (request.path == "/state") return state(request, last);
    if (request.path == "/frame") return frame(request, last);
    if (request.path == "/pixel") return pixel(request, last);
    return file(request.path);
}

/// The page has the token in it, for what it will ask: another site's page cannot read it there.
HttpResponse Routes::file(const std::string& path) const {
    const PageFile* const found = pageFile(path);
    if (!found) return textResponse(404, "there is nothing of this name");
    std::string content(found->content);
    constexpr std::string_view kMark = "@METROLUX_TOKEN@";
    if (const size_t at = content.find(kMark); at != std::string::npos)
        content.replace(at, kMark.size(), access_.token());
    const std::string_view extension = found->name.substr(found->name.rfind('.') + 1);
    const char* const type = extension == "html"  ? "text/html; charset=utf-8"
                             : extension == "css" ? "text/css; charset=utf-8"
                                                  : "text/javascript; charset=utf-8";
    return textResponse(200, std::move(content), type);
}

HttpResponse Routes::about() const {
    const BoardInfo& info = board_.info();
    nlohmann::json list = nlohmann::json::array();
    for (const metrolux::IntegratorDescription& integrator : metrolux::integrators())
        list.push_back({{"name", integrator.name}, {"summary", integrator.summary}});
    return jsonResponse({{"program", fmt::format("metrolux {}", version())},
                         {"scene", info.scene},
                         {"explores", info.explores},
                         {"layers", info.layers},
                         {"outputs", info.outputs},
                         {"integrators", list}});
}

/// Answers as soon as there is something after the version that is known.
Routes::Answer Routes::state(const HttpRequest& request, bool last) {
    board_.watch(false);
    const BoardState state = board_.state();
    if (!last && state.version <= number<uint64_t>(request, "after", 0) && request.query.contains("after"))
        return std::nullopt;
    return jsonResponse(toJson(state));
}

std::shared_ptr<const std::string> Routes::encoded(const std::string& key, std::span<const float> values) {
    std::erase_if(sent_, [](const Encoded& e) { return e.bytes.expired(); });
    for (const Encoded& e : sent_)
        if (e.key == key)
            if (auto bytes = e.bytes.lock()) return bytes;
    if (sent_.size() >= kMostEncoded) return nullptr;
    auto bytes = std::make_shared<const std::string>(halfFloats(values));
    sent_.push_back({key, bytes});
    return bytes;
}

Routes::Answer Routes::frame(const HttpRequest& request, bool last) {
    const std::string layer = layerOf(request);
    const bool variance = layer == "error" || layer == "variance";
    board_.watch(variance);
    const BoardState state = board_.state();
    const auto side = number<size_t>(request, "side", 0);
    if (side >= state.sides.size() || !state.sides[side].frame) return nothingYet();
    const std::shared_ptr<const Frame> frame = state.sides[side].frame;
    const auto answer = [&](int width, int height, int channels,
                            std::span<const float> values) -> HttpResponse {
        const uint64_t version = layer == "color" || variance ? frame->version : 0;
        auto bytes =
            encoded(fmt::format("{} {} {} {}", side, state.sides[side].generation, layer, version), values);
        if (!bytes) return textResponse(503, "the pictures before are still being taken");
        newest_[side] = bytes;  // for the next viewer
        HttpResponse response{200, "application/octet-stream", std::move(bytes), {}};
        response.headers.emplace_back("X-Frame", nlohmann::json{{"width", width},
                                                                {"height", height},
                                                                {"channels", channels},
                                                                {"scale", frame->scale},
                                                                {"version", frame->version},
                                                                {"generation", frame->generation},
                                                                {"passes", frame->progress.passes}}
                                                     .dump());
        return response;
    };
    const Crop& w = frame->window;
    if (layer == "color") return answer(w.width, w.height, 3, frame->color);
    if (variance) {
        if (frame->variance.empty()) {
            if (!last) return std::nullopt;
            return nothingYet();
        }
        if (layer == "variance") return answer(w.width, w.height, 1, frame->variance);
        return answer(w.width, w.height, 1, relativeErrors(frame->color, frame->variance));
    }
    const auto& known = board_.info().layers;
    if (std::find(known.begin(), known.end(), layer) == known.end())
        throw Error("layer: found '{}', expected color, error, variance{}{}", layer,
                    known.empty() ? "" : ", ", fmt::join(known, ", "));
    const auto pixels = board_.layer(static_cast<int>(side), layer);
    if (pixels) return answer(pixels->width, pixels->height, pixels->channels, pixels->values);
    if (!last) return std::nullopt;
    return textResponse(503, "the layer is not there yet");
}

/// Exact values: the shortest text that gives the same float.
Routes::Answer Routes::pixel(const HttpRequest& request, bool last) {
    const std::string layer = layerOf(request);
    const BoardState state = board_.state();
    const auto side = number<size_t>(request, "side", 0);
    if (side >= state.sides.size() || !state.sides[side].frame) return nothingYet();
    const std::shared_ptr<const Frame> frame = state.sides[side].frame;
    LayerPixels shown{frame->window.width, frame->window.height, 3, {}};
    const std::vector<float>* values = &frame->color;
    std::shared_ptr<const LayerPixels> camera;
    std::vector<float> errors;
    if (layer == "error" || layer == "variance") {
        shown.channels = 1;
        if (frame->variance.empty()) return nothingYet();
        values = &frame->variance;
        if (layer == "error") values = &(errors = relativeErrors(frame->color, frame->variance));
    } else if (layer != "color") {
        const auto& known = board_.info().layers;
        if (std::find(known.begin(), known.end(), layer) == known.end())
            throw Error("there is no layer '{}'", layer);
        camera = board_.layer(static_cast<int>(side), layer);
        if (!camera) return last ? Answer(textResponse(503, "the layer is not there yet")) : std::nullopt;
        shown = {camera->width, camera->height, camera->channels, {}};
        values = &camera->values;
    }
    // The place in the picture that the viewer sees, which may have had another resolution.
    const int width = number(request, "width", shown.width), height = number(request, "height", shown.height),
              seenX = number(request, "x", 0), seenY = number(request, "y", 0);
    if (seenX < 0 || seenY < 0 || seenX >= width || seenY >= height)
        throw Error("found pixel {}, {}, expected one of {} x {}", seenX, seenY, width, height);
    const auto x = static_cast<int>(int64_t{seenX} * shown.width / width),
               y = static_cast<int>(int64_t{seenY} * shown.height / height);
    const auto c = static_cast<size_t>(shown.channels);
    const size_t first =
        c * (static_cast<size_t>(y) * static_cast<size_t>(shown.width) + static_cast<size_t>(x));
    std::vector<std::string> texts;
    for (size_t i = 0; i < c; ++i) {
        const float value = (*values)[first + i];
        texts.push_back(std::isfinite(value) ? fmt::format("{}", value) : fmt::format("\"{}\"", value));
    }
    return textResponse(200,
                        fmt::format(R"({{"values":[{}],"passes":{},"version":{}}})", fmt::join(texts, ","),
                                    frame->progress.passes, frame->version),
                        "application/json");
}

HttpResponse Routes::command(const HttpRequest& request) {
    using Kind = Command::Kind;
    const Command command = commandFromText(request.body);
    const bool watches = command.kind == Kind::Pause || command.kind == Kind::Resume ||
                         command.kind == Kind::Stop || command.kind == Kind::Save;
    if (!watches && !board_.info().explores)
        return textResponse(
            409, "this rendering is that of a `metrolux render`: it can be paused, saved and stopped");
    const BoardState state = board_.state();
    if (state.phase == Phase::Loading) return textResponse(409, "the scene is still being loaded");
    if (state.phase == Phase::Ended) return textResponse(409, "the rendering has ended");
    if (command.crop) {
        const Crop& c = *command.crop;
        const Resolution& full = state.resolution;
        if (c.x < 0 || c.y < 0 || c.width < 1 || c.height < 1 || c.x > full.width - c.width ||
            c.y > full.height - c.height)
            throw Error("found a crop of {} x {} pixels at {}, {}, expected one in the image of {} x {}",
                        c.width, c.height, c.x, c.y, full.width, full.height);
    }
    if (!board_.post(command)) return textResponse(429, "too many commands are waiting");
    return textResponse(202, "{}", "application/json");
}

}  // namespace metrolux::core::view
